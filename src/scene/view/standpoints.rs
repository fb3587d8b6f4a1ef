//! Places inside a model, and whether it is a room there.

use super::Search;
use super::axes::Axes;
use super::light::arriving;
use super::pieces::{Piece, Pieces, Sight};
use super::subject::Subject;
use crate::geometry::Ray;
use crate::math::rng::Rng;
use crate::scene::Scene;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::f32::consts::PI;

/// Places that are tried in the box about the model.
const PLACES: usize = 96;
/// Rays that look about from each, of which about a twelfth are in a picture.
pub(super) const RAYS: usize = 2048;
/// Paths that look for light from each.
const PATHS: usize = 64;
/// Share of the directions in which there is a surface, from which on a place is indoors: of six sides that a room has, two may
/// be missing.
const INDOORS: f32 = 4.0 / 6.0;
/// How high eyes are between floor and ceiling: people stand, and rooms are seldom twice as high as they are.
const EYES: f32 = 0.45;
/// How far from all surfaces one can stand, as a share of the way from floor to ceiling: less than that, and a door would not
/// open, or a chair would fill the picture.
const CLEARANCE: f32 = 0.1;

/// A place, and what is seen from there.
pub(super) struct Standpoint {
    pub(super) place: Vec3,
    /// In the directions of [`sphere`].
    pub(super) sights: Vec<Option<Sight>>,
    /// Whether there are surfaces in most directions.
    pub(super) indoors: bool,
    /// Whether nothing is too near.
    pub(super) clear: bool,
    /// Whether light arrives.
    pub(super) lit: bool,
}

/// Directions evenly over the sphere: a spiral by the golden angle.
pub(super) fn sphere(axes: &Axes) -> Vec<Vec3> {
    let golden = PI * (3.0 - 5f32.sqrt());
    let direction = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f32 / RAYS as f32;
        let (sin, cos) = (golden * k as f32).sin_cos();
        (axes.front * cos + axes.side * sin) * (1.0 - z * z).sqrt() + axes.up * z
    };
    (0..RAYS).map(direction).collect()
}

/// Places evenly over the box about what is to be seen, each at the height of eyes between what is above and below it.
pub(super) fn inside(search: &Search) -> Vec<Standpoint> {
    let Search { scene, axes, subject, pieces, sphere, .. } = search;
    // Whatever is up, so that a model which lies is tried in the places of one that stands.
    let reach = axes.side.abs() + axes.up.abs() + axes.front.abs();
    let point = |k: usize| {
        let at = 2.0 * spread(k) - 1.0;
        let at = (axes.side * at.x + axes.up * at.y + axes.front * at.z) / reach;
        subject.centre() + at * 0.5 * (subject.high - subject.low)
    };
    let standpoint = |k: usize| {
        let (place, height) = at_eye_level(scene, axes, subject, point(k));
        Standpoint::new(scene, pieces, sphere, place, height)
    };
    (0..PLACES).into_par_iter().map(standpoint).collect()
}

/// Point `k` of a sequence that fills the unit cube evenly (M. Roberts 2018, R₃: multiples of powers of the inverse of the root
/// of x⁴ = x + 1).
fn spread(k: usize) -> Vec3 {
    const ROOT: f64 = 1.220_744_084_605_76;
    let powers = DVec3::new(ROOT.powi(-1), ROOT.powi(-2), ROOT.powi(-3));
    (powers * (k + 1) as f64).fract().as_vec3()
}

/// The place above or below `p`, and how high it is there from floor to ceiling. The box ends what nothing else ends.
fn at_eye_level(scene: &Scene, axes: &Axes, subject: &Subject, p: Vec3) -> (Vec3, f32) {
    let way = |dir: Vec3| {
        let corner = Vec3::select(dir.cmpgt(Vec3::ZERO), subject.high, subject.low);
        let hit = scene.geometry().intersect(&Ray { org: p, dir, tfar: f32::INFINITY });
        hit.map_or((corner - p).dot(dir), |hit| hit.t)
    };
    let (above, below) = (way(axes.up), way(-axes.up));
    (p + axes.up * (EYES * (above + below) - below), above + below)
}

impl Standpoint {
    /// `height`: from floor to ceiling.
    pub(super) fn new(scene: &Scene, pieces: &Pieces, sphere: &[Vec3], place: Vec3, height: f32) -> Standpoint {
        let sights = pieces.seen(scene, place, sphere);
        let met = sights.iter().flatten();
        Standpoint {
            place,
            indoors: met.clone().count() as f32 >= INDOORS * RAYS as f32,
            clear: met.map(|sight| sight.distance).fold(f32::INFINITY, f32::min) >= CLEARANCE * height,
            lit: is_lit(scene, place, sphere),
            sights,
        }
    }
}

fn is_lit(scene: &Scene, place: Vec3, sphere: &[Vec3]) -> bool {
    let mut rng = Rng::new(0);
    let mut ways = sphere.iter().skip(RAYS / PATHS / 2).step_by(RAYS / PATHS);
    ways.any(|&dir| arriving(scene, Ray { org: place, dir, tfar: f32::INFINITY }, &mut rng) > 0.0)
}

/// What is seen in rooms, where most of the model's inside is rooms; `None` where it is something to be seen from outside. Places
/// that no light reaches, as within solids, are neither.
pub(super) fn rooms(places: &[Standpoint]) -> Option<FxHashSet<Piece>> {
    let lit = places.iter().filter(|place| place.lit);
    let rooms: Vec<&Standpoint> = lit.clone().filter(|place| place.indoors).collect();
    let most = 2 * rooms.len() > lit.count();
    most.then(|| rooms.iter().flat_map(|place| place.sights.iter().flatten().map(|sight| sight.piece)).collect())
}
