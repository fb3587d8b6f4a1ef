//! The regions: stores what is known of each, in shards, within the memory there is.

use super::directional::DirectionalModel;
use super::memory::{bytes_besides_directions, region_bytes, usual_region_bytes};
use super::recorder::{SHARDS, shard_of};
use super::region::Region;
use super::spatial::RegionId;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// Share of the memory up to which directions refine: the rest is for regions yet to be met.
const REFINED_SHARE: f64 = 0.75;

/// The regions whose keys hash to one shard, in the order in which they were first met.
#[derive(Clone, Debug)]
pub struct Shard<L> {
    rows: FxHashMap<RegionId, u32>,
    regions: Vec<Region<L>>,
    bytes: usize,
}

/// All regions.
#[derive(Clone, Debug)]
pub struct RegionStore<D: DirectionalModel> {
    pub(super) model: D,
    shards: Vec<Shard<D::Learnt>>,
    /// Bytes that all regions together may take.
    memory: usize,
    /// All of that for any shard, where regions are made between iterations only; else shards have equal parts, as they
    /// know nothing of each other.
    shared: bool,
    /// How much larger than the settings' the share of light is for which directions are cut, so that there is room for
    /// all.
    coarseness: f32,
}

/// How much regions take, and may take.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoreLimits {
    memory: usize,
    coarseness: f32,
    /// By shard.
    bytes: Vec<usize>,
}

impl<L> Shard<L> {
    fn new() -> Shard<L> {
        Shard { rows: FxHashMap::default(), regions: Vec::new(), bytes: 0 }
    }

    pub fn get(&self, key: RegionId) -> Option<&Region<L>> {
        self.row(key).map(|row| self.region(row))
    }

    /// Where a region is held.
    #[inline]
    pub fn row(&self, key: RegionId) -> Option<u32> {
        self.rows.get(&key).copied()
    }

    #[inline]
    pub fn region(&self, row: u32) -> &Region<L> {
        &self.regions[row as usize]
    }

    #[inline]
    pub fn region_mut(&mut self, row: u32) -> &mut Region<L> {
        &mut self.regions[row as usize]
    }

    pub fn regions(&self) -> &[Region<L>] {
        &self.regions
    }

    /// Bytes of the shard's regions, snapshot included.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    pub fn insert<D: DirectionalModel<Learnt = L>>(&mut self, model: &D, region: Region<L>) {
        self.bytes += region_bytes(model, &region);
        self.rows.insert(region.key, self.regions.len() as u32);
        self.regions.push(region);
    }

    /// Drops regions: `stays` says of each in turn whether it does.
    fn keep<D: DirectionalModel<Learnt = L>>(&mut self, model: &D, mut stays: impl Iterator<Item = bool> + Clone) {
        if stays.clone().all(|stays| stays) {
            return;
        }
        self.regions.retain(|_| stays.next().unwrap_or(true));
        self.regions.shrink_to_fit();
        self.rows = self.regions.iter().enumerate().map(|(row, region)| (region.key, row as u32)).collect();
        self.count_bytes(model);
    }

    /// Gives each region the directions that `forms` has for it, as long as all of them take `room` bytes at most.
    fn reshape<D: DirectionalModel<Learnt = L>>(&mut self, model: &D, forms: Vec<Option<L>>, room: usize) {
        let mut left = room.saturating_sub(self.bytes);
        for (region, form) in self.regions.iter_mut().zip(forms) {
            let Some(form) = form else { continue };
            let (before, after) = (model.bytes(&region.directions), model.bytes(&form));
            if after <= before + left {
                region.directions = form;
                left = (left + before).saturating_sub(after);
            }
        }
        self.count_bytes(model);
    }

    /// Counts again after regions have changed in size.
    fn count_bytes<D: DirectionalModel<Learnt = L>>(&mut self, model: &D) {
        self.bytes = self.regions.iter().map(|region| region_bytes(model, region)).sum();
    }
}

impl<D: DirectionalModel> RegionStore<D> {
    /// Nothing known yet. `shared`: regions are made between iterations only.
    pub fn new(model: D, memory: usize, shared: bool) -> RegionStore<D> {
        let shards = (0..SHARDS).map(|_| Shard::new()).collect();
        RegionStore { model, shards, memory, shared, coarseness: 1.0 }
    }

    /// Bytes that a shard may take.
    fn room(&self) -> usize {
        // the first of regions that are made by division is always there
        if self.shared { self.memory.max(usual_region_bytes(&self.model)) } else { self.memory / SHARDS }
    }

    /// The shards, the model, and the bytes that each shard may take.
    pub(super) fn parts_mut(&mut self) -> (&mut [Shard<D::Learnt>], &D, usize) {
        let room = self.room();
        (&mut self.shards, &self.model, room)
    }

