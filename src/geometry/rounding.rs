//! How far rounding may put a point beside the plane of its triangle, and how far Embree's test may put the plane beside
//! the point. Rays start further away than both together, and no further: what is nearer to a surface than that is lost.
//!
//! With u = 2⁻²⁴, half of what separates 1 from the next number, and first-order terms only (Higham 2002, §3; Pharr,
//! Jakob and Humphreys 2023, §6.8):
//!
//! - The point p = a + (e₁·u + e₂·v), with e₁ = b − a and e₂ = c − a, is wrong by at most u·|p| + 3u·m in each coordinate,
//!   where m = |e₁·u| + |e₂·v|. It is nearer than a sum of weighted corners: what is large, the place of the triangle,
//!   rounds once. Moving it off the surface rounds once more, by u·|p|.
//! - Embree decides by the sign of Ng·(a − o) whether a ray from o meets the plane in front of it, where Ng = e₁ × e₂. Each
//!   coordinate of Ng is wrong by at most 4u·X, with X the cross product in which all terms count as positive, that of a − o
//!   by u·|a − o|, and the sum of products by 3u. For o near p, |a − o| ≤ m, and |Ng| ≤ X: all together 8u·X·m, which is a
//!   distance of 8u·X·m/|Ng|.
//!
//! Only what lies across the plane counts: a point that is wrong within the plane still is a point of the triangle.

use glam::Vec3;

/// Half of what separates 1 from the next number: no single operation is wrong by more, relative to its result.
pub(crate) const ROUNDING: f32 = f32::EPSILON / 2.0;

/// Of the coordinates of a point, in units of [`ROUNDING`]: one for the point, one for the ray's origin.
const OF_PLACE: f32 = 2.0;

/// Of X·m/|Ng|, in units of [`ROUNDING`]: 8 for Embree's test, 3 for the point, which are no more than 3·|n|·m.
const OF_TRIANGLE: f32 = 11.0;

/// X/|Ng| counts as no more than this. It is 1 for right angles and as large as the triangle is longer than it is high:
/// where the normal of a sliver is mostly rounding, rays would start far beyond what is next to it.
const THINNEST: f32 = 1024.0;

/// X/|Ng|: the cross product of the edges in which all terms count as positive, what the rounding of their cross product is
/// relative to, by the length of that. `per_length`: 1/|e₁ × e₂|.
#[inline(always)]
pub(crate) fn thinness([a, b]: [Vec3; 2], per_length: f32) -> Vec3 {
    let (a, b) = (a.abs(), b.abs());
    let sizes = Vec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x);
    (sizes * per_length).min(Vec3::splat(THINNEST))
}

/// How far across its plane, at most, a point of a triangle and Embree's idea of the triangle are apart. `size` is m, as
/// above, and `per_length` 1/|e₁ × e₂|, or 0 where that is not known. Without a jump, so that loops run in vectors.
///
/// It is never 0: where all of the above cancels, in planes like y = 0, it is one rounding of the triangle's size.
#[inline(always)]
pub(crate) fn across(edges: [Vec3; 2], p: Vec3, size: Vec3, ng: Vec3, per_length: f32) -> f32 {
    let extent = (edges[0].abs() + edges[1].abs()).max_element();
    (OF_PLACE * ng.abs().dot(p.abs()) + OF_TRIANGLE * thinness(edges, per_length).dot(size) + extent) * ROUNDING
}

/// The unit vector along `v`, and 1 over the length of `v`; zeros where it has no direction. Squares of its coordinates
/// may be beyond an `f32`: they are divided by the largest first. Without a jump.
#[inline(always)]
pub(crate) fn unit(v: Vec3) -> (Vec3, f32) {
    let per_largest = 1.0 / v.abs().max_element();
    let v = v * per_largest;
    let per_length = v.length_recip();
    // neither without a number nor without a length: those of 0 and of infinity are NaN here
    let usable = per_length > 0.0;
    let (unit, per_length) = (v * per_length, per_length * per_largest);
    (if usable { unit } else { Vec3::ZERO }, if usable { per_length } else { 0.0 })
}

#[cfg(test)]
#[path = "rounding_tests.rs"]
mod tests;
