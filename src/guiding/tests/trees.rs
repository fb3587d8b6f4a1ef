//! Trees of directions, by themselves and in a guide.

use super::directions::{chi2, turned};
use super::hemitree::LearntTree;
use super::*;
use crate::math::rng::Rng;
use crate::simd::{self, LANES, Vec3Lanes};
use crate::stats::{Domain as Whole, chi2_discrete, sidak};
use proptest::prelude::*;

/// Smallest cells along the side of the square.
const FINE: usize = 64;
/// Nodes of a tree at most: one, those of its cells, and those of theirs.
const ALL_NODES: usize = 1 + 16 + 256;

/// The middles of the smallest cells.
fn fine() -> impl Iterator<Item = Vec3> {
    (0..FINE * FINE).map(|i| {
        let at = [i % FINE, i / FINE].map(|c| (c as f32 + 0.5) / FINE as f32);
        warp::square_to_uniform_hemisphere(at)
    })
}

/// Radiance from a direction: a lobe, the sharper the larger `sharpness`, over a sky that is all but black.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    axis: Vec3,
    sharpness: f32,
}

impl Lobe {
    fn random(rng: &mut Rng) -> Lobe {
        let axis = warp::square_to_uniform_hemisphere(rng.f32x2());
        Lobe { axis, sharpness: (10.0 * rng.f32()).exp2() }
    }

    fn radiance(&self, w: Vec3) -> f32 {
        1e-4 + (self.sharpness * (w.dot(self.axis) - 1.0)).exp()
    }
}

fn look(cells: &mut LearntTree, rng: &mut Rng, lobe: &Lobe, visits: usize) {
    for _ in 0..visits {
        let w = warp::square_to_uniform_hemisphere(rng.f32x2());
        let entry = cells.entry_mut(w).expect("the direction is above the horizon");
        entry.visits += 1.0;
        entry.q += (lobe.radiance(w) - entry.q) / entry.visits;
    }
}

/// A tree that has learnt a lobe, and was cut three times.
fn learnt(rng: &mut Rng, shape: &TreeShape, lobe: &Lobe, visits: usize) -> LearntTree {
    let mut cells = LearntTree::new();
    for _ in 0..3 {
        look(&mut cells, rng, lobe, visits);
        cells = shape.refine(&cells);
    }
    look(&mut cells, rng, lobe, visits);
    cells
}

fn frozen(shape: &TreeShape, cells: &LearntTree) -> Vec<crate::guiding::Node> {
    let mut nodes = Vec::new();
    shape.freeze(cells, &|q, cos| q * cos, &mut nodes);
    nodes
}

/// Of each of the smallest cells, which entry answers for it.
fn entries_of(cells: &mut LearntTree) -> Vec<usize> {
    fine().map(|w| std::ptr::from_mut(cells.entry_mut(w).expect("above the horizon")) as usize).collect()
}

fn weight(cells: &LearntTree) -> f64 {
    // a cut cell's own entry repeats what its node's say
    let mut cells = cells.clone();
    let mut entries: Vec<(usize, f64)> = fine()
        .map(|w| {
            let entry = cells.entry_mut(w).expect("above the horizon");
            (std::ptr::from_mut(entry) as usize, entry.visits as f64)
        })
        .collect();
    entries.sort_unstable_by_key(|(entry, _)| *entry);
    entries.dedup_by_key(|(entry, _)| *entry);
    entries.iter().map(|(_, visits)| visits).sum()
}

#[test]
fn cells_are_drawn_as_often_as_their_density_says() {
    const TREES: usize = 40;
    let mut rng = Rng::new(1);
    let level = sidak(1e-6, TREES);
    let shape = TreeShape::new(0.01, 16.0);
    for _ in 0..TREES {
        let lobe = Lobe::random(&mut rng);
        let cells = learnt(&mut rng, &shape, &lobe, 5000);
        let nodes = frozen(&shape, &cells);
        let solid_angle = std::f64::consts::TAU / (FINE * FINE) as f64;
        let pmf: Vec<f64> = fine().map(|w| hemitree::pdf(&nodes, w) as f64 * solid_angle).collect();
        assert!((pmf.iter().sum::<f64>() - 1.0).abs() < 1e-5, "the density integrates to one");
        let mut counts = vec![0; FINE * FINE];
        for _ in 0..100_000 {
            // away from the borders of cells, where rounding decides
            let inside = rng.f32x2().map(|u| 0.005 + 0.99 * u);
            let (w, density) = hemitree::sample(&nodes, rng.f64(), inside);
            assert!((density / hemitree::pdf(&nodes, w) - 1.0).abs() < 1e-5, "drawn with the density asked for");
            let [x, y] = warp::uniform_hemisphere_to_square(w).map(|u| (u * FINE as f32) as usize);
            counts[y * FINE + x] += 1;
        }
        let report = chi2_discrete(&counts, &pmf);
        assert!(report.passes(level), "{lobe:?}, {} nodes: {report}", cells.nodes());
        // another tree's density
        let other =
            frozen(&shape, &learnt(&mut rng, &shape, &Lobe { sharpness: 1.5 * lobe.sharpness + 1.0, ..lobe }, 5000));
        let wrong: Vec<f64> = fine().map(|w| hemitree::pdf(&other, w) as f64 * solid_angle).collect();
        assert!(!chi2_discrete(&counts, &wrong).passes(1e-6), "{lobe:?}: a sharper lobe goes unseen");
    }
}

