//! A path that splits, its targets computed by hand.

use super::*;
use crate::guiding::recorder::SHARDS;
use crate::guiding::{PackedDirection, RegionId};
use glam::Vec3;

fn edge(key: u64) -> Option<PathSegment> {
    let [wi, normal] = [Vec3::X, Vec3::Y].map(PackedDirection::new);
    let scattered = 0.25;
    Some(PathSegment { key: RegionId(key), wi, normal, pdf: 0.5, bsdf_pdf: 0.75, guide_pdf: -1.0, scattered })
}

type Expected = Option<Targets<BootstrapValue>>;

type Vertex = (VertexRecord, Rgb, Expected);

fn vertex(parent: u32, weight: f32, edge: Option<PathSegment>, local: f32, expected: Expected) -> Vertex {
    let weight = Targets { rule: weight, moments: weight }.map(Rgb::splat);
    (VertexRecord { parent, weight, edge }, Rgb::splat(local), expected)
}

fn record_all(waves: &[Vec<Vertex>], buffers: &mut [Vec<Return>; 2], recorder: &mut Recorder) {
    let wave = |wave: &Vec<Vertex>| {
        let (mut arrivals, mut vertices) = (VertexRecords::default(), WaveRecord::default());
        wave.iter().for_each(|(arrival, ..)| arrivals.push(arrival));
        vertices.begin(&mut arrivals);
        for (i, &(_, local, expected)) in wave.iter().enumerate() {
            (vertices.local[i], vertices.expected[i]) = (local, expected.unwrap_or(Targets::NOTHING_EXPECTED));
            vertices.shadows[i] = ShadowOutcome::new(1.0 + i as f32, true);
        }
        vertices
    };
    record(&mut waves.iter().map(wave).collect::<Vec<_>>(), buffers, recorder);
}

/// What a rule expects of a grey surface of albedo 1/2 under an irradiance of 4π (a peak of 6π), after 30 visits.
const RULES: [LearningRule; 4] =
    [LearningRule::MonteCarlo, LearningRule::ExpectedSarsa, LearningRule::QLearning, LearningRule::Blend];

fn expected(rule: LearningRule) -> Expected {
    let pi = std::f32::consts::PI;
    let value = |rule| BootstrapValue::new(rule, 10.0, (4.0 * pi, 6.0 * pi, 30.0), Rgb::splat(0.5));
    Some(Targets::expected(rule, value))
}

/// The camera sees x; from there one path goes to y1 and another to y2, and from y1 on to z. Beside it, a second path
/// leaves the scene at once. Returns state, target and rays of what is recorded, sorted by the target's state.
fn learnt(x: Expected, y: Expected) -> Vec<(u64, f32, f32)> {
    recorded(x, y).into_iter().map(|t| (t.key.0, t.target, f32::from(t.rays))).collect()
}

/// The same with the targets of roulette's moments.
fn bootstrapped(x: Expected, y: Expected) -> Vec<(u64, f32, f32)> {
    recorded(x, y).into_iter().map(|t| (t.key.0, t.bootstrapped, f32::from(t.rays))).collect()
}

fn recorded(x: Expected, y: Expected) -> Vec<Transition> {
    let waves = vec![
        vec![vertex(u32::MAX, 1.0, None, 9.0, None), vertex(u32::MAX, 1.0, None, 0.25, x)],
        vec![vertex(1, 0.5, edge(10), 1.0, y), vertex(1, 0.25, edge(11), 3.0, None)],
        vec![vertex(0, 2.0, edge(20), 5.0, None)],
        // longer paths have been here before
        Vec::new(),
    ];
    let mut recorder = Recorder::new();
    // memory that an earlier batch has left behind
    let radiance = Targets { rule: Rgb::splat(1e9), moments: Rgb::splat(1e9) };
    let rest = || vec![Return { radiance, rays: 1e9 }; 3];
    record_all(&waves, &mut [rest(), rest()], &mut recorder);
    let mut all: Vec<Transition> = (0..SHARDS).flat_map(|shard| recorder.shard(shard)).copied().collect();
    all.sort_by_key(|t| t.key);
    all
}

fn near(found: &[(u64, f32, f32)], by_hand: &[(u64, f32, f32)]) -> bool {
    let same = |(a, b): (&(u64, f32, f32), &(u64, f32, f32))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-5 && a.2 == b.2;
    found.len() == by_hand.len() && found.iter().zip(by_hand).all(same)
}

#[test]
fn each_rule_learns_what_it_says() {
    // from z arrives its own 5; y1 has 1, and finds 2·5 beyond; y2 has 3
    let by_hand = |y1: f32| [(10, y1, 2.0), (11, 3.0, 1.0), (20, 5.0, 1.0)];
    let cases = [
        (LearningRule::MonteCarlo, 1.0 + 10.0),
        // albedo/π · E = 1/2 · 4
        (LearningRule::ExpectedSarsa, 1.0 + 2.0),
        (LearningRule::QLearning, 1.0 + 3.0),
        // 30 of 40 parts of the expectation
        (LearningRule::Blend, 1.0 + 0.75 * 2.0 + 0.25 * 10.0),
    ];
    for (rule, y1) in cases {
        let found = learnt(expected(rule), expected(rule));
        assert!(near(&found, &by_hand(y1)), "{rule:?}: {found:?}");
        assert!(!near(&found, &by_hand(y1 + 1e-3)), "{rule:?}");
    }
}

