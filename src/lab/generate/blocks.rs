//! Shapes cut from and built of axis-aligned boxes: rooms with doorways, tables, frames.
//!
//! Space is divided by every plane in which a box begins or ends, so that each cell is wholly solid or wholly empty.
//! The surface is what separates the two: closed by construction, without a vertex in the middle of an edge.

use super::shape::{Shape, Triangle};
use glam::DVec3;
use std::collections::HashMap;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cuboid {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

/// The box between two corners.
pub(crate) fn cuboid(min: [f64; 3], max: [f64; 3]) -> Cuboid {
    Cuboid { min: min.into(), max: max.into() }
}

impl Cuboid {
    /// Whether a point is inside or on the boundary.
    pub(crate) fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

/// Boxes filled and carved one after the other; later ones win.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    background_solid: bool,
    steps: Vec<(Cuboid, bool)>,
    planes: [Vec<f64>; 3],
}

impl Blocks {
    /// Nothing yet, in empty space.
    pub(crate) fn in_air() -> Blocks {
        Blocks { background_solid: false, steps: Vec::new(), planes: Default::default() }
    }

    /// Nothing carved yet from rock without end: only inner surfaces will appear.
    pub(crate) fn in_rock() -> Blocks {
        Blocks { background_solid: true, ..Blocks::in_air() }
    }

    /// Makes a box solid.
    pub(crate) fn fill(self, cuboid: Cuboid) -> Blocks {
        self.step(cuboid, true)
    }

    /// Makes a box empty.
    pub(crate) fn carve(self, cuboid: Cuboid) -> Blocks {
        self.step(cuboid, false)
    }

    /// Cuts the surface where the materials change: `axis` 0 is x.
    pub(crate) fn cut(mut self, axis: usize, at: impl IntoIterator<Item = f64>) -> Blocks {
        self.planes[axis].extend(at);
        self
    }

    fn step(mut self, cuboid: Cuboid, solid: bool) -> Blocks {
        self.steps.push((cuboid, solid));
        for axis in 0..3 {
            self.planes[axis].extend([cuboid.min[axis], cuboid.max[axis]]);
        }
        self
    }

    fn solid(&self, p: DVec3) -> bool {
        let last = self.steps.iter().rev().find(|(cuboid, _)| cuboid.contains(p));
        last.map_or(self.background_solid, |step| step.1)
    }

    /// The surface, facing into the empty side. `material` is asked with the centre of a face and its normal.
    pub(crate) fn surface(self, material: impl Fn(DVec3, DVec3) -> &'static str) -> Shape {
        let mut builder = Builder { planes: self.planes.clone().map(sorted), ..Default::default() };
        let cells = builder.planes.each_ref().map(|planes| planes.len() - 1);
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for (i, j, k) in triples(cells[axis] + 1, cells[u], cells[v]) {
                let mut cell = [0; 3];
                (cell[axis], cell[u], cell[v]) = (i, j, k);
                let (low, high) = builder.sides(cell, axis);
                let (low, high) = (self.solid(low), self.solid(high));
                if low != high {
                    builder.face(cell, axis, low, &material);
                }
            }
        }
        builder.shape
    }
}

fn triples(a: usize, b: usize, c: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| (i, j, k))))
}

/// Planes nearer than a micrometre are one.
fn sorted(mut planes: Vec<f64>) -> Vec<f64> {
    planes.sort_by(f64::total_cmp);
    planes.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    planes
}

#[derive(Default)]
struct Builder {
    planes: [Vec<f64>; 3],
    vertices: HashMap<[usize; 3], u32>,
    shape: Shape,
}

impl Builder {
    /// The centres of the cells below and above the lower face of `cell` across `axis`.
    fn sides(&self, cell: [usize; 3], axis: usize) -> (DVec3, DVec3) {
        let middle = |axis: usize| {
            let i = cell[axis];
            (self.planes[axis][i] + self.planes[axis][i + 1]) / 2.0
        };
        let across = |i: usize| {
            let planes = &self.planes[axis];
            match i {
                0 => planes[0] - 1.0,
                i if i == planes.len() => planes[i - 1] + 1.0,
                i => (planes[i - 1] + planes[i]) / 2.0,
            }
        };
        let at = |i: usize| DVec3::from_array([0, 1, 2].map(|a| if a == axis { across(i) } else { middle(a) }));
        (at(cell[axis]), at(cell[axis] + 1))
    }

    /// Adds the lower face of `cell` across `axis`; it faces up the axis if what is below is solid.
    fn face(&mut self, cell: [usize; 3], axis: usize, up: bool, material: &impl Fn(DVec3, DVec3) -> &'static str) {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(du, dv)| {
            let mut corner = cell;
            corner[u] += du;
            corner[v] += dv;
            self.vertex(corner)
        });
        if !up {
            corners.reverse();
        }
        let at = |i: u32| self.shape.positions[i as usize];
        let centre = (at(corners[0]) + at(corners[2])) / 2.0;
        let normal = DVec3::AXES[axis] * if up { 1.0 } else { -1.0 };
        let material = material(centre, normal);
        let [a, b, c, d] = corners;
        self.shape.triangles.extend([[a, b, c], [a, c, d]].map(|corners| Triangle { corners, material }));
    }

    fn vertex(&mut self, at: [usize; 3]) -> u32 {
        *self.vertices.entry(at).or_insert_with(|| {
            let [x, y, z] = [0, 1, 2].map(|axis| self.planes[axis][at[axis]]);
            self.shape.positions.push(DVec3::new(x, y, z));
            self.shape.positions.len() as u32 - 1
        })
    }
}
