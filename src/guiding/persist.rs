//! The serialised form of a guide: what it has learnt. Snapshots are made again when a guide is loaded.

use super::directional::{DirectionalModel, Model};
use super::guide::Guide;
use super::region::Region;
use super::spatial::{Partition, SpatialPartition};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What a guide has learnt.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Stored<'g, S: SpatialPartition = Partition, D: DirectionalModel = Model> {
    partition: S::Stored,
    /// By shard, in the order in which they were met.
    shards: Vec<Cow<'g, [Region<D::Learnt>]>>,
    ended: bool,
    learnt_paths: f64,
}

impl<S: SpatialPartition, D: DirectionalModel> Stored<'_, S, D> {
    /// The same again.
    pub(super) fn borrowed(&self) -> Stored<'_, S, D> {
        let shards = self.shards.iter().map(|regions| Cow::Borrowed(&**regions)).collect();
        let partition = self.partition.clone();
        Stored { partition, shards, ended: self.ended, learnt_paths: self.learnt_paths }
    }

    /// The same, which outlives the guide.
    pub(super) fn into_owned(self) -> Stored<'static, S, D> {
        let shards = self.shards.into_iter().map(|regions| Cow::Owned(regions.into_owned())).collect();
        Stored { partition: self.partition, shards, ended: self.ended, learnt_paths: self.learnt_paths }
    }
}

impl<S: SpatialPartition, D: DirectionalModel> Guide<S, D> {
    pub fn stored(&self) -> Stored<'_, S, D> {
        let shards = self.store.shards().iter().map(|shard| Cow::Borrowed(shard.regions())).collect();
        Stored { partition: self.partition.stored(), shards, ended: self.ended, learnt_paths: self.learnt_paths }
    }

    /// Puts back what a guide of the same settings has learnt, where this one is empty; its snapshot is then that of the
    /// guide that was stored.
    ///
    /// # Errors
    /// Where that is not what such a guide can have learnt, or is more than its memory holds.
    pub fn restore(&mut self, stored: Stored<S, D>) -> Result<(), String> {
        self.take_over(stored)?;
        if self.store.bytes() > self.store.memory() {
            let (takes, has) = (self.bytes() >> 20, self.store.memory() >> 20);
            return Err(format!("the guide takes {takes} MiB, and guiding.memory leaves {has} MiB"));
        }
        self.freeze();
        Ok(())
    }

    /// As [`Self::restore`], but the snapshot stays as it is, and the guide may be larger than its memory.
    pub(super) fn take_over(&mut self, stored: Stored<S, D>) -> Result<(), String> {
        let Stored { partition, shards, ended, learnt_paths } = stored;
        if !(learnt_paths.is_finite() && learnt_paths >= 0.0) {
            return Err(format!("it says that it learnt from {learnt_paths} paths"));
        }
        self.learnt_paths = learnt_paths;
        self.partition.restore(partition, self.store.memory())?;
        self.make_room();
        for region in shards.into_iter().flat_map(Cow::into_owned) {
            self.restore_region(region)?;
        }
        self.ended = ended;
        Ok(())
    }

    fn restore_region(&mut self, region: Region<D::Learnt>) -> Result<(), String> {
        let known = self.store.get(region.key).is_some();
        if known || !self.partition.holds(region.key) || !region.is_sound(&self.store.model) {
            return Err(format!("region {:016x} is not one that a guide can have learnt", region.key.0));
        }
        self.store.restore(region);
        Ok(())
    }
}
