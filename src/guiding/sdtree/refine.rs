//! Between iterations: what was learnt becomes the snapshot, and the trees follow it, within the memory there is.

use super::{Frozen, Learner, SdTree, SdTreeSettings};
use crate::guiding::directional::quadtree::building::{Building, Fineness};
use crate::guiding::directional::quadtree::frozen::{Branch, Node};
use crate::guiding::spatial::kd_tree::{MAX_DEPTH, SpatialTree};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Bytes of a spatial tree that was never split.
const ROOT_BYTES: u64 = size_of::<u32>() as u64;
/// Bytes of a leaf besides its quadtrees.
const LEAF_BYTES: usize = size_of::<Frozen>() + size_of::<Learner>() + SpatialTree::BYTES_PER_SPLIT;
/// Share of the memory that halving leaves may use up: the rest is for quadtrees to become finer.
const SPLIT_SHARE: f64 = 0.75;

impl SdTree {
    /// Writes the snapshot. A leaf that found no light keeps the distribution it had.
    pub(super) fn freeze(&mut self) {
        let energies: Vec<f64> = self.learners.par_iter_mut().map(|learner| learner.quadtree.sum_up()).collect();
        let old = std::mem::take(&mut self.nodes);
        let before = self.frozen.clone();
        let mut first = 0;
        for ((frozen, learner), &energy) in self.frozen.iter_mut().zip(&self.learners).zip(&energies) {
            frozen.first = first;
            if energy > 0.0 {
                frozen.nodes = learner.quadtree.nodes() as u32;
                frozen.mean = learner.mean(energy);
            }
            if self.settings.learned_fraction {
                frozen.fraction = learner.fraction.value() as f32;
            }
            first += frozen.nodes;
        }
        let empty = Node::new(Branch::new(1, 0), [0.0; 4]);
        self.nodes = vec![empty; first as usize];
        let parts = parts(&mut self.nodes, &self.frozen);
        (parts, &self.learners, &energies, &before).into_par_iter().for_each(|(part, learner, energy, before)| {
            match *energy > 0.0 {
                true => learner.quadtree.write(part),
                false => part.copy_from_slice(&old[before.first as usize..][..before.nodes as usize]),
            }
        });
    }

    /// Gives every quadtree the form that its energy asks for, and begins to count anew. Where all of them together
    /// are too large, they are built for twice the ρ, and so on.
    pub(super) fn refine(&mut self) {
        let mut fineness = Fineness::of(&self.settings);
        let forms = loop {
            let refined = |learner: &Learner| learner.quadtree.refined(fineness);
            let forms: Vec<Vec<Branch>> = self.learners.par_iter().map(refined).collect();
            let sizes = forms
                .iter()
                .zip(&self.frozen)
                .map(|(form, frozen)| leaf_bytes(&self.settings, form.len(), frozen.nodes));
            // beyond 1, ρ divides nothing
            if ROOT_BYTES + sizes.sum::<u64>() <= self.memory || fineness.rho >= 1.0 {
                break forms;
            }
            fineness.rho *= 2.0;
        };
        self.learners.par_iter_mut().zip(forms).for_each(|(learner, form)| {
            learner.quadtree = Building::of(form);
            learner.last_visits = std::mem::take(&mut learner.visits) as f64;
        });
    }

    /// Halves the leaves that got more than `most` samples, the fullest first, while there is room. Returns which leaf
    /// each new one is a half of.
    pub(super) fn split(&mut self, most: f64) -> Vec<u32> {
        let room = (self.memory as f64 * SPLIT_SHARE) as u64;
        let bytes = |l: &Learner, frozen: &Frozen| leaf_bytes(&self.settings, l.quadtree.nodes(), frozen.nodes);
        let sizes = self.learners.iter().zip(&self.frozen).map(|(l, frozen)| bytes(l, frozen));
        let mut used = ROOT_BYTES + sizes.sum::<u64>();
        // positive floats are ordered as their bits are
        let entry = |leaf: usize, learner: &Learner| (learner.last_visits.to_bits(), Reverse(leaf));
        let mut open: BinaryHeap<_> = self.learners.iter().enumerate().map(|(i, l)| entry(i, l)).collect();
        let mut parents = Vec::new();
        while let Some((visits, Reverse(leaf))) = open.pop() {
            used += leaf_bytes(&self.settings, self.learners[leaf].quadtree.nodes(), self.frozen[leaf].nodes);
            if f64::from_bits(visits) <= most || used > room {
                break;
            }
            if self.learners[leaf].depth < MAX_DEPTH {
                let other = self.halve(leaf);
                parents.push(leaf as u32);
                open.extend([leaf, other].map(|half| entry(half, &self.learners[half])));
            }
        }
        self.spatial.shrink();
        self.frozen.shrink_to_fit();
        self.learners.shrink_to_fit();
        parents
    }

    /// Halves a leaf; both halves begin as copies of it, with half of its samples. Returns the new one.
    fn halve(&mut self, leaf: usize) -> usize {
        let other = self.learners.len();
        let learner = &mut self.learners[leaf];
        let nodes = self.spatial.split(learner.node, other as u32);
        learner.depth += 1;
        learner.last_visits *= 0.5;
        learner.node = nodes[0];
        let half = Learner { node: nodes[1], ..learner.clone() };
        self.learners.push(half);
        self.frozen.push(self.frozen[leaf]);
        other
    }
}

/// Bytes to set aside for a leaf whose next quadtree has `nodes`: that one, the `frozen` nodes that it has or will
/// have to itself, and the one that is written next, while the other is still there.
fn leaf_bytes(settings: &SdTreeSettings, nodes: usize, frozen: u32) -> u64 {
    let now = frozen.max(1) as usize;
    let snapshots = (now + now.max(nodes)) * size_of::<Node>();
    (LEAF_BYTES + settings.bytes_beside + nodes * Building::BYTES + snapshots) as u64
}

/// The nodes of each leaf.
fn parts<'a>(mut nodes: &'a mut [Node], leaves: &[Frozen]) -> Vec<&'a mut [Node]> {
    let mut part = |leaf: &Frozen| {
        let (part, rest) = std::mem::take(&mut nodes).split_at_mut(leaf.nodes as usize);
        nodes = rest;
        part
    };
    leaves.iter().map(&mut part).collect()
}

/// The form of an untrained quadtree, as fine as there is room for.
pub(super) fn untrained(settings: &SdTreeSettings, memory: u64) -> Building {
    let mut fineness = Fineness::of(settings);
    loop {
        let quadtree = Building::uniform(fineness);
        if ROOT_BYTES + leaf_bytes(settings, quadtree.nodes(), 0) <= memory || fineness.rho >= 1.0 {
            return quadtree;
        }
        fineness.rho *= 2.0;
    }
}
