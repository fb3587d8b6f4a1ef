//! The principled model's second, clear coat.

use super::super::fresnel;
use super::super::microfacet::Microfacet;
use super::super::microfacet::MicrofacetDistribution::Ggx;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// The clear coat: Burley's GTR1 distribution, Schlick's Fresnel from 0.04, shadowing as of GGX with alpha 0.25.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearcoat {
    pub(super) alpha: f32,
}

impl Clearcoat {
    #[inline(always)]
    pub(super) fn fresnel(cos: f32) -> f32 {
        0.04 + 0.96 * fresnel::schlick_weight(cos)
    }

    /// F·D·G·cosθi/4: Burley's lobe has no 1/(4 cosθo cosθi).
    #[inline(always)]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
        let shadowing = Microfacet::new(Ggx, 0.25);
        let g = shadowing.g1(wo) * shadowing.g1(wi);
        0.25 * Clearcoat::fresnel(wo.dot(m)) * self.d(m) * g * wi.z
    }

    /// D(m) = (α² − 1)/(π ln α² (1 + (α² − 1) cos²θm)); ∫D cosθm dωm = 1 (Burley 2012, appendix B).
    #[inline(always)]
    fn d(&self, m: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        // 1 + (α² − 1) cos² without cancellation near the pole
        let t = m.x * m.x + m.y * m.y + a2 * m.z * m.z;
        (a2 - 1.0) * FRAC_1_PI / (a2.ln() * t)
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3 {
        let a2 = self.alpha * self.alpha;
        let cos2 = ((1.0 - a2.powf(1.0 - u[0])) / (1.0 - a2)).clamp(0.0, 1.0);
        let (sin, (sin_phi, cos_phi)) = ((1.0 - cos2).sqrt(), (TAU * u[1]).sin_cos());
        Vec3::new(sin * cos_phi, sin * sin_phi, cos2.sqrt())
    }

    /// Density of wi when m is drawn by [`Self::sample`] and wo mirrored at it.
    #[inline(always)]
    pub(super) fn pdf(&self, wo: Vec3, m: Vec3) -> f32 {
        0.25 * self.d(m) * m.z / wo.dot(m)
    }
}
