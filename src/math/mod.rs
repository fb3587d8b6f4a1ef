//! Numbers: colours, warps from the unit square, random numbers, discrete distributions, numbers side by side.

pub mod alias;
pub(crate) mod fixed;
mod frame;
pub(crate) mod hash;
pub mod rng;
pub(crate) mod sobol;
pub mod warp;

pub use frame::Frame;

use glam::Vec3;

/// Linear RGB with sRGB primaries: radiance (W/(sr·m²)), reflectance or weight.
pub type Rgb = Vec3;

/// The luminance of each channel.
pub(crate) const LUMINANCE: Rgb = Rgb::new(0.2126, 0.7152, 0.0722);

/// Luminance of linear sRGB (ITU-R BT.709): what the guide learns, being one number per direction.
#[inline(always)]
pub fn luminance(c: Rgb) -> f32 {
    LUMINANCE.x * c.x + LUMINANCE.y * c.y + LUMINANCE.z * c.z
}

/// Whether a number can be a sum of light or of visits: finite and not negative.
pub(crate) fn is_amount(x: f64) -> bool {
    x >= 0.0 && x.is_finite()
}

/// The largest `f32` below 1: random numbers stay in [0, 1).
pub(crate) const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// The largest `f64` below 1.
pub(crate) const ONE_MINUS_EPSILON_F64: f64 = 1.0 - f64::EPSILON / 2.0;

#[cfg(test)]
mod tests;
