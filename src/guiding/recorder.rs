//! What a tile learnt: transitions, in the order of its paths, sorted only by the shard that will read them.

use super::state::StateKey;
use crate::math::rng::mix;

/// Shards of the table that are updated in parallel. Fixed, so that no result depends on the number of threads.
pub const SHARDS: usize = 32;

/// The shard that owns a state.
#[inline]
pub fn shard_of(key: StateKey) -> usize {
    (mix(key.0) >> 59) as usize
}

/// One visit to a state-action pair, and the radiance (luminance) that arrived from there.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    pub key: StateKey,
    pub target: f32,
    pub action: u16,
}

/// Owned by one tile while it renders, then folded into the table in the order of tiles.
#[derive(Debug, Default)]
pub struct Recorder {
    shards: Vec<Vec<Transition>>,
}

impl Recorder {
    pub fn new() -> Recorder {
        Recorder { shards: (0..SHARDS).map(|_| Vec::new()).collect() }
    }

    #[inline]
    pub fn push(&mut self, transition: Transition) {
        self.shards[shard_of(transition.key)].push(transition);
    }

    pub fn shard(&self, shard: usize) -> &[Transition] {
        &self.shards[shard]
    }

    pub fn clear(&mut self) {
        self.shards.iter_mut().for_each(Vec::clear);
    }

    pub fn len(&self) -> usize {
        self.shards.iter().map(Vec::len).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
