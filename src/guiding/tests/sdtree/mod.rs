//! The SD-tree, a binary tree over space with quadtrees of directions, without a renderer: light fields are known, so what
//! is learnt can be held against them.

mod directions;
mod growth;
mod learning;
mod schedule;
mod space;

use super::{PackedDirection, Recorder, Transition};
use crate::guiding::directional::quadtree::{Branch, Fineness, QuadNode, Quadtree, SphereQuadtree, encode};
use crate::guiding::directional::{DirectionalModel, Directions};
use crate::guiding::guide::Guide;
use crate::guiding::settings::{GuidingMethod, GuidingSettings};
use crate::guiding::spatial::{KdTree, RegionId, SpatialPartition};
use crate::guiding::{Hue, ShadowOutcome};
use crate::math::rng::Rng;
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};
use glam::Vec3;
use std::f64::consts::PI;

#[derive(Clone, Copy)]
struct SdTreeSettings {
    split: f32,
    rho: f32,
    levels: u32,
    spatial_filter: bool,
    directional_filter: bool,
    learned_fraction: bool,
    fraction: f32,
}

impl Default for SdTreeSettings {
    fn default() -> SdTreeSettings {
        let settings = GuidingSettings::default();
        SdTreeSettings {
            split: settings.leaf_samples,
            rho: settings.rho,
            levels: 16,
            spatial_filter: true,
            directional_filter: true,
            learned_fraction: true,
            fraction: 0.5,
        }
    }
}

/// Pixels of a picture for which thresholds are taken as they stand.
const PICTURE: u64 = 1280 * 720;

/// The pair, with leaves by the number of their node.
struct SdTree(Guide<KdTree, SphereQuadtree>);

/// What a path found in one direction from one vertex.
#[derive(Clone, Copy)]
struct Sample {
    leaf: u32,
    w: Vec3,
    radiance: f32,
    pdf: f32,
    bsdf_pdf: f32,
    guide_pdf: f32,
    scattered: f32,
}

impl SdTree {
    fn new(low: Vec3, high: Vec3, settings: SdTreeSettings, memory: u64) -> SdTree {
        let partition = KdTree::new(low, high, settings.spatial_filter, false);
        let fineness = Fineness::new(settings.rho, settings.levels);
        let model = SphereQuadtree::new(fineness, settings.directional_filter, memory);
        let guiding = GuidingSettings {
            method: GuidingMethod::SdTree,
            leaf_samples: settings.split,
            bsdf_fraction: settings.fraction,
            learned_fraction: Some(settings.learned_fraction),
            memory,
            ..GuidingSettings::default()
        };
        SdTree(Guide::of(&guiding, partition, model))
    }

    fn leaf_at(&self, p: Vec3) -> u32 {
        self.0.partition.leaf(p)
    }

    /// Where to record.
    fn leaf(&self, p: Vec3, jitter: [f32; 3]) -> u32 {
        self.0.partition.locate(p, Vec3::Z, jitter).expect("leaves are everywhere").recorded.0 as u32
    }

    fn distribution(&self, leaf: u32) -> Option<Quadtree<'_>> {
        let info = self.0.field().summary(RegionId(leaf as u64))?;
        Some(self.0.field().distribution(info, Vec3::Z).directions)
    }

    fn mean_radiance(&self, leaf: u32) -> f32 {
        let info = self.0.field().summary(RegionId(leaf as u64));
        info.map_or(0.0, |info| info.irradiance / std::f32::consts::PI)
    }

    fn fraction(&self, leaf: u32) -> f32 {
        self.0.field().summary(RegionId(leaf as u64)).expect("the leaf is known").bsdf_fraction
    }

    fn fold(&mut self, batches: &[&[Sample]]) {
        let record = |batch: &&[Sample]| {
            let mut recorder = Recorder::new();
            batch.iter().for_each(|sample| recorder.push(sample.transition()));
            recorder
        };
        let recorders: Vec<Recorder> = batches.iter().map(record).collect();
        self.0.learn(&recorders.iter().collect::<Vec<_>>());
    }

    fn end_iteration(&mut self, spp: u32) {
        // of a picture of the size that the threshold is meant for
        self.0.end_iteration(u64::from(spp) * PICTURE);
    }

    /// Leaves that something is known of: all, once anything was learnt.
    fn leaves(&self) -> usize {
        self.0.states()
    }

    fn bytes(&self) -> u64 {
        self.0.bytes() as u64
    }

    /// The leaves in the order of space.
    fn numbers(&self) -> Vec<u32> {
        self.0.partition.leaves().map(|leaf| leaf.leaf).collect()
    }

    /// Weight of a leaf's samples.
    fn visits(&self, leaf: u32) -> f64 {
        self.0.visits(RegionId(leaf as u64)).map_or(0.0, f64::from)
    }

    /// Nodes of the quadtree that learns in a leaf.
    fn learning_nodes(&self, leaf: u32) -> usize {
        let region = self.0.store.get(RegionId(leaf as u64));
        region.map_or_else(
            || self.0.store.model.untrained().energy().nodes(),
            |region| region.directions.energy().nodes(),
        )
    }
}

