//! The hash of a snapshot: which row a state's summary is.

use super::snapshot::RegionInfo;
use crate::guiding::spatial::StateKey;
use crate::math::rng::mix;

/// Open addressing with linear probing, at most half full; `EMPTY` ends a probe. Keys lie with the summaries, which a
/// look-up reads anyway: eight slots share a cache line.
#[derive(Clone, Debug)]
pub struct RegionIndex(Vec<Slot>);

/// The upper half of a key's hash, and the row.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slot {
    hash: u32,
    row: u32,
}

const EMPTY: Slot = Slot { hash: u32::MAX, row: u32::MAX };

impl RegionIndex {
    /// Bytes for a state: a quarter full at worst.
    pub const BYTES_PER_STATE: usize = 4 * size_of::<Slot>();

    /// The keys' rows are their places in this order.
    pub fn new(keys: impl ExactSizeIterator<Item = StateKey>) -> RegionIndex {
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
        RegionIndex(slots)
    }

    /// The key's summary, if there is one.
    #[inline(always)]
    pub fn find<'s>(&self, summaries: &'s [RegionInfo], key: StateKey) -> Option<&'s RegionInfo> {
        let (hash, mask) = (mix(key.0), self.0.len() - 1);
        let mut at = hash as usize & mask;
        loop {
            let slot = self.0[at];
            if slot == EMPTY {
                return None;
            }
            if slot.hash == (hash >> 32) as u32 {
                let summary = &summaries[slot.row as usize];
                if summary.key == key {
                    return Some(summary);
                }
            }
            at = (at + 1) & mask;
        }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}
