//! What is known of the point where a ray met a surface.

use super::rounding::{across, unit};
use super::{Mesh, Placement};
use crate::geometry::Hit;
use crate::math::Frame;
use crate::simd::normalize_or;
use glam::Vec3;

/// A point on a surface, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    pub p: Vec3,
    /// Unit normal of the triangle, on the same side as the shading normal.
    pub(crate) ng: Vec3,
    /// Shading frame; its `n` is the interpolated normal where the mesh has one.
    pub frame: Frame,
    /// Whether the ray came from the side from which the triangle's corners run counter-clockwise.
    pub(crate) front: bool,
    pub uv: [f32; 2],
    pub(crate) material: u32,
    /// How far rays start from the surface: as far as rounding may put `p` and the surface apart ([`rounding`]).
    ///
    /// [`rounding`]: super::rounding
    pub(super) offset: f32,
}

impl SurfaceInteraction {
    /// The point of `hit` on `mesh`, met by a ray that leaves towards `wo`.
    #[inline]
    pub fn new(mesh: &Mesh, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        Facet::of(mesh, hit, wo).point().on(mesh, hit)
    }

    /// The point of `hit` on an instance of `mesh`. It is what the same hit on a copy of the mesh in the world would
    /// give: corners and normals are moved first and interpolated then.
    pub(crate) fn placed(mesh: &Mesh, placement: &Placement, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        Facet::placed(mesh, placement, hit, wo).point().on(mesh, hit)
    }

    /// Where a ray towards the unit direction `w` starts.
    #[inline]
    pub(crate) fn spawn(&self, w: Vec3) -> Vec3 {
        self.p + self.ng * self.offset.copysign(w.dot(self.ng))
    }

    /// The shading normal on the side of `w`.
    #[inline]
    pub(crate) fn facing(&self, w: Vec3) -> Vec3 {
        if w.dot(self.frame.n) < 0.0 { -self.frame.n } else { self.frame.n }
    }

    /// Whether the shading normal and the triangle agree on which side `w` is. Where they do not, light would
    /// leak through the surface.
    #[inline]
    pub(crate) fn consistent(&self, w: Vec3) -> bool {
        w.dot(self.ng) * w.dot(self.frame.n) > 0.0
    }
}

/// A triangle that was hit, in world space: what the point on it follows from by arithmetic alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// In the mesh's order.
    pub(crate) corners: [Vec3; 3],
    /// Of the corners; zero where there are none.
    pub(crate) normals: [Vec3; 3],
    /// By the winding in the mesh, as long as the cross product of two edges.
    pub(crate) winding: Vec3,
    /// Barycentric weights of the second and third corner.
    pub(crate) weights: [f32; 2],
    /// How much further than by the rounding of its points they and the triangle may be apart.
    pub(crate) slack: f32,
    /// Unit, to where the ray came from.
    pub(crate) wo: Vec3,
}

/// Where the ray met it.
pub(super) struct Point {
    pub(crate) p: Vec3,
    pub(crate) ng: Vec3,
    pub(crate) frame: Frame,
    /// Cosine between `wo` and the side from which the corners run counter-clockwise.
    pub(crate) facing: f32,
    pub(crate) offset: f32,
}

impl Facet {
    fn of(mesh: &Mesh, hit: &Hit, wo: Vec3) -> Facet {
        let corners = mesh.corners(hit.primitive as usize);
        let normals = corner_normals(mesh, hit.primitive as usize).unwrap_or_default();
        Facet { corners, normals, winding: hit.ng, weights: [hit.u, hit.v], slack: 0.0, wo }
    }

    pub(crate) fn placed(mesh: &Mesh, placement: &Placement, hit: &Hit, wo: Vec3) -> Facet {
        let own = mesh.corners(hit.primitive as usize);
        let corners = own.map(|p| placement.point(p));
        let normals = corner_normals(mesh, hit.primitive as usize).map(|normals| normals.map(|n| placement.normal(n)));
        let n = placement.normal(hit.ng);
        let [a, b, c] = corners;
        let (_, per_length) = unit((b - a).cross(c - a));
        let (winding, slack) = (if per_length > 0.0 { n / per_length } else { n }, placement.slack(own, n));
        Facet { corners, normals: normals.unwrap_or_default(), winding, weights: [hit.u, hit.v], slack, wo }
    }

    /// Without a jump, so that a loop over many runs in vectors.
    #[inline(always)]
    pub(crate) fn point(&self) -> Point {
        let Facet { corners: [a, b, c], normals, winding, weights: [u, v], slack, wo } = *self;
        let edges = [b - a, c - a];
        let (along_b, along_c) = (edges[0] * u, edges[1] * v);
        let p = a + (along_b + along_c);
        let (winding, per_length) = unit(winding);
        let (ng, ns) = shading(normals, [1.0 - u - v, u, v], winding, wo);
        let offset = across(edges, p, along_b.abs() + along_c.abs(), ng, per_length) + slack;
        Point { p, ng, frame: Frame::from_normal(ns), facing: winding.dot(wo), offset }
    }
}

impl Point {
    fn on(self, mesh: &Mesh, hit: &Hit) -> SurfaceInteraction {
        let Point { p, ng, frame, facing, offset } = self;
        let triangle = hit.primitive as usize;
        let (uv, material) = (mesh.uv(triangle, hit.u, hit.v), mesh.materials[triangle]);
        SurfaceInteraction { p, ng, frame, front: facing > 0.0, uv, material, offset }
    }
}

#[inline(always)]
pub(super) fn corner_normals(mesh: &Mesh, triangle: usize) -> Option<[Vec3; 3]> {
    let [a, b, c] = mesh.normals.as_ref()?.corners(&mesh.triangles, triangle)?;
    Some([Vec3::from(a), Vec3::from(b), Vec3::from(c)])
}

/// Geometric and shading normal. A shading normal that is turned away from a viewer who sees the triangle's
/// other side gives way to the triangle's own.
#[inline(always)]
fn shading([a, b, c]: [Vec3; 3], weights: [f32; 3], winding: Vec3, wo: Vec3) -> (Vec3, Vec3) {
    // zero where there are no normals, or where they cancel: then all below is on the winding's side
    let ns = normalize_or(a * weights[0] + b * weights[1] + c * weights[2], Vec3::ZERO);
    let ng = if winding.dot(ns) < 0.0 { -winding } else { winding };
    (ng, if wo.dot(ng) * wo.dot(ns) > 0.0 { ns } else { ng })
}
