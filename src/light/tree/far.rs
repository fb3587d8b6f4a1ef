//! Lights at infinity.

use glam::Vec3;

/// A light at infinity, as the tree sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarLight {
    /// Unit, to the middle of the light; zero for light from all around.
    pub axis: Vec3,
    /// Angle between the middle and the edge, at most a right one.
    pub size: f64,
    /// Luminance of the irradiance on a surface that faces the light; of light from all around ∫ L dω.
    pub irradiance: f64,
}

impl FarLight {
    /// Light from all around.
    pub fn around(integral: f64) -> FarLight {
        FarLight { axis: Vec3::ZERO, size: 0.0, irradiance: integral }
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
            return self.irradiance * if oriented { OF_AROUND } else { 2.0 * OF_AROUND };
        }
        if !oriented {
            return self.irradiance;
        }
        let cos = self.axis.dot(n);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let received = if cos < self.cos_size { cos * self.cos_size + sin * self.sin_size } else { 1.0 };
        self.irradiance * received.max(0.0)
    }
}
