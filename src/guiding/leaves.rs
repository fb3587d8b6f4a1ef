//! The SD-tree as a guide: its leaves are the states, and what they learn is what whole paths brought.

use super::distribution::GuidingDistribution;
use super::field::Summary;
use super::qtable::Returns;
use super::recorder::{Recorder, SHARDS, Transition};
use super::sdtree::{Sample, SdTree, SdTreeSettings, encode};
use super::states::StateKey;
use crate::scene::description::GuidingSettings;
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The tree, and what guided roulette wants to know of its leaves besides.
pub struct Leaves {
    tree: SdTree,
    /// By leaf: of this iteration, and where there was nothing in it, of the last one that had something.
    returns: Vec<Returns>,
    /// By leaf, as of the snapshot.
    summaries: Vec<Option<Summary>>,
}

impl Leaves {
    /// Nothing known yet. `(low, high)` are the scene's bounds.
    pub fn new(settings: &GuidingSettings, (low, high): (Vec3, Vec3)) -> Leaves {
        let tree = SdTreeSettings {
            split: settings.leaf_samples,
            rho: settings.rho,
            // without jitter there is none to move a record by
            spatial_filter: settings.jitter,
            directional_filter: settings.directional_filter,
            learned_fraction: settings.learns_fraction(),
            fraction: settings.bsdf_fraction,
            bytes_beside: size_of::<Returns>() + size_of::<Option<Summary>>(),
            ..SdTreeSettings::default()
        };
        let tree = SdTree::new(low, high, tree, settings.memory);
        Leaves { tree, returns: vec![Returns::default()], summaries: vec![None] }
    }

    /// The leaf to draw from at `p`.
    #[inline]
    pub fn drawn(&self, p: Vec3) -> StateKey {
        StateKey(self.tree.leaf_at(p) as u64)
    }

    /// The leaf in which to record what is found at `p`: [`SdTree::leaf`].
    #[inline]
    pub fn recorded(&self, p: Vec3, jitter: [f32; 3]) -> StateKey {
        StateKey(self.tree.leaf(p, jitter) as u64)
    }

    /// What is known of a leaf, where anything is.
    #[inline]
    pub fn summary(&self, key: StateKey) -> Option<&Summary> {
        self.summaries.get(key.0 as usize)?.as_ref()
    }

    /// Where to go on in a leaf of which `summary` is known.
    #[inline]
    pub fn distribution(&self, summary: &Summary) -> GuidingDistribution<'_> {
        let quadtree = self.tree.distribution(summary.leaf());
        GuidingDistribution::in_leaf(quadtree.expect("a summary is of a leaf that was learnt"))
    }

    /// Leaves that can be drawn from.
    pub fn known(&self) -> usize {
        self.summaries.iter().flatten().count()
    }

    /// Learns from what tiles recorded, in their order. All transitions of a leaf are in one shard, so that the result
    /// is the same for any number of threads.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        let returns = &self.returns;
        let learnt: Vec<_> = (0..SHARDS)
            .into_par_iter()
            .map(|shard| {
                let mut changed: FxHashMap<usize, Returns> = FxHashMap::default();
                let transitions = recorders.iter().flat_map(|recorder| recorder.shard(shard));
                let samples: Vec<Sample> = transitions
                    .inspect(|transition| {
                        let leaf = transition.key.0 as usize;
                        changed.entry(leaf).or_insert(returns[leaf]).add(transition);
                    })
                    .map(sample)
                    .collect();
                (samples, changed)
            })
            .collect();
        let samples: Vec<&[Sample]> = learnt.iter().map(|(samples, _)| &samples[..]).collect();
        self.tree.fold(&samples);
        for (leaf, returns) in learnt.into_iter().flat_map(|(_, changed)| changed) {
            self.returns[leaf] = returns;
        }
    }

    /// Ends an iteration of `spp` samples per pixel: [`SdTree::end_iteration`].
    pub fn end_iteration(&mut self, spp: u32) {
        for parent in self.tree.end_iteration(spp as f32) {
            self.returns.push(self.returns[parent as usize]);
        }
        let mut leaves: Vec<_> = self.tree.inspect().map(|leaf| (leaf.leaf, leaf.visits as f32)).collect();
        leaves.sort_unstable_by_key(|(leaf, _)| *leaf);
        let summary = |(leaf, visits): (u32, f32)| {
            self.tree.distribution(leaf)?;
            let (radiance, fraction) = (self.tree.mean_radiance(leaf), self.tree.fraction(leaf));
            Some(Summary::of_leaf(leaf, radiance, fraction, &self.returns[leaf as usize], visits))
        };
        self.summaries = leaves.into_iter().map(summary).collect();
        self.returns.shrink_to_fit();
        self.returns.iter_mut().for_each(|returns| returns.weight = 0.0);
    }

    pub fn tree(&self) -> &SdTree {
        &self.tree
    }

    /// Bytes of the tree and of what is kept beside it.
    pub fn bytes(&self) -> usize {
        self.tree.bytes() as usize
    }
}

/// What the tree learns from a transition.
fn sample(transition: &Transition) -> Sample {
    Sample {
        leaf: transition.key.0 as u32,
        direction: encode(transition.wi.unpack()),
        radiance: transition.target,
        pdf: transition.pdf,
        bsdf_pdf: transition.bsdf_pdf,
        scattered: transition.scattered,
    }
}
