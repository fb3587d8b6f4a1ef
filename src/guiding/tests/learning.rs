//! What is learnt from known targets, and how much memory it takes.

use super::*;
use crate::guiding::visibility::Visibility;
use crate::math::Rgb;
use crate::math::rng::Rng;
use proptest::prelude::*;

pub(super) const TABLES: [DirectionTable; 3] =
    [DirectionTable::Hemisphere, DirectionTable::Sphere, DirectionTable::Tree];

pub(super) fn random_transitions(rng: &mut Rng, guide: &Guide, n: usize) -> Vec<Transition> {
    let one = |rng: &mut Rng| {
        let normal = unit(rng);
        let key = state(guide, point(rng), normal);
        let wi = Frame::from_normal(normal).to_world(warp::square_to_uniform_hemisphere(rng.f32x2()));
        // from 2⁻⁴⁰ to 2⁴⁰, a tenth of them black
        let target = if rng.f32() < 0.1 { 0.0 } else { (80.0 * rng.f32() - 40.0).exp2() };
        let guide_pdf = if rng.f32() < 0.2 { -1.0 } else { rng.f32() };
        let (rays, bsdf_pdf) = (1 + (9.0 * rng.f32()) as u16, rng.f32());
        let seen = ShadowOutcome::new(1.0 + 9.0 * rng.f32(), rng.f32() < 0.3);
        let shadow = if rng.f32() < 0.2 { ShadowOutcome::NONE } else { seen };
        Transition { rays, bsdf_pdf, guide_pdf, shadow, ..visit(key, normal, wi, target) }
    };
    (0..n).map(|_| one(rng)).collect()
}

/// The transitions in recorders of the given sizes, in their order.
fn recorders(transitions: &[Transition], size: usize) -> Vec<Recorder> {
    let fill = |part: &[Transition]| {
        let mut recorder = Recorder::new();
        part.iter().for_each(|t| recorder.push(*t));
        recorder
    };
    transitions.chunks(size).map(fill).collect()
}

fn learn_all(guide: &mut Guide, transitions: &[Transition], size: usize) {
    guide.learn(&recorders(transitions, size).iter().collect::<Vec<_>>());
}

#[test]
fn values_stay_finite_and_never_fall_below_zero() {
    let mut rng = Rng::new(1);
    let rates =
        [Rate::Vanishing, Rate::Forgetting(0.5), Rate::Forgetting(0.0), Rate::Constant(0.1), Rate::Constant(1.0)];
    for (table, rate) in TABLES.into_iter().flat_map(|table| rates.map(|rate| (table, rate))) {
        for method in [GuidingMethod::Grid, GuidingMethod::Adaptive] {
            let mut guide = guide(|s| {
                (s.table, s.rate, s.method, s.resolution) = (table, rate, method, 2);
                (s.refine_visits, s.learned_fraction) = (50.0, Some(true));
            });
            for _ in 0..4 {
                let transitions = random_transitions(&mut rng, &guide, 20_000);
                learn_all(&mut guide, &transitions, 1000);
                guide.end_iteration(1);
                let holds = |e: &Entry| e.q.is_finite() && e.q >= 0.0 && e.visits.is_finite() && e.visits >= 0.0;
                for state in guide.store.regions() {
                    assert!(entries(state).iter().all(holds), "{table:?}, {rate:?}");
                    let r = state.returns;
                    assert!([r.weight, r.mean, r.square, r.rays].iter().all(|v| v.is_finite() && *v >= 0.0));
                    assert!((0.0..=1.0).contains(&state.fraction.value()), "{table:?}, {rate:?}");
                }
            }
            assert!(guide.field().len() > 100, "{table:?}, {rate:?}: {} states can be drawn from", guide.field().len());
        }
    }
}

#[test]
fn how_transitions_are_shared_among_recorders_and_threads_changes_nothing() {
    let mut rng = Rng::new(2);
    for table in TABLES {
        let new = || guide(|s| s.table = table);
        let transitions = random_transitions(&mut rng, &new(), 20_000);
        let learnt = |size: usize, threads: usize| {
            let mut guide = new();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| learn_all(&mut guide, &transitions, size));
            contents(&guide)
        };
        let one = learnt(transitions.len(), 1);
        for (size, threads) in [(transitions.len(), 3), (100, 1), (777, 3), (1, 2)] {
            assert!(one == learnt(size, threads), "{table:?}: recorders of {size}, {threads} threads");
        }
        // the order, in contrast, is seen in the last bits
        let mut turned = transitions.clone();
        turned.reverse();
        let mut other = new();
        learn_all(&mut other, &turned, turned.len());
        assert!(one != contents(&other), "{table:?}");
    }
}

