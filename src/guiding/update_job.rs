//! What one shard of the table learns from transitions: the innermost loop of learning.

use super::learner::{Table, in_table};
use super::recorder::{Recorder, Transition};
use crate::guiding::directional::hemitree::{CellCoords, spots};
use crate::guiding::packed_direction::PackedDirection;
use crate::guiding::settings::Rate;
use crate::guiding::spatial::States;
use crate::guiding::store::{Actions, Entry, Fraction, ReturnMoments, Shard, State};
use crate::simd::{LANES, Vec3Lanes};

/// What is the same for all shards.
#[derive(Clone, Copy)]
pub(super) struct Rules<'a> {
    pub states: &'a States,
    pub table: &'a Table,
    /// Whether a state's table is held in the frame about its own normal.
    pub oriented: bool,
    pub rate: Rate,
    /// Bytes that a shard may hold.
    pub room: usize,
}

/// What one shard has yet to learn, in the order in which it was recorded. Shards are independent of each other, so that
/// lessons may be learnt on any threads in any order.
///
/// Targets were computed from the frozen table, so one visit after the other, Q ← Q + (target − Q)/n, gives just what one
/// batch update with the vanishing rate w = b/(n + b) would.
pub struct UpdateJob<'a> {
    pub(super) rules: Rules<'a>,
    pub(super) shard: &'a mut Shard,
    /// Of the shard.
    pub(super) number: usize,
    pub(super) recorders: &'a [&'a Recorder],
}

impl UpdateJob<'_> {
    pub fn learn(mut self) {
        for recorder in self.recorders {
            // some at once: what is arithmetic runs in vectors, and memory is waited for together
            recorder.shard(self.number).chunks(LANES).for_each(|some| self.learn_some(some));
        }
    }

    fn learn_some(&mut self, some: &[Transition]) {
        let mut rows = [None; LANES];
        for (row, transition) in rows.iter_mut().zip(some) {
            *row = self.row_for(transition);
        }
        let spots = match self.rules.table {
            Table::Tree(_) => Some(self.spots(some, &rows)),
            Table::Strata(_) => None,
        };
        let Rules { table, oriented, rate, .. } = self.rules;
        for ((k, transition), row) in some.iter().enumerate().zip(rows) {
            let Some(row) = row else { continue };
            let state = self.shard.state_mut(row);
            let entry = match (&mut state.actions, table) {
                (Actions::Tree(cells), _) => spots.as_ref().and_then(|spots| cells.entry_at(spots.get(k)?)),
                (Actions::Strata(entries), Table::Strata(strata)) => {
                    let normal = if oriented { state.normal } else { transition.normal.unpack() };
                    let at = in_table(strata.domain(), normal, transition.wi.unpack());
                    strata.index(at).map(|k| &mut entries[k])
                }
                _ => unreachable!("a state's actions are those of its table"),
            };
            if let Some(entry) = entry {
                entry.learn(transition.target, rate);
            }
            state.visit(transition);
        }
    }

    /// Where the directions of transitions lie in the trees of their states.
    #[inline(always)]
    fn spots(&self, some: &[Transition], rows: &[Option<u32>; LANES]) -> CellCoords {
        let (mut normals, mut directions) = ([PackedDirection::default(); LANES], [PackedDirection::default(); LANES]);
        for (k, transition) in some.iter().enumerate() {
            (normals[k], directions[k]) = (transition.normal, transition.wi);
        }
        let mut about = Vec3Lanes::ZERO;
        if self.rules.oriented {
            for (k, row) in rows.iter().enumerate() {
                about.set(k, row.map_or(glam::Vec3::Z, |row| self.shard.state(row).normal));
            }
        } else {
            PackedDirection::unpack_lanes(&normals, &mut about);
        }
        let mut wi = Vec3Lanes::ZERO;
        PackedDirection::unpack_lanes(&directions, &mut wi);
        spots(&about, &wi)
    }

    /// Where the transition's state is held, which is made where there is none and room for one.
    #[inline]
    fn row_for(&mut self, transition: &Transition) -> Option<u32> {
        let known = self.shard.row(transition.key);
        known.or_else(|| self.make_room(transition).then(|| self.shard.row(transition.key))?)
    }

    /// Makes a state for a transition, if there is room.
    #[cold]
    fn make_room(&mut self, transition: &Transition) -> bool {
        let Rules { states, table, room, .. } = self.rules;
        let state = State {
            key: transition.key,
            normal: states.normal(transition.key).unwrap_or_else(|| transition.normal.unpack()),
            actions: table.nothing_known(),
            visits: 0.0,
            fresh: 0.0,
            met: true,
            returns: ReturnMoments::default(),
            fraction: Fraction::default(),
        };
        let fits = self.shard.bytes() + state.bytes() <= room;
        if fits {
            self.shard.insert(state);
        }
        fits
    }
}

impl State {
    /// Counts a visit in, but for the action's.
    #[inline(always)]
    fn visit(&mut self, transition: &Transition) {
        self.visits += 1.0;
        self.fresh += 1.0;
        self.met = true;
        self.returns.add(transition);
        self.fraction.step(transition);
    }
}

impl Entry {
    #[inline(always)]
    fn learn(&mut self, target: f32, rate: Rate) {
        self.visits += 1.0;
        // the first visit has nothing to keep
        let step = match rate {
            Rate::Constant(alpha) if self.visits > 1.0 => alpha,
            _ => 1.0 / self.visits,
        };
        self.q += (target - self.q) * step;
    }
}
