//! Lights at infinity.

use super::node::{less, sine};
use crate::simd::pick;
use glam::Vec3;

/// A light at infinity, as the tree sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarLight {
    /// Unit, to the middle of the light; zero for light from all around.
    pub axis: Vec3,
    /// Angle between the middle and the edge, at most a right one.
    pub size: f64,
    /// Luminance of the irradiance on a surface that faces the light; of light from all around, of that which directions
    /// drawn by the surface itself find badly, as ∫ L dω.
    pub irradiance: f64,
}

/// Share of light from all around that counts even where it is the same everywhere.
const DEFENSIVE: f64 = 0.1;

impl FarLight {
    /// Light from all around, ∫ L dω, of which `excess` is brighter than the mean. The mean is what directions that are drawn
    /// without regard to lights find as well: by multiple importance sampling, samples of it are better spent on other lights
    /// (Karlík et al. 2019, "MIS Compensation").
    pub fn around(integral: f64, excess: f64) -> FarLight {
        FarLight { axis: Vec3::ZERO, size: 0.0, irradiance: excess.max(DEFENSIVE * integral) }
    }
}

/// The same, ready to be weighed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Far {
    axis: Vec3,
    sin_size: f32,
    cos_size: f32,
    irradiance: f32,
}

/// By how much rounding may make angles too small.
const ANGLE_ERROR: f64 = 1.0 / 1024.0;

/// Share of light from all around that a side of a surface receives on average.
const OF_AROUND: f32 = 0.25;

impl Far {
    /// `unit`: of irradiances.
    pub fn new(light: &FarLight, unit: f64) -> Far {
        let size = light.size + ANGLE_ERROR;
        let irradiance = ((light.irradiance / unit) as f32).max(f32::MIN_POSITIVE);
        Far { axis: light.axis, sin_size: size.sin() as f32, cos_size: size.cos() as f32, irradiance }
    }

    /// An estimate of the irradiance on a surface with the normal `n`; 0 only where the light is behind it. Where `n` is
    /// zero, both sides count.
    #[inline(always)]
    pub fn importance(&self, n: Vec3) -> f32 {
        let oriented = n != Vec3::ZERO;
        if self.axis == Vec3::ZERO {
            return self.irradiance * pick(oriented, OF_AROUND, 2.0 * OF_AROUND);
        }
        let cos = self.axis.dot(n);
        let received = less(cos, sine(cos), self.cos_size, self.sin_size);
        self.irradiance * pick(oriented, pick(received > 0.0, received, 0.0), 1.0)
    }
}
