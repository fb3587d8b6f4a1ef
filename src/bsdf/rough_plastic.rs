//! A diffuse base under a rough dielectric coat.

use super::coat::CoatTable;
use super::microfacet::{Microfacet, sin_cos_turn};
use super::model::Prepared;
use super::plastic::base_under_coat;
use super::rough_conductor::{reflection_pdf, sample_reflection};
use super::{BLACK, BsdfSample, Gloss, Scatter, choice, fresnel};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use glam::Vec3;
use std::sync::Arc;

/// A rough coat; the base may vary from place to place.
#[derive(Clone, Debug)]
pub(crate) struct RoughPlasticModel {
    pub(super) coat: Arc<CoatTable>,
    pub(super) specular: Rgb,
    pub(super) nonlinear: bool,
}

impl Prepared for RoughPlasticModel {
    type At<'s> = RoughPlastic<'s>;

    #[inline(always)]
    fn colors(&self, [reflectance, other]: [Rgb; 2]) -> [Rgb; 2] {
        [base_under_coat(reflectance, self.coat.internal_reflectance(), self.coat.eta(), self.nonlinear), other]
    }

    #[inline(always)]
    fn at(&self, [base, _]: [Rgb; 2]) -> RoughPlastic<'_> {
        RoughPlastic { base, specular: self.specular, coat: &self.coat, microfacet: *self.coat.microfacet() }
    }
}

/// A microfacet reflection and a base T(cosθo)·T(cosθi)·base/π, T what enters a rough coat at all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughPlastic<'s> {
    /// As `base_under_coat` gives it.
    pub base: Rgb,
    /// Times the coat's reflection.
    pub specular: Rgb,
    pub coat: &'s CoatTable,
    /// Of the coat.
    microfacet: Microfacet,
}

impl RoughPlastic<'_> {
    /// Albedos from wo: of the coat, and of the base.
    #[inline(always)]
    fn albedos(&self, wo: Vec3) -> (Rgb, Rgb) {
        let entering = self.coat.transmittance(wo.z) * self.coat.mean_transmittance();
        (self.coat.reflectance(wo.z) * self.specular, entering * self.base)
    }

    /// The direction of [`Scatter::sample`]; `turn` as of [`Microfacet::sample_visible_with`].
    #[inline(always)]
    fn draw(&self, wo: Vec3, u_lobe: f32, u: [f32; 2], turn: impl Fn() -> (f32, f32)) -> Option<Vec3> {
        if wo.z <= 0.0 {
            return None;
        }
        let (coat, base) = self.albedos(wo);
        if u_lobe < choice(coat, base)? {
            sample_reflection(&self.microfacet, wo, u, turn)
        } else {
            Some(square_to_cosine_hemisphere(u))
        }
    }

    /// The base's share of `eval_pdf`.
    fn eval_pdf_base(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return BLACK;
        }
        let (coat, base) = self.albedos(wo);
        let Some(p) = choice(coat, base) else { return BLACK };
        let cosine = square_to_cosine_hemisphere_pdf(wi);
        let t = self.coat.transmittance(wo.z) * self.coat.transmittance(wi.z);
        (self.base * (t * cosine), (1.0 - p) * cosine)
    }
}

impl Scatter for RoughPlastic<'_> {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let microfacet = &self.microfacet;
        let Some((m, coat_pdf)) = reflection_pdf(microfacet, wo, wi) else { return BLACK };
        let (coat, base) = self.albedos(wo);
        let Some(p) = choice(coat, base) else { return BLACK };
        let (f, _) = fresnel::dielectric(wo.dot(m), self.coat.eta());
        let cosine = square_to_cosine_hemisphere_pdf(wi);
        let t = self.coat.transmittance(wo.z) * self.coat.transmittance(wi.z);
        let value = self.specular * (f * coat_pdf * microfacet.g1(wi)) + self.base * (t * cosine);
        (value, p * coat_pdf + (1.0 - p) * cosine)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = self.draw(wo, u_lobe, u, || sin_cos_turn(u[0]))?;
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 {
            return Rgb::ZERO;
        }
        let (coat, base) = self.albedos(wo);
        coat + base
    }

    fn roughness(&self) -> f32 {
        self.microfacet.alpha()
    }

    fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        if wo.z <= 0.0 {
            return 1.0;
        }
        let (coat, base) = self.albedos(wo);
        choice(coat, base).map_or(1.0, |p| if self.roughness() < alpha { p } else { 0.0 })
    }

    fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        if self.roughness() < alpha { self.eval_pdf_base(wo, wi) } else { self.eval_pdf(wo, wi) }
    }

    fn gloss(&self, wo: Vec3) -> Option<Gloss> {
        let (coat, base) = self.albedos(wo);
        Gloss::new(self.roughness(), coat, base)
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 { Rgb::ZERO } else { self.albedos(wo).1 }
    }
}