/// Powers of two leave every digit as it is, so that nothing may change but the exponents of what is a radiance.
#[test]
fn light_scaled_by_a_power_of_two_scales_every_bit() {
    let learnt = |table: DirectionTable, rate: Rate, scale: f32, lift: f32| {
        let mut guide = guide(|s| {
            (s.table, s.rate, s.resolution, s.learned_fraction) = (table, rate, 2, Some(true));
            (s.mis_compensation, s.smoothing) = (true, 0.25);
        });
        let mut rng = Rng::new(3);
        for _ in 0..3 {
            let mut transitions = random_transitions(&mut rng, &guide, 20_000);
            // six orders of magnitude, so that squares stay normal numbers
            transitions.iter_mut().for_each(|t| {
                t.target = t.target.powf(0.25) * scale + lift;
                t.bootstrapped = t.target;
            });
            learn_all(&mut guide, &transitions, 1000);
            guide.end_iteration(1);
        }
        guide
    };
    for table in TABLES {
        for rate in [Rate::Vanishing, Rate::Forgetting(0.5), Rate::Constant(0.125)] {
            let one = learnt(table, rate, 1.0, 0.0);
            for scale in [2.0f32.powi(-20), 2.0f32.powi(20)] {
                assert!(scaled_alike(&one, &learnt(table, rate, scale, 0.0), scale), "{table:?}, {rate:?}, {scale:e}");
            }
            // an absolute radiance, however small, would be seen
            assert!(!scaled_alike(&one, &learnt(table, rate, 1.0, 1e-6), 1.0));
        }
    }
}

/// Whether `b` is `a` under light that is `scale` times as bright.
fn scaled_alike(a: &Guide, b: &Guide, scale: f32) -> bool {
    let learnt = |(old, new): (&Region<Learnt>, &Region<Learnt>)| {
        let entries = entries(old).iter().zip(entries(new)).all(|(a, b)| a.q * scale == b.q && a.visits == b.visits);
        let (r, s) = (old.returns, new.returns);
        let returns = r.mean * scale == s.mean && r.square * (scale * scale) == s.square && r.rays == s.rays;
        old.key == new.key && entries && returns && old.fraction.value() == new.fraction.value()
    };
    let frozen = |state: &Region<Learnt>| match [a, b].map(|guide| guide.field().summary(state.key)) {
        [None, None] => true,
        [Some(x), Some(y)] => {
            let densities = |guide: &Guide, known: &RegionInfo| {
                let distribution = guide.field().distribution(known, state.normal);
                let mut rng = Rng::new(state.key.0);
                [(); 20].map(|_| distribution.pdf(unit(&mut rng)))
            };
            x.irradiance * scale == y.irradiance
                && x.bsdf_fraction == y.bsdf_fraction
                && densities(a, x) == densities(b, y)
        }
        _ => false,
    };
    let states = |guide: &Guide| guide.store.regions().cloned().collect::<Vec<_>>();
    let (old, new) = (states(a), states(b));
    old.len() == new.len() && old.iter().zip(&new).all(learnt) && old.iter().all(frozen)
}

#[test]
fn learning_leaves_the_snapshot_alone() {
    let mut guide = guide(|s| s.strata = 2);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    teach(&mut guide, key, Vec3::X, &[1.0, 2.0, 3.0, 4.0], 20);
    guide.end_iteration(1);
    let w = Frame::from_normal(Vec3::X).to_world(Vec3::new(0.3, 0.4, 0.866));
    let answer = |guide: &Guide| {
        let summary = summary(guide, key);
        (guide.field().distribution(&summary, Vec3::X).pdf(w), summary)
    };
    let before = answer(&guide);
    teach(&mut guide, key, Vec3::X, &[9.0, 0.0, 0.0, 0.0], 200);
    assert_eq!(before, answer(&guide));
    guide.refresh();
    assert_ne!(before, answer(&guide));
}

#[test]
fn returns_are_moments_of_the_irradiance_s_estimate() {
    let mut guide = guide(|s| s.strata = 1);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    let one = |target: f32, pdf: f32, scattered: f32, rays: u16| Transition {
        pdf,
        scattered,
        rays,
        ..visit(key, Vec3::X, Vec3::X, target)
    };
    // estimates 4, 0 and 2; what a sharp lobe scattered says nothing
    learn(&mut guide, [one(2.0, 0.5, 1.0, 3), one(0.0, 0.5, 1.0, 1), one(4.0, 0.25, 0.125, 5), one(9.0, 1.0, 0.0, 9)]);
    let returns = guide.store.get(key).unwrap().returns;
    assert_eq!((returns.weight, returns.mean, returns.square, returns.rays), (3.0, 2.0, 20.0 / 3.0, 3.0));
    // of grey light, whose channels are as bright as it is
    assert!((returns.red - 2.0).abs() < 1e-5 && (returns.blue - 2.0).abs() < 1e-5, "{returns:?}");
    // three estimates of relative variance 2/3
    let expected = returns.expected();
    assert!((expected - Rgb::splat(2.0 * 3.0 / (3.0 + 2.0 / 3.0))).abs().max_element() < 1e-4, "{expected}");
}

