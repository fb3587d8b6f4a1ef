//! The SD-tree as a guide: its leaves are the states, and what they learn is what whole paths brought.

use super::recorder::{Recorder, SHARDS, Transition};
use super::sdtree::{LeafInfo, Sample, SdTree, SdTreeSettings, encode};
use super::snapshot::RegionInfo;
use crate::guiding::directional::distribution::GuidingDistribution;
use crate::guiding::settings::GuidingSettings;
use crate::guiding::spatial::StateKey;
use crate::guiding::store::ReturnMoments;
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The tree, and what guided roulette wants to know of its leaves besides.
pub struct PpgGuide {
    pub(super) tree: SdTree,
    /// By leaf: of this iteration, and where there was nothing in it, of the last one that had something.
    pub(super) returns: Vec<ReturnMoments>,
    /// By leaf, as of the snapshot; empty before the first.
    summaries: Vec<RegionInfo>,
}

impl PpgGuide {
    /// Nothing known yet. `(low, high)` are the scene's bounds.
    pub fn new(settings: &GuidingSettings, (low, high): (Vec3, Vec3)) -> PpgGuide {
        let tree = SdTreeSettings {
            split: settings.leaf_samples,
            rho: settings.rho,
            // without jitter there is none to move a record by
            spatial_filter: settings.jitter,
            directional_filter: settings.directional_filter,
            learned_fraction: settings.learns_fraction(),
            fraction: settings.bsdf_fraction,
            bytes_beside: size_of::<ReturnMoments>() + size_of::<RegionInfo>(),
            ..SdTreeSettings::default()
        };
        let tree = SdTree::new(low, high, tree, settings.memory);
        PpgGuide { tree, returns: vec![ReturnMoments::default()], summaries: Vec::new() }
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
    pub fn summary(&self, key: StateKey) -> Option<&RegionInfo> {
        self.summaries.get(key.0 as usize).filter(|summary| summary.is_known())
    }

    /// Where to go on in a leaf of which `summary` is known.
    #[inline]
    pub fn distribution(&self, summary: &RegionInfo) -> GuidingDistribution<'_> {
        let quadtree = self.tree.distribution(summary.leaf());
        GuidingDistribution::in_leaf(quadtree.expect("a summary is of a leaf that was learnt"))
    }

    /// Leaves that can be drawn from.
    pub fn known(&self) -> usize {
        self.summaries.iter().filter(|summary| summary.is_known()).count()
    }

