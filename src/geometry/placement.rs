//! Where a mesh stands.

use super::Mesh;
use super::rounding::{ROUNDING, across, unit};
use glam::{Affine3A, DMat3, DVec3, Mat3, Mat3A, Vec3, Vec3A};

/// An affine map from a mesh's own space to the world, with what normals need of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    to_world: Affine3A,
    /// Inverse transpose of the linear part, over `growth`. It keeps what is outside outside, under mirrorings too.
    normal_to_world: Mat3A,
    /// The largest entry of the inverse.
    growth: f32,
    mirrored: bool,
    /// How far the inverse in single precision puts a point of the world wrong, as seen in the world: what the sizes of its
    /// coordinates relative to the place's origin are to be multiplied by.
    inversion: Mat3A,
    /// The same for the rounding of sums and products on that way, by sizes of coordinates in the world.
    carrying: Mat3A,
}

/// Sizes of the entries.
fn sizes(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// Sizes of the terms of a cross product, added.
fn cross_of_sizes(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

impl Placement {
    /// The determinant of `to_world` is not 0.
    pub(crate) fn new(to_world: Affine3A) -> Placement {
        let linear = linear(&to_world);
        let (inverse, determinant) = (linear.inverse(), linear.determinant());
        let growth = largest(inverse);
        Placement {
            to_world,
            normal_to_world: (inverse * growth.recip()).transpose().as_mat3().into(),
            growth: growth as f32,
            mirrored: determinant < 0.0,
            inversion: inversion(linear, inverse, determinant).as_mat3().into(),
            carrying: (sizes(linear) * sizes(inverse) * (4.0 * ROUNDING as f64)).as_mat3().into(),
        }
    }

    /// Whether rays can be moved to the mesh's own space in single precision, as Embree does it, and meet there what they
    /// should. All coordinates of the world are at most `world`, those of the meshes in their own space at most `own`.
    pub(crate) fn carries_rays(&self, world: f32, own: f32) -> bool {
        let linear = linear(&self.to_world);
        let terms = sizes_of_adjugate(linear);
        let determinant = linear.determinant().abs();
        let determinant_terms = linear.x_axis.abs().dot(cross_of_sizes(linear.y_axis, linear.z_axis));
        let range = f32::MIN_POSITIVE as f64..=f32::MAX as f64;
        let inverts =
            range.contains(&determinant) && range.contains(&determinant_terms) && largest(terms) <= *range.end();
        // Embree multiplies two edges and a distance, or an edge, a distance and the ray's direction
        let (growth, edge) = (3.0 * largest(linear.inverse()), 2.0 * own as f64);
        let distance = 2.0 * growth * world as f64 + own as f64;
        let products = 6.0 * edge * distance * edge.max(growth);
        inverts && products <= *range.end() && self.doubt() <= LARGEST_DOUBT
    }

    pub(crate) fn to_world(self) -> Affine3A {
        self.to_world
    }

    /// Whether corners that run counter-clockwise run clockwise in the world.
    pub(crate) fn mirrored(&self) -> bool {
        self.mirrored
    }

    #[inline]
    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        self.to_world.transform_point3(p)
    }

    /// The unit normal in the world of a surface with the normal `n`; zero where it has no direction.
    #[inline]
    pub(crate) fn normal(&self, n: Vec3) -> Vec3 {
        unit((self.normal_to_world * Vec3A::from(unit(n).0)).into()).0
    }

    /// The largest numbers that may occur on the way of a point to the world, for points of which no coordinate is
    /// larger than `extent`: what rounding is relative to.
    #[inline]
    pub(crate) fn reach(&self, extent: Vec3) -> Vec3 {
        let m = self.to_world.matrix3;
        let linear = m.x_axis.abs() * extent.x + m.y_axis.abs() * extent.y + m.z_axis.abs() * extent.z;
        (linear + self.to_world.translation.abs()).into()
    }

    /// How far across its plane a point of this triangle of the mesh may be apart from where rays meet the triangle, by
    /// all that lies between its own space and the world. `n`: its unit normal in the world.
    pub(crate) fn slack(&self, corners: [Vec3; 3], n: Vec3) -> f32 {
        let [a, b, c] = corners;
        let reach = Vec3A::from(self.reach(a.abs().max(b.abs()).max(c.abs())));
        let translation = self.to_world.translation.abs();
        // three products and three sums from the triangle to the world, and back
        let back = self.inversion * (reach - translation) + self.carrying * (reach + translation);
        let moved = Vec3::from(4.0 * ROUNDING * reach + back);
        let (own, per_length) = unit((b - a).cross(c - a));
        let tested = across([b - a, c - a], Vec3::ZERO, (b - a).abs().max((c - a).abs()), own, per_length);
        // a step of length 1 off the triangle in its own space is as long as this in the world
        let (_, step) = unit((self.normal_to_world * Vec3A::from(own)).into());
        n.abs().dot(moved) + tested * (step / self.growth)
    }

    /// [`Self::slack`] of a triangle of the mesh.
    pub(crate) fn slack_of(&self, mesh: &Mesh, triangle: usize) -> f32 {
        let [a, b, c] = mesh.corners(triangle);
        self.slack([a, b, c], self.normal((b - a).cross(c - a)))
    }

    /// The corners of a triangle in the world, counter-clockwise seen from outside.
    pub(crate) fn facet(&self, mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = mesh.corners(triangle).map(|p| self.point(p));
        if self.mirrored { [a, c, b] } else { [a, b, c] }
    }

    /// The share of the distances of a scene by which rays may go astray on their way to the mesh's own space and back.
    fn doubt(&self) -> f32 {
        let m = self.inversion + self.carrying;
        (m.x_axis + m.y_axis + m.z_axis).max_element()
    }
}

/// Where rays may go astray by more than this share of their coordinates, what they meet no longer is what stands there.
const LARGEST_DOUBT: f32 = 1.0 / 1024.0;

fn linear(transform: &Affine3A) -> DMat3 {
    Mat3::from(transform.matrix3).as_dmat3()
}

fn largest(m: DMat3) -> f64 {
    let m = sizes(m);
    m.x_axis.max(m.y_axis).max(m.z_axis).max_element()
}

/// Sums of the sizes of the terms of the adjugate's entries.
fn sizes_of_adjugate(m: DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    DMat3::from_cols(cross_of_sizes(y, z), cross_of_sizes(z, x), cross_of_sizes(x, y)).transpose()
}

/// Embree inverts the matrix by its adjugate and its determinant, in single precision. To first order an entry ab − cd of
/// the adjugate is wrong by 2u(|ab| + |cd|), the determinant by 4u times the sum of its terms' sizes, the quotient by u.
fn inversion(linear: DMat3, inverse: DMat3, determinant: f64) -> DMat3 {
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let terms = sizes_of_adjugate(linear);
    let determinant_terms = x.abs().dot(cross_of_sizes(y, z));
    let relative = 4.0 * determinant_terms / determinant.abs() + 1.0;
    let wrong = terms * (2.0 / determinant.abs()) + sizes(inverse) * relative;
    sizes(linear) * wrong * ROUNDING as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn normals_stay_normal_to_their_surface_and_outside() {
        for scale in [Vec3::ONE, Vec3::new(1.0, 4.0, 0.3), Vec3::new(-1.0, 2.0, 1.0), Vec3::splat(-0.5)] {
            let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.8);
            let shear = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.4, 1.0, 0.0), Vec3::Z));
            let placement = Placement::new(Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ONE) * shear);
            let (u, v) = (Vec3::new(1.0, 0.2, 0.0), Vec3::new(0.1, 0.0, -1.0));
            let n = placement.normal(u.cross(v));
            let moved = |w: Vec3| placement.point(w) - placement.point(Vec3::ZERO);
            assert!(n.dot(moved(u)).abs() < 1e-5 && n.dot(moved(v)).abs() < 1e-5 && n.is_normalized());
            assert!(n.dot(moved(u.cross(v))) > 0.0, "what was outside is outside");
            assert_eq!(placement.mirrored(), scale.x * scale.y * scale.z < 0.0);
        }
    }
}
