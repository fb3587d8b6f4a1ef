//! The schedule of Practical Path Guiding (Müller et al. 2017, with the rule of 2019 for iterations that start with 1
//! sample): each iteration is learnt from alone, and leaves are halved by their samples.

use super::directional::DirectionalModel;
use super::memory::region_bytes;
use super::spatial::SpatialPartition;
use super::store::RegionStore;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Share of the memory that halving leaves may use up: the rest is for quadtrees to become finer.
const SPLIT_SHARE: f64 = 0.75;

/// Camera paths of an iteration for which `c` is meant: 4 samples per pixel of the pictures of the paper, 1280 × 720.
pub(super) const PATHS_OF_C: f64 = 4.0 * 1280.0 * 720.0;

/// What it takes to halve a leaf.
#[derive(Clone, Copy, Debug)]
pub struct SplitLimits {
    /// c: a leaf is halved that got more than c·√(n/[`PATHS_OF_C`]) samples in an iteration of n paths. The paper's law in
    /// the number of paths, whatever the size of the picture that they make.
    pub samples: f32,
}

/// Halves the leaves that got more samples than their limit, the fullest first, while there is room; both halves begin as
/// copies of the whole, with half of its samples.
pub fn split<D: DirectionalModel>(
    partition: &mut impl SpatialPartition,
    store: &mut RegionStore<D>,
    limits: SplitLimits,
    paths: u64,
) {
    let most = f64::from(limits.samples) * (paths as f64 / PATHS_OF_C).sqrt();
    let mut cells = vec![(0.0, 0); partition.cells()];
    for region in store.regions() {
        let (samples, bytes) = &mut cells[partition.cell_of(region.key)];
        (*samples, *bytes) = (*samples + region.visits as f64, *bytes + region_bytes(&store.model, region));
    }
    let room = (store.memory() as f64 * SPLIT_SHARE) as usize;
    let mut used = store.bytes();
    // positive floats are ordered as their bits are
    let entry = |(cell, (samples, bytes)): (usize, (f64, usize))| (samples.to_bits(), Reverse(cell), bytes);
    let mut open: BinaryHeap<_> =
        cells.into_iter().enumerate().filter(|(_, (_, bytes))| *bytes > 0).map(entry).collect();
    while let Some((samples, Reverse(cell), bytes)) = open.pop() {
        used += bytes;
        if f64::from_bits(samples) <= most || used > room {
            break;
        }
        let halves = partition.divide(cell).into_iter().flatten();
        open.extend(halves.map(|half| entry((half, (0.5 * f64::from_bits(samples), bytes)))));
    }
    replace_divided(partition, store);
}

/// Gives the parts of divided regions what the whole knew.
pub(super) fn replace_divided<D: DirectionalModel>(partition: &impl SpatialPartition, store: &mut RegionStore<D>) {
    store.replace(|model, region| {
        let parts = partition.parts(region.key);
        let part = |(key, share)| region.part(model, key, share);
        (!parts.is_empty()).then(|| parts.into_iter().map(part).collect())
    });
}
