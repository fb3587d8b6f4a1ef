//! Where cells are divided: visits must be many enough to fill the parts, neighbours must differ, and there must be room.

use super::directional::{DirectionalModel, PROFILE};
use super::memory::region_bytes;
use super::ppg::replace_divided;
use super::recorder::shard_of;
use super::region::Region;
use super::spatial::{RegionId, SpatialPartition};
use super::store::{RegionStore, Shard};
use rayon::prelude::*;

/// What it takes to divide a cell.
#[derive(Clone, Copy, Debug)]
pub struct DivisionLimits {
    /// Visits in an iteration, for each region of the cell.
    pub visits: f32,
    /// Relative deviation of neighbouring regions' irradiance, direction by direction.
    pub difference: f32,
}

/// Sums over the regions of a cell.
#[derive(Clone, Copy, Default)]
struct CellSums {
    regions: f32,
    visits: f32,
    difference: f32,
    pairs: f32,
    bytes: usize,
}

/// Share of the memory up to which cells are divided: the rest is for directions to refine, and for regions yet to be met.
const DIVIDED_SHARE: f64 = 0.5;

/// Divides cells where it pays; the parts begin with what the whole knew. Regions that inherited and were not met
/// in the whole iteration since are dropped; those that were once met stay, as another camera's may have been.
pub fn refine<D: DirectionalModel>(
    partition: &mut impl SpatialPartition,
    store: &mut RegionStore<D>,
    limits: DivisionLimits,
) {
    if partition.cells() == 0 {
        return;
    }
    store.replace(|_, region| (!region.met).then(Vec::new));
    let cells = sums(partition, store);
    let pays = |cell: &CellSums| {
        let differs = cell.pairs == 0.0 || cell.difference > limits.difference * cell.pairs;
        cell.visits > limits.visits * cell.regions && differs
    };
    let mut paying: Vec<(usize, &CellSums)> = cells.iter().enumerate().filter(|(_, cell)| pays(cell)).collect();
    // where there is not room for all, the most visited regions come first
    paying.sort_by(|(_, a), (_, b)| (b.visits / b.regions).total_cmp(&(a.visits / a.regions)));
    let mut room = (store.memory() as f64 * DIVIDED_SHARE) as usize;
    room = room.saturating_sub(store.bytes());
    for (cell, sums) in paying {
        let growth = (partition.parts_per_region() - 1) * sums.bytes;
        if growth <= room && partition.divide(cell).is_some() {
            room -= growth;
        }
    }
    replace_divided(partition, store);
}

fn sums<D: DirectionalModel>(partition: &impl SpatialPartition, store: &RegionStore<D>) -> Vec<CellSums> {
    let mut cells = vec![CellSums::default(); partition.cells()];
    let differences = differences(partition, store);
    for (region, differences) in store.regions().zip(differences).filter(|(region, _)| region.fresh > 0.0) {
        let cell = &mut cells[partition.cell_of(region.key)];
        cell.regions += 1.0;
        cell.visits += region.fresh;
        cell.bytes += region_bytes(&store.model, region);
        for difference in differences {
            cell.difference += difference;
            cell.pairs += 1.0;
        }
    }
    cells
}

/// How much the regions beyond the faces differ from each region, where both are known; in the order of the regions.
fn differences<D: DirectionalModel>(
    partition: &impl SpatialPartition,
    store: &RegionStore<D>,
) -> impl Iterator<Item = Vec<f32>> {
    let profile = |region: &Region<D::Learnt>| store.model.profile(&region.directions);
    let of_shard = |shard: &Shard<D::Learnt>| shard.regions().iter().map(profile).collect();
    let profiles: Vec<Vec<[f32; PROFILE]>> = store.shards().par_iter().map(of_shard).collect();
    let known = |key: RegionId| {
        let shard = shard_of(key);
        store.shards()[shard].row(key).map(|row| &profiles[shard][row as usize])
    };
    let of_region = |region: &Region<D::Learnt>| {
        let Some(own) = known(region.key).filter(|_| region.fresh > 0.0) else { return Vec::new() };
        let others = partition.neighbours(region.key).into_iter().filter_map(known);
        others.filter_map(|other| difference(own, other)).collect()
    };
    let of_shard = |shard: &Shard<D::Learnt>| shard.regions().iter().map(of_region).collect();
    let all: Vec<Vec<_>> = store.shards().par_iter().map(of_shard).collect();
    all.into_iter().flatten()
}

/// Relative; `None` where both are dark.
fn difference(a: &[f32; PROFILE], b: &[f32; PROFILE]) -> Option<f32> {
    let (difference, sum) = a.iter().zip(b).fold((0.0, 0.0), |(d, s), (a, b)| (d + (a - b).abs(), s + a + b));
    (sum > 0.0).then_some(difference / sum)
}
