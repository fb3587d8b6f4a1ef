//! Round shapes: spheres, surfaces of revolution, tubes, cones. Normals point outward.

use super::shape::Shape;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

/// A unit icosphere whose edges are cut into `frequency` parts: 20·frequency² nearly equal triangles, flat.
pub(crate) fn icosphere(frequency: u32, material: &'static str) -> Shape {
    let corners = icosahedron_corners();
    let mut vertices = Welder::default();
    let mut triangles = Vec::new();
    for face in ICOSAHEDRON_FACES {
        let [a, b, c] = face.map(|i| corners[i]);
        let mut at = |i: u32, j: u32| {
            let k = frequency - i - j;
            vertices.index((a * k as f64 + b * i as f64 + c * j as f64).normalize())
        };
        for i in 0..frequency {
            for j in 0..frequency - i {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < frequency {
                    triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    Shape::new(vertices.positions, triangles, material)
}

/// An icosphere pushed out along its radii: `radius` of each unit direction; smooth.
pub(crate) fn displaced_sphere(frequency: u32, material: &'static str, radius: impl Fn(DVec3) -> f64) -> Shape {
    let mut shape = icosphere(frequency, material);
    shape.positions.iter_mut().for_each(|p| *p *= radius(*p));
    shape.smooth()
}

const ICOSAHEDRON_FACES: [[usize; 3]; 20] = {
    let mut faces = [[0; 3]; 20];
    let mut i = 0;
    while i < 5 {
        let next = (i + 1) % 5;
        faces[4 * i] = [0, 1 + i, 1 + next];
        faces[4 * i + 1] = [1 + i, 6 + i, 1 + next];
        faces[4 * i + 2] = [1 + next, 6 + i, 6 + next];
        faces[4 * i + 3] = [11, 6 + next, 6 + i];
        i += 1;
    }
    faces
};

/// North pole, ring of five, ring of five turned by half a step, south pole.
fn icosahedron_corners() -> Vec<DVec3> {
    let (y, r) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let ring = |y: f64, offset: f64| (0..5).map(move |i| around_y(r, (i as f64 + offset) / 5.0 * TAU) + DVec3::Y * y);
    let poles = [DVec3::Y, DVec3::NEG_Y];
    [poles[0]].into_iter().chain(ring(y, 0.0)).chain(ring(-y, 0.5)).chain([poles[1]]).collect()
}

/// Gives vertices that are met again, up to 10⁻⁹, the index they had.
#[derive(Default)]
struct Welder {
    positions: Vec<DVec3>,
    seen: HashMap<[i64; 3], u32>,
}

impl Welder {
    fn index(&mut self, position: DVec3) -> u32 {
        let key = (position * 1e9).round().to_array().map(|x| x as i64);
        *self.seen.entry(key).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        })
    }
}

/// The point at `angle` on a circle about the y axis, counter-clockwise seen from above.
fn around_y(radius: f64, angle: f64) -> DVec3 {
    DVec3::new(radius * angle.cos(), 0.0, -radius * angle.sin())
}

/// A surface of revolution about the y axis, smooth. `profile` holds (radius, y) with the outside to the right of its
/// way; its first and last point lie on the axis.
pub(crate) fn revolve(profile: &[DVec2], segments: u32, material: &'static str) -> Shape {
    let on_axis = |p: DVec2| DVec3::Y * p.y;
    let rings: Vec<Vec<DVec3>> = profile[1..profile.len() - 1]
        .iter()
        .map(|p| turns(segments).map(|a| around_y(p.x, a) + on_axis(*p)).collect())
        .collect();
    loft(&rings, on_axis(profile[0]), on_axis(profile[profile.len() - 1]), material).smooth()
}

/// A tube along a path in the xy plane, smooth. `path` holds (x, y, radius); `mouth` is the depth of the hole at its
/// end, the other end is flat.
pub(crate) fn tube(path: &[DVec3], mouth: f64, segments: u32, material: &'static str) -> Shape {
    let centre = |i: usize| path[i].truncate();
    let last = path.len() - 1;
    let tangent = |i: usize| (centre((i + 1).min(last)) - centre(i.saturating_sub(1))).normalize();
    let ring = |i: usize, radius: f64| -> Vec<DVec3> {
        let side = tangent(i).perp().extend(0.0);
        let at = |a: f64| centre(i).extend(0.0) + (side * a.cos() + DVec3::Z * a.sin()) * radius;
        turns(segments).map(at).collect()
    };
    let mut rings: Vec<Vec<DVec3>> = (0..=last).map(|i| ring(i, path[i].z)).collect();
    rings.push(ring(last, path[last].z * 0.7));
    let bottom = centre(last) - tangent(last) * mouth;
    loft(&rings, centre(0).extend(0.0), bottom.extend(0.0), material).smooth()
}

fn turns(segments: u32) -> impl Iterator<Item = f64> {
    (0..segments).map(move |i| TAU * i as f64 / segments as f64)
}

/// Rings of equally many points joined one after the other and closed by a fan at either end. Each ring runs
/// counter-clockwise about the way from `start` to `end`.
fn loft(rings: &[Vec<DVec3>], start: DVec3, end: DVec3, material: &'static str) -> Shape {
    let n = rings[0].len() as u32;
    let last = (rings.len() as u32 - 1) * n;
    let positions: Vec<DVec3> = rings.iter().flatten().copied().chain([start, end]).collect();
    let (start, end) = (last + n, last + n + 1);
    let mut corners = Vec::new();
    for j in 0..n {
        let k = (j + 1) % n;
        corners.push([start, k, j]);
        for i in (0..last).step_by(n as usize) {
            corners.extend([[i + j, i + k, i + n + k], [i + j, i + n + k, i + n + j]]);
        }
        corners.push([last + j, last + k, end]);
    }
    Shape::new(positions, corners, material)
}

/// A cone that stands on y = 0 with its apex at `height`. The side is smooth, the rim and the base sharp.
pub(crate) fn cone(radius: f64, height: f64, segments: u32, material: &'static str) -> Shape {
    let angle = |i: f64| TAU * i / segments as f64;
    let slope = |i: f64| (around_y(height, angle(i)) + DVec3::Y * radius).normalize();
    let (mut positions, mut normals, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..segments {
        let (a, b) = (i as f64, ((i + 1) % segments) as f64);
        let rim = [around_y(radius, angle(a)), around_y(radius, angle(b))];
        let first = positions.len() as u32;
        positions.extend([rim[0], rim[1], DVec3::Y * height, rim[1], rim[0], DVec3::ZERO]);
        normals.extend([slope(a), slope(b), slope(a + 0.5)]);
        normals.extend([DVec3::NEG_Y; 3]);
        corners.extend([[first, first + 1, first + 2], [first + 3, first + 4, first + 5]]);
    }
    Shape { normals, ..Shape::new(positions, corners, material) }
}

/// A curve through all `points` (uniform Catmull-Rom; the ends count twice), each span cut into `parts`.
pub(crate) fn spline<V>(points: &[V], parts: u32) -> Vec<V>
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>,
{
    let last = points.len() - 1;
    let mut curve = Vec::new();
    for i in 0..last {
        let (a, b) = (points[i.saturating_sub(1)], points[i]);
        let (c, d) = (points[i + 1], points[(i + 2).min(last)]);
        for part in 0..parts {
            let t = part as f64 / parts as f64;
            let cubic = (b - c) * 3.0 + d - a;
            let square = a * 2.0 - b * 5.0 + c * 4.0 - d;
            curve.push(b + ((c - a) + (square + cubic * t) * t) * (t * 0.5));
        }
    }
    curve.push(points[last]);
    curve
}
