//! What is known of the point where a ray met a surface.

use super::{Frame, Mesh, Placement};
use crate::embree::Hit;
use glam::Vec3;

/// A point on a surface, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    pub p: Vec3,
    /// Unit normal of the triangle, on the same side as the shading normal.
    pub ng: Vec3,
    /// Shading frame; its `n` is the interpolated normal where the mesh has one.
    pub frame: Frame,
    /// Whether the ray came from the side from which the triangle's corners run counter-clockwise.
    pub front: bool,
    pub uv: [f32; 2],
    pub material: u32,
    /// How far rays start from the surface: more than `p` can be wrong by rounding.
    offset: f32,
}

/// Rounding of the interpolated point and of Embree's test, relative to the largest coordinate of the triangle:
/// some ten operations of half an ulp each, with a margin for grazing rays.
const RELATIVE_OFFSET: f32 = 1.0 / (1 << 16) as f32;

impl SurfaceInteraction {
    /// The point of `hit` on `mesh`, met by a ray that leaves towards `wo`.
    #[inline]
    pub fn new(mesh: &Mesh, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        let corners = mesh.corners(hit.primitive as usize);
        let normals = corner_normals(mesh, hit);
        let extent = extent(corners).max_element();
        Triangle { corners, normals, winding: hit.ng.normalize(), extent }.at(mesh, hit, wo)
    }

    /// The point of `hit` on an instance of `mesh`. It is what the same hit on a copy of the mesh in the world would
    /// give: corners and normals are moved first and interpolated then.
    pub fn placed(mesh: &Mesh, placement: &Placement, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        let own = mesh.corners(hit.primitive as usize);
        let corners = own.map(|p| placement.point(p));
        let normals = corner_normals(mesh, hit).map(|normals| normals.map(|n| placement.normal(n)));
        let extent = placement.reach(extent(own));
        Triangle { corners, normals, winding: placement.normal(hit.ng), extent }.at(mesh, hit, wo)
    }

    /// Where a ray towards the unit direction `w` starts.
    #[inline]
    pub fn spawn(&self, w: Vec3) -> Vec3 {
        self.p + self.ng * self.offset.copysign(w.dot(self.ng))
    }

    /// The shading normal on the side of `w`.
    #[inline]
    pub fn facing(&self, w: Vec3) -> Vec3 {
        if w.dot(self.frame.n) < 0.0 { -self.frame.n } else { self.frame.n }
    }

    /// Whether the shading normal and the triangle agree on which side `w` is. Where they do not, light would
    /// leak through the surface.
    #[inline]
    pub fn consistent(&self, w: Vec3) -> bool {
        w.dot(self.ng) * w.dot(self.frame.n) > 0.0
    }
}

/// The triangle that was hit, in world space, its corners in the mesh's order.
struct Triangle {
    corners: [Vec3; 3],
    normals: Option<[Vec3; 3]>,
    /// Unit, by the winding in the mesh.
    winding: Vec3,
    /// What the rounding of its points is relative to.
    extent: f32,
}

impl Triangle {
    #[inline(always)]
    fn at(self, mesh: &Mesh, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        let Triangle { corners: [a, b, c], normals, winding, extent } = self;
        let (triangle, u, v) = (hit.primitive as usize, hit.u, hit.v);
        let w = 1.0 - u - v;
        let (ng, ns) = shading(normals, [w, u, v], winding, wo);
        SurfaceInteraction {
            p: a * w + b * u + c * v,
            ng,
            frame: Frame::from_normal(ns),
            front: winding.dot(wo) > 0.0,
            uv: mesh.uv(triangle, u, v),
            material: mesh.materials[triangle],
            offset: extent * RELATIVE_OFFSET,
        }
    }
}

#[inline]
fn extent([a, b, c]: [Vec3; 3]) -> Vec3 {
    a.abs().max(b.abs()).max(c.abs())
}

#[inline]
fn corner_normals(mesh: &Mesh, hit: &Hit) -> Option<[Vec3; 3]> {
    let normals = mesh.normals.as_ref()?.corners(&mesh.triangles, hit.primitive as usize)?;
    Some(normals.map(Vec3::from))
}

/// Geometric and shading normal. A shading normal that is turned away from a viewer who sees the triangle's
/// other side gives way to the triangle's own.
#[inline]
fn shading(normals: Option<[Vec3; 3]>, weights: [f32; 3], winding: Vec3, wo: Vec3) -> (Vec3, Vec3) {
    let Some([a, b, c]) = normals else {
        return (winding, winding);
    };
    let interpolated = a * weights[0] + b * weights[1] + c * weights[2];
    let Some(ns) = interpolated.try_normalize() else {
        return (winding, winding);
    };
    let ng = if winding.dot(ns) < 0.0 { -winding } else { winding };
    if wo.dot(ng) * wo.dot(ns) > 0.0 { (ng, ns) } else { (ng, ng) }
}
