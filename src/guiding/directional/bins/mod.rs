//! Bins of equal solid angle: the strata of the paper's tables, over the hemisphere or the sphere.

mod directions;
mod hemisphere;
mod rows;
mod sphere;
mod strata;

pub(crate) use directions::BinDirections;
pub(crate) use hemisphere::HemisphereBins;
pub(crate) use sphere::SphereBins;
pub(super) use strata::mean_cosine;
pub(crate) use strata::{Domain, Strata};

use super::{Entry, PROFILE};
use crate::guiding::settings::Rate;

/// Bytes of a stratum: learnt, and frozen at most.
const BYTES_PER_STRATUM: usize = size_of::<Entry>() + size_of::<f32>();

/// Learns from a target that arrived from stratum `k`.
#[inline(always)]
fn record(entries: &mut [Entry], k: Option<usize>, target: f32, rate: Rate) {
    if let Some(k) = k {
        entries[k].learn(target, rate);
    }
}

fn decay(entries: &mut [Entry], share: f32) {
    entries.iter_mut().for_each(|entry| entry.visits *= share);
}

fn is_informed(entries: &[Entry]) -> bool {
    entries.iter().any(|entry| entry.q > 0.0)
}

fn is_sound(entries: &[Entry], strata: &Strata) -> bool {
    entries.len() == strata.count() && entries.iter().all(Entry::is_sound)
}

/// Irradiance from each sixteenth of the square.
fn profile(entries: &[Entry], strata: &Strata) -> [f32; PROFILE] {
    let mut profile = [0.0; PROFILE];
    let (columns, lines) = (strata.columns(), strata.lines());
    for (k, entry) in entries.iter().enumerate() {
        let cos = strata.cosines().get(k).copied().unwrap_or(1.0);
        let (x, y) = (4 * (k % columns) / columns, 4 * (k / columns) / lines);
        profile[4 * y + x] += entry.q * cos * strata.solid_angle();
    }
    profile
}

/// Appends to a pool; returns where.
fn append<T>(row: Vec<T>, pool: &mut Vec<T>) -> std::ops::Range<u32> {
    let first = pool.len() as u32;
    pool.extend(row);
    first..pool.len() as u32
}
