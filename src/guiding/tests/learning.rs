//! What is learnt from known targets, and how much memory it takes.

use super::*;
use crate::math::rng::Rng;
use proptest::prelude::*;

fn random_transitions(rng: &mut Rng, guide: &Guide, n: usize) -> Vec<Transition> {
    let one = |rng: &mut Rng| {
        let key = state(guide, point(rng), unit(rng));
        // from 2⁻⁴⁰ to 2⁴⁰, a tenth of them black
        let target = if rng.f32() < 0.1 { 0.0 } else { (80.0 * rng.f32() - 40.0).exp2() };
        Transition { key, target, action: (rng.next_u32() % 144) as u16 }
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

#[test]
fn values_stay_finite_and_never_fall_below_zero() {
    let (mut rng, mut guide) = (Rng::new(1), guide(|s| (s.retain, s.resolution) = (0.5, 2)));
    for _ in 0..5 {
        let transitions = random_transitions(&mut rng, &guide, 40_000);
        let recorders = recorders(&transitions, 1000);
        guide.learn(&recorders.iter().collect::<Vec<_>>());
        guide.end_iteration();
    }
    let entries = || guide.learner.shards().iter().flat_map(|s| s.states()).flat_map(|(_, e)| e.to_vec());
    assert!(entries().all(|e| e.q.is_finite() && e.q >= 0.0 && e.visits >= 0.0));
    let drawn = guide.field().states();
    println!("{} values of {} states, {drawn} of which can be drawn from", entries().count(), guide.states());
    assert!(drawn > 100);
}

#[test]
fn how_transitions_are_shared_among_recorders_and_threads_changes_nothing() {
    let (mut rng, reference) = (Rng::new(2), guide(|_| ()));
    let transitions = random_transitions(&mut rng, &reference, 20_000);
    let learnt = |size: usize, threads: usize| {
        let mut guide = guide(|_| ());
        let recorders = recorders(&transitions, size);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| guide.learn(&recorders.iter().collect::<Vec<_>>()));
        contents(&guide)
    };
    let one = learnt(transitions.len(), 1);
    for (size, threads) in [(transitions.len(), 3), (100, 1), (777, 3), (1, 2)] {
        assert!(one == learnt(size, threads), "recorders of {size}, {threads} threads");
    }
    // the order, in contrast, is seen in the last bits
    let mut turned = transitions.clone();
    turned.reverse();
    let mut other = guide(|_| ());
    other.learn(&recorders(&turned, turned.len()).iter().collect::<Vec<_>>());
    assert!(one != contents(&other));
}

#[test]
fn noisy_targets_converge_to_their_mean() {
    let (mut rng, mut guide) = (Rng::new(3), guide(|s| s.strata = 1));
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    let visits = 10_000;
    for round in 1..=4 {
        let mut recorder = Recorder::new();
        for _ in 0..visits / 4 {
            // exponential with mean 7, the standard deviation of which is 7 as well
            recorder.push(Transition { key, action: 0, target: -7.0 * (1.0 - rng.f32()).ln() });
        }
        guide.learn(&[&recorder]);
        guide.end_iteration();
        let entry = row(&guide, key)[0];
        assert_eq!(entry.visits, (round * visits / 4) as f32);
    }
    let q = row(&guide, key)[0].q;
    println!("mean of {visits} noisy targets: {q:.3}, their expectation: 7");
    // five standard errors: false alarm 6·10⁻⁷
    assert!((q - 7.0).abs() < 5.0 * 7.0 / (visits as f32).sqrt());
}

#[test]
fn an_iteration_keeps_the_share_of_visits_that_is_retained() {
    for retain in [0.0f32, 0.25, 0.5, 1.0] {
        let mut guide = guide(|s| (s.strata, s.retain) = (1, retain));
        let key = state(&guide, Vec3::splat(0.3), Vec3::X);
        teach(&mut guide, key, &[8.0], 32);
        guide.end_iteration();
        let kept = row(&guide, key)[0];
        assert_eq!((kept.q, kept.visits), (8.0, 32.0 * retain), "the value stays, its weight fades");
        assert_eq!(guide.field().states(), 1, "the snapshot was taken before");
        teach(&mut guide, key, &[2.0], 8);
        let q = row(&guide, key)[0].q;
        let expected = (8.0 * 32.0 * retain + 2.0 * 8.0) / (32.0 * retain + 8.0);
        assert!((q - expected).abs() < 1e-5, "retain {retain}: {q}, not {expected}");
    }
}

#[test]
fn learning_leaves_the_snapshot_alone() {
    let mut guide = guide(|s| s.strata = 2);
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    teach(&mut guide, key, &[1.0, 2.0, 3.0, 4.0], 20);
    guide.end_iteration();
    let w = guide.field().grid().frame(key).to_world(Vec3::new(0.3, 0.4, 0.866));
    let answer = |guide: &Guide| guide.field().distribution(key).map(|d| (d.pdf(w), d.irradiance));
    let before = answer(&guide);
    teach(&mut guide, key, &[9.0, 0.0, 0.0, 0.0], 200);
    assert_eq!(before, answer(&guide));
    guide.end_iteration();
    assert_ne!(before, answer(&guide));
}

#[test]
fn memory_stays_within_its_bound() {
    let mut rng = Rng::new(4);
    for memory in [1, 1_000, 5_000, 60_000, 1_000_000, 10_000_000] {
        for strata in [1, 4, 12] {
            let mut guide = guide(|s| (s.memory, s.strata, s.resolution) = (memory, strata, 64));
            let mut met = std::collections::HashSet::new();
            for _ in 0..3 {
                let mut transitions = random_transitions(&mut rng, &guide, 20_000);
                transitions.iter_mut().for_each(|t| t.action %= (strata * strata) as u16);
                met.extend(transitions.iter().map(|t| t.key));
                guide.learn(&recorders(&transitions, 5000).iter().collect::<Vec<_>>());
                guide.end_iteration();
            }
            let per_state =
                Shard::bytes_per_state((strata * strata) as usize) + Field::bytes_per_state(&Strata::new(strata));
            let room = memory as usize / per_state;
            println!(
                "{memory} bytes, K = {}: {} of {} states, {} bytes",
                strata * strata,
                guide.states(),
                met.len(),
                guide.bytes()
            );
            assert!(guide.states() <= room.min(met.len()), "{} states, room for {room}", guide.states());
            // an empty snapshot has a table of two slots
            assert!(guide.bytes() <= memory as usize + 32, "{} bytes of {memory}", guide.bytes());
            // and the room is used: shards fill unevenly, but not by half
            assert!(2 * guide.states() >= room.min(met.len()), "{} states, room for {room}", guide.states());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Keys that look alike, with positions in one corner and consecutive, as walls make them.
    #[test]
    fn every_state_that_was_learnt_is_found(start in 0u64..1 << 40, step in 1u64..1 << 20, n in 1usize..400, bins in 1u64..54) {
        let mut guide = guide(|s| s.strata = 1);
        let key = |i: usize| StateKey(((start + i as u64 * step) & ((1 << 51) - 1)) | (i as u64 % bins) << 51);
        let mut recorder = Recorder::new();
        for i in 0..n {
            (0..20).for_each(|_| recorder.push(Transition { key: key(i), action: 0, target: 1.0 + i as f32 }));
        }
        guide.learn(&[&recorder]);
        guide.end_iteration();
        prop_assert_eq!(guide.field().states(), n);
        for i in 0..n {
            let found = guide.field().distribution(key(i)).map(|d| d.irradiance);
            // Q = 1 + i over the hemisphere: irradiance π·Q
            let expected = std::f32::consts::PI * (1.0 + i as f32);
            prop_assert!(found.is_some_and(|e| (e / expected - 1.0).abs() < 1e-5), "{:?} for {}", found, expected);
            prop_assert!(guide.field().distribution(key(n + i)).is_none());
        }
    }
}