#[test]
fn directions_about_any_normal_follow_their_density() {
    const TREES: usize = 20;
    let mut rng = Rng::new(2);
    let level = sidak(1e-6, TREES);
    for _ in 0..TREES {
        let mut guide = guide(|s| s.table = DirectionTable::Tree);
        let n = unit(&mut rng);
        let key = state(&guide, point(&mut rng), n);
        let frame = Frame::from_normal(PackedDirection::new(n).unpack());
        let lobe = Lobe::random(&mut rng);
        for _ in 0..3 {
            look_around(&mut guide, &mut rng, (key, n), 3000, |w| lobe.radiance(frame.to_local(w)));
            guide.end_iteration(1);
        }
        let summary = summary(&guide, key);
        let distribution = guide.field().distribution(&summary, n);
        let report = chi2(&distribution, &frame, Whole::Hemisphere, &mut rng, |w| w);
        assert!(report.passes(level) && (report.mass - 1.0).abs() < 2e-3, "{lobe:?}, {n}: {report}");
        let wrong = chi2(&distribution, &frame, Whole::Hemisphere, &mut rng, turned);
        assert!(!wrong.passes(1e-6), "{lobe:?}, {n}: turned, and unseen: {wrong}");
    }
}

#[test]
fn trees_of_a_packet_are_drawn_from_as_each_by_itself() {
    let mut rng = Rng::new(14);
    let shape = TreeShape::new(0.01, 16.0);
    let sharp = frozen(&shape, &learnt(&mut rng, &shape, &Lobe { axis: Vec3::Z, sharpness: 300.0 }, 5000));
    let trees = [sharp, frozen(&shape, &LearntTree::new())];
    assert!(trees[0].len() > 2 && trees[1].len() == 1);
    for _ in 0..1000 {
        let mut lanes = GuideLanes::new();
        let (mut w, mut u, mut inside) = (Vec3Lanes::ZERO, [0.0; LANES], [[0.0; LANES]; 2]);
        for k in 0..LANES {
            if rng.f32() < 0.8 {
                lanes.set(k, unit(&mut rng), &trees[(rng.f32() < 0.3) as usize]);
            }
            w.set(k, unit(&mut rng));
            (u[k], [inside[0][k], inside[1][k]]) = (rng.f64(), rng.f32x2());
        }
        lanes.resolve();
        let asked = simd::mask(|k| k % 3 > 0);
        let (mut pdf, mut drawn, mut density) = ([-1.0; LANES], Vec3Lanes::ZERO, [0.0; LANES]);
        lanes.pdf(asked, &w, &mut pdf);
        lanes.sample(lanes.are(), &u, &inside, &mut drawn, &mut density);
        for k in 0..LANES {
            let alone = lanes.get(k);
            assert_eq!(pdf[k], alone.as_ref().filter(|_| asked.has(k)).map_or(0.0, |alone| alone.pdf(w.get(k))));
            if let Some(alone) = alone {
                assert_eq!((drawn.get(k), density[k]), alone.sample(u[k], [inside[0][k], inside[1][k]]));
            }
        }
    }
}

