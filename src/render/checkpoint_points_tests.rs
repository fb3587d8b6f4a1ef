//! Wherever a render is left, it goes on to the same bits: at twenty points that chance has chosen, for each guide
//! (`auto` at regular ones, in `checkpoint_tests`).

use super::super::{GuideIo, Rendering, Settings, Stop, render_shown};
use super::Header;
use super::tests::{Keeper, Stopper, assert_same, door, gone_on};
use crate::integrator::probe::Watch;
use crate::math::rng::Rng;
use crate::scene::Scene;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

const POINTS: usize = 20;

/// Renders until `watch` has seen enough, and returns the checkpoint of the end.
fn left<W: Watch>(
    (scene, settings): (&Scene, &Settings),
    keeper: &mut Keeper,
    (watch, stop): (&W, &Stop),
) -> (Rendering, Option<PathBuf>) {
    let rendering = render_shown(scene, settings, GuideIo::default(), watch, stop, (&mut |_| true, keeper));
    (rendering, keeper.written.pop())
}

/// Leaves a render at [`POINTS`] tasks, in the middle of a pass if `at_once`, and goes on from each; with how many different points
/// these were, by the paths that were traced.
fn check(set: &[&str], at_once: bool) -> usize {
    let (scene, settings) = door(&[&["render.spp=11"], set].concat());
    let header = Header::new(&scene, &settings, ());
    let job = (&scene, &settings);
    let all = Stopper::new(usize::MAX, at_once);
    let (whole, _) = left(job, &mut Keeper::new(&header, usize::MAX), (&all, &all.stop));
    let tasks = all.begun.load(Ordering::Relaxed);
    let (mut rng, mut paths) = (Rng::new(20), BTreeSet::new());
    for _ in 0..POINTS {
        let at = 1 + rng.next_u32() as usize % tasks;
        let watch = Stopper::new(at, at_once);
        let mut keeper = Keeper::new(&header, usize::MAX);
        let (cut, checkpoint) = left(job, &mut keeper, (&watch, &watch.stop));
        paths.insert(cut.total().paths);
        assert_same(&whole, &gone_on(&checkpoint.unwrap(), &scene, &settings), &format!("{set:?}, left at {at}"));
    }
    paths.len()
}

#[test]
fn at_random_points_of_each_guide() {
    for set in [
        &["guiding.method=none"][..],
        &["guiding.method=grid", "guiding.table=hemisphere"],
        &["guiding.method=adaptive"],
        &["guiding.method=voronoi", "guiding.placement=paths"],
        &["guiding.method=sdtree"],
    ] {
        let points = check(set, true);
        assert!(points >= 8, "{set:?}: only {points} different points");
    }
}

#[test]
fn between_random_passes_of_a_guide_that_learns_round_by_round() {
    let points = check(&["guiding.method=grid", "guiding.updates=online"], false);
    assert!(points >= 4, "only {points} different points");
}
