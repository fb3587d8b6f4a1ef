//! What the learner keeps of a state's directions.

use super::square::{cell_at, coordinates};
use super::{DEPTH, FAN, bytes_per_node};
use crate::guiding::directional::Entry;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What the learner keeps of a state's directions: the cells of all nodes, and which node cuts each (0 for none).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntTree {
    pub entries: Vec<Entry>,
    pub(super) children: Vec<u16>,
}

impl LearntTree {
    /// Nothing known, nothing cut.
    pub fn new() -> LearntTree {
        LearntTree { entries: vec![Entry::default(); FAN], children: vec![0; FAN] }
    }

    pub fn nodes(&self) -> usize {
        self.children.len() / FAN
    }

    #[inline]
    pub(super) fn child(&self, node: usize, k: usize) -> Option<usize> {
        Some(self.children[node * FAN + k] as usize).filter(|&child| child != 0)
    }

    /// The entry for a direction in the region's frame; `None` below its horizon.
    #[cfg(test)]
    pub fn entry_mut(&mut self, local: Vec3) -> Option<&mut Entry> {
        self.entry_at(coordinates(local)?)
    }

    /// The entry for a direction with these [`coordinates`].
    #[inline]
    pub fn entry_at(&mut self, coordinates: [u32; 2]) -> Option<&mut Entry> {
        let index = self.index_at(coordinates)?;
        Some(&mut self.entries[index])
    }

    /// Which entry that is.
    #[inline]
    pub fn index_at(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let mut node = 0;
        for depth in 1..=DEPTH {
            let k = cell_at(x, y, depth);
            match self.child(node, k) {
                Some(child) => node = child,
                None => return Some(node * FAN + k),
            }
        }
        None
    }

    /// The estimate for a direction in the region's frame, as sampling sees it; `None` below the horizon.
    pub fn estimate(&self, local: Vec3) -> Option<f32> {
        let [x, y] = coordinates(local)?;
        let (mut node, mut prior) = (0, 0.0);
        for depth in 1..=DEPTH {
            prior = self.mean(node).unwrap_or(prior);
            let k = cell_at(x, y, depth);
            match self.child(node, k) {
                Some(child) => node = child,
                None => return Some(self.entries[node * FAN + k].shrunk(prior)),
            }
        }
        None
    }

    /// Whether the nodes form one tree, in the order in which [`TreeShape::refine`] makes them, and no deeper than there
    /// are cells: what all else relies on, and a file need not hold.
    pub fn is_sound(&self) -> bool {
        let nodes = self.nodes();
        let shaped = nodes >= 1 && self.children.len() == nodes * FAN && self.entries.len() == nodes * FAN;
        let mut next = 1;
        shaped && self.is_sound_below(0, 1, &mut next) && next == nodes
    }

    /// `next` is the node that comes next in the tree's order.
    fn is_sound_below(&self, node: usize, depth: usize, next: &mut usize) -> bool {
        (0..FAN).filter_map(|k| self.child(node, k)).all(|child| {
            let sound = child == *next && child < self.nodes() && depth < DEPTH;
            *next += 1;
            sound && self.is_sound_below(child, depth + 1, next)
        })
    }

    /// Mean over the cells of a node that were visited, cut ones by theirs.
    pub(super) fn mean(&self, node: usize) -> Option<f32> {
        let known = (0..FAN).filter_map(|k| match self.child(node, k) {
            Some(child) => self.mean(child),
            None => Some(self.entries[node * FAN + k]).filter(|e| e.visits > 0.0).map(|e| e.q),
        });
        let (sum, n) = known.fold((0.0, 0), |(sum, n), q| (sum + q, n + 1));
        (n > 0).then(|| sum / n as f32)
    }

    /// A node as one cell would know it.
    pub(super) fn summary(&self, node: usize) -> Entry {
        let visits = (0..FAN).map(|k| match self.child(node, k) {
            Some(child) => self.summary(child).visits,
            None => self.entries[node * FAN + k].visits,
        });
        Entry { q: self.mean(node).unwrap_or(0.0), visits: visits.sum() }
    }

    /// Bytes of what is kept of one state's directions.
    pub fn bytes(&self) -> usize {
        self.nodes() * bytes_per_node()
    }
}

impl Default for LearntTree {
    fn default() -> LearntTree {
        LearntTree::new()
    }
}