#[test]
fn what_is_learnt_of_a_direction_is_drawn_there() {
    // all of the light in one cell: learner and sampler must mean the same cell, near borders too
    let mut rng = Rng::new(3);
    let shape = TreeShape::new(0.01, 16.0);
    let mut cells = learnt(&mut rng, &shape, &Lobe { axis: Vec3::new(0.6, 0.0, 0.8), sharpness: 300.0 }, 5000);
    let entries = entries_of(&mut cells);
    for k in 0..2000 {
        let mut square = rng.f32x2();
        if k % 2 == 0 {
            // on a border of the smallest cells, or next to it
            square[0] = (square[0] * FINE as f32).floor() / FINE as f32 + 1e-7 * (k % 3) as f32;
        }
        let w = warp::square_to_uniform_hemisphere(square);
        let mut spike = cells.clone();
        for v in fine() {
            *spike.entry_mut(v).unwrap() = Entry { q: 0.0, visits: 1e9 };
        }
        let own = spike.entry_mut(w).unwrap();
        *own = Entry { q: 1e9, visits: 1e9 };
        let own = std::ptr::from_mut(own) as usize;
        let size = entries_of(&mut spike).iter().filter(|&&entry| entry == own).count();
        let expected = (FINE * FINE) as f32 / (size as f32 * std::f32::consts::TAU);
        let pdf = hemitree::pdf(&frozen(&shape, &spike), w);
        assert!((pdf / expected - 1.0).abs() < 0.05, "{square:?}: {pdf} in a cell of {size}, not {expected}");
    }
    let sizes: std::collections::HashSet<usize> =
        entries.iter().map(|entry| entries.iter().filter(|other| *other == entry).count()).collect();
    assert_eq!(sizes.len(), 3, "cells of all three sizes were tried: {sizes:?}");
}

#[test]
fn cells_are_cut_where_the_light_is() {
    let mut rng = Rng::new(4);
    let shape = TreeShape::new(0.02, 32.0);
    for _ in 0..20 {
        // not so near the horizon that the cosine leaves nothing of the lobe
        let axis = warp::square_to_cosine_hemisphere(rng.f32x2().map(|u| 0.2 + 0.6 * u));
        let mut cells = learnt(&mut rng, &shape, &Lobe { axis, sharpness: 300.0 }, 20_000);
        let entries = entries_of(&mut cells);
        let size = |w: Vec3| {
            let near = fine().zip(&entries).max_by(|(a, _), (b, _)| a.dot(w).total_cmp(&b.dot(w))).unwrap().1;
            entries.iter().filter(|entry| *entry == near).count()
        };
        let away = Vec3::new(-axis.x, -axis.y, axis.z);
        let away = if away.dot(axis) < 0.7 { away } else { Vec3::new(1.0, 0.0, 0.02).normalize() };
        assert_eq!((size(axis), size(away)), (1, 256), "{axis}");
        // dark cells were joined or never cut
        assert!(cells.nodes() <= 32, "{} nodes", cells.nodes());
    }
}

#[test]
fn cells_are_joined_again_where_the_light_went() {
    let mut rng = Rng::new(5);
    let shape = TreeShape::new(0.02, 32.0);
    let (old, new) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.6, 0.0, 0.8));
    let mut cells = learnt(&mut rng, &shape, &Lobe { axis: old, sharpness: 300.0 }, 20_000);
    let size = |cells: &mut LearntTree, w: Vec3| {
        let own = std::ptr::from_mut(cells.entry_mut(w).unwrap()) as usize;
        entries_of(cells).iter().filter(|&&entry| entry == own).count()
    };
    assert_eq!((size(&mut cells, old), size(&mut cells, new)), (1, 256));
    for _ in 0..4 {
        cells.entries.iter_mut().for_each(|e| e.visits *= 0.01);
        look(&mut cells, &mut rng, &Lobe { axis: new, sharpness: 300.0 }, 20_000);
        cells = shape.refine(&cells);
    }
    assert_eq!((size(&mut cells, old), size(&mut cells, new)), (256, 1));
}

/// Half of the mean of |density − L cosθ/E| over the hemisphere: the share of draws that go astray.
fn astray(lobe: &Lobe, density: impl Fn(Vec3) -> f32) -> f32 {
    let solid_angle = std::f32::consts::TAU / (FINE * FINE) as f32;
    let irradiance: f32 = fine().map(|w| lobe.radiance(w) * w.z * solid_angle).sum();
    let off = |w: Vec3| (density(w) - lobe.radiance(w) * w.z / irradiance).abs();
    0.5 * fine().map(off).sum::<f32>() * solid_angle
}

