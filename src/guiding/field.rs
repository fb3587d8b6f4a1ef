//! The frozen guide: what sampling and pdf read during an iteration, and nothing changes.

use super::action::Strata;
use super::learner::Learner;
use super::qtable::Entry;
use super::state::{Grid, StateKey};
use crate::geometry::Frame;
use crate::math::rng::mix;
use glam::Vec3;
use rayon::prelude::*;

/// Visits of the whole state that a stratum's own must outweigh: below it, a stratum leans towards its state's mean,
/// so that what was never tried stays possible, in units that no exposure changes.
const PRIOR_VISITS: f32 = 1.0;

/// A state with fewer visits knows too little to guide.
const MIN_VISITS: f32 = 16.0;

/// A snapshot of the table, ready to be drawn from.
#[derive(Clone, Debug)]
pub struct Field {
    grid: Grid,
    strata: Strata,
    /// Open addressing with linear probing, at most half full; `EMPTY` ends a probe.
    slots: Vec<(StateKey, u32)>,
    /// Row by row, the distribution function over strata of Q·cosθ, its last value being 1; before it, its values at
    /// the end of each line of strata, so that a draw reads two short runs instead of the whole row.
    rows: Vec<f32>,
    /// Per row, ∫ Q cosθ dω over the hemisphere.
    irradiance: Vec<f32>,
}

const EMPTY: (StateKey, u32) = (StateKey(u64::MAX), u32::MAX);

/// Distribution over directions at one path vertex, frozen for this iteration.
///
/// Directions are unit, in world space, away from the surface; densities are per steradian. For every `wi`, `pdf(wi)`
/// is the density with which `sample` returns it. It covers the hemisphere of the state's normal, not the BSDF's
/// support: the mixture does that.
#[derive(Clone, Copy, Debug)]
pub struct GuidingDistribution<'f> {
    strata: &'f Strata,
    frame: &'f Frame,
    /// As in `Field::rows`.
    row: &'f [f32],
    /// ∫ Q cosθ dω: the state's irradiance (luminance) from what the table holds.
    pub irradiance: f32,
}

impl Field {
    /// A field that knows nothing yet.
    pub fn empty(grid: Grid, strata: Strata) -> Field {
        Field { grid, strata, slots: vec![EMPTY; 2], rows: Vec::new(), irradiance: Vec::new() }
    }

    /// Freezes what the learner knows now.
    pub fn freeze(&mut self, learner: &Learner) {
        let strata = &self.strata;
        let usable: Vec<(StateKey, &[Entry])> = learner
            .shards()
            .iter()
            .flat_map(|shard| shard.states())
            .filter(|(_, entries)| entries.iter().map(|e| e.visits).sum::<f32>() >= MIN_VISITS)
            .filter(|(_, entries)| entries.iter().any(|e| e.q > 0.0))
            .collect();
        let mut rows = vec![0.0; usable.len() * row_length(strata)];
        let mut irradiance = vec![0.0; usable.len()];
        (rows.par_chunks_exact_mut(row_length(strata)), &mut irradiance, &usable)
            .into_par_iter()
            .for_each(|(row, irradiance, (_, entries))| *irradiance = fill_row(strata, entries, row));
        self.slots = hash_slots(usable.iter().map(|(key, _)| *key));
        (self.rows, self.irradiance) = (rows, irradiance);
    }

    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The distribution of a state, where enough is known of it.
    #[inline]
    pub fn distribution(&self, key: StateKey) -> Option<GuidingDistribution<'_>> {
        let mask = self.slots.len() - 1;
        let mut at = mix(key.0) as usize & mask;
        loop {
            let (found, row) = self.slots[at];
            if found == key {
                let (row, length) = (row as usize, row_length(&self.strata));
                return Some(GuidingDistribution {
                    strata: &self.strata,
                    frame: self.grid.frame(key),
                    row: &self.rows[row * length..(row + 1) * length],
                    irradiance: self.irradiance[row],
                });
            }
            if found == EMPTY.0 {
                return None;
            }
            at = (at + 1) & mask;
        }
    }

    /// The action that direction `w` (world space) is in a state; `None` below its horizon.
    #[inline]
    pub fn action(&self, key: StateKey, w: Vec3) -> Option<usize> {
        self.strata.index(self.grid.frame(key).to_local(w))
    }

    /// K, the strata of each state.
    pub fn strata_count(&self) -> usize {
        self.strata.count()
    }

    /// States that can be drawn from.
    pub fn states(&self) -> usize {
        self.irradiance.len()
    }

    /// Bytes of the snapshot.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.rows[..]) + size_of_val(&self.irradiance[..]) + size_of_val(&self.slots[..])
    }

    /// Bytes that one state adds to a snapshot, its places in a hash at worst a quarter full included.
    pub fn bytes_per_state(strata: &Strata) -> usize {
        (row_length(strata) + 1) * size_of::<f32>() + 4 * size_of::<(StateKey, u32)>()
    }
}

