//! Where a mesh stands.

use super::Mesh;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// An affine map from a mesh's own space to the world, with what normals need of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    to_world: Affine3A,
    /// Inverse transpose of the linear part. It keeps what is outside outside, under mirrorings too.
    normal_to_world: Mat3A,
    mirrored: bool,
}

impl Placement {
    /// The determinant of `to_world` is not 0.
    pub fn new(to_world: Affine3A) -> Placement {
        Placement {
            to_world,
            normal_to_world: to_world.matrix3.inverse().transpose(),
            mirrored: to_world.matrix3.determinant() < 0.0,
        }
    }

    pub fn to_world(&self) -> Affine3A {
        self.to_world
    }

    /// Whether corners that run counter-clockwise run clockwise in the world.
    pub fn mirrored(&self) -> bool {
        self.mirrored
    }

    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.to_world.transform_point3(p)
    }

    /// The unit normal in the world of a surface with the normal `n`; zero where it has no direction.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        (self.normal_to_world * n).try_normalize().unwrap_or(Vec3::ZERO)
    }

    /// The largest number that may occur on the way of a point to the world, for points of which no coordinate is
    /// larger than `extent`: what rounding is relative to.
    #[inline]
    pub fn reach(&self, extent: Vec3) -> f32 {
        let m = self.to_world.matrix3;
        let linear = m.x_axis.abs() * extent.x + m.y_axis.abs() * extent.y + m.z_axis.abs() * extent.z;
        let sum: Vec3A = linear + self.to_world.translation.abs();
        sum.max_element()
    }

    /// The corners of a triangle in the world, counter-clockwise seen from outside.
    pub fn facet(&self, mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = mesh.corners(triangle).map(|p| self.point(p));
        if self.mirrored { [a, c, b] } else { [a, b, c] }
    }
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
