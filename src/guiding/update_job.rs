//! What one shard learns from transitions: the innermost loop of learning.

use super::directional::{DirectionalModel, Model};
use super::memory::region_bytes;
use super::packed_direction::PackedDirection;
use super::recorder::{Recorder, Transition};
use super::region::Region;
use super::spatial::{Partition, SpatialPartition};
use super::store::Shard;
use crate::guiding::settings::Rate;
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;

/// What is the same for all shards.
pub(super) struct Rules<'a, S, D> {
    pub partition: &'a S,
    pub model: &'a D,
    pub rate: Rate,
    /// Logit of the BSDF's share where nothing is known yet.
    pub origin: f32,
    /// Bytes that a shard may hold.
    pub room: usize,
}

impl<S, D> Copy for Rules<'_, S, D> {}

impl<S, D> Clone for Rules<'_, S, D> {
    fn clone(&self) -> Self {
        *self
    }
}

/// What one shard has yet to learn, in the order in which it was recorded. Shards are independent of each other, so that
/// jobs may be done on any threads in any order.
pub struct UpdateJob<'a, S = Partition, D: DirectionalModel = Model> {
    pub(super) rules: Rules<'a, S, D>,
    pub(super) shard: &'a mut Shard<D::Learnt>,
    /// Of the shard.
    pub(super) number: usize,
    pub(super) recorders: &'a [&'a Recorder],
}

impl<S: SpatialPartition, D: DirectionalModel> UpdateJob<'_, S, D> {
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
        let located = self.locate(some, &rows);
        let Rules { model, rate, origin, .. } = self.rules;
        for ((k, transition), row) in some.iter().enumerate().zip(rows) {
            let Some(row) = row else { continue };
            let region = self.shard.region_mut(row);
            model.record(&mut region.directions, &located, k, transition, rate);
            region.visit(transition, origin);
        }
    }

    /// Where the directions of transitions lie in their regions.
    #[inline(always)]
    fn locate(&self, some: &[Transition], rows: &[Option<u32>; LANES]) -> D::Located {
        let (mut normals, mut directions) = ([PackedDirection::default(); LANES], [PackedDirection::default(); LANES]);
        for (k, transition) in some.iter().enumerate() {
            (normals[k], directions[k]) = (transition.normal, transition.wi);
        }
        let mut about = Vec3Lanes::ZERO;
        if self.rules.partition.is_oriented() {
            for (k, row) in rows.iter().enumerate() {
                about.set(k, row.map_or(Vec3::Z, |row| self.shard.region(row).normal));
            }
        } else {
            PackedDirection::unpack_lanes(&normals, &mut about);
        }
        let mut wi = Vec3Lanes::ZERO;
        PackedDirection::unpack_lanes(&directions, &mut wi);
        self.rules.model.locate(&about, &wi)
    }

    /// Where the transition's region is held, which is made where there is none and room for one.
    #[inline]
    fn row_for(&mut self, transition: &Transition) -> Option<u32> {
        let known = self.shard.row(transition.key);
        known.or_else(|| self.make_room(transition).then(|| self.shard.row(transition.key))?)
    }

    /// Makes a region for a transition, if there is room.
    #[cold]
    fn make_room(&mut self, transition: &Transition) -> bool {
        let Rules { partition, model, origin, room, .. } = self.rules;
        let normal = partition.normal(transition.key).unwrap_or_else(|| transition.normal.unpack());
        let region = Region::new(transition.key, normal, model.untrained(), origin);
        let fits = self.shard.bytes() + region_bytes(model, &region) <= room;
        if fits {
            self.shard.insert(model, region);
        }
        fits
    }
}
