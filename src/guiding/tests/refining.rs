//! Where the states of an adaptive grid are cut, and what their parts know.

use super::*;
use crate::guiding::directional::DirectionalModel;
use crate::guiding::recorder::SHARDS;

/// Two coarse cells along the side of a cube; states are cut after few visits.
fn adaptive(change: impl FnOnce(&mut GuidingSettings)) -> Guide {
    guide(|s| {
        (s.method, s.table, s.resolution, s.levels) = (GuidingMethod::Adaptive, DirectionTable::Tree, 4, 3);
        (s.refine_visits, s.refine_difference) = (100.0, 0.1);
        change(s);
    })
}

/// The middles of a floor's coarse cells, by their places along x and z.
fn middle(i: usize, k: usize) -> Vec3 {
    // cells begin off the box, by shares of themselves that are odd
    Vec3::new((i as f32 + 0.13) * 0.25, 0.5, (k as f32 + 0.17) * 0.25)
}

/// Visits points all over a floor, `visits` of each of 4 × 4 cells; `light` goes by the point and the direction.
fn visit_floor(guide: &mut Guide, rng: &mut Rng, visits: usize, light: impl Fn(Vec3, Vec3) -> f32) {
    let transitions: Vec<Transition> = (0..16 * visits)
        .map(|k| {
            let p = middle(k % 4, k / 4 % 4) + 0.25 * Vec3::new(rng.f32() - 0.5, 0.0, rng.f32() - 0.5);
            let w = Frame::from_normal(Vec3::Y).to_world(warp::square_to_uniform_hemisphere(rng.f32x2()));
            visit(state(guide, p, Vec3::Y), Vec3::Y, w, light(p, w))
        })
        .collect();
    learn(guide, transitions);
}

/// Light from one side for one half of the floor, from the other for the other.
fn two_sided(p: Vec3, w: Vec3) -> f32 {
    if (w.x > 0.0) == (p.x > 0.5) { 1.0 } else { 0.01 }
}

/// How often the coarse cell at `p` was halved.
fn level(guide: &Guide, p: Vec3) -> u64 {
    state(guide, p, Vec3::Y).0 >> 57
}

fn levels(guide: &Guide) -> Vec<u64> {
    (0..16).map(|k| level(guide, middle(k % 4, k / 4))).collect()
}

#[test]
fn cells_are_cut_where_neighbours_differ_and_not_under_an_even_sky() {
    let after = |light: fn(Vec3, Vec3) -> f32, visits: usize| {
        let (mut guide, mut rng) = (adaptive(|_| ()), Rng::new(1));
        for _ in 0..3 {
            visit_floor(&mut guide, &mut rng, visits, light);
            guide.end_iteration(1);
        }
        levels(&guide)
    };
    assert_eq!(after(|_, _| 1.0, 4000), [0; 16], "under an even sky nothing is to be told apart");
    assert_eq!(after(two_sided, 50), [0; 16], "visits are too few");
    let cut = after(two_sided, 4000);
    println!("levels along x: {:?}", &cut[..4]);
    // the border of the light is between the second and the third cell
    for line in cut.chunks(4) {
        assert!(line[1] > 0 && line[2] > 0, "{cut:?}");
        assert!(line[1] >= line[0] && line[2] >= line[3], "{cut:?}");
    }
}

#[test]
fn a_state_without_neighbours_is_cut_by_its_visits_alone() {
    for (visits, expected) in [(50, 0), (500, 1)] {
        let (mut guide, mut rng) = (adaptive(|_| ()), Rng::new(2));
        let key = state(&guide, middle(1, 1), Vec3::Y);
        look_around(&mut guide, &mut rng, (key, Vec3::Y), visits, |_| 1.0);
        guide.end_iteration(1);
        assert_eq!(level(&guide, middle(1, 1)), expected, "{visits} visits");
    }
}

#[test]
fn parts_know_what_the_whole_knew_and_those_never_met_are_dropped() {
    let (mut guide, mut rng) = (adaptive(|s| s.levels = 1), Rng::new(3));
    let n = Vec3::Y;
    let key = state(&guide, middle(1, 1), n);
    look_around(&mut guide, &mut rng, (key, n), 4000, |w| if w.x > 0.3 { 5.0 } else { 1.0 });
    let whole = guide.store.get(key).unwrap().clone();
    let model = guide.store.model.clone();
    guide.end_iteration(1);
    assert!(guide.store.get(key).is_none() && guide.field().summary(key).is_none());
    let parts: Vec<RegionId> = key.parts().collect();
    assert_eq!(guide.states(), 8);
    for part in &parts {
        let part = guide.store.get(*part).expect("all eight are there");
        assert_eq!((part.visits, part.fresh, part.normal), (0.25 * whole.visits, 0.0, whole.normal));
        assert_eq!(part.returns, ReturnMoments { weight: 0.25 * whole.returns.weight, ..whole.returns });
        assert_eq!(part.fraction, whole.fraction);
        assert_eq!(part.visibility.rays, 0.25 * whole.visibility.rays);
        assert_eq!(part.visibility.open, 0.25 * whole.visibility.open);
        // few visits lean a little more towards the mean
        for (old, new) in model.profile(&whole.directions).iter().zip(model.profile(&part.directions)) {
            assert!((new - old).abs() < 0.03 * old, "{new}, not {old}");
        }
    }
    // one of them is met again
    let met = state(&guide, middle(1, 1), n);
    assert!(parts.contains(&met));
    look_around(&mut guide, &mut rng, (met, n), 10, |_| 1.0);
    guide.end_iteration(1);
    assert_eq!(guide.store.regions().map(|s| s.key).collect::<Vec<_>>(), [met]);
}

#[test]
fn eight_parts_stay_within_the_memory() {
    let mut rng = Rng::new(4);
    for bytes in [2_000u64, 40_000, 100_000, 400_000, 1_000_000] {
        let mut guide = adaptive(|s| (s.memory, s.split_visits, s.refine_difference) = (bytes, 1.0, 0.0));
        let (mut most, mut levels) = (0, 0);
        for _ in 0..5 {
            visit_floor(&mut guide, &mut rng, 2000, two_sided);
            guide.end_iteration(1);
            assert!(guide.bytes() <= (bytes as usize).max(guide.partition.bytes()), "{} of {bytes}", guide.bytes());
            let room = (bytes as usize).saturating_sub(guide.partition.bytes()) / SHARDS;
            let mut shards = [0; SHARDS];
            guide
                .store
                .regions()
                .for_each(|s| shards[recorder::shard_of(s.key)] += memory::region_bytes(&guide.store.model, s));
            assert!(shards.iter().all(|bytes| *bytes <= room), "{shards:?}, room for {room}");
            (most, levels) = (most.max(guide.states()), level(&guide, middle(1, 1)));
        }
        println!("{bytes} bytes: {most} states at most, {levels} halvings");
    }
}

#[test]
fn any_number_of_threads_cuts_alike() {
    let learnt = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            // a bound that is reached: who comes first matters then
            let (mut guide, mut rng) = (adaptive(|s| s.memory = 300_000), Rng::new(seed));
            for _ in 0..4 {
                visit_floor(&mut guide, &mut rng, 2000, two_sided);
                guide.end_iteration(1);
            }
            contents(&guide)
        })
    };
    let one = learnt(1, 5);
    assert!(one.len() > 50, "{} states", one.len());
    assert!(one == learnt(2, 5) && one == learnt(3, 5));
    assert!(one != learnt(1, 6), "other visits are other contents");
}