/// What the guide learns of directions is the rule's target, and roulette's moments are of the bootstrapped one.
#[test]
fn returns_are_of_bootstrapped_targets() {
    let mut guide = guide(|s| s.strata = 1);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    let one = Transition { bootstrapped: 3.0, pdf: 0.5, scattered: 1.0, ..visit(key, Vec3::X, Vec3::X, 1.0) };
    learn(&mut guide, [one; 4]);
    let region = guide.store.get(key).unwrap();
    assert_eq!((region.returns.mean, region.returns.square), (6.0, 36.0));
    let visited: Vec<f32> = entries(region).iter().filter(|entry| entry.visits > 0.0).map(|entry| entry.q).collect();
    assert_eq!(visited, [1.0]);
}

/// Rays count as many as they stand for, and few say little: the share stays between 0 and 1, in what is drawn from too.
#[test]
fn a_state_knows_how_often_its_shadow_rays_are_open() {
    let mut guide = guide(|s| s.strata = 1);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    let one = |shadow| Transition { shadow, rays: 0, ..visit(key, Vec3::X, Vec3::X, 1.0) };
    let outcomes = [ShadowOutcome::new(1.5, true), ShadowOutcome::new(4.5, false), ShadowOutcome::NONE];
    learn(&mut guide, outcomes.map(one));
    let seen = guide.store.get(key).unwrap().visibility;
    assert_eq!((seen.rays, seen.open, seen.share()), (6.0, 1.5, 2.0 / 7.0));
    learn(&mut guide, [one(ShadowOutcome::NONE); 20]);
    guide.end_iteration(1);
    let known = summary(&guide, key);
    assert_eq!(known.open, 2.0 / 7.0);
    // rays of a state that is black at once count as one
    let returns = guide.store.get(key).unwrap().returns;
    assert_eq!((returns.rays, known.square), (0.0, returns.square));
    for (rays, open) in [(0.0, 0.0), (1e30, 0.0), (1e30, 1e30), (f32::MAX, f32::MAX)] {
        let share = Visibility { rays, open }.share();
        assert!((0.0..=1.0).contains(&share) && (rays > 0.0 || share == 0.5), "{open} of {rays}: {share}");
    }
    let sound = |rays, open| Visibility { rays, open }.is_sound();
    assert!(
        sound(2.0, 2.0) && ![(1.0, 2.0), (f32::NAN, 0.0), (1.0, f32::NAN), (1.0, -1.0)].iter().any(|v| sound(v.0, v.1))
    );
}

/// What is expected has the colour of the light, nothing is expected where nothing is known, and no file can make it anything but a
/// colour.
#[test]
fn what_is_expected_is_a_colour() {
    let mut guide = guide(|s| s.strata = 1);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    let light = Rgb::new(3.0, 0.0, 0.5);
    let one = Transition {
        hue: Hue::of(light),
        scattered: 1.0,
        pdf: 1.0,
        ..visit(key, Vec3::X, Vec3::X, crate::math::luminance(light))
    };
    learn(&mut guide, [one; 50]);
    let known = guide.store.get(key).unwrap().returns;
    assert!((known.expected() - light).abs().max_element() < 0.03, "{}", known.expected());
    assert_eq!(ReturnMoments::default().expected(), Rgb::ZERO);
    for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        for returns in [
            ReturnMoments { mean: broken, ..known },
            ReturnMoments { red: broken, ..known },
            ReturnMoments { square: broken, ..known },
            ReturnMoments { weight: broken, ..known },
        ] {
            let expected = returns.expected();
            assert!(expected.is_finite() && expected.min_element() >= 0.0, "{returns:?}: {expected}");
        }
    }
}

