//! What is known of the point where a ray met a surface.

use super::{Frame, Mesh};
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
        let triangle = hit.primitive as usize;
        let (u, v) = (hit.u, hit.v);
        let w = 1.0 - u - v;
        let [a, b, c] = mesh.triangles[triangle].map(|i| Vec3::from(mesh.positions[i as usize]));
        let extent = a.abs().max(b.abs()).max(c.abs()).max_element();
        let winding = hit.ng.normalize();
        let (ng, ns) = normals(mesh, triangle, [w, u, v], winding, wo);
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

/// Geometric and shading normal. A shading normal that is turned away from a viewer who sees the triangle's
/// other side gives way to the triangle's own.
#[inline]
fn normals(mesh: &Mesh, triangle: usize, weights: [f32; 3], winding: Vec3, wo: Vec3) -> (Vec3, Vec3) {
    let Some([a, b, c]) = mesh.normals.as_ref().and_then(|n| n.corners(triangle)) else {
        return (winding, winding);
    };
    let interpolated = Vec3::from(a) * weights[0] + Vec3::from(b) * weights[1] + Vec3::from(c) * weights[2];
    let Some(ns) = interpolated.try_normalize() else {
        return (winding, winding);
    };
    let ng = if winding.dot(ns) < 0.0 { -winding } else { winding };
    if wo.dot(ng) * wo.dot(ns) > 0.0 { (ng, ns) } else { (ng, ng) }
}