#[test]
fn a_known_radiance_is_approached() {
    let mut rng = Rng::new(6);
    let lobe = Lobe { axis: Vec3::new(0.36, 0.48, 0.8), sharpness: 100.0 };
    let truth: f32 = fine().map(|w| lobe.radiance(w) * w.z).sum::<f32>() * std::f32::consts::TAU / 4096.0;
    let shapes = [0.002, 1.0].map(|share| TreeShape::new(share, 32.0));
    let mut cells = [LearntTree::new(), LearntTree::new()];
    println!("visits: share of draws astray, of a tree, of its first 16 cells only");
    let mut errors = [1.0; 2];
    for round in 0..12 {
        // as a render does: iterations double, and half of what was known before counts
        for k in 0..2 {
            cells[k] = shapes[k].refine(&cells[k]);
            cells[k].entries.iter_mut().for_each(|e| e.visits *= 0.5);
            look(&mut cells[k], &mut rng, &lobe, 50 << round);
            let nodes = frozen(&shapes[k], &cells[k]);
            errors[k] = astray(&lobe, |w| hemitree::pdf(&nodes, w));
        }
        println!("{:7}: {:.3} ({} nodes), {:.3}", 50 << round, errors[0], cells[0].nodes(), errors[1]);
    }
    // parts know their whole's mean, and forget it as the share of older iterations does
    assert!(errors[0] < 0.1 && errors[1] > 0.6, "{errors:?}");
    let irradiance = shapes[0].totals(&cells[0]).irradiance;
    assert!((irradiance / truth - 1.0).abs() < 0.02, "irradiance {irradiance}, not {truth}");
}

#[test]
fn nodes_and_bytes_are_bounded() {
    let mut rng = Rng::new(7);
    let lobe = Lobe { axis: Vec3::Z, sharpness: 0.1 };
    let all = learnt(&mut rng, &TreeShape::new(0.0, 0.0), &lobe, 5000);
    assert_eq!((all.nodes(), all.bytes()), (ALL_NODES, ALL_NODES * bytes_per_node()));
    assert_eq!(all.entries.len(), 16 * all.nodes());
    assert_eq!(frozen(&TreeShape::new(0.0, 0.0), &all).len(), all.nodes());
    assert_eq!(size_of::<crate::guiding::Node>(), 64, "one cache line");
    for share in [0.5, 0.1, 0.03, 0.01] {
        let most = 1 + (2.0 / share) as usize;
        for _ in 0..10 {
            let lobe = Lobe::random(&mut rng);
            let shape = TreeShape::new(share, 16.0);
            let cells = shape.refine(&learnt(&mut rng, &shape, &lobe, 2000));
            // of each size, fewer than 1/share cells can have more than that share of the light
            assert!(cells.nodes() <= most, "{} nodes at a share of {share}", cells.nodes());
        }
    }
    assert_eq!(learnt(&mut rng, &TreeShape::new(0.01, f32::INFINITY), &lobe, 5000).nodes(), 1, "visits are asked for");
}

#[test]
fn nothing_known_is_drawn_from_evenly() {
    let shape = TreeShape::new(0.02, 32.0);
    let nodes = frozen(&shape, &LearntTree::new());
    assert!(fine().all(|w| (hemitree::pdf(&nodes, w) * std::f32::consts::TAU - 1.0).abs() < 1e-6));
    assert_eq!(hemitree::pdf(&nodes, -Vec3::Z), 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever was seen, cutting and joining keep all visits and an answer for every direction.
    #[test]
    fn cutting_loses_nothing(seed in any::<u64>(), rounds in 1usize..5, share in 0.001f32..0.5, least in 0.0f32..100.0, fade in 0.1f32..1.0) {
        let mut rng = Rng::new(seed);
        let shape = TreeShape::new(share, least);
        let mut cells = LearntTree::new();
        for _ in 0..rounds {
            let lobe = Lobe::random(&mut rng);
            let visits = 1 + rng.next_u32() as usize % 4000;
            look(&mut cells, &mut rng, &lobe, visits);
            let before = cells.clone();
            cells = shape.refine(&cells);
            let (old, new) = (weight(&before), weight(&cells));
            prop_assert!((new - old).abs() <= 1e-4 * old, "{} visits became {}", old, new);
            let values = |cells: &LearntTree| -> Vec<Entry> {
                let mut cells = cells.clone();
                fine().map(|w| *cells.entry_mut(w).unwrap()).collect()
            };
            let (lowest, highest) = values(&before).iter().filter(|e| e.visits > 0.0).fold((f32::MAX, 0.0f32), |(l, h), e| (l.min(e.q), h.max(e.q)));
            for (w, (old, new)) in fine().zip(values(&before).iter().zip(&values(&cells))) {
                prop_assert!(old.visits == 0.0 || new.visits > 0.0, "what was known of {} is lost", w);
                if new.visits > 0.0 {
                    prop_assert!(new.q >= 0.999 * lowest && new.q <= 1.001 * highest, "{:?} out of {:?}", new, old);
                }
            }
            let nodes = frozen(&shape, &cells);
            let mass: f64 = fine().map(|w| hemitree::pdf(&nodes, w) as f64).sum::<f64>() * std::f64::consts::TAU / 4096.0;
            prop_assert!((mass - 1.0).abs() < 1e-4, "mass {}", mass);
            cells.entries.iter_mut().for_each(|e| e.visits *= fade);
        }
    }
}
