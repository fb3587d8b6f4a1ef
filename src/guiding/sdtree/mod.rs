//! Practical path guiding: a spatial tree with a quadtree of directions in each leaf, learnt from the returns of
//! whole paths (Müller, Gross & Novák 2017, with the improvements of Müller 2019: both filters, and the learnt
//! fraction of directions that stay with the BSDF).
//!
//! What is drawn from is frozen during an iteration. Samples are folded in between whiles, and
//! [`SdTree::end_iteration`] turns what they built into the next snapshot. A snapshot knows one iteration only:
//! iterations are meant to double, each as long as all before it together.

mod refine;
mod stored;
#[cfg(test)]
mod tests;

pub use crate::guiding::directional::quadtree::frozen::{Quadtree, encode};
pub use stored::StoredTree;

use crate::guiding::bsdf_fraction::Fraction;
use crate::guiding::directional::quadtree::building::Building;
use crate::guiding::directional::quadtree::frozen::{MAX_LEVELS, Node};
use crate::guiding::spatial::kd_tree::SpatialTree;
use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How a tree grows; the defaults are Müller's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SdTreeSettings {
    /// c: a spatial leaf is halved that got more than c·√(spp/4) samples in an iteration of spp samples per pixel.
    pub split: f32,
    /// ρ: a cell of directions is divided where it holds more than this share of its quadtree's energy.
    pub rho: f32,
    /// Levels of a quadtree at most; 16 is the most there can be.
    pub levels: u32,
    /// Records blur over the neighbouring leaves.
    pub spatial_filter: bool,
    /// A record spreads over a box as large as its cell of directions.
    pub directional_filter: bool,
    /// Learns for each leaf how many directions stay with the BSDF.
    pub learned_fraction: bool,
    /// Fraction of directions drawn from the BSDF, in [0, 1]; where it is learnt, the one to start from.
    pub fraction: f32,
    /// Bytes that whoever uses the tree keeps for each of its leaves; they count as the tree's own.
    pub bytes_beside: usize,
}

impl Default for SdTreeSettings {
    fn default() -> SdTreeSettings {
        SdTreeSettings {
            split: 12_000.0,
            rho: 0.01,
            levels: MAX_LEVELS,
            spatial_filter: true,
            directional_filter: true,
            learned_fraction: true,
            fraction: 0.5,
            bytes_beside: 0,
        }
    }
}

/// Samples of one leaf that make a task of their own.
const PIECE: usize = 1 << 14;

/// What a path found in one direction from one vertex.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Where it is recorded: [`SdTree::leaf`].
    pub leaf: u32,
    /// [`encode`] of the direction.
    pub direction: [u16; 2],
    /// Luminance that arrived from there: the return of the rest of the path.
    pub radiance: f32,
    /// Density per steradian that it was drawn with, of the whole mixture.
    pub pdf: f32,
    /// Density per steradian by which the BSDF draws it.
    pub bsdf_pdf: f32,
    /// Luminance of f·|cosθ| in that direction.
    pub scattered: f32,
}

impl Sample {
    /// Whether there is anything to learn from it.
    fn is_sound(&self) -> bool {
        let finite = |v: f32| v.is_finite() && v >= 0.0;
        finite(self.radiance) && finite(self.bsdf_pdf) && finite(self.scattered) && finite(self.pdf) && self.pdf > 0.0
    }

    /// Radiance over density: its mean is ∫ L dω.
    fn energy(&self) -> f64 {
        self.radiance as f64 / self.pdf as f64
    }

    /// Its mean is what the vertex scatters, ∫ L f |cosθ| dω.
    fn contribution(&self) -> f64 {
        self.energy() * self.scattered as f64
    }
}

/// The tree: what it has learnt so far, and the snapshot that is in use.
#[derive(Clone, Debug)]
pub struct SdTree {
    settings: SdTreeSettings,
    /// Bytes that all of it may take.
    memory: u64,
    spatial: SpatialTree,
    /// The snapshot, leaf by leaf, and the quadtrees of all leaves.
    frozen: Vec<Frozen>,
    nodes: Vec<Node>,
    /// What is being learnt, leaf by leaf.
    learners: Vec<Learner>,
}

