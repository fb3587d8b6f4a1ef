//! Rays, and where they meet triangles: one by one, and sixteen side by side.

use crate::simd::LANES;
use glam::Vec3;

/// A ray from `org` along the unit direction `dir`, for 0 < t < `tfar`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub(crate) org: Vec3,
    pub(crate) dir: Vec3,
    pub(crate) tfar: f32,
}

/// In place of a geometry where a ray met nothing, and of an instance where there is none.
pub const NOTHING: u32 = u32::MAX;

/// What a packet of rays met, component by component. A lane whose ray met nothing holds any numbers.
pub struct HitRows<'a> {
    pub(crate) dir: [&'a [f32; LANES]; 3],
    pub(crate) ng: [&'a [f32; LANES]; 3],
    /// As [`Hit::u`] and [`Hit::v`].
    pub(crate) weights: [&'a [f32; LANES]; 2],
    /// As [`Hit::geometry`]; [`NOTHING`] where nothing was met.
    pub(crate) geometry: &'a [u32; LANES],
    pub(crate) primitive: &'a [u32; LANES],
    /// As [`Hit::instance`]; [`NOTHING`] where the mesh belongs to the scene itself.
    pub(crate) instance: &'a [u32; LANES],
}

/// Rays of a packet, component by component.
pub struct RayRows<'a> {
    pub(crate) org: [&'a [f32; LANES]; 3],
    pub(crate) dir: [&'a [f32; LANES]; 3],
    pub(crate) tfar: &'a [f32; LANES],
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f32,
    /// Barycentric weights of the triangle's second and third corner.
    pub u: f32,
    pub v: f32,
    /// Geometric normal by the triangle's winding; not normalised, in the geometry's own space.
    pub ng: Vec3,
    pub primitive: u32,
    /// As returned when the mesh was added to its scene.
    pub geometry: u32,
    /// As returned when the instance was added; `u32::MAX` where the mesh belongs to the scene itself.
    pub instance: u32,
}
