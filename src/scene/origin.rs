//! Where coordinates are counted from: 0, or a place near a model that is far from it.
//!
//! Coordinates are traced in single precision, whose steps grow with the distance from 0: at 5 000 000 m, the order of survey
//! coordinates, they are half a metre. Models and scenes that would suffer are moved near 0 in double precision, and only then
//! rounded.

use super::description::{InstanceDescription, SceneDescription};
use crate::embree::LARGEST_COORDINATE;
use crate::geometry::Mesh;
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// An origin is taken where a model's extent is fewer steps of single precision than this, 2¹⁸. So many keep steps below a pixel in
/// views of a hundredth of the model on 2000 pixels.
const LEAST_STEPS: f64 = 262_144.0;

/// Triangles that are looked at for whether a model may be small beside what its vertices span.
const SAMPLES: usize = 64;

/// Positions that a thread looks at a time.
const BLOCK: usize = 1 << 16;

/// Corners of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Of positions that can be traced; others are passed over.
    pub(crate) fn of(positions: &[[f32; 3]]) -> Bounds {
        let traced = |p: &&[f32; 3]| p.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
        let block = |points: &[[f32; 3]]| {
            let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let points = points.iter().filter(traced).map(|p| Vec3::from(*p));
            let (low, high) = points.fold(start, |(low, high), p| (low.min(p), high.max(p)));
            Bounds { low: low.as_dvec3(), high: high.as_dvec3() }
        };
        positions.par_chunks(BLOCK).map(block).reduce(|| Bounds::EMPTY, Bounds::union)
    }

    /// Of the positions that triangles use, where they may need an origin that the box around all positions does not show: files may hold
    /// vertices at 0 beside a model far from it. `None` where a sample shows that they do not.
    pub(crate) fn of_used(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<Bounds> {
        let used = |triangles: &[[u32; 3]]| {
            let corners = triangles.iter().flatten().map(|&i| positions[i as usize]);
            Bounds::of(&corners.collect::<Vec<_>>())
        };
        let sample: Vec<[u32; 3]> = triangles.iter().step_by(triangles.len() / SAMPLES + 1).copied().collect();
        if used(&sample).origin() == DVec3::ZERO {
            return None;
        }
        Some(triangles.par_chunks(BLOCK).map(used).reduce(|| Bounds::EMPTY, Bounds::union))
    }

    fn union(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// A box around what was in this one.
    fn transformed(self, transform: &DAffine3) -> Bounds {
        if self.low.x > self.high.x {
            return self;
        }
        let corner = |k: usize| DVec3::from([0, 1, 2].map(|axis| [self.low, self.high][k >> axis & 1][axis]));
        let corners = (0..8).map(|k| transform.transform_point3(corner(k)));
        corners.fold(Bounds::EMPTY, |all, p| all.union(Bounds { low: p, high: p }))
    }

    /// What is within is to be counted from here: 0 along axes on which single precision does. Round numbers near the middle.
    pub(crate) fn origin(self) -> DVec3 {
        let extent = (self.high - self.low).max_element();
        if !(extent > 0.0 && extent.is_finite()) {
            return DVec3::ZERO;
        }
        let largest = self.low.abs().max(self.high.abs());
        let places = extent.log10().floor() as i32;
        let round = |x: f64| match places {
            0.. => (x / 10f64.powi(places)).round() * 10f64.powi(places),
            _ => (x * 10f64.powi(-places)).round() / 10f64.powi(-places),
        };
        DVec3::from([0, 1, 2].map(|axis| {
            let coarse = step(largest[axis]) * LEAST_STEPS > extent;
            if coarse { round(0.5 * (self.low[axis] + self.high[axis])) } else { 0.0 }
        }))
    }
}

/// The distance from a number to the next one in single precision.
fn step(x: f64) -> f64 {
    let x = x as f32;
    f64::from(x.next_up()) - f64::from(x)
}

/// The scene with all of it counted from an origin. `meshes` are those of the description, each counted from its own of `origins`; the
/// transforms take them from there. What is in a group is counted from an origin of the group's, and instances from there.
pub(super) fn rebase(description: &SceneDescription, meshes: &[Mesh], origins: &[DVec3]) -> (SceneDescription, DVec3) {
    let mut moved = description.clone();
    for (mesh, origin) in moved.meshes.iter_mut().zip(origins) {
        mesh.transform = from(mesh.transform, *origin);
    }
    let boxes = || moved.meshes.iter().zip(meshes).map(|(said, mesh)| (said, Bounds::of(&mesh.positions)));
    let (mut world, mut groups) = (Bounds::EMPTY, BTreeMap::<String, Bounds>::new());
    for (said, own) in boxes() {
        let placed = own.transformed(&said.transform);
        match &said.group {
            None => world = world.union(placed),
            Some(name) => {
                let group = groups.entry(name.clone()).or_insert(Bounds::EMPTY);
                *group = group.union(placed);
            }
        }
    }
    let boxed =
        |instance: &InstanceDescription| groups.get(&instance.group).map(|own| own.transformed(&instance.transform));
    let origin = moved.instances.iter().filter_map(boxed).fold(world, Bounds::union).origin();
    let group_origin = |name: &str| groups.get(name).map_or(DVec3::ZERO, |own| own.origin());
    for mesh in &mut moved.meshes {
        mesh.transform.translation -= mesh.group.as_deref().map_or(origin, group_origin);
    }
    for instance in &mut moved.instances {
        instance.transform = from(instance.transform, group_origin(&instance.group));
        instance.transform.translation -= origin;
    }
    moved.lights.iter_mut().for_each(|light| light.translate(-origin));
    if let Some(camera) = &mut moved.camera {
        camera.origin -= origin;
        camera.target -= origin;
    }
    (moved, origin)
}

/// The transform of what is counted from `origin`.
fn from(transform: DAffine3, origin: DVec3) -> DAffine3 {
    if origin == DVec3::ZERO {
        return transform;
    }
    DAffine3 { translation: transform.transform_point3(origin), ..transform }
}

/// What there is to say of a scene that is counted from `origin`.
pub(super) fn note(origin: DVec3) -> Option<String> {
    let [x, y, z] = origin.to_array();
    let message = "coordinates are far from 0 for the size of the scene: they are counted from";
    (origin != DVec3::ZERO).then(|| format!("{message} ({x}, {y}, {z}), and rounded to single precision only then"))
}

#[cfg(test)]
mod tests;