impl GuidingDistribution<'_> {
    /// A direction in world space; its density is `pdf` of it.
    #[inline]
    pub fn sample(&self, u_stratum: f32, u: [f32; 2]) -> Vec3 {
        let side = self.strata.side();
        let (ends, cdf) = self.row.split_at(side);
        // counting instead of searching: no branch to guess wrong, and it runs in vectors
        let before = |values: &[f32]| values.iter().map(|&c| (c <= u_stratum) as usize).sum::<usize>();
        let line = before(&ends[..side - 1]);
        let k = line * side + before(&cdf[line * side..(line + 1) * side - 1]);
        self.frame.to_world(self.strata.direction(k, u))
    }

    /// Density per steradian of `sample` at the unit direction `w`; 0 below the horizon of the state's frame.
    #[inline]
    pub fn pdf(&self, w: Vec3) -> f32 {
        let Some(k) = self.strata.index(self.frame.to_local(w)) else { return 0.0 };
        let cdf = &self.row[self.strata.side()..];
        let below = if k == 0 { 0.0 } else { cdf[k - 1] };
        self.strata.density(cdf[k] - below)
    }
}

fn row_length(strata: &Strata) -> usize {
    strata.count() + strata.side()
}

/// Fills a row for drawing from Q·cosθ and returns ∫ Q cosθ dω.
fn fill_row(strata: &Strata, entries: &[Entry], row: &mut [f32]) -> f32 {
    let (ends, cdf) = row.split_at_mut(strata.side());
    let visits: f64 = entries.iter().map(|e| e.visits as f64).sum();
    let mean = (entries.iter().map(|e| e.q as f64 * e.visits as f64).sum::<f64>() / visits) as f32;
    let mut sum = 0.0f64;
    for ((out, entry), cos) in cdf.iter_mut().zip(entries).zip(strata.cosines()) {
        let q = (entry.q * entry.visits + mean * PRIOR_VISITS) / (entry.visits + PRIOR_VISITS);
        sum += (q * cos) as f64;
        *out = sum as f32;
    }
    let scale = (1.0 / sum) as f32;
    cdf.iter_mut().for_each(|c| *c = (*c * scale).min(1.0));
    cdf[cdf.len() - 1] = 1.0;
    ends.iter_mut().zip(cdf.chunks_exact(strata.side())).for_each(|(end, line)| *end = line[line.len() - 1]);
    sum as f32 * strata.solid_angle()
}

fn hash_slots(keys: impl ExactSizeIterator<Item = StateKey>) -> Vec<(StateKey, u32)> {
    let mut slots = vec![EMPTY; (2 * keys.len()).next_power_of_two().max(2)];
    let mask = slots.len() - 1;
    for (row, key) in keys.enumerate() {
        let mut at = mix(key.0) as usize & mask;
        while slots[at].0 != EMPTY.0 {
            at = (at + 1) & mask;
        }
        slots[at] = (key, row as u32);
    }
    slots
}
