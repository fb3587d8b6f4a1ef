//! The learner: folds transitions into the Q-table between rounds, and only there.

use super::qtable::Shard;
use super::recorder::{Recorder, SHARDS};
use rayon::prelude::*;

/// Owns the Q-table; the only code that changes it.
#[derive(Clone, Debug)]
pub struct Learner {
    shards: Vec<Shard>,
    /// States that all shards together may hold.
    capacity: usize,
}

impl Learner {
    /// A learner over `actions` strata that keeps at most `states` states.
    pub fn new(actions: usize, states: usize) -> Learner {
        Learner { shards: (0..SHARDS).map(|_| Shard::new(actions)).collect(), capacity: states }
    }

    /// Folds what the tiles recorded, in the order of `recorders`; shards are independent, so the result is the
    /// same for any number of threads.
    ///
    /// Targets were computed from the frozen table, so one visit after the other, Q ← Q + (target − Q)/n, gives
    /// just what one batch update with the vanishing rate w = b/(n + b) would.
    pub fn fold(&mut self, recorders: &[&Recorder]) {
        let states = self.capacity;
        self.shards.par_iter_mut().enumerate().for_each(|(k, shard)| {
            // Shares of the whole that add up to no more than it, however few states there is room for.
            let capacity = states / SHARDS + usize::from(k < states % SHARDS);
            for transition in recorders.iter().flat_map(|recorder| recorder.shard(k)) {
                let Some(row) = shard.row_or_insert(transition.key, capacity) else { continue };
                let entry = shard.entry_mut(row, transition.action as usize);
                entry.visits += 1.0;
                entry.q += (transition.target - entry.q) / entry.visits;
            }
        });
    }

    /// Begins an iteration: earlier visits keep only the share `retain` of their weight. Early targets were
    /// bootstrapped from a table that knew little; a rate of 1/n alone forgets their error only as n^−(1−albedo).
    pub fn forget(&mut self, retain: f32) {
        self.shards.par_iter_mut().for_each(|shard| {
            shard.entries_mut().iter_mut().for_each(|entry| entry.visits *= retain);
        });
    }

    pub fn shards(&self) -> &[Shard] {
        &self.shards
    }

    pub fn states(&self) -> usize {
        self.shards.iter().map(Shard::len).sum()
    }
}
