//! The guide without a renderer: what goes in is known, so what comes out can be held against it.

mod directions;
mod learning;
mod states;

use super::*;
use crate::math::rng::Rng;
use crate::scene::description::GuidingSettings;

/// The settings' guide of a cube of side 1, with the cells that most tests want.
fn guide(change: impl FnOnce(&mut GuidingSettings)) -> Guide {
    let mut settings = GuidingSettings { resolution: 8, retain: 1.0, ..GuidingSettings::default() };
    change(&mut settings);
    Guide::new(&settings, (Vec3::ZERO, Vec3::ONE)).expect("the method is the grid")
}

/// Uniform on the sphere.
fn unit(rng: &mut Rng) -> Vec3 {
    crate::math::warp::square_to_uniform_sphere(rng.f32x2())
}

fn point(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.f32(), rng.f32(), rng.f32())
}

/// The state at `p` on the side of `n`, without jitter.
fn state(guide: &Guide, p: Vec3, n: Vec3) -> StateKey {
    guide.field().grid().key(p, n, [0.5; 2])
}

/// Visits each action of a state `visits` times and finds `row` there.
fn teach(guide: &mut Guide, key: StateKey, row: &[f32], visits: usize) {
    let mut recorder = Recorder::new();
    for (action, target) in row.iter().enumerate() {
        (0..visits).for_each(|_| recorder.push(Transition { key, action: action as u16, target: *target }));
    }
    guide.learn(&[&recorder]);
}

/// All that a learner knows, in bits.
fn contents(guide: &Guide) -> Vec<(StateKey, Vec<(u32, u32)>)> {
    let bits = |entries: &[qtable::Entry]| entries.iter().map(|e| (e.q.to_bits(), e.visits.to_bits())).collect();
    let shards = guide.learner.shards().iter();
    shards.flat_map(|shard| shard.states()).map(|(key, entries)| (key, bits(entries))).collect()
}

/// The entries of a state.
fn row(guide: &Guide, key: StateKey) -> Vec<qtable::Entry> {
    let mut states = guide.learner.shards().iter().flat_map(|shard| shard.states());
    states.find(|(k, _)| *k == key).map(|(_, entries)| entries.to_vec()).expect("the state is in the table")
}
