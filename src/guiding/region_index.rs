//! The index of a snapshot: which row a region is.

use super::snapshot::RegionInfo;
use super::spatial::RegionId;
use crate::math::rng::mix;

/// Where keys are dense, they are their own places. Else open addressing with linear probing, at most half full; `EMPTY`
/// ends a probe. Keys lie with the rows, which a look-up reads anyway: eight slots share a cache line.
#[derive(Clone, Debug)]
pub enum RegionIndex {
    Hashed(Vec<Slot>),
    /// By key; `NONE` where there is no row.
    Dense(Vec<u32>),
}

/// The upper half of a key's hash, and the row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    hash: u32,
    row: u32,
}

const EMPTY: Slot = Slot { hash: u32::MAX, row: u32::MAX };
const NONE: u32 = u32::MAX;

impl RegionIndex {
    /// Bytes for a region: a quarter full at worst.
    pub const BYTES_PER_REGION: usize = 4 * size_of::<Slot>();

    /// The keys' rows are their places in this order. `dense` is a bound on the keys, where that is near their number.
    pub fn new(keys: impl ExactSizeIterator<Item = RegionId>, dense: Option<usize>) -> RegionIndex {
        match dense {
            Some(bound) => RegionIndex::dense(keys, bound),
            None => RegionIndex::hashed(keys),
        }
    }

    fn dense(keys: impl Iterator<Item = RegionId>, bound: usize) -> RegionIndex {
        let mut rows = vec![NONE; bound];
        keys.enumerate().for_each(|(row, key)| rows[key.0 as usize] = row as u32);
        RegionIndex::Dense(rows)
    }

    fn hashed(keys: impl ExactSizeIterator<Item = RegionId>) -> RegionIndex {
        let mut slots = vec![EMPTY; (2 * keys.len()).next_power_of_two().max(2)];
        let mask = slots.len() - 1;
        for (row, key) in keys.enumerate() {
            let hash = mix(key.0);
            let mut at = hash as usize & mask;
            while slots[at] != EMPTY {
                at = (at + 1) & mask;
            }
            slots[at] = Slot { hash: (hash >> 32) as u32, row: row as u32 };
        }
        RegionIndex::Hashed(slots)
    }

    /// The key's row, if there is one.
    #[inline(always)]
    pub fn find<'s>(&self, rows: &'s [RegionInfo], key: RegionId) -> Option<&'s RegionInfo> {
        match self {
            RegionIndex::Hashed(slots) => find_hashed(slots, rows, key),
            RegionIndex::Dense(places) => rows.get(*places.get(key.0 as usize)? as usize),
        }
    }

    pub fn bytes(&self) -> usize {
        match self {
            RegionIndex::Hashed(slots) => size_of_val(&slots[..]),
            RegionIndex::Dense(rows) => size_of_val(&rows[..]),
        }
    }
}

#[inline(always)]
fn find_hashed<'s>(slots: &[Slot], rows: &'s [RegionInfo], key: RegionId) -> Option<&'s RegionInfo> {
    let (hash, mask) = (mix(key.0), slots.len() - 1);
    let mut at = hash as usize & mask;
    loop {
        let slot = slots[at];
        if slot == EMPTY {
            return None;
        }
        if slot.hash == (hash >> 32) as u32 {
            let row = &rows[slot.row as usize];
            if row.key == key {
                return Some(row);
            }
        }
        at = (at + 1) & mask;
    }
}
