//! Any partition of space makes a guide with any model of directions, those that the settings have no names for too.

use super::directions::{chi2, turned};
use super::one_lobe::OneLobe;
use super::*;
use crate::guiding::directional::bins::{HemisphereBins, SphereBins};
use crate::guiding::directional::hemitree::HemisphereTree;
use crate::guiding::directional::quadtree::{Fineness, SphereQuadtree};
use crate::guiding::directional::{DirectionalModel, WORLD};
use crate::guiding::spatial::{Grid, KdTree, Partition, TwoLevelGrid};
use crate::stats::{Domain as Whole, sidak};

/// False alarm of each whole set of tests here.
const LEVEL: f64 = 1e-6;

/// Memory is plenty, and cells are divided after few visits.
fn settings() -> GuidingSettings {
    GuidingSettings { refine_visits: 2000.0, sites: 8, ..GuidingSettings::default() }
}

fn spaces() -> Vec<(&'static str, Partition)> {
    let (low, high) = (Vec3::ZERO, Vec3::ONE);
    let voronoi = GuidingSettings { method: GuidingMethod::Voronoi, ..settings() };
    vec![
        ("grid", Partition::Grid(Grid::new(low, high, 2, true))),
        ("grid without normals", Partition::Grid(Grid::new(low, high, 2, false))),
        ("two-level grid", Partition::TwoLevel(TwoLevelGrid::new(low, high, 2, 3))),
        ("kd-tree", Partition::KdTree(KdTree::new(low, high, true, true))),
        ("kd-tree without normals", Partition::KdTree(KdTree::new(low, high, false, false))),
        ("Voronoi", Partition::new(&voronoi, (low, high), std::iter::empty(), 1000).expect("there is a method")),
    ]
}

fn models() -> Vec<(&'static str, Model)> {
    vec![
        ("hemisphere tree", Model::Tree(HemisphereTree::new(0.02, 32.0))),
        ("hemisphere bins", Model::Hemisphere(HemisphereBins::new(12))),
        ("sphere bins", Model::Sphere(SphereBins::new(12))),
        ("quadtree", Model::Quadtree(SphereQuadtree::new(Fineness::new(0.02, 6), true, 1 << 20))),
    ]
}

/// Over a floor, light from one side for one half of it, from the other for the other.
fn light(p: Vec3, w: Vec3) -> f32 {
    let axis = Vec3::new(if p.x < 0.5 { 0.6 } else { -0.6 }, 0.8, 0.0);
    0.02 + (0.5 + 0.5 * w.dot(axis)).powi(20)
}

/// Learns from `n` visits all over the floor, and ends an iteration.
fn iterate<S: SpatialPartition, D: DirectionalModel>(guide: &mut Guide<S, D>, rng: &mut Rng, n: usize) {
    let (mut recorder, up) = (Recorder::new(), Frame::from_normal(Vec3::Y));
    for _ in 0..n {
        let p = Vec3::new(rng.f32(), 0.5, rng.f32());
        let w = up.to_world(warp::square_to_uniform_hemisphere(rng.f32x2()));
        match guide.field().locate(p, Vec3::Y, [rng.f32(), rng.f32(), rng.f32()]) {
            Some(at) => recorder.push(visit(at.recorded, Vec3::Y, w, light(p, w))),
            None => recorder.push_point(p, Vec3::Y),
        }
    }
    guide.learn(&[&recorder]);
    guide.end_iteration(1);
}

/// Where the light is from one side only, in any of these partitions.
const POINT: Vec3 = Vec3::new(0.12, 0.5, 0.3);

fn known<S: SpatialPartition, D: DirectionalModel>(guide: &Guide<S, D>) -> Option<RegionInfo> {
    guide.field().summary(guide.field().locate(POINT, Vec3::Y, [0.5; 3])?.drawn).copied()
}

