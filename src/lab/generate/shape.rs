//! Triangles with materials, and what can be done to them as a whole.

use glam::{DAffine3, DVec3};

/// A triangle: indices into [`Shape::positions`], counter-clockwise seen from the front, and a material's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Triangle {
    pub(crate) corners: [u32; 3],
    pub(crate) material: &'static str,
}

/// An indexed triangle mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<DVec3>,
    /// One unit normal per position, or none at all: then the faces are flat.
    pub(crate) normals: Vec<DVec3>,
    pub(crate) triangles: Vec<Triangle>,
}

impl Shape {
    /// A flat shape of one material.
    pub(crate) fn new(positions: Vec<DVec3>, corners: Vec<[u32; 3]>, material: &'static str) -> Shape {
        let triangles = corners.into_iter().map(|corners| Triangle { corners, material }).collect();
        Shape { positions, normals: Vec::new(), triangles }
    }

    /// Rectangles given by four corners each, counter-clockwise seen from the front.
    pub(crate) fn quads(quads: &[[DVec3; 4]], material: &'static str) -> Shape {
        let corners = (0..quads.len() as u32)
            .flat_map(|q| [[4 * q, 4 * q + 1, 4 * q + 2], [4 * q, 4 * q + 2, 4 * q + 3]])
            .collect();
        Shape::new(quads.concat(), corners, material)
    }

    /// The corners of a triangle in space.
    pub(crate) fn corners(&self, triangle: &Triangle) -> [DVec3; 3] {
        triangle.corners.map(|i| self.positions[i as usize])
    }

    /// With normals at the vertices: the mean of the faces around one, weighted by their angle there (Thürmer and
    /// Wüthrich 1998), so that they do not depend on how a surface is cut into triangles.
    pub(crate) fn smooth(mut self) -> Shape {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            let p = self.corners(triangle);
            let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
            for i in 0..3 {
                let (to_next, to_last) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
                sums[triangle.corners[i] as usize] += normal * to_next.angle_between(to_last);
            }
        }
        self.normals = sums.into_iter().map(DVec3::normalize).collect();
        self
    }

    /// The same triangles seen from the other side.
    pub(crate) fn flipped(mut self) -> Shape {
        self.triangles.iter_mut().for_each(|t| t.corners.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
        self
    }

    /// Moved by an affine map that keeps orientation (positive determinant).
    pub(crate) fn transformed(mut self, map: &DAffine3) -> Shape {
        let normal_map = map.matrix3.inverse().transpose();
        self.positions.iter_mut().for_each(|p| *p = map.transform_point3(*p));
        self.normals.iter_mut().for_each(|n| *n = (normal_map * *n).normalize());
        self
    }

    /// Both shapes in one; either both have normals or neither has.
    pub(crate) fn with(mut self, other: Shape) -> Shape {
        debug_assert_eq!(self.normals.is_empty(), other.normals.is_empty());
        let offset = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.triangles
            .extend(other.triangles.into_iter().map(|t| Triangle { corners: t.corners.map(|i| i + offset), ..t }));
        self
    }
}
