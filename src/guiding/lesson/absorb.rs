//! A guide takes in what was summed up.

use super::{Lesson, RegionSums};
use crate::guiding::PackedDirection;
use crate::guiding::directional::{DirectionalModel, Entry};
use crate::guiding::guide::Guide;
use crate::guiding::memory::region_bytes;
use crate::guiding::region::{Region, ReturnMoments};
use crate::guiding::settings::Rate;
use crate::guiding::spatial::{RegionId, SpatialPartition};
use crate::guiding::store::Shard;
use crate::math::fixed::value;
use crate::simd::{LANES, Vec3Lanes};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::cmp::Reverse;

/// What is the same for all regions.
struct Teacher<'a, S, D> {
    partition: &'a S,
    model: &'a D,
    rate: Rate,
    /// Logit of the BSDF's share where nothing is known yet.
    origin: f32,
    /// Bytes that a shard may hold.
    room: usize,
}

impl<S: SpatialPartition, D: DirectionalModel> Guide<S, D> {
    /// Learns from a whole iteration of `paths` camera paths at once, and freezes what it knows then.
    ///
    /// # Errors
    /// Sums that are not of transitions under this guide.
    pub(crate) fn take_in(&mut self, lesson: Lesson, paths: u64) -> Result<(), String> {
        self.begin_iteration(paths);
        self.forget();
        let partition = &self.partition;
        let (shards, model, room) = self.store.parts_mut();
        let teacher = Teacher { partition, model, rate: self.rate, origin: self.origin, room };
        let mut of_shards = lesson.into_shards();
        let foreign = of_shards.iter().flatten().find(|(key, _)| !partition.holds(*key)).map(|(key, _)| *key);
        foreign.map_or(Ok(()), |key| Err(unsound(key)))?;
        let both = shards.par_iter_mut().zip(&mut of_shards);
        both.try_for_each(|(shard, sums)| teacher.teach(shard, std::mem::take(sums)))?;
        self.end_iteration(paths);
        Ok(())
    }
}

fn unsound(key: RegionId) -> String {
    format!("region {:016x} is not one that paths under this guide can have met", key.0)
}

impl<S: SpatialPartition, D: DirectionalModel> Teacher<'_, S, D> {
    /// Regions that are new come in while there is room, those with the most visits first.
    fn teach(&self, shard: &mut Shard<D::Learnt>, sums: Vec<(RegionId, RegionSums)>) -> Result<(), String> {
        let mut new = Vec::new();
        for (key, sums) in sums {
            match shard.row(key) {
                Some(row) => self.teach_known(shard.region_mut(row), &sums)?,
                None => new.push((key, sums)),
            }
        }
        new.sort_by_key(|(key, sums)| (Reverse(sums.visits), *key));
        for (key, sums) in new {
            let region = self.met(key, &sums).ok_or_else(|| unsound(key))?;
            if shard.bytes() + region_bytes(self.model, &region) <= self.room {
                shard.insert(self.model, region);
            }
        }
        Ok(())
    }

    fn teach_known(&self, region: &mut Region<D::Learnt>, sums: &RegionSums) -> Result<(), String> {
        let entries = self.model.entries_mut(&mut region.directions);
        if !sums.is_sound(entries.len()) {
            return Err(unsound(region.key));
        }
        for (cell, sums) in &sums.cells {
            entries[*cell as usize].learn_all(sums.visits, value(sums.target), self.rate);
        }
        self.count(region, sums);
        Ok(())
    }

    /// A region that the guide did not know: its frame is about the mean of the normals, where the partition says no other.
    fn met(&self, key: RegionId, sums: &RegionSums) -> Option<Region<D::Learnt>> {
        let mean = DVec3::from_array(sums.normal.map(|sum| sum as f64)).try_normalize()?.as_vec3();
        let normal = self.partition.normal(key).unwrap_or(mean);
        if !sums.is_sound(PackedDirection::CELLS as usize) {
            return None;
        }
        let mut region = Region::new(key, normal, self.model.untrained(), self.origin);
        let mut by_entry = vec![(0, 0i128); self.model.entries_mut(&mut region.directions).len()];
        for some in sums.cells.chunks(LANES) {
            let mut wi = Vec3Lanes::ZERO;
            some.iter().enumerate().for_each(|(k, (cell, _))| wi.set(k, PackedDirection::of_cell(*cell).unpack()));
            let located = self.model.locate(&all(normal), &wi);
            for (k, (_, sums)) in some.iter().enumerate() {
                if let Some(entry) = self.model.entry_index(&region.directions, &located, k) {
                    let (visits, target) = &mut by_entry[entry];
                    (*visits, *target) = (*visits + sums.visits, target.saturating_add(sums.target));
                }
            }
        }
        let entries: &mut [Entry] = self.model.entries_mut(&mut region.directions);
        entries.iter_mut().zip(by_entry).for_each(|(entry, (visits, target))| {
            entry.learn_all(visits, value(target), self.rate);
        });
        self.count(&mut region, sums);
        Some(region)
    }

    /// All but the directions.
    fn count(&self, region: &mut Region<D::Learnt>, sums: &RegionSums) {
        region.visits += sums.visits as f32;
        region.fresh += sums.visits as f32;
        region.met = true;
        let returns = &sums.returns;
        let means = [returns.estimate, returns.square, returns.red, returns.blue].map(value);
        region.returns.add_all(returns.visits, means, returns.rays as f64);
        sums.fraction.teach(&mut region.fraction, self.origin);
        let [rays, open] = [sums.visibility.rays, sums.visibility.open].map(|sum| value(sum) as f32);
        region.visibility.rays += rays;
        region.visibility.open += open;
    }
}

/// The same vector in all lanes.
fn all(v: Vec3) -> Vec3Lanes {
    let mut lanes = Vec3Lanes::ZERO;
    (0..LANES).for_each(|k| lanes.set(k, v));
    lanes
}

impl ReturnMoments {
    /// Counts so many visits in at once, by their sums: of the estimate, its square, its red and its blue, and of their rays.
    fn add_all(&mut self, visits: u64, [mean, square, red, blue]: [f64; 4], rays: f64) {
        if visits == 0 {
            return;
        }
        let (count, before) = (visits as f64, f64::from(self.weight));
        let join =
            |own: f32, sum: f64| ((f64::from(own) * before + sum) / (before + count)).min(f64::from(f32::MAX)) as f32;
        *self = ReturnMoments {
            weight: (before + count) as f32,
            mean: join(self.mean, mean),
            square: join(self.square, square),
            rays: join(self.rays, rays),
            red: join(self.red, red),
            blue: join(self.blue, blue),
        };
    }
}
