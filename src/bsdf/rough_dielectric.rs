//! Frosted glass (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces").

use super::dielectric::relative_index;
use super::microfacet::Microfacet;
use super::model::Prepared;
use super::rough_conductor::reflection_pdf;
use super::{BLACK, BsdfSample, Scatter, choice, fresnel, mirrored};
use crate::math::Rgb;
use glam::Vec3;

/// A rough interface; `eta` is the index below the surface over that above, not 1 (where the half-vector of
/// refraction is undefined). Light that facets send to each other is lost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughDielectric {
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
    pub microfacet: Microfacet,
}

impl Prepared for RoughDielectric {
    type At<'s> = RoughDielectric;

    #[inline(always)]
    fn at(&self, _: [Rgb; 2]) -> RoughDielectric {
        *self
    }
}

impl RoughDielectric {
    /// What a facet met at cosine `cos` reflects and lets through.
    fn split(&self, cos: f32, eta: f32) -> (Rgb, Rgb) {
        let (f, _) = fresnel::dielectric(cos, eta);
        (f * self.reflectance, (1.0 - f) * self.transmittance)
    }

    /// Reflection; both directions on the side of wo.z > 0.
    fn eval_reflection(&self, wo: Vec3, wi: Vec3, eta: f32) -> (Rgb, f32) {
        let Some((m, pdf)) = reflection_pdf(&self.microfacet, wo, wi) else { return BLACK };
        let (reflected, transmitted) = self.split(wo.dot(m), eta);
        let Some(p) = choice(reflected, transmitted) else { return BLACK };
        (reflected * (pdf * self.microfacet.g1(wi)), p * pdf)
    }

    /// Refraction (eq. 21) from wo.z > 0 to wi.z < 0; dωm/dωi = η²|wi·m|/(wo·m + η wi·m)² (eq. 17).
    fn eval_refraction(&self, wo: Vec3, wi: Vec3, eta: f32) -> (Rgb, f32) {
        let h = wo + eta * wi;
        let Some(m) = h.try_normalize().map(|m| if m.z < 0.0 { -m } else { m }) else {
            return BLACK;
        };
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        if cos_o <= 0.0 || cos_i >= 0.0 || m.z == 0.0 {
            return BLACK;
        }
        let (reflected, transmitted) = self.split(cos_o, eta);
        let Some(p) = choice(reflected, transmitted) else { return BLACK };
        let jacobian = eta * eta * -cos_i / h.length_squared();
        let pdf = self.microfacet.visible_pdf(wo, m) * jacobian;
        (transmitted * (pdf * self.microfacet.g1(wi) / (eta * eta)), (1.0 - p) * pdf)
    }
}

impl Scatter for RoughDielectric {
    const SMOOTH: bool = true;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z == 0.0 || wi.z == 0.0 {
            return BLACK;
        }
        // seen from below, the surface is its mirror image with the indices exchanged
        let eta = relative_index(self.eta, wo);
        let (wo, wi) = if wo.z < 0.0 { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        if wi.z > 0.0 { self.eval_reflection(wo, wi, eta) } else { self.eval_refraction(wo, wi, eta) }
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let eta = relative_index(self.eta, wo);
        let up = if wo.z < 0.0 { mirrored(wo) } else { wo };
        let m = self.microfacet.sample_visible(up, u);
        let cos = up.dot(m);
        let (reflected, transmitted) = self.split(cos, eta);
        let p = choice(reflected, transmitted)?;
        let (wi, eta) = if u_lobe < p {
            (fresnel::reflect(up, m), 1.0)
        } else {
            let (_, cos_t) = fresnel::dielectric(cos, eta);
            (fresnel::refract(up, m, cos_t, eta), eta)
        };
        if cos <= 0.0 || (wi.z > 0.0) != (u_lobe < p) {
            return None;
        }
        let wi = if wo.z < 0.0 { mirrored(wi) } else { wi }.normalize();
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), eta)
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        let (reflected, transmitted) = self.split(wo.z.abs(), relative_index(self.eta, wo));
        reflected + transmitted
    }

    fn roughness(&self) -> f32 {
        self.microfacet.alpha()
    }
}
