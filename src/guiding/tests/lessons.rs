//! Sums teach a guide what transitions one after the other would.

use super::learning::random_transitions;
use super::*;
use crate::guiding::lesson::{Lesson, RegionSums};

fn recorder(transitions: &[Transition]) -> Recorder {
    let mut recorder = Recorder::new();
    transitions.iter().for_each(|t| recorder.push(*t));
    recorder
}

/// The same transitions as sums, from parts of so many.
fn lesson(guide: &Guide, transitions: &[Transition], size: usize) -> Lesson {
    let mut whole = Lesson::new();
    for part in transitions.rchunks(size) {
        let lesson = Lesson::new();
        lesson.learn(guide, &recorder(part), size);
        for (number, shard) in lesson.into_shards().into_iter().enumerate() {
            assert!(whole.add(number, shard));
        }
    }
    whole
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 2e-3 * a.abs().max(b.abs())
}

#[test]
fn what_is_known_grows_as_it_does_one_by_one() {
    let tables = [DirectionTable::Hemisphere, DirectionTable::Tree];
    for (table, rate) in tables.into_iter().flat_map(|t| [(t, Rate::Vanishing), (t, Rate::Forgetting(0.5))]) {
        // neither cells nor directions are cut anew, so that rounding decides nothing
        let new = || guide(|s| (s.table, s.rate, s.resolution, s.split_visits) = (table, rate, 2, 1e9));
        let (mut one_by_one, mut at_once, mut rng) = (new(), new(), Rng::new(4));
        let first = random_transitions(&mut rng, &one_by_one, 20_000);
        for guide in [&mut one_by_one, &mut at_once] {
            guide.learn(&[&recorder(&first)]);
            guide.end_iteration(1000);
        }
        let known: Vec<RegionId> = one_by_one.store.regions().map(|region| region.key).collect();
        let second = random_transitions(&mut rng, &one_by_one, 20_000);
        one_by_one.begin_iteration(3000);
        one_by_one.learn(&[&recorder(&second)]);
        one_by_one.end_iteration(3000);
        let lesson = lesson(&at_once, &second, 777);
        at_once.take_in(lesson, 3000).unwrap();
        assert_eq!(one_by_one.learnt_paths(), at_once.learnt_paths());
        assert_eq!(one_by_one.states(), at_once.states());
        // those that are new have frames of their own
        assert!(known.len() > 1000, "{}", known.len());
        let mut rays = 0.0;
        for key in known {
            let (region, other) = (one_by_one.store.get(key).unwrap(), at_once.store.get(key).unwrap());
            for (a, b) in entries(region).iter().zip(entries(other)) {
                assert!(close(a.q, b.q) && close(a.visits, b.visits), "{table:?} {rate:?}: {a:?} {b:?}");
            }
            let (a, b) = (region.returns, other.returns);
            let both = [(a.weight, b.weight), (a.mean, b.mean), (a.rays, b.rays), (a.red, b.red), (a.blue, b.blue)];
            assert!(both.into_iter().all(|(a, b)| close(a, b)), "{table:?} {rate:?}: {a:?} {b:?}");
            let (a, b) = (region.visibility, other.visibility);
            assert!(close(a.rays, b.rays) && close(a.open, b.open), "{table:?} {rate:?}: {a:?} {b:?}");
            rays += a.rays;
            assert!(
                close(region.visits, other.visits) && close(region.fresh, other.fresh) && region.normal == other.normal
            );
        }
        assert!(rays > 0.0, "{table:?} {rate:?}: no state has seen a shadow ray");
    }
}

#[test]
fn no_part_and_no_order_of_parts_changes_a_bit() {
    let taught = |seed: u64, size: usize| {
        let mut rng = Rng::new(seed);
        let mut guide =
            guide(|s| (s.method, s.table, s.refine_visits) = (GuidingMethod::Adaptive, DirectionTable::Tree, 50.0));
        for _ in 0..3 {
            let transitions = random_transitions(&mut rng, &guide, 20_000);
            let lesson = lesson(&guide, &transitions, size);
            guide.take_in(lesson, 1000).unwrap();
        }
        contents(&guide)
    };
    let whole = taught(5, 20_000);
    assert!(whole.len() > 1000 && taught(6, 20_000) != whole);
    assert!([7000, 901].into_iter().all(|size| taught(5, size) == whole));
}

