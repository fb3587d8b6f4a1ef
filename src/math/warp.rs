//! Warps from the unit square to directions and disks, each with its density and, where it is used, its inverse.
//!
//! Directions are unit vectors in the local frame (z up); densities are per steradian unless said otherwise.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

/// Unit disk by Shirley & Chiu's concentric map (1997, "A Low Distortion Map Between Disk and Square"):
/// equal areas stay equal, neighbours stay neighbours.
#[inline(always)]
pub fn square_to_disk(u: [f32; 2]) -> Vec2 {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    // the angle from the nearer axis: there short polynomials do, without a call; and choices instead of jumps, which
    // would be guessed wrong every other time
    let wide = x * x > y * y;
    let (major, minor) = if wide { (x, y) } else { (y, x) };
    let ratio = if major == 0.0 { 0.0 } else { minor / major };
    let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * ratio);
    if wide { Vec2::new(major * cos, major * sin) } else { Vec2::new(major * sin, major * cos) }
}

/// Sine and cosine on [−π/4, π/4] to 10⁻⁷ in single precision, by the polynomials of Moshier's Cephes library (1989,
/// `sinf`, `cosf`).
#[inline(always)]
fn sin_cos_eighth(x: f32) -> (f32, f32) {
    let s = x * x;
    let sin = (-1.951_529_6e-4 * s + 8.332_161e-3) * s - 1.666_665_5e-1;
    let cos = (2.443_315_7e-5 * s - 1.388_731_6e-3) * s + 4.166_664_6e-2;
    (x + x * s * sin, 1.0 - 0.5 * s + s * s * cos)
}

/// The point of the unit square that [`square_to_disk`] sends to `p`; every component in [0, 1).
#[inline(always)]
pub(crate) fn disk_to_square(p: Vec2) -> [f32; 2] {
    let r = p.length();
    let (ax, ay) = (p.x.abs(), p.y.abs());
    // choices and no jumps, as above
    let wide = ax > ay;
    let (long, short) = if wide { (ax, ay) } else { (ay, ax) };
    let ratio = if long > 0.0 { short / long } else { 0.0 };
    // angle from the nearer axis, in [0, π/4]
    let minor = r * atan_unit(ratio) / FRAC_PI_4;
    let (x, y) = if wide { (r, minor) } else { (minor, r) };
    let (x, y) = (x.copysign(p.x), y.copysign(p.y));
    let to_unit = |v: f32| (0.5 * (v + 1.0)).clamp(0.0, super::ONE_MINUS_EPSILON);
    [to_unit(x), to_unit(y)]
}

/// atan on [0, 1] to 2·10⁻⁷ in single precision (Abramowitz & Stegun 1964, eq. 4.4.49): the table look-ups need no more.
#[inline(always)]
pub(crate) fn atan_unit(t: f32) -> f32 {
    let s = t * t;
    let p = 0.002_866_225_7;
    let p = p * s - 0.016_165_737;
    let p = p * s + 0.042_909_615;
    let p = p * s - 0.075_289_64;
    let p = p * s + 0.106_562_64;
    let p = p * s - 0.142_089;
    let p = p * s + 0.199_935_51;
    let p = p * s - 0.333_331_47;
    t + t * s * p
}

/// Cosine-weighted hemisphere about +z (Malley's method).
#[inline(always)]
pub fn square_to_cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let d = square_to_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`square_to_cosine_hemisphere`]: cosθ/π above the horizon, else 0.
#[inline(always)]
pub(crate) fn square_to_cosine_hemisphere_pdf(w: Vec3) -> f32 {
    w.z.max(0.0) * FRAC_1_PI
}

/// Uniform hemisphere about +z, equal-area and concentric: strata of the square become compact strata of
/// equal solid angle.
#[inline(always)]
pub fn square_to_uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    let d = square_to_disk(u);
    let r2 = d.length_squared();
    // |xy| = r√(2 − r²) and z = 1 − r² keep area: dz = 2r dr
    (d * (2.0 - r2).max(0.0).sqrt()).extend(1.0 - r2)
}

/// Density of [`square_to_uniform_hemisphere`]: 1/2π above the horizon, else 0.
#[cfg(test)]
pub(crate) fn square_to_uniform_hemisphere_pdf(w: Vec3) -> f32 {
    if w.z >= 0.0 { 0.5 * FRAC_1_PI } else { 0.0 }
}

/// Inverse of [`square_to_uniform_hemisphere`]; a direction below the horizon maps like its mirror image above.
#[inline(always)]
pub fn uniform_hemisphere_to_square(w: Vec3) -> [f32; 2] {
    let r2 = 1.0 - w.z.abs();
    let scale = 1.0 / (2.0 - r2).max(1e-12).sqrt();
    disk_to_square(w.truncate() * scale)
}

/// Uniform triangle: barycentric weights (of vertices 1 and 2); density 2 in that plane.
#[inline]
pub fn square_to_triangle(u: [f32; 2]) -> [f32; 2] {
    let s = u[0].sqrt();
    [1.0 - s, u[1] * s]
}

/// The numbers of which [`square_to_triangle`] makes these weights, each in [0, 1).
#[inline]
pub(crate) fn triangle_to_square(weights: [f32; 2]) -> [f32; 2] {
    let s = 1.0 - weights[0];
    let along = if s > 0.0 { weights[1] / s } else { 0.0 };
    [s * s, along].map(|x| x.clamp(0.0, super::ONE_MINUS_EPSILON))
}

/// Uniform sphere: z and azimuth.
#[inline]
pub fn square_to_uniform_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(r * cos, r * sin, z)
}

/// Density of [`square_to_uniform_sphere`]: 1/4π.
pub(crate) const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;
