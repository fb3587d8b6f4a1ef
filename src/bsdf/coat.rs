//! What a rough dielectric coat reflects and lets through, tabulated per (η, roughness, distribution).

use super::fresnel;
use super::microfacet::Microfacet;
use crate::bsdf::MicrofacetDistribution;
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// Nodes of the tables, equidistant in cosθ from 0 to 1.
const NODES: usize = 64;
/// Points of the quadrature over visible normals: half the turn (the other half is its mirror image) × radius.
const POINTS: [usize; 2] = [24, 64];

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

    pub fn microfacet(&self) -> &Microfacet {
        &self.microfacet
    }

    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// Share of light at cosine `cos` ≥ 0 that enters.
    #[inline]
    pub fn transmittance(&self, cos: f32) -> f32 {
        interpolate(&self.transmittance, cos)
    }

    /// Share of light at cosine `cos` ≥ 0 that is reflected; with [`Self::transmittance`] at most 1.
    #[inline]
    pub fn reflectance(&self, cos: f32) -> f32 {
        interpolate(&self.reflectance, cos)
    }

    /// Cosine-weighted mean of [`Self::transmittance`].
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

/// Builds each table once.
#[derive(Debug, Default)]
pub struct CoatTables(HashMap<(u32, u32, bool, bool), Arc<CoatTable>>);

impl CoatTables {
    /// [`CoatTable::conserving`] or [`CoatTable::new`].
    pub(crate) fn get(
        &mut self,
        eta: f32,
        alpha: f32,
        kind: MicrofacetDistribution,
        conserving: bool,
    ) -> Arc<CoatTable> {
        let key = (eta.to_bits(), alpha.to_bits(), kind == MicrofacetDistribution::Ggx, conserving);
        let build = if conserving { CoatTable::conserving } else { CoatTable::new };
        self.0.entry(key).or_insert_with(|| Arc::new(build(eta, Microfacet::new(kind, alpha)))).clone()
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
    for (u0, w0) in points(POINTS[0]) {
        for (u1, w1) in points(POINTS[1]) {
            let m = microfacet.sample_visible(wo, [0.5 * u0, u1]);
            let (f, cos_t) = fresnel::dielectric(wo.dot(m).max(0.0), eta);
            let (r, t) = (fresnel::reflect(wo, m), fresnel::refract(wo, m, cos_t, eta));
            let weight = w0 * w1;
            reflected += if r.z > 0.0 { weight * f * microfacet.g1(r) } else { 0.0 };
            transmitted += if t.z < 0.0 { weight * (1.0 - f) * microfacet.g1(t) } else { 0.0 };
        }
    }
    Albedos { reflected, transmitted }
}

/// Points and weights on [0, 1]: midpoints in s with u = s²(3 − 2s), dense at both ends, where normals are extreme.
fn points(n: usize) -> impl Iterator<Item = (f32, f32)> {
    let n = n as f32;
    // the weights 6s(1 − s)/n sum to this much
    let sum = 1.0 + 0.5 / (n * n);
    (0..n as usize).map(move |i| {
        let s = (i as f32 + 0.5) / n;
        (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / (n * sum))
    })
}

/// Cosine of a node; the first is moved off the horizon.
fn node(i: usize) -> f32 {
    (i as f32 / (NODES - 1) as f32).max(1e-6)
}

#[inline]
fn interpolate(table: &[f32; NODES], cos: f32) -> f32 {
    let x = cos.clamp(0.0, 1.0) * (NODES - 1) as f32;
    let i = (x as usize).min(NODES - 2);
    let t = x - i as f32;
    table[i] + t * (table[i + 1] - table[i])
}

/// 2∫f(µ)µ dµ of the interpolated table, exactly.
fn cosine_mean(table: &[f32; NODES]) -> f32 {
    let step = 1.0 / (NODES - 1) as f32;
    let piece = |i: usize| {
        let (a, b, x) = (table[i], table[i + 1], i as f32);
        (3.0 * x * (a + b) + a + 2.0 * b) / 3.0
    };
    (0..NODES - 1).map(piece).sum::<f32>() * step * step
}

/// Twice the mean of f(µ)µ over the nodes.
fn node_mean(table: &[f32; NODES]) -> f32 {
    2.0 * (0..NODES).map(|i| table[i] * node(i)).sum::<f32>() / NODES as f32
}