/// A leaf of the snapshot. The halves of a leaf share its quadtree until they have their own.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Frozen {
    /// Its quadtree in `SdTree::nodes`; without nodes, nothing is known.
    first: u32,
    nodes: u32,
    mean: f32,
    fraction: f32,
}

/// A leaf that learns.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Learner {
    /// In the spatial tree.
    node: u32,
    depth: u32,
    /// Samples of this iteration, and of the last one.
    visits: u64,
    last_visits: f64,
    quadtree: Building,
    fraction: Fraction,
}

/// A leaf, as tables and pictures show it.
#[derive(Clone, Copy, Debug)]
pub struct LeafInfo {
    pub leaf: u32,
    /// Its box in world space.
    pub low: Vec3,
    pub high: Vec3,
    /// Samples that it got in the last iteration; halves of a leaf got half of its.
    pub visits: f64,
    /// Nodes of its quadtree; 0 where nothing is known.
    pub nodes: usize,
}

impl SdTree {
    /// An untrained tree over the box `(low, high)`, made a cube, that keeps within `memory` bytes: where they are
    /// used up, no leaf is halved any more, and quadtrees get coarser. The smallest tree takes some 220 bytes.
    pub fn new(low: Vec3, high: Vec3, settings: SdTreeSettings, memory: u64) -> SdTree {
        let fraction = Fraction::new(settings.fraction);
        let quadtree = refine::untrained(&settings, memory);
        let learner = Learner { node: 0, depth: 0, visits: 0, last_visits: 0.0, quadtree, fraction };
        let frozen = Frozen { first: 0, nodes: 0, mean: 0.0, fraction: settings.fraction };
        let spatial = SpatialTree::new(low, high);
        SdTree { settings, memory, spatial, frozen: vec![frozen], nodes: Vec::new(), learners: vec![learner] }
    }

    /// The leaf of `p`: the one to draw from.
    #[inline]
    pub fn leaf_at(&self, p: Vec3) -> u32 {
        self.spatial.find(p).0
    }

    /// The leaf in which to record what was found at `p`: with the spatial filter, that of a point up to half of the
    /// leaf's extent away. `jitter` is uniform in [0, 1)³.
    #[inline]
    pub fn leaf(&self, p: Vec3, jitter: [f32; 3]) -> u32 {
        if self.settings.spatial_filter { self.spatial.find_jittered(p, jitter) } else { self.leaf_at(p) }
    }