    pub(super) fn for_each(&mut self, change: impl Fn(&D, &mut Region<D::Learnt>) + Sync) {
        let RegionStore { shards, model, .. } = self;
        let model = &*model;
        shards.par_iter_mut().flat_map(|shard| &mut shard.regions).for_each(|region| change(model, region));
    }

    /// Takes notice that an iteration ended.
    pub fn end_iteration(&mut self) {
        self.for_each(|model, region| model.end_iteration(&mut region.directions));
        let RegionStore { shards, model, .. } = self;
        let model = &*model;
        shards.par_iter_mut().for_each(|shard| shard.count_bytes(model));
    }

    /// Cuts directions anew where the light is. Comes between two iterations, before the snapshot is taken. Where all of
    /// them together would be too large, they are cut for twice the share of light, and so on.
    pub fn refine_directions(&mut self) {
        let most = (self.memory as f64 * REFINED_SHARE) as usize;
        let forms = loop {
            let refined = |region: &Region<D::Learnt>| self.model.refined(&region.directions, self.coarseness);
            let forms = |shard: &Shard<D::Learnt>| shard.regions().iter().map(refined).collect::<Vec<_>>();
            let forms: Vec<Vec<_>> = self.shards.par_iter().map(forms).collect();
            let fixed = bytes_besides_directions::<D::Learnt>() * self.len();
            let bytes = fixed + forms.iter().flatten().flatten().map(|form| self.model.bytes(form)).sum::<usize>();
            if bytes <= most || self.model.is_coarsest(self.coarseness) {
                break forms;
            }
            self.coarseness *= 2.0;
        };
        let room = self.room();
        let RegionStore { shards, model, .. } = self;
        let model = &*model;
        shards.par_iter_mut().zip(forms).for_each(|(shard, forms)| shard.reshape(model, forms, room));
    }

    /// Replaces each region by others: `heirs` says by which; where it says nothing, the region stays.
    pub fn replace(&mut self, heirs: impl Fn(&D, &Region<D::Learnt>) -> Option<Vec<Region<D::Learnt>>> + Sync) {
        let RegionStore { shards, model, .. } = self;
        let model = &*model;
        let of_shard = |shard: &mut Shard<D::Learnt>| {
            let heirs: Vec<Option<Vec<_>>> = shard.regions().iter().map(|region| heirs(model, region)).collect();
            shard.keep(model, heirs.iter().map(Option::is_none));
            heirs.into_iter().flatten().flatten().collect()
        };
        let new: Vec<Vec<Region<D::Learnt>>> = shards.par_iter_mut().map(of_shard).collect();
        let room = self.room();
        for region in new.into_iter().flatten() {
            let shard = &mut self.shards[shard_of(region.key)];
            let fits = shard.bytes() + region_bytes(&self.model, &region) <= room;
            if fits && shard.get(region.key).is_none() {
                shard.insert(&self.model, region);
            }
        }
    }

    /// What is known, by shard.
    pub fn shards(&self) -> &[Shard<D::Learnt>] {
        &self.shards
    }

    /// Puts back a region that is not there yet.
    pub fn restore(&mut self, region: Region<D::Learnt>) {
        self.shards[shard_of(region.key)].insert(&self.model, region);
    }

    /// What decides how much more regions may take.
    pub fn limits(&self) -> StoreLimits {
        let bytes = self.shards.iter().map(Shard::bytes).collect();
        StoreLimits { memory: self.memory, coarseness: self.coarseness, bytes }
    }

    /// Goes on with the limits of another store that holds the same.
    ///
    /// # Errors
    /// Where they are none.
    pub fn set_limits(&mut self, StoreLimits { memory, coarseness, bytes }: StoreLimits) -> Result<(), String> {
        if bytes.len() != self.shards.len() || !(coarseness >= 1.0 && coarseness.is_finite()) {
            return Err("the limits of its memory are none".into());
        }
        (self.memory, self.coarseness) = (memory, coarseness);
        self.shards.iter_mut().zip(bytes).for_each(|(shard, bytes)| shard.bytes = bytes);
        Ok(())
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.shards.iter_mut().for_each(|shard| *shard = Shard::new());
    }

    /// Bytes that all regions may take.
    pub fn memory(&self) -> usize {
        self.memory
    }

    /// Changes the bytes that all regions together may take, where none is yet.
    pub fn keep_within(&mut self, memory: usize) {
        self.memory = memory;
    }

    pub fn get(&self, key: RegionId) -> Option<&Region<D::Learnt>> {
        self.shards[shard_of(key)].get(key)
    }

    /// All regions, in an order that depends on nothing but what was learnt.
    pub fn regions(&self) -> impl Iterator<Item = &Region<D::Learnt>> {
        self.shards.iter().flat_map(|shard| shard.regions())
    }

    pub fn len(&self) -> usize {
        self.shards.iter().map(|shard| shard.regions().len()).sum()
    }

    /// Bytes of all regions, snapshot included.
    pub fn bytes(&self) -> usize {
        self.shards.iter().map(Shard::bytes).sum()
    }
}
