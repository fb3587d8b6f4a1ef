//! A diffuse base under a smooth dielectric coat.

use super::{BLACK, BsdfSample, DIFFUSE, Scatter, choice, fresnel};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use glam::Vec3;

/// The coat, computed once per material.
#[derive(Clone, Copy, Debug)]
pub struct SmoothCoat {
    /// Index of the coat over that of the air.
    pub eta: f32,
    /// 2∫(1 − F)µ dµ: share of diffuse light that enters.
    pub mean_transmittance: f32,
    /// 2∫F µ dµ from inside: share of what the base reflects that the coat sends back to it.
    pub internal_reflectance: f32,
}

impl SmoothCoat {
    pub fn new(eta: f32) -> SmoothCoat {
        SmoothCoat {
            eta,
            mean_transmittance: 1.0 - fresnel::diffuse_reflectance(eta),
            internal_reflectance: fresnel::diffuse_reflectance(1.0 / eta),
        }
    }
}

/// What a Lambertian base of reflectance R under a coat makes of light that has entered, times the 1/η² of its
/// way out: R/((1 − R·ρ)η²) with ρ the `internal` reflectance of the coat. With `nonlinear` false the colours of
/// textures are kept: R/((1 − ρ)η²).
#[inline]
pub(super) fn base_under_coat(reflectance: Rgb, internal: f32, eta: f32, nonlinear: bool) -> Rgb {
    let returned = if nonlinear { reflectance * internal } else { Rgb::splat(internal) };
    reflectance / ((Rgb::ONE - returned) * (eta * eta))
}

/// A delta reflection F and a base T(cosθo)·T(cosθi)·base/π with T = 1 − F.
#[derive(Clone, Copy, Debug)]
pub struct Plastic {
    /// As [`base_under_coat`] gives it.
    pub base: Rgb,
    /// Times the coat's reflection.
    pub specular: Rgb,
    pub coat: SmoothCoat,
}

impl Plastic {
    /// Albedos from wo: of the coat, and of the base.
    fn albedos(&self, wo: Vec3) -> (Rgb, Rgb) {
        let (f, _) = fresnel::dielectric(wo.z, self.coat.eta);
        (f * self.specular, ((1.0 - f) * self.coat.mean_transmittance) * self.base)
    }
}

impl Scatter for Plastic {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return BLACK;
        }
        let (coat, base) = self.albedos(wo);
        let Some(p) = choice(coat, base) else { return BLACK };
        let t_o = 1.0 - fresnel::dielectric(wo.z, self.coat.eta).0;
        let t_i = 1.0 - fresnel::dielectric(wi.z, self.coat.eta).0;
        let cosine = square_to_cosine_hemisphere_pdf(wi);
        (self.base * (t_o * t_i * cosine), (1.0 - p) * cosine)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (coat, base) = self.albedos(wo);
        let p = choice(coat, base)?;
        if u_lobe < p {
            return BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), coat, p, 1.0);
        }
        let wi = square_to_cosine_hemisphere(u);
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 {
            return Rgb::ZERO;
        }
        let (coat, base) = self.albedos(wo);
        coat + base
    }

    fn roughness(&self) -> f32 {
        DIFFUSE
    }

    /// That of the coat, which is a delta lobe.
    fn sharp_probability(&self, wo: Vec3, _alpha: f32) -> f32 {
        if wo.z <= 0.0 {
            return 1.0;
        }
        let (coat, base) = self.albedos(wo);
        choice(coat, base).unwrap_or(1.0)
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 { Rgb::ZERO } else { self.albedos(wo).1 }
    }
}
