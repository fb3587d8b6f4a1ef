//! Polished metal.

use super::rough_conductor::Metal;
use super::{BLACK, BsdfSample, Scatter};
use crate::math::Rgb;
use glam::Vec3;

/// A perfect mirror of Fresnel reflectance times `reflectance`.
#[derive(Clone, Copy, Debug)]
pub struct Mirror {
    pub metal: Metal,
    pub reflectance: Rgb,
}

impl Scatter for Mirror {
    const SMOOTH: bool = false;
    const OPAQUE: bool = true;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        let value = self.albedo(wo);
        if wo.z > 0.0 { BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), value, 1.0, 1.0) } else { None }
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.reflectance * self.metal.fresnel(wo.z) } else { Rgb::ZERO }
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