#[test]
fn a_region_that_is_new_gets_the_frame_and_the_light_of_its_visits() {
    let (mut rng, n) = (Rng::new(7), Vec3::new(0.3, 0.2, 0.9).normalize());
    let sun = Frame::from_normal(n).to_world(Vec3::new(0.5, 0.1, 0.8).normalize());
    for table in [DirectionTable::Hemisphere, DirectionTable::Tree] {
        let mut guide = guide(|s| s.table = table);
        let key = state(&guide, Vec3::splat(0.5), n);
        let frame = Frame::from_normal(n);
        let draw = |_| {
            let w = frame.to_world(warp::square_to_uniform_hemisphere(rng.f32x2()));
            visit(key, n, w, if w.dot(sun) > 0.95 { 1.0 } else { 0.01 })
        };
        let transitions: Vec<Transition> = (0..20_000).map(draw).collect();
        let lesson = lesson(&guide, &transitions, 5000);
        guide.take_in(lesson, 1000).unwrap();
        let region = guide.store.get(key).unwrap();
        assert!((region.normal - n).length() < 1e-3, "{}", region.normal);
        let pdf = |w: Vec3| guide.field().distribution(&summary(&guide, key), n).pdf(w);
        let away = frame.to_world(Vec3::new(-0.5, 0.1, 0.8).normalize());
        assert!(pdf(sun) > 8.0 * pdf(away), "{table:?}: {} and {}", pdf(sun), pdf(away));
        let irradiance = transitions.iter().map(|t| t.target * t.wi.unpack().dot(n).max(0.0)).sum::<f32>();
        let irradiance = irradiance * std::f32::consts::TAU / transitions.len() as f32;
        let found = summary(&guide, key).irradiance;
        assert!((found / irradiance - 1.0).abs() < 0.15, "{table:?}: {found} {irradiance}");
    }
}

#[test]
fn the_share_of_the_bsdf_goes_where_its_steps_lead() {
    let (mut rng, n) = (Rng::new(8), Vec3::Z);
    for (bsdf, guided) in [(0.2, 1.0), (1.0, 0.2), (1.0, 1.0)] {
        let new = || guide(|s| s.learned_fraction = Some(true));
        let (mut one_by_one, mut at_once) = (new(), new());
        let key = state(&at_once, Vec3::splat(0.5), n);
        let first: Vec<Transition> = (0..100).map(|_| visit(key, n, n, 1.0)).collect();
        for guide in [&mut one_by_one, &mut at_once] {
            learn(guide, first.clone());
            guide.end_iteration(100);
        }
        // mostly where one of them is denser, and sometimes where the other is
        let draw = |_| {
            let (bsdf_pdf, guide_pdf) = if rng.f32() < 0.7 { (bsdf, guided) } else { (guided, bsdf) };
            Transition { bsdf_pdf, guide_pdf, ..visit(key, n, n, 1.0) }
        };
        let transitions: Vec<Transition> = (0..20_000).map(draw).collect();
        learn(&mut one_by_one, transitions.clone());
        let lesson = lesson(&at_once, &transitions, 5000);
        at_once.take_in(lesson, 1000).unwrap();
        let [a, b] = [&one_by_one, &at_once].map(|guide| guide.store.get(key).unwrap().fraction.value());
        assert!((a - b).abs() < 0.06, "{bsdf} {guided}: {a} step by step, {b} at once");
    }
    // few visits move it no further than as many steps
    let mut guide = guide(|s| s.learned_fraction = Some(true));
    let key = state(&guide, Vec3::splat(0.5), n);
    let few: Vec<Transition> =
        (0..10).map(|_| Transition { bsdf_pdf: 0.1, guide_pdf: 1.0, ..visit(key, n, n, 1.0) }).collect();
    let lesson = lesson(&guide, &few, 3);
    guide.take_in(lesson, 100).unwrap();
    let found = guide.store.get(key).unwrap().fraction.value();
    assert!((0.47..0.5).contains(&found), "{found}");
}

#[test]
fn sums_that_no_paths_leave_are_refused() {
    let good = |guide: &Guide| lesson(guide, &random_transitions(&mut Rng::new(9), guide, 1000), 100).into_shards();
    let said = |change: &dyn Fn(&mut RegionId, &mut RegionSums)| {
        let mut guide = guide(|_| ());
        let mut shards = good(&guide);
        let (number, shard) = shards.iter_mut().enumerate().find(|(_, shard)| !shard.is_empty()).unwrap();
        let (key, sums) = &mut shard[0];
        change(key, sums);
        let mut lesson = Lesson::new();
        let one = vec![shard[0].clone()];
        if lesson.add(number, one) { guide.take_in(lesson, 100).err() } else { Some("of another shard".into()) }
    };
    assert_eq!(said(&|_, _| ()), None);
    let refused = |change: &dyn Fn(&mut RegionId, &mut RegionSums)| assert!(said(change).is_some());
    refused(&|key, _| key.0 ^= 1 << 63);
    refused(&|_, sums| sums.cells.last_mut().unwrap().0 = 1 << 20);
    refused(&|_, sums| sums.cells[0].1.target = -1);
    refused(&|_, sums| sums.cells[0].1.visits = sums.visits + 1);
    refused(&|_, sums| sums.visits = 0);
    refused(&|_, sums| sums.visits = u64::MAX);
    refused(&|_, sums| sums.normal = [0; 3]);
    refused(&|_, sums| sums.returns.square = -1);
    refused(&|_, sums| sums.visibility.open = -1);
    refused(&|_, sums| sums.visibility.open = sums.visibility.rays + 1);
    refused(&|_, sums| sums.returns.visits = sums.visits + 1);
}