#[test]
fn a_part_that_is_expected_is_added_to_what_the_path_finds() {
    // of y1, diffuse lobes bring 1/2 · 4 by the table, and the path 2·5 by the others: its weight leaves the diffuse ones out
    let parts = [
        (LearningRule::ExpectedSarsa, 1.0 + 2.0 + 10.0),
        (LearningRule::Blend, 1.0 + 0.75 * 2.0 + 10.0),
        (LearningRule::MonteCarlo, 1.0 + 10.0),
    ];
    for (rule, y1) in parts {
        let part = expected(rule).map(|values| values.map(BootstrapValue::of_a_part));
        let found = learnt(None, part);
        assert!(near(&found, &[(10, y1, 2.0), (11, 3.0, 1.0), (20, 5.0, 1.0)]), "{rule:?}: {found:?}");
        let found = bootstrapped(None, part);
        assert!(near(&found, &[(10, 1.0 + 2.0 + 10.0, 2.0), (11, 3.0, 1.0), (20, 5.0, 1.0)]), "{rule:?}: {found:?}");
    }
}

/// Where the table knows a state, roulette's moments are of what the next vertex adds and its table expects on average: albedo/π · E =
/// 1/2 · 4 at y1. Where it does not, of what the path finds.
#[test]
fn moments_are_of_bootstrapped_targets_under_every_rule() {
    for rule in RULES {
        let found = bootstrapped(expected(rule), expected(rule));
        assert!(near(&found, &[(10, 1.0 + 2.0, 2.0), (11, 3.0, 1.0), (20, 5.0, 1.0)]), "{rule:?}: {found:?}");
        let found = bootstrapped(None, None);
        assert!(near(&found, &[(10, 1.0 + 10.0, 2.0), (11, 3.0, 1.0), (20, 5.0, 1.0)]), "{rule:?}: {found:?}");
    }
}

/// What flows back to each target goes by that target's weight.
#[test]
fn each_target_has_its_own_weight() {
    let mut waves = vec![
        vec![vertex(u32::MAX, 1.0, None, 0.0, None)],
        vec![vertex(0, 1.0, edge(1), 0.5, None)],
        vec![vertex(0, 2.0, edge(2), 1.0, None)],
    ];
    waves[2][0].0.weight.moments = Rgb::splat(0.25);
    let mut recorder = Recorder::new();
    record_all(&waves, &mut [Vec::new(), Vec::new()], &mut recorder);
    let first = (0..SHARDS).flat_map(|shard| recorder.shard(shard)).find(|t| t.key == RegionId(1)).unwrap();
    assert!((first.target - 2.5).abs() < 1e-5 && (first.bootstrapped - 0.75).abs() < 1e-5, "{first:?}");
}

#[test]
fn what_the_camera_sees_is_nobody_s_to_learn() {
    // whatever is expected at the camera's vertex, the targets are the same, and none is its own
    let sarsa = expected(LearningRule::ExpectedSarsa);
    assert_eq!(learnt(None, sarsa), learnt(sarsa, sarsa));
    assert_eq!(learnt(None, None).len(), 3);
}

#[test]
fn parts_of_a_split_add_up() {
    // the first vertex of three is where the path splits: its arrival is learnt as well
    let waves = vec![
        vec![vertex(u32::MAX, 1.0, None, 0.0, None)],
        vec![vertex(0, 1.0, edge(1), 0.5, None)],
        vec![
            vertex(0, 0.5, edge(2), 1.0, None),
            vertex(0, 0.25, edge(3), 2.0, None),
            vertex(0, 1.0, edge(4), 4.0, None),
        ],
    ];
    let mut recorder = Recorder::new();
    record_all(&waves, &mut [Vec::new(), Vec::new()], &mut recorder);
    let found = (0..SHARDS).flat_map(|shard| recorder.shard(shard)).find(|t| t.key == RegionId(1)).unwrap();
    assert!((found.target - (0.5 + 0.5 + 0.5 + 4.0)).abs() < 1e-5 && found.rays == 4, "{found:?}");
    let Transition { pdf, bsdf_pdf, guide_pdf, scattered, .. } = *found;
    assert_eq!((pdf, bsdf_pdf, guide_pdf, scattered), (0.5, 0.75, -1.0, 0.25));
}

/// What a shadow ray has found is told once, however many branches go on, and by one that teaches.
#[test]
fn a_shadow_ray_is_told_once() {
    let waves = vec![
        vec![vertex(u32::MAX, 1.0, None, 0.0, None), vertex(u32::MAX, 1.0, None, 0.0, None)],
        vec![vertex(1, 1.0, None, 0.0, None), vertex(1, 1.0, edge(1), 0.0, None), vertex(1, 1.0, edge(2), 0.0, None)],
    ];
    let mut recorder = Recorder::new();
    record_all(&waves, &mut [Vec::new(), Vec::new()], &mut recorder);
    let mut told: Vec<_> = (0..SHARDS).flat_map(|shard| recorder.shard(shard)).map(|t| (t.key.0, t.shadow)).collect();
    told.sort_by_key(|(key, _)| *key);
    assert_eq!(told, [(1, ShadowOutcome::new(2.0, true)), (2, ShadowOutcome::NONE)]);
}

#[test]
fn what_is_not_finite_is_not_learnt() {
    for bad in [f32::INFINITY, f32::NAN] {
        let waves = vec![
            vec![vertex(u32::MAX, 1.0, None, 0.0, None), vertex(u32::MAX, 1.0, None, 0.0, None)],
            vec![vertex(0, 1.0, edge(1), bad, None), vertex(1, 1.0, edge(2), 1.0, None)],
        ];
        let mut recorder = Recorder::new();
        record_all(&waves, &mut [Vec::new(), Vec::new()], &mut recorder);
        assert_eq!(recorder.len(), 1);
    }
}
