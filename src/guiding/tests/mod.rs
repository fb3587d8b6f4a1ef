//! The guide without a renderer: what goes in is known, so what comes out can be held against it.

mod directions;
mod learning;
mod lessons;
mod one_lobe;
mod pairs;
mod rates;
mod refining;
mod sdtree;
mod states;
mod trees;

use super::directional::bins::{Domain, Strata};
use super::directional::hemitree::{TreeShape, bytes_per_node};
use super::directional::{Entry, Learnt, Model, hemitree};
use super::region::{Region, ReturnMoments};
use super::spatial::SpatialPartition;
use super::*;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Rate};
use crate::math::Frame;
use crate::math::rng::Rng;
use crate::math::warp;
use glam::Vec3;

/// A guide of a cube of side 1: a grid of strata of the hemisphere, at the vanishing rate, unless changed.
fn guide(change: impl FnOnce(&mut GuidingSettings)) -> Guide {
    let mut settings = GuidingSettings {
        method: GuidingMethod::Grid,
        table: DirectionTable::Hemisphere,
        resolution: 8,
        rate: Rate::Vanishing,
        ..GuidingSettings::default()
    };
    change(&mut settings);
    Guide::new(&settings, (Vec3::ZERO, Vec3::ONE), std::iter::empty()).expect("the method is one of guides")
}

/// Uniform on the sphere.
fn unit(rng: &mut Rng) -> Vec3 {
    warp::square_to_uniform_sphere(rng.f32x2())
}

fn point(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.f32(), rng.f32(), rng.f32())
}

/// The state at `p` on the side of `n`, without jitter.
fn state(guide: &Guide, p: Vec3, n: Vec3) -> RegionId {
    guide.partition.locate(p, n, [0.5; 3]).expect("cells are everywhere").recorded
}

/// A visit to a Lambertian surface, its direction drawn uniformly from the hemisphere about `n`.
fn visit(key: RegionId, n: Vec3, wi: Vec3, target: f32) -> Transition {
    let cos = wi.dot(n).max(0.0);
    Transition {
        key,
        wi: PackedDirection::new(wi),
        normal: PackedDirection::new(n),
        target,
        bootstrapped: target,
        pdf: 0.5 * std::f32::consts::FRAC_1_PI,
        bsdf_pdf: cos * std::f32::consts::FRAC_1_PI,
        guide_pdf: -1.0,
        scattered: cos * std::f32::consts::FRAC_1_PI,
        hue: Hue::GREY,
        rays: 2,
        shadow: ShadowOutcome::NONE,
    }
}

/// All transitions in one recorder.
fn learn(guide: &mut Guide, transitions: impl IntoIterator<Item = Transition>) {
    let mut recorder = Recorder::new();
    transitions.into_iter().for_each(|t| recorder.push(t));
    guide.learn(&[&recorder]);
}

/// Visits each stratum of a state with the normal `n` in its middle, `visits` times, and finds `row` there.
fn teach(guide: &mut Guide, key: RegionId, n: Vec3, row: &[f32], visits: usize) {
    let strata = match &guide.store.model {
        Model::Hemisphere(bins) => bins.strata().clone(),
        Model::Sphere(bins) => bins.strata().clone(),
        _ => panic!("the model has strata"),
    };
    let sphere = strata.domain() == Domain::Sphere;
    // the table lies about the normal as it is packed
    let frame = Frame::from_normal(PackedDirection::new(n).unpack());
    let middle = |k: usize| {
        let w = strata.direction(k, [0.5; 2]);
        if sphere { w } else { frame.to_world(w) }
    };
    let visits = row.iter().enumerate().flat_map(|(k, q)| (0..visits).map(move |_| (k, *q)));
    learn(guide, visits.map(|(k, q)| visit(key, n, middle(k), q)));
}

/// Visits a state `visits` times in random directions, and finds what `light` sends from there (in world space).
fn look_around(
    guide: &mut Guide,
    rng: &mut Rng,
    (key, n): (RegionId, Vec3),
    visits: usize,
    light: impl Fn(Vec3) -> f32,
) {
    let frame = Frame::from_normal(n);
    let transitions: Vec<Transition> = (0..visits)
        .map(|_| frame.to_world(warp::square_to_uniform_hemisphere(rng.f32x2())))
        .map(|w| visit(key, n, w, light(w)))
        .collect();
    learn(guide, transitions);
}

/// All that a learner knows, in bits.
fn contents(guide: &Guide) -> Vec<(RegionId, Vec<u32>)> {
    let bits = |state: &Region<Learnt>| {
        let entries = entries(state).iter().flat_map(|e| [e.q, e.visits]);
        let (r, f, v) = (state.returns, state.fraction, state.visibility);
        let rest = [state.visits, state.fresh, r.weight, r.mean, r.square, r.rays, f.value(), v.rays, v.open];
        entries.chain(rest).map(f32::to_bits).collect()
    };
    guide.store.regions().map(|state| (state.key, bits(state))).collect()
}

/// What a table knows of its cells, one after the other.
fn entries(region: &Region<Learnt>) -> &[Entry] {
    match &region.directions {
        Learnt::Tree(cells) => &cells.entries,
        Learnt::Hemisphere(entries) | Learnt::Sphere(entries) => entries,
        Learnt::Quadtree(_) => panic!("a quadtree has no entries"),
    }
}

/// The entries of a state.
fn row(guide: &Guide, key: RegionId) -> Vec<Entry> {
    entries(guide.store.get(key).expect("the state is in the table")).to_vec()
}

/// What the snapshot knows of a state.
fn summary(guide: &Guide, key: RegionId) -> RegionInfo {
    *guide.field().summary(key).expect("enough visits")
}
