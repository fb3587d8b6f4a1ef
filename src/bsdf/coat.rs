//! What a rough dielectric coat reflects and lets through, tabulated per (η, roughness, distribution).

use super::fresnel;
use super::microfacet::Microfacet;
use super::table::{NODES, cosine_mean, interpolate, node, visible_normals};
use glam::Vec3;

/// What a base under a coat gets of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Entering {
    /// [`CoatTable::new`].
    Refracted,
    /// [`CoatTable::conserving`].
    Conserving,
    /// [`CoatTable::additive`].
    All,
}

/// Directional albedos of a rough interface (single scattering), as in Mitsuba's `roughplastic`.
#[derive(Debug)]
pub(crate) struct CoatTable {
    microfacet: Microfacet,
    eta: f32,
    transmittance: [f32; NODES],
    reflectance: [f32; NODES],
    mean_transmittance: f32,
    internal_reflectance: f32,
}

impl CoatTable {
    /// `eta` is the index of the coat over that of the air.
    pub fn new(eta: f32, microfacet: Microfacet) -> CoatTable {
        let outside: [Albedos; NODES] = std::array::from_fn(|i| albedos(&microfacet, node(i), eta));
        let inside: [f32; NODES] = std::array::from_fn(|i| albedos(&microfacet, node(i), 1.0 / eta).reflected);
        let transmittance = outside.map(|a| a.transmitted);
        CoatTable {
            microfacet,
            eta,
            transmittance,
            reflectance: outside.map(|a| a.reflected),
            mean_transmittance: cosine_mean(&transmittance),
            internal_reflectance: node_mean(&inside),
        }
    }

    /// The same reflection over a base that gets all that is not reflected, T(µ) = 1 − E(µ) with E the reflected share: with a base
    /// of albedo R the whole reflects R(1 − E) + E, and no light is lost (albedo scaling: Kelemen & Szirmay-Kalos 2001).
    pub fn conserving(eta: f32, microfacet: Microfacet) -> CoatTable {
        let table = CoatTable::new(eta, microfacet);
        let transmittance = table.reflectance.map(|reflected| 1.0 - reflected);
        let mean_transmittance = cosine_mean(&transmittance);
        // so that (1 − ρ)η², by which the base is divided, is the share of diffuse light that enters
        let internal_reflectance = 1.0 - mean_transmittance / (eta * eta);
        CoatTable { transmittance, mean_transmittance, internal_reflectance, ..table }
    }

    /// The same reflection over a base that is seen as if there were no coat: T = 1, and (1 − ρ)η² = 1.
    pub fn additive(eta: f32, microfacet: Microfacet) -> CoatTable {
        let internal_reflectance = 1.0 - 1.0 / (eta * eta);
        let table = CoatTable::new(eta, microfacet);
        CoatTable { transmittance: [1.0; NODES], mean_transmittance: 1.0, internal_reflectance, ..table }
    }

    #[inline(always)]
    pub fn microfacet(&self) -> &Microfacet {
        &self.microfacet
    }

    #[inline(always)]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// Share of light at cosine `cos` ≥ 0 that enters.
    #[inline(always)]
    pub fn transmittance(&self, cos: f32) -> f32 {
        interpolate(&self.transmittance, cos)
    }

    /// Share of light at cosine `cos` ≥ 0 that is reflected; with [`Self::transmittance`] at most 1, but of [`Self::additive`].
    #[inline(always)]
    pub fn reflectance(&self, cos: f32) -> f32 {
        interpolate(&self.reflectance, cos)
    }

    /// Cosine-weighted mean of [`Self::transmittance`].
    #[inline(always)]
    pub fn mean_transmittance(&self) -> f32 {
        self.mean_transmittance
    }

    /// Share of light from a diffuse base that the coat sends back to it. As in Mitsuba it is the plain mean of
    /// the nodes, ends included in full, which is below the integral by 1/64 and half an end's share: pictures
    /// are compared with Mitsuba's, and what becomes of the base's light is a convention of the model anyway.
    pub fn internal_reflectance(&self) -> f32 {
        self.internal_reflectance
    }
}

#[derive(Clone, Copy)]
struct Albedos {
    reflected: f32,
    transmitted: f32,
}

/// What visible facets reflect and let through of light at cosine `cos`, shadowing on the way out included:
/// ∫F·G1(wi) and ∫(1 − F)·G1(wi) over the distribution of visible normals.
fn albedos(microfacet: &Microfacet, cos: f32, eta: f32) -> Albedos {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let (mut reflected, mut transmitted) = (0.0, 0.0);
    for (u, weight) in visible_normals() {
        let m = microfacet.sample_visible(wo, u);
        let (f, cos_t) = fresnel::dielectric(wo.dot(m).max(0.0), eta);
        let (r, t) = (fresnel::reflect(wo, m), fresnel::refract(wo, m, cos_t, eta));
        reflected += if r.z > 0.0 { weight * f * microfacet.g1(r) } else { 0.0 };
        transmitted += if t.z < 0.0 { weight * (1.0 - f) * microfacet.g1(t) } else { 0.0 };
    }
    Albedos { reflected, transmitted }
}

/// Twice the mean of f(µ)µ over the nodes.
fn node_mean(table: &[f32; NODES]) -> f32 {
    2.0 * (0..NODES).map(|i| table[i] * node(i)).sum::<f32>() / NODES as f32
}