/// Where BSDF and guide each have two halves of the directions, the learnt share goes to whichever is right.
#[test]
fn the_learnt_fraction_goes_to_the_better_sampler() {
    let (bsdf, wrong_way) = ([1.8f32, 0.2], [0.2f32, 1.8]);
    let learnt = |product: [f32; 2], scale: f32| {
        let mut rng = Rng::new(4);
        let mut guide = guide(|s| (s.strata, s.learned_fraction) = (1, Some(true)));
        let key = state(&guide, Vec3::splat(0.3), Vec3::X);
        let mixture = [0, 1].map(|half| 0.5 * bsdf[half] + 0.5 * wrong_way[half]);
        for _ in 0..20 {
            let transitions: Vec<Transition> = (0..1000)
                .map(|_| {
                    let half = (2.0 * rng.f32() >= mixture[0]) as usize;
                    let (bsdf_pdf, guide_pdf, pdf) = (bsdf[half], wrong_way[half], mixture[half]);
                    let target = product[half] * scale;
                    Transition { bsdf_pdf, guide_pdf, pdf, scattered: 1.0, ..visit(key, Vec3::X, Vec3::X, target) }
                })
                .collect();
            learn(&mut guide, transitions);
            guide.end_iteration(1);
        }
        summary(&guide, key).bsdf_fraction
    };
    let shares = [bsdf, wrong_way, [1.0, 1.0]].map(|product| learnt(product, 1.0));
    println!(
        "BSDF's share where it is right {:.3}, where the guide is {:.3}, half and half {:.3}",
        shares[0], shares[1], shares[2]
    );
    assert!(shares[0] > 0.9 && shares[1] < 0.1 && (shares[2] - 0.5).abs() < 0.1, "{shares:?}");
    // a rate of one hundredth in units of the gradient: exposure is nothing to it
    assert_eq!(learnt(bsdf, 2.0f32.powi(20)), shares[0]);
}

#[test]
fn memory_stays_within_its_bound() {
    let mut rng = Rng::new(4);
    let methods = [GuidingMethod::Grid, GuidingMethod::Adaptive];
    for (table, method) in TABLES.into_iter().flat_map(|table| methods.map(|method| (table, method))) {
        for memory in [1, 1_000, 5_000, 60_000, 1_000_000, 10_000_000] {
            let mut guide = guide(|s| {
                (s.memory, s.table, s.method, s.strata) = (memory, table, method, 4);
                (s.resolution, s.refine_visits, s.split_visits) = (8, 1.0, 1.0);
            });
            let mut met = std::collections::HashSet::new();
            for _ in 0..3 {
                let transitions = random_transitions(&mut rng, &guide, 20_000);
                met.extend(transitions.iter().map(|t| t.key));
                learn_all(&mut guide, &transitions, 5000);
                guide.end_iteration(1);
            }
            let cells = guide.partition.bytes();
            let held = held_bytes(&guide);
            println!(
                "{table:?}, {method:?}: {memory} bytes hold {} of {} states, {held} bytes",
                guide.states(),
                met.len()
            );
            // cells are there before anything is learnt
            assert!(guide.bytes() <= (memory as usize).max(cells), "{} bytes of {memory}", guide.bytes());
            // an empty snapshot has a table of two slots
            assert!(held <= guide.bytes() + 32 + cells, "{held} bytes are held, {} are admitted", guide.bytes());
            // the room is used: shards fill unevenly, but not by half
            let one = memory::bytes_besides_directions::<Learnt>() + bytes_of_directions(table);
            let room = (memory as usize / 32 / one * 32).min(met.len()) * one;
            assert!(method != GuidingMethod::Grid || 2 * guide.bytes() >= room, "{} bytes of {room}", guide.bytes());
        }
    }
}

/// Of a table as it begins, with four strata along a side.
fn bytes_of_directions(table: DirectionTable) -> usize {
    match table {
        DirectionTable::Hemisphere => 16 * (size_of::<Entry>() + size_of::<f32>()),
        DirectionTable::Sphere => 32 * (size_of::<Entry>() + size_of::<f32>()),
        DirectionTable::Tree => bytes_per_node(),
    }
}

/// Bytes of the states, of the hash at its least load, and of the snapshot.
fn held_bytes(guide: &Guide) -> usize {
    let state = |state: &Region<Learnt>| size_of::<Region<Learnt>>() + size_of_val(entries(state));
    guide.store.regions().map(state).sum::<usize>() + guide.field().bytes()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Keys that look alike, with positions in one corner and consecutive, as walls make them.
    #[test]
    fn every_state_that_was_learnt_is_found(start in 0u64..1 << 40, step in 1u64..1 << 20, n in 1usize..400, bins in 1u64..54) {
        let mut guide = guide(|s| s.strata = 1);
        let key = |i: usize| RegionId(((start + i as u64 * step) & ((1 << 51) - 1)) | (i as u64 % bins) << 51);
        let visits = (0..n).flat_map(|i| (0..20).map(move |_| (i, 1.0 + i as f32)));
        learn(&mut guide, visits.map(|(i, target)| visit(key(i), Vec3::Y, Vec3::Y, target)));
        guide.end_iteration(1);
        prop_assert_eq!(guide.field().len(), n);
        for i in 0..n {
            let found = guide.field().summary(key(i)).map(|s| s.irradiance);
            // Q = 1 + i over the hemisphere: irradiance π·Q
            let expected = std::f32::consts::PI * (1.0 + i as f32);
            prop_assert!(found.is_some_and(|e| (e / expected - 1.0).abs() < 1e-5), "{:?} for {}", found, expected);
            prop_assert!(guide.field().summary(key(n + i)).is_none());
        }
    }
}
