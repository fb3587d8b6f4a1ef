//! What of a model is to be seen, if it stands on a ground or before a wall that is only there to be behind it.

use super::axes::Axes;
use crate::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;

/// Triangles longer than this share of the model are large.
const LARGE: f32 = 0.5;
/// How far from a side of the box about the model, as a share of its longest side, the ground and walls behind may reach.
const LAYER: f32 = 0.05;
/// Triangles of instances that are looked at.
const INSTANCED: usize = 1 << 22;

/// The part of a scene that a camera is placed for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subject {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// Triangles from this length on are no part of it.
    large: f32,
}

/// A box that grows.
type Bounds = (Vec3, Vec3);
const NOTHING: Bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);

impl Subject {
    /// All of the model, but for a backdrop: where all large triangles lie along the ground and along walls of which no two
    /// face each other, and something else is there.
    pub(super) fn of(scene: &Scene, axes: &Axes) -> Subject {
        let (low, high) = scene.bounds();
        let size = (high - low).max_element();
        let large = LARGE * size;
        let sides = Sides { low, high, layer: LAYER * size, ground: side(-axes.up) };
        let (small, along) = survey(scene, large, &sides);
        let backdrop = along.is_some_and(|along| {
            let opposite = (0..3).any(|axis| along & (0b11 << (2 * axis)) == 0b11 << (2 * axis));
            along & (1 << sides.ground) != 0 && !opposite
        });
        match backdrop && small.0.cmple(small.1).all() {
            true => Subject { low: small.0, high: small.1, large },
            false => Subject { low, high, large: f32::INFINITY },
        }
    }

    /// Corners of about so many of its triangles, evenly over each mesh.
    pub(super) fn outline<'a>(&self, scene: &'a Scene, triangles: usize) -> impl Iterator<Item = Vec3> + use<'a> {
        let (step, large) = (scene.triangles() / triangles + 1, self.large);
        let own = scene.meshes.iter();
        let own = own.flat_map(move |mesh| (0..mesh.triangles.len()).step_by(step).map(|t| mesh.corners(t)));
        own.chain(placed(scene, step)).filter(move |corners| length(corners) < large).flatten()
    }

    pub(super) fn centre(&self) -> Vec3 {
        self.low + 0.5 * (self.high - self.low)
    }
}

/// Every so many of the triangles of each instance.
fn placed(scene: &Scene, step: usize) -> impl Iterator<Item = [Vec3; 3]> + '_ {
    let surfaces = scene.instances.surfaces();
    surfaces
        .flat_map(move |(_, mesh, place)| (0..mesh.triangles.len()).step_by(step).map(move |t| place.facet(mesh, t)))
}

/// The box about all triangles that are not large, and the sides of the model's box along which large ones lie, a bit each;
/// `None` where a large one lies elsewhere.
fn survey(scene: &Scene, large: f32, sides: &Sides) -> (Bounds, Option<u8>) {
    let add = |(small, along): (Bounds, Option<u8>), corners: [Vec3; 3]| match length(&corners) < large {
        true => (corners.iter().fold(small, |(low, high), p| (low.min(*p), high.max(*p))), along),
        false => (small, along.zip(sides.along(&corners)).map(|(a, b)| a | b)),
    };
    let join = |a: (Bounds, Option<u8>), b: (Bounds, Option<u8>)| {
        let small = (a.0.0.min(b.0.0), a.0.1.max(b.0.1));
        (small, a.1.zip(b.1).map(|(a, b)| a | b))
    };
    let none = (NOTHING, Some(0));
    let own = scene.meshes.iter().map(|mesh| {
        let triangles = (0..mesh.triangles.len()).into_par_iter();
        triangles.fold(|| none, |sum, t| add(sum, mesh.corners(t))).reduce(|| none, join)
    });
    let own = own.fold(none, join);
    placed(scene, scene.triangles() / INSTANCED + 1).fold(own, add)
}

/// The longest side of the box about a triangle.
fn length(corners: &[Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    (a.max(*b).max(*c) - a.min(*b).min(*c)).max_element()
}

/// The six sides of the model's box: two for each axis, the lower one first.
struct Sides {
    low: Vec3,
    high: Vec3,
    layer: f32,
    /// Which side is below.
    ground: usize,
}

/// The side that is furthest in this direction.
fn side(direction: Vec3) -> usize {
    let axis = direction.abs().max_position();
    2 * axis + usize::from(direction[axis] > 0.0)
}

impl Sides {
    /// The side along which a triangle lies: the ground, if it can be, for a ground has edges.
    fn along(&self, corners: &[Vec3; 3]) -> Option<u8> {
        let within = |side: usize| {
            let axis = side / 2;
            let distance =
                |p: &Vec3| if side.is_multiple_of(2) { p[axis] - self.low[axis] } else { self.high[axis] - p[axis] };
            corners.iter().all(|p| distance(p) <= self.layer)
        };
        [self.ground].into_iter().chain(0..6).find(|side| within(*side)).map(|side| 1 << side)
    }
}
