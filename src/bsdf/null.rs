//! No surface at all.

use super::{BLACK, BsdfSample, Scatter};
use crate::math::Rgb;
use glam::Vec3;

/// Lets everything pass straight through.
#[derive(Clone, Copy, Debug)]
pub struct Null;

impl Scatter for Null {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        BsdfSample::delta(-wo, Rgb::ONE, 1.0, 1.0)
    }

    fn albedo(&self, _wo: Vec3) -> Rgb {
        Rgb::ONE
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