/// Share of the draws that go astray: half of the mean of |density − target| over the sphere, the target being in
/// proportion to the radiance, times the cosine where a model goes by that.
fn astray<S: SpatialPartition, D: DirectionalModel>(guide: &Guide<S, D>, cosine: bool) -> f32 {
    const SIDE: usize = 64;
    let directions = (0..SIDE * SIDE).map(|i| {
        let at = [i % SIDE, i / SIDE].map(|c| (c as f32 + 0.5) / SIDE as f32);
        Frame::from_normal(Vec3::Y).to_world(warp::square_to_uniform_hemisphere(at))
    });
    let directions: Vec<Vec3> = directions.collect();
    let target = |w: &Vec3| light(POINT, *w) * if cosine { w.y } else { 1.0 };
    let solid_angle = std::f32::consts::TAU / directions.len() as f32;
    let whole: f32 = directions.iter().map(target).sum::<f32>() * solid_angle;
    let Some(info) = known(guide) else { return 1.0 };
    let drawn = guide.field().distribution(&info, Vec3::Y);
    let covered: f32 = directions.iter().map(|w| drawn.pdf(*w).min(target(w) / whole)).sum();
    1.0 - covered * solid_angle
}

#[test]
fn every_pair_learns_and_draws_by_the_density_that_it_claims() {
    let mut rng = Rng::new(1);
    let level = sidak(LEVEL, spaces().len() * models().len());
    for (space, partition) in spaces() {
        for (name, model) in models() {
            let cosine = name != "quadtree";
            let mut guide = Guide::of(&settings(), partition.clone(), model);
            let errors: Vec<f32> = (0..6)
                .map(|k| {
                    iterate(&mut guide, &mut rng, 5_000 << k);
                    astray(&guide, cosine)
                })
                .collect();
            println!("{space} × {name}: {} regions, draws astray {errors:.3?}", guide.states());
            assert!(errors[5] < 0.25 && errors[5] < errors[0], "{space} × {name}: {errors:?}");
            let info = known(&guide).expect("the floor was visited");
            let drawn = guide.field().distribution(&info, Vec3::Y);
            let domain = if drawn.frame.n == WORLD.n { Whole::Sphere } else { Whole::Hemisphere };
            let report = chi2(&drawn, &drawn.frame, domain, &mut rng, |w| w);
            assert!(report.passes(level) && (report.mass - 1.0).abs() < 2e-3, "{space} × {name}: {report}");
            let wrong = chi2(&drawn, &drawn.frame, domain, &mut rng, turned);
            assert!(!wrong.passes(LEVEL), "{space} × {name}: turned, and unseen: {wrong}");
        }
    }
}

/// A model that is nothing but its own file: it learns, draws, is divided in space, and comes back from a file.
#[test]
fn a_model_of_ones_own_makes_a_guide_with_any_partition() {
    let mut rng = Rng::new(2);
    let level = sidak(LEVEL, spaces().len());
    for (space, partition) in spaces() {
        let mut guide = Guide::of(&settings(), partition.clone(), OneLobe);
        let errors: Vec<f32> = (0..5)
            .map(|k| {
                iterate(&mut guide, &mut rng, 5_000 << k);
                astray(&guide, false)
            })
            .collect();
        assert!(errors[4] < 0.35, "{space}: {errors:?}");
        let info = known(&guide).expect("the floor was visited");
        let drawn = guide.field().distribution(&info, Vec3::Y);
        let report = chi2(&drawn, &WORLD, Whole::Sphere, &mut rng, |w| w);
        assert!(report.passes(level) && (report.mass - 1.0).abs() < 2e-3, "{space}: {report}");
        let wrong = chi2(&drawn, &WORLD, Whole::Sphere, &mut rng, turned);
        assert!(!wrong.passes(LEVEL), "{space}: turned, and unseen: {wrong}");
        let mut back = Guide::of(&settings(), partition, OneLobe);
        back.restore(guide.stored()).expect("what was stored can be restored");
        assert_eq!((back.stats(), known(&back)), (guide.stats(), known(&guide)), "{space}");
    }
}

/// Where cells are divided by a partition's own rule, each region is one that it holds, and none is lost.
#[test]
fn divided_regions_are_those_of_the_partition() {
    let mut rng = Rng::new(3);
    for (space, partition) in spaces() {
        let divides = partition.cells() > 0;
        let mut guide = Guide::of(&settings(), partition, OneLobe);
        for k in 0..5 {
            iterate(&mut guide, &mut rng, 5_000 << k);
            assert!(guide.store.regions().all(|region| guide.partition.holds(region.key)), "{space}");
        }
        let visits: f64 = guide.store.regions().map(|region| f64::from(region.fresh)).sum();
        assert!(!divides || guide.states() > 4, "{space}: {} regions", guide.states());
        assert!(visits <= (5_000 << 4) as f64, "{space}: {visits} visits");
    }
}