    /// The distribution of a leaf: approximately ∝ incident radiance (luminance). `None` while nothing is known.
    #[inline]
    pub fn distribution(&self, leaf: u32) -> Option<Quadtree<'_>> {
        let Frozen { first, nodes, .. } = self.frozen[leaf as usize];
        let first = first as usize;
        (nodes > 0).then(|| Quadtree::new(&self.nodes[first..first + nodes as usize]))
    }

    /// Mean over the sphere of the radiance (luminance) incident in a leaf, ∫ L dω / 4π, over all directions that
    /// are drawn there: none of them is below a BSDF's horizon. 0 while nothing is known.
    #[inline]
    pub fn mean_radiance(&self, leaf: u32) -> f32 {
        self.frozen[leaf as usize].mean
    }

    /// Fraction of directions to draw from the BSDF.
    #[inline]
    pub fn fraction(&self, leaf: u32) -> f32 {
        self.frozen[leaf as usize].fraction
    }

    /// Learns from samples, in the order given, wherever one batch ends and the next begins; the snapshot stays as it
    /// is, and the result is the same for any number of threads. Samples that are not finite, negative, of density 0 or of no leaf are left out.
    pub fn fold(&mut self, batches: &[&[Sample]]) {
        let (samples, ends) = by_leaf(batches, self.learners.len());
        let SdTree { settings, frozen, nodes, learners, .. } = self;
        learners.par_iter_mut().enumerate().for_each(|(leaf, learner)| {
            let start = if leaf == 0 { 0 } else { ends[leaf - 1] };
            let Frozen { first, nodes: count, .. } = frozen[leaf];
            let guide = &nodes[first as usize..(first + count) as usize];
            let guide = (!guide.is_empty() && settings.learned_fraction).then(|| Quadtree::new(guide));
            learner.learn(&samples[start..ends[leaf]], guide, settings);
        });
    }

    /// Ends an iteration of `spp` samples per pixel: what was learnt becomes the snapshot, quadtrees take the form of
    /// their energy, and leaves with more than c·√(spp/4) samples are halved. That is c·√(2^k) for iteration k of
    /// 4·2^k samples (2017), and the rule of 2019 for iterations that start with 1.
    ///
    /// Returns, for each new leaf in the order of their numbers, the leaf that it was a half of.
    pub fn end_iteration(&mut self, spp: f32) -> Vec<u32> {
        self.freeze();
        self.refine();
        self.split(self.settings.split as f64 * (spp as f64 / 4.0).sqrt())
    }

    /// Leaves of the spatial tree.
    pub fn leaves(&self) -> usize {
        self.frozen.len()
    }

    /// Nodes of all quadtrees in use.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes of all of it: the snapshot, what is being learnt, and [`SdTreeSettings::bytes_beside`]. (A `fold` sorts
    /// a copy of its samples.)
    pub fn bytes(&self) -> u64 {
        let quadtrees: usize = self.learners.iter().map(|learner| learner.quadtree.bytes()).sum();
        let leaves = self.frozen.capacity() * size_of::<Frozen>() + self.learners.capacity() * size_of::<Learner>();
        let beside = self.frozen.len() * self.settings.bytes_beside;
        (self.spatial.bytes() + leaves + beside + self.nodes.capacity() * size_of::<Node>() + quadtrees) as u64
    }

    /// All leaves, in the order of space.
    pub fn inspect(&self) -> impl Iterator<Item = LeafInfo> {
        self.spatial.cells().map(|cell| LeafInfo {
            leaf: cell.leaf,
            low: cell.low,
            high: cell.high,
            visits: self.learners[cell.leaf as usize].last_visits,
            nodes: self.frozen[cell.leaf as usize].nodes as usize,
        })
    }
}

impl Learner {
    fn learn(&mut self, samples: &[Sample], guide: Option<Quadtree>, settings: &SdTreeSettings) {
        let filter = settings.directional_filter;
        // An untrained tree is a single leaf: only pieces of it keep all threads busy. They are fixed, and so are sums.
        let tally = |piece: &[Sample]| {
            let mut sums = self.quadtree.emptied();
            piece.iter().for_each(|sample| sums.splat(sample.direction, sample.energy(), filter));
            sums
        };
        let pieces: Vec<Building> = samples.par_chunks(PIECE).map(tally).collect();
        pieces.iter().for_each(|sums| self.quadtree.add(sums));
        self.visits += samples.len() as u64;
        let Some(guide) = guide else { return };
        for sample in samples.iter().filter(|sample| sample.contribution() > 0.0) {
            let guide_pdf = guide.pdf_encoded(sample.direction);
            self.fraction.learn(sample.contribution(), sample.bsdf_pdf as f64, guide_pdf as f64);
        }
    }

    /// Mean radiance over the sphere, of samples with the given energy.
    fn mean(&self, energy: f64) -> f32 {
        (energy / (4.0 * PI * self.visits as f64)).min(f32::MAX as f64) as f32
    }
}

/// Sorts samples by leaf; within a leaf they stay in order. Also where the samples of each leaf end.
fn by_leaf(batches: &[&[Sample]], leaves: usize) -> (Vec<Sample>, Vec<usize>) {
    let all = || batches.iter().flat_map(|batch| batch.iter()).filter(|s| (s.leaf as usize) < leaves && s.is_sound());
    let mut ends = vec![0; leaves];
    all().for_each(|sample| ends[sample.leaf as usize] += 1);
    let mut begun = 0;
    for end in &mut ends {
        // where its next sample goes: after the last one, that is its end
        begun += std::mem::replace(end, begun);
    }
    let Some(any) = all().next() else { return (Vec::new(), ends) };
    let mut sorted = vec![*any; begun];
    for sample in all() {
        let place = &mut ends[sample.leaf as usize];
        sorted[*place] = *sample;
        *place += 1;
    }
    (sorted, ends)
}