    /// Learns from what tiles recorded, in their order. All transitions of a leaf are in one shard, so that the result
    /// is the same for any number of threads.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        let returns = &self.returns;
        let learnt: Vec<_> = (0..SHARDS)
            .into_par_iter()
            .map(|shard| {
                let mut changed: FxHashMap<usize, ReturnMoments> = FxHashMap::default();
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
        self.summarise();
        self.returns.shrink_to_fit();
        self.returns.iter_mut().for_each(|returns| returns.weight = 0.0);
    }

    /// What is now known of each leaf.
    pub(super) fn summarise(&mut self) {
        let mut leaves: Vec<_> = self.tree.inspect().collect();
        leaves.sort_unstable_by_key(|leaf| leaf.leaf);
        let summary = |leaf: &LeafInfo| {
            let (radiance, fraction) = (self.tree.mean_radiance(leaf.leaf), self.tree.fraction(leaf.leaf));
            RegionInfo::of_leaf(leaf, radiance, fraction, &self.returns[leaf.leaf as usize])
        };
        self.summaries = leaves.iter().map(summary).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guiding::PackedDirection;
    use crate::guiding::settings::GuidingMethod;
    use crate::math::rng::Rng;
    use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};

    /// `n` uniform directions; light comes from above, from the half of the cube with x > 0.5 twice as much.
    fn record(leaves: &PpgGuide, n: usize, rng: &mut Rng) -> Recorder {
        let mut recorder = Recorder::new();
        for _ in 0..n {
            let (p, w) = (Vec3::new(rng.f32(), rng.f32(), rng.f32()), square_to_uniform_sphere(rng.f32x2()));
            let light = if w.z < 0.0 { 0.0 } else { 1.0 + (p.x > 0.5) as u32 as f32 };
            recorder.push(Transition {
                key: leaves.recorded(p, [rng.f32(), rng.f32(), rng.f32()]),
                wi: PackedDirection::new(w),
                normal: PackedDirection::new(Vec3::Z),
                target: light,
                pdf: UNIFORM_SPHERE_PDF,
                bsdf_pdf: UNIFORM_SPHERE_PDF,
                guide_pdf: -1.0,
                scattered: 1.0,
                rays: 2.0,
            });
        }
        recorder
    }

    fn trained(change: impl FnOnce(&mut GuidingSettings)) -> PpgGuide {
        let mut settings = GuidingSettings { method: GuidingMethod::SdTree, ..GuidingSettings::default() };
        (settings.jitter, settings.leaf_samples) = (false, 4000.0);
        change(&mut settings);
        let mut leaves = PpgGuide::new(&settings, (Vec3::ZERO, Vec3::ONE));
        let mut rng = Rng::new(1);
        for _ in 0..3 {
            let recorders = [record(&leaves, 10_000, &mut rng), record(&leaves, 30_000, &mut rng)];
            leaves.learn(&recorders.iter().collect::<Vec<_>>());
            leaves.end_iteration(1);
        }
        leaves
    }

    #[test]
    fn a_leaf_knows_what_arrives_in_it() {
        let leaves = trained(|_| ());
        assert!(leaves.tree().leaves() > 8 && leaves.known() == leaves.tree().leaves());
        for (x, light) in [(0.1, 1.0), (0.9, 2.0)] {
            let summary = leaves.summary(leaves.drawn(Vec3::new(x, 0.2, 0.3))).expect("all leaves are known");
            // six standard errors of the mean of 1250 samples that are as wide as their mean
            let tolerance = 0.17;
            let irradiance = std::f32::consts::PI * light / 2.0;
            assert!((summary.irradiance / irradiance - 1.0).abs() < tolerance, "{x}: {summary:?}");
            // the estimate is 4π·L for one half of the directions and 0 for the other
            let mean = 4.0 * std::f32::consts::PI * light / 2.0;
            assert!((summary.mean / mean - 1.0).abs() < tolerance, "{x}: {summary:?}");
            assert!((summary.square / (2.0 * mean * mean) - 1.0).abs() < tolerance, "{x}: {summary:?}");
            assert_eq!(summary.rays, 2.0);
            let distribution = leaves.distribution(summary);
            let mut rng = Rng::new(2);
            let up = (0..1000).filter(|_| distribution.sample(0.0, rng.f32x2()).0.z > 0.0).count();
            // the filter spreads a little of the light over the horizon, and below it cells are large
            let down = distribution.pdf(-Vec3::Z);
            assert!(up > 900 && down < 0.2 * UNIFORM_SPHERE_PDF, "{x}: {up} of 1000 upwards");
        }
    }

    #[test]
    fn the_share_of_the_bsdf_is_learnt_or_kept() {
        let share = |leaves: &PpgGuide| leaves.summary(leaves.drawn(Vec3::splat(0.3))).expect("known").bsdf_fraction;
        assert_eq!(share(&trained(|s| (s.learned_fraction, s.bsdf_fraction) = (Some(false), 0.3))), 0.3);
        // the BSDF wastes half of its directions, the guide none
        assert!(share(&trained(|_| ())) < 0.3);
    }

    #[test]
    fn memory_bounds_the_leaves() {
        for memory in [10_000, 100_000] {
            let leaves = trained(|s| (s.memory, s.leaf_samples) = (memory, 10.0));
            assert!(leaves.bytes() as u64 <= memory, "{} bytes of {memory}", leaves.bytes());
            assert!(leaves.tree().leaves() > 1);
        }
    }
}
