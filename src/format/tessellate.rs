//! Shapes that are no meshes, as meshes. v of texture coordinates counts from below, which is 1 − v of Mitsuba's.

use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices};
use crate::scene::model::Model;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Segments of a circle. Radii are such that areas are those of the round shape (of a sphere, a disk or a cylinder), so that lights have
/// its power; the outline is then within 1.3·10⁻³ of the radius of a sphere, 4·10⁻⁴ of that of a disk or a cylinder.
const SEGMENTS: usize = 96;

/// Rows of a sphere from pole to pole.
const ROWS: usize = SEGMENTS / 2;

/// A mesh while it is made: each vertex has a normal and a texture coordinate.
#[derive(Default)]
struct Builder {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Builder {
    /// `v` counts from above.
    fn vertex(&mut self, p: DVec3, n: DVec3, [u, v]: [f64; 2]) -> u32 {
        self.positions.push(p.as_vec3().into());
        self.normals.push(n.as_vec3().into());
        self.uvs.push([u as f32, (1.0 - v) as f32]);
        self.positions.len() as u32 - 1
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// `smooth`: the shape is round.
    fn model(self, smooth: bool) -> Arc<Model> {
        let indices = Indices::OfPositions;
        let mesh = Mesh {
            materials: vec![0; self.triangles.len()],
            positions: self.positions,
            triangles: self.triangles,
            normals: smooth.then(|| Attribute { values: self.normals, indices: indices.clone() }),
            uvs: Some(Attribute { values: self.uvs, indices }),
            colors: None,
        };
        Arc::new(Model { mesh, material_names: vec![String::new()], ..Model::default() })
    }
}

/// [−1, 1]² in the plane z = 0, seen from +z.
pub(crate) fn rectangle() -> Arc<Model> {
    let mut b = Builder::default();
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let corners = corners.map(|[u, v]| b.vertex(DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0), DVec3::Z, [u, v]));
    b.quad(corners);
    b.model(false)
}

/// [−1, 1]³.
pub(crate) fn cube() -> Arc<Model> {
    const FACES: [[[f64; 3]; 4]; 6] = [
        [[1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, -1.0, -1.0]],
        [[1.0, 1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0]],
        [[1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]],
        [[1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]],
        [[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, -1.0]],
        [[1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, -1.0], [-1.0, 1.0, -1.0]],
    ];
    let mut b = Builder::default();
    for face in FACES {
        let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let corners = std::array::from_fn(|k| b.vertex(face[k].into(), DVec3::Z, uvs[k]));
        b.quad(corners);
    }
    b.model(false)
}

/// About the origin, with radius 1; z is its axis.
pub(crate) fn sphere() -> Arc<Model> {
    // the area of the bands between rows, with radius 1
    let at = |row: usize, column: usize| {
        let (theta, phi) = (PI * row as f64 / ROWS as f64, TAU * column as f64 / SEGMENTS as f64);
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let area = |a: DVec3, b: DVec3, c: DVec3| 0.5 * (b - a).cross(c - a).length();
    let band = |row: usize| {
        let [a, b, c, d] = [at(row, 0), at(row + 1, 0), at(row + 1, 1), at(row, 1)];
        SEGMENTS as f64 * (area(a, b, c) + area(a, c, d))
    };
    let radius = (4.0 * PI / (0..ROWS).map(band).sum::<f64>()).sqrt();
    let mut b = Builder::default();
    for row in 0..=ROWS {
        for column in 0..=SEGMENTS {
            let n = at(row, column);
            b.vertex(n * radius, n, [column as f64 / SEGMENTS as f64, row as f64 / ROWS as f64]);
        }
    }
    let number = |row: usize, column: usize| (row * (SEGMENTS + 1) + column) as u32;
    for row in 0..ROWS {
        for column in 0..SEGMENTS {
            let [p, q, r, s] =
                [number(row, column), number(row + 1, column), number(row + 1, column + 1), number(row, column + 1)];
            if row > 0 {
                b.triangles.push([p, r, s]);
            }
            if row < ROWS - 1 {
                b.triangles.push([p, q, r]);
            }
        }
    }
    b.model(true)
}

/// Points of a circle whose polygon has its area, or length, as `factor` says.
fn circle(factor: f64) -> impl Iterator<Item = (f64, DVec2, DVec2)> {
    (0..=SEGMENTS).map(move |k| {
        let share = k as f64 / SEGMENTS as f64;
        let (sin, cos) = (TAU * share).sin_cos();
        (share, DVec2::new(cos, sin), DVec2::new(cos, sin) * factor)
    })
}

/// About the origin in the plane z = 0, with radius 1, seen from +z.
pub(crate) fn disk() -> Arc<Model> {
    let step = TAU / SEGMENTS as f64;
    let mut b = Builder::default();
    for (share, _, p) in circle((step / step.sin()).sqrt()) {
        b.vertex(DVec3::ZERO, DVec3::Z, [0.0, share]);
        b.vertex(p.extend(0.0), DVec3::Z, [1.0, share]);
    }
    for k in 0..SEGMENTS as u32 {
        b.triangles.push([2 * k, 2 * k + 1, 2 * k + 3]);
    }
    b.model(false)
}

/// From z = 0 to z = 1 about the z axis, with radius 1, open at both ends, seen from outside.
pub(crate) fn cylinder() -> Arc<Model> {
    let half = PI / SEGMENTS as f64;
    let mut b = Builder::default();
    for (share, n, p) in circle(half / half.sin()) {
        b.vertex(p.extend(0.0), n.extend(0.0), [share, 0.0]);
        b.vertex(p.extend(1.0), n.extend(0.0), [share, 1.0]);
    }
    for k in 0..SEGMENTS as u32 {
        b.quad([2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1]);
    }
    b.model(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Area, volume over the origin by the winding, and the largest distance of a corner from the z axis and the origin.
    fn measure(model: &Model) -> (f64, f64, f64) {
        let mesh = &model.mesh;
        let facets = (0..mesh.triangles.len()).map(|t| mesh.corners(t).map(|p| p.as_dvec3()));
        let (mut area, mut volume) = (0.0, 0.0);
        for [a, b, c] in facets {
            area += 0.5 * (b - a).cross(c - a).length();
            volume += a.dot(b.cross(c)) / 6.0;
        }
        let reach = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3().length()).fold(0.0, f64::max);
        (area, volume, reach)
    }

    #[test]
    fn areas_are_those_of_the_round_shapes_and_outlines_nearly() {
        let (area, volume, reach) = measure(&sphere());
        assert!((area / (4.0 * PI) - 1.0).abs() < 1e-6 && volume > 4.17 && volume < 4.19, "{area} {volume}");
        assert!(reach < 1.0013, "{reach}");
        let (area, _, reach) = measure(&disk());
        assert!((area / PI - 1.0).abs() < 1e-6 && reach < 1.0008, "{area} {reach}");
        let (area, volume, _) = measure(&cylinder());
        assert!((area / TAU - 1.0).abs() < 1e-6 && volume > 0.0, "{area}");
        assert_eq!(measure(&cube()).0, 24.0);
        assert_eq!(measure(&cube()).1, 8.0);
        assert_eq!(measure(&rectangle()).0, 4.0);
    }

    #[test]
    fn normals_are_those_of_the_windings() {
        for model in [sphere(), cylinder()] {
            let mesh = &model.mesh;
            for t in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(t);
                let normals = mesh.normals.as_ref().unwrap().corners(&mesh.triangles, t).unwrap();
                let face = (b - a).cross(c - a).normalize();
                assert!(normals.iter().all(|n| Vec3::from(*n).dot(face) > 0.99), "{t}");
            }
        }
        for model in [rectangle(), disk()] {
            assert!((0..model.mesh.triangles.len()).all(|t| {
                let [a, b, c] = model.mesh.corners(t);
                (b - a).cross(c - a).z > 0.0
            }));
        }
    }
}