impl Sample {
    fn transition(&self) -> Transition {
        Transition {
            key: RegionId(self.leaf as u64),
            wi: PackedDirection::new(self.w),
            normal: PackedDirection::new(Vec3::Z),
            target: self.radiance,
            bootstrapped: self.radiance,
            pdf: self.pdf,
            bsdf_pdf: self.bsdf_pdf,
            guide_pdf: self.guide_pdf,
            scattered: self.scattered,
            hue: Hue::GREY,
            rays: 1,
            shadow: ShadowOutcome::NONE,
        }
    }
}

/// A tree over the unit cube with all the memory it wants.
fn tree(change: impl FnOnce(&mut SdTreeSettings)) -> SdTree {
    let mut settings = SdTreeSettings::default();
    change(&mut settings);
    SdTree::new(Vec3::ZERO, Vec3::ONE, settings, 1 << 30)
}

/// The default tree, but it never splits in space.
fn single(change: impl FnOnce(&mut SdTreeSettings)) -> SdTree {
    tree(|s| {
        s.split = f32::INFINITY;
        change(s);
    })
}

fn point(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.f32(), rng.f32(), rng.f32())
}

/// A sample of `radiance` from `w`, drawn with density `pdf` by a BSDF that scatters `scattered`.
fn sample(leaf: u32, w: Vec3, radiance: f32, pdf: f32, scattered: f32) -> Sample {
    Sample { leaf, w, radiance, pdf, bsdf_pdf: UNIFORM_SPHERE_PDF, guide_pdf: -1.0, scattered }
}

/// `n` samples of the field `light`, uniform over the sphere and over the cube.
fn uniform_samples(tree: &SdTree, rng: &mut Rng, n: usize, light: impl Fn(Vec3, Vec3) -> f32) -> Vec<Sample> {
    let one = |rng: &mut Rng| {
        let (p, w) = (point(rng), square_to_uniform_sphere(rng.f32x2()));
        let leaf = tree.leaf(p, [rng.f32(), rng.f32(), rng.f32()]);
        // as at a path's vertex, the guide's density is that of the leaf that is drawn from
        let guide_pdf = tree.distribution(tree.leaf_at(p)).map_or(-1.0, |quadtree| quadtree.density(w));
        Sample { guide_pdf, ..sample(leaf, w, light(p, w), UNIFORM_SPHERE_PDF, 1.0) }
    };
    (0..n).map(|_| one(rng)).collect()
}

/// Trains for `iterations`, the first with `n` samples, each of the others with twice those of the one before.
fn train(tree: &mut SdTree, rng: &mut Rng, iterations: u32, n: usize, light: impl Fn(Vec3, Vec3) -> f32) {
    for k in 0..iterations {
        let samples = uniform_samples(tree, rng, n << k, &light);
        tree.fold(&[&samples]);
        tree.end_iteration(1 << k);
    }
}

/// Light from about `axis`: (1 + cos)ⁿ, the stronger the higher n.
fn lobe(w: Vec3, axis: Vec3, n: i32) -> f32 {
    (0.5 + 0.5 * w.dot(axis)).powi(n)
}

/// All that the snapshot of a tree knows but for the mean radiance, to the bit.
fn contents(tree: &SdTree) -> impl PartialEq + std::fmt::Debug + use<> {
    let leaf = |leaf: u32| {
        let known = tree.distribution(leaf).map(|quadtree| quadtree.words().to_vec());
        let info = tree.0.field().summary(RegionId(leaf as u64));
        (leaf, known, info.map(|info| (info.visits, info.bsdf_fraction.to_bits())))
    };
    tree.numbers().into_iter().map(leaf).collect::<Vec<_>>()
}
