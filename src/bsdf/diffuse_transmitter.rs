//! Leaves and paper: Lambertian on both sides.

use super::{BLACK, BsdfSample, DIFFUSE, Scatter, choice};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use glam::Vec3;

/// f = reflectance/π on the side of wo, transmittance/π on the other.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmitter {
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl Scatter for DiffuseTransmitter {
    const SMOOTH: bool = true;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(reflect) = choice(self.reflectance, self.transmittance) else { return BLACK };
        let cosine = square_to_cosine_hemisphere_pdf(wi.abs());
        if wo.z * wi.z > 0.0 {
            (self.reflectance * cosine, reflect * cosine)
        } else if wo.z * wi.z < 0.0 {
            (self.transmittance * cosine, (1.0 - reflect) * cosine)
        } else {
            BLACK
        }
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let reflect = choice(self.reflectance, self.transmittance)?;
        let mut wi = square_to_cosine_hemisphere(u);
        if (wo.z < 0.0) == (u_lobe < reflect) {
            wi.z = -wi.z;
        }
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    fn albedo(&self, _wo: Vec3) -> Rgb {
        self.reflectance + self.transmittance
    }

    fn roughness(&self) -> f32 {
        DIFFUSE
    }
}
