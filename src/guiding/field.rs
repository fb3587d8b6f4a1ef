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

/// Parts into which a row divides the unit interval.
const WHOLE: u32 = 1 << 16;

/// A snapshot of the table, ready to be drawn from.
#[derive(Clone, Debug)]
pub struct Field {
    grid: Grid,
    strata: Strata,
    /// Open addressing with linear probing, at most half full; `EMPTY` ends a probe.
    slots: Vec<(StateKey, u32)>,
    /// Row by row, for drawing in proportion to Q·cosθ: where each stratum begins in the unit interval, in units of
    /// 1/`WHOLE`; before these, the same for the lines of strata, so that a draw reads two short runs of a row. Small
    /// numbers keep a row in few cache lines, where the time of a guided bounce goes; the rounding is exact for all
    /// that reads it, as draws and densities go by the rounded numbers.
    rows: Vec<u16>,
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
    row: &'f [u16],
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
        let mut rows = vec![0; usable.len() * row_length(strata)];
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
        row_length(strata) * size_of::<u16>() + size_of::<f32>() + 4 * size_of::<(StateKey, u32)>()
    }
}

impl GuidingDistribution<'_> {
    /// A direction in world space; its density is `pdf` of it.
    #[inline]
    pub fn sample(&self, u_stratum: f32, u: [f32; 2]) -> Vec3 {
        let side = self.strata.side();
        let (lines, strata) = self.row.split_at(side);
        let at = (u_stratum * WHOLE as f32) as u16;
        // counting instead of searching: no branch to guess wrong, and it runs in vectors
        let begun = |starts: &[u16]| starts.iter().map(|&start| (start <= at) as usize).sum::<usize>();
        let line = begun(&lines[1..]);
        let k = line * side + begun(&strata[line * side + 1..(line + 1) * side]);
        self.frame.to_world(self.strata.direction(k, u))
    }

    /// Density per steradian of `sample` at the unit direction `w`; 0 below the horizon of the state's frame.
    #[inline]
    pub fn pdf(&self, w: Vec3) -> f32 {
        let Some(k) = self.strata.index(self.frame.to_local(w)) else { return 0.0 };
        let strata = &self.row[self.strata.side()..];
        let end = strata.get(k + 1).map_or(WHOLE, |&start| start as u32);
        self.strata.density((end - strata[k] as u32) as f32 / WHOLE as f32)
    }
}

fn row_length(strata: &Strata) -> usize {
    strata.count() + strata.side()
}

/// Fills a row for drawing from Q·cosθ and returns ∫ Q cosθ dω.
fn fill_row(strata: &Strata, entries: &[Entry], row: &mut [u16]) -> f32 {
    let visits: f64 = entries.iter().map(|e| e.visits as f64).sum();
    let mean = (entries.iter().map(|e| e.q as f64 * e.visits as f64).sum::<f64>() / visits) as f32;
    let weight = |(entry, cos): (&Entry, &f32)| {
        let q = (entry.q * entry.visits + mean * PRIOR_VISITS) / (entry.visits + PRIOR_VISITS);
        (q * cos) as f64
    };
    let weights = || entries.iter().zip(strata.cosines()).map(weight);
    let whole: f64 = weights().sum();
    let (lines, starts) = row.split_at_mut(strata.side());
    let mut begun = 0.0;
    for (start, weight) in starts.iter_mut().zip(weights()) {
        *start = (begun / whole * WHOLE as f64).round().min((WHOLE - 1) as f64) as u16;
        begun += weight;
    }
    lines.iter_mut().zip(starts.chunks_exact(strata.side())).for_each(|(line, starts)| *line = starts[0]);
    whole as f32 * strata.solid_angle()
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
