//! What transitions teach, as sums that do not depend on their order: machines that share an iteration write theirs, and the guide
//! takes in all of them at once, to the same bits however the transitions were dealt among them.
//!
//! All targets of an iteration come from one frozen guide, so that sums tell the guide as much as one transition after the other
//! would. What is a step after another in a single render (the share of the BSDF, the normal of a region's first visit) has a form of
//! its own here that depends on sums alone.

mod absorb;
mod fraction_sums;
mod region_sums;

pub(crate) use fraction_sums::FractionSums;
pub(crate) use region_sums::RegionSums;

use super::directional::DirectionalModel;
use super::guide::Guide;
use super::packed_direction::PackedDirection;
use super::recorder::{Recorder, SHARDS, Transition, shard_of};
use super::spatial::{RegionId, SpatialPartition};
use super::store::Shard;
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::{Mutex, PoisonError};

/// The sums of a shard's regions.
type ShardSums = FxHashMap<RegionId, RegionSums>;

/// The sums of an iteration, or of a part of it. Any threads add to it in any order.
pub(crate) struct Lesson {
    shards: Vec<Mutex<ShardSums>>,
}

impl Lesson {
    pub(crate) fn new() -> Lesson {
        Lesson { shards: (0..SHARDS).map(|_| Mutex::default()).collect() }
    }

    /// Adds what was recorded under this guide, whose snapshot was in use. `turn` tells threads apart, so that they begin
    /// with different shards.
    pub(crate) fn learn<S: SpatialPartition, D: DirectionalModel>(
        &self,
        guide: &Guide<S, D>,
        recorder: &Recorder,
        turn: usize,
    ) {
        for number in (0..SHARDS).map(|k| (turn + k) % SHARDS) {
            let mut sums = self.shards[number].lock().unwrap_or_else(PoisonError::into_inner);
            let known = &guide.store.shards()[number];
            let some = recorder.shard(number).chunks(LANES);
            some.for_each(|some| learn_some(&guide.store.model, known, &mut sums, some));
        }
    }

    /// Adds the sums of a shard of another part; `false` where regions of other shards are among them.
    pub(crate) fn add(&mut self, number: usize, others: Vec<(RegionId, RegionSums)>) -> bool {
        let sums = self.shards[number].get_mut().unwrap_or_else(PoisonError::into_inner);
        let fits = others.iter().all(|(key, _)| shard_of(*key) == number);
        for (key, other) in others.into_iter().filter(|_| fits) {
            sums.entry(key).or_default().add_sums(&other);
        }
        fits
    }

    /// The sums, shard by shard, each in the order of its keys.
    pub(crate) fn into_shards(self) -> Vec<Vec<(RegionId, RegionSums)>> {
        let sorted = |sums: Mutex<ShardSums>| {
            let mut all: Vec<_> = sums.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect();
            all.sort_unstable_by_key(|(key, _)| *key);
            all
        };
        self.shards.into_iter().map(sorted).collect()
    }

    /// How many shards there are.
    pub(crate) const SHARDS: usize = SHARDS;
}

/// Transitions of regions that the guide knows are summed up by its cells of directions. The frame of one that it does not know yet
/// is known when all are summed up: those are told apart by world cells until then.
fn learn_some<D: DirectionalModel>(model: &D, known: &Shard<D::Learnt>, sums: &mut ShardSums, some: &[Transition]) {
    let (mut about, mut wi) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
    let mut directions = [PackedDirection::default(); LANES];
    for (k, transition) in some.iter().enumerate() {
        directions[k] = transition.wi;
        about.set(k, known.get(transition.key).map_or(Vec3::Z, |region| region.normal));
    }
    PackedDirection::unpack_lanes(&directions, &mut wi);
    let located = model.locate(&about, &wi);
    for (k, transition) in some.iter().enumerate() {
        let cell = match known.get(transition.key) {
            Some(region) => model.entry_index(&region.directions, &located, k).map(|cell| cell as u32),
            None => Some(transition.wi.cell()),
        };
        sums.entry(transition.key).or_default().add(transition, cell);
    }
}

impl Default for Lesson {
    fn default() -> Lesson {
        Lesson::new()
    }
}
