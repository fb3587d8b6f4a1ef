//! The Q-table: stores values and visits by state and action, and does nothing else.

use super::state::StateKey;
use rustc_hash::FxHashMap;

/// The part of the table whose states hash to one shard. States get rows in the order in which they are first met.
#[derive(Clone, Debug)]
pub struct Shard {
    actions: usize,
    rows: FxHashMap<StateKey, u32>,
    keys: Vec<StateKey>,
    /// Row by row: what is known of a state-action pair.
    entries: Vec<Entry>,
}

/// A state-action pair: the estimate of incident radiance (luminance), and the weight of the visits behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    pub q: f32,
    pub visits: f32,
}

impl Shard {
    pub fn new(actions: usize) -> Shard {
        Shard { actions, rows: FxHashMap::default(), keys: Vec::new(), entries: Vec::new() }
    }

    /// The row of a state; a new one where there is room for it among at most `capacity` states.
    #[inline]
    pub fn row_or_insert(&mut self, key: StateKey, capacity: usize) -> Option<usize> {
        if let Some(&row) = self.rows.get(&key) {
            return Some(row as usize);
        }
        let row = self.keys.len();
        if row >= capacity {
            return None;
        }
        self.rows.insert(key, row as u32);
        self.keys.push(key);
        self.entries.resize(self.entries.len() + self.actions, Entry::default());
        Some(row)
    }

    #[inline]
    pub fn entry_mut(&mut self, row: usize, action: usize) -> &mut Entry {
        &mut self.entries[row * self.actions + action]
    }

    /// All states with their entries, in the order of their rows.
    pub fn states(&self) -> impl Iterator<Item = (StateKey, &[Entry])> {
        self.keys.iter().copied().zip(self.entries.chunks_exact(self.actions))
    }

    pub fn entries_mut(&mut self) -> &mut [Entry] {
        &mut self.entries
    }

    pub fn len(&self) -> usize {
        self.keys.len()
    }

    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Bytes that one state takes in a shard: its entries, its key, and its place in the map at full load.
    pub fn bytes_per_state(actions: usize) -> usize {
        actions * size_of::<Entry>() + size_of::<StateKey>() + 2 * (size_of::<(StateKey, u32)>() + 1)
    }
}
