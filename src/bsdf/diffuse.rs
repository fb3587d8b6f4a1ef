//! Lambert's law.

use super::{BLACK, BsdfSample, Scatter};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use glam::Vec3;

/// f = reflectance/π above the horizon.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    pub reflectance: Rgb,
}

impl Scatter for Diffuse {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 {
            return BLACK;
        }
        let pdf = square_to_cosine_hemisphere_pdf(wi);
        (self.reflectance * pdf, pdf)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = square_to_cosine_hemisphere(u);
        let pdf = square_to_cosine_hemisphere_pdf(wi);
        (wo.z > 0.0 && pdf > 0.0).then_some(BsdfSample { wi, weight: self.reflectance, pdf, delta: false, eta: 1.0 })
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.reflectance } else { Rgb::ZERO }
    }

    fn roughness(&self) -> f32 {
        1.0
    }
}
