//! The quadtree as a directional model. Only whole iterations are frozen, as published.

use super::building::{EnergyTree, Fineness};
use super::frozen::{Branch, MAX_LEVELS, QuadNode, Quadtree, encode};
use crate::guiding::directional::{
    DirectionalModel, Evaluator, InFrame, Normals, PROFILE, SamplingOptions, Totals, WORLD,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::Rate;
use crate::math::is_amount;
use crate::simd::{LANES, Vec3Lanes};
use serde::{Deserialize, Serialize};
use std::f32::consts::PI;
use std::ops::Range;

/// How quadtrees grow, and the form in which they begin.
#[derive(Clone, Debug)]
pub struct SphereQuadtree {
    fineness: Fineness,
    /// A record spreads over a box as large as its cell of directions.
    filter: bool,
    untrained: EnergyTree,
}

/// What is learnt of a region's directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntQuadtree {
    energy: EnergyTree,
    /// Weight of the samples behind it.
    samples: f64,
    /// As of the last iteration that found light.
    known: Vec<QuadNode>,
    /// Mean over the sphere of the radiance (luminance) that arrived then.
    mean: f32,
}

impl SphereQuadtree {
    /// A cell is divided where it holds more than `rho` of its quadtree's energy; `filter` spreads records. Quadtrees begin
    /// as fine as that asks for, or as half of `memory` bytes have room for.
    pub fn within(rho: f32, filter: bool, memory: u64) -> SphereQuadtree {
        SphereQuadtree::new(Fineness::new(rho, MAX_LEVELS), filter, memory)
    }

    pub(in crate::guiding) fn new(fineness: Fineness, filter: bool, memory: u64) -> SphereQuadtree {
        let mut first = fineness;
        let untrained = loop {
            let untrained = EnergyTree::uniform(first);
            if (untrained.nodes() * BYTES_PER_NODE) as u64 <= memory / 2 || first.is_coarsest() {
                break untrained;
            }
            first = first.coarser(2.0);
        };
        SphereQuadtree { fineness, filter, untrained }
    }
}

#[cfg(test)]
impl LearntQuadtree {
    pub(in crate::guiding) fn energy(&self) -> &EnergyTree {
        &self.energy
    }

    pub(in crate::guiding) fn samples(&self) -> f64 {
        self.samples
    }
}

/// Of the mean radiance: 4π times as much is still a number.
const MAX_MEAN: f32 = f32::MAX / 16.0;

/// Bytes of a node: learnt, and in two snapshots, that of the last iteration that found light and the one in use.
const BYTES_PER_NODE: usize = EnergyTree::BYTES + 2 * size_of::<QuadNode>();

impl DirectionalModel for SphereQuadtree {
    type Learnt = Box<LearntQuadtree>;
    type Located = [[u16; 2]; LANES];
    type Frozen = Vec<QuadNode>;
    type Pool = Vec<QuadNode>;
    type Directions<'f> = Quadtree<'f>;

    fn untrained(&self) -> Box<LearntQuadtree> {
        let energy = self.untrained.clone();
        Box::new(LearntQuadtree { energy, samples: 0.0, known: Vec::new(), mean: 0.0 })
    }

    fn locate(&self, _about: &Vec3Lanes, wi: &Vec3Lanes) -> [[u16; 2]; LANES] {
        std::array::from_fn(|k| encode(wi.get(k)))
    }

    /// Density estimation: each sample's energy is radiance over density, so that a learning rate has no say. Samples
    /// that are not finite, negative or of density 0 are left out.
    fn record(&self, learnt: &mut Self::Learnt, at: &Self::Located, k: usize, transition: &Transition, _rate: Rate) {
        let Transition { target, pdf, bsdf_pdf, scattered, .. } = *transition;
        if pdf > 0.0 && [target, pdf, bsdf_pdf, scattered].iter().all(|v| is_amount(*v as f64)) {
            learnt.energy.splat(at[k], target as f64 / pdf as f64, self.filter);
            learnt.samples += 1.0;
        }
    }

    fn decay(&self, learnt: &mut Self::Learnt, share: f32) {
        learnt.energy.decay(share);
        learnt.samples *= share as f64;
    }

    fn is_informed(&self, learnt: &Self::Learnt) -> bool {
        !learnt.known.is_empty()
    }

    /// A region that found no light keeps the distribution it had.
    fn end_iteration(&self, learnt: &mut Self::Learnt) {
        let energy = learnt.energy.sum_up();
        if energy > 0.0 {
            learnt.known = vec![QuadNode::new(Branch::new(1, 0), [0.0; 4]); learnt.energy.nodes()];
            learnt.energy.write(&mut learnt.known);
            let mean = energy / (4.0 * std::f64::consts::PI * learnt.samples);
            learnt.mean = mean.min(MAX_MEAN as f64) as f32;
        }
    }

    fn refined(&self, learnt: &Self::Learnt, coarseness: f32) -> Option<Self::Learnt> {
        let energy = learnt.energy.refined(self.fineness.coarser(coarseness));
        Some(Box::new(LearntQuadtree { energy, ..(**learnt).clone() }))
    }

    fn is_coarsest(&self, coarseness: f32) -> bool {
        self.fineness.coarser(coarseness).is_coarsest()
    }

    /// From a sixteenth of the sphere each, as if all of it were at the mean cosine of a hemisphere.
    fn profile(&self, learnt: &Self::Learnt) -> [f32; PROFILE] {
        let mut profile = [0.0; PROFILE];
        let scale = if learnt.samples > 0.0 { 0.5 / learnt.samples } else { 0.0 };
        learnt.energy.visit_leaves(&mut |[x, y], energy| {
            profile[4 * (4.0 * y) as usize + (4.0 * x) as usize] += (energy * scale) as f32;
        });
        profile
    }

    /// Irradiance is that of light from everywhere alike.
    fn freeze(&self, learnt: &Self::Learnt, _options: &SamplingOptions, _fraction: f32) -> (Vec<QuadNode>, Totals) {
        (learnt.known.clone(), Totals { irradiance: PI * learnt.mean, peak: learnt.mean })
    }

    fn append(&self, frozen: Vec<QuadNode>, pool: &mut Vec<QuadNode>) -> Range<u32> {
        let first = pool.len() as u32;
        pool.extend(frozen);
        first..pool.len() as u32
    }

    #[inline(always)]
    fn directions<'f>(
        &'f self,
        pool: &'f Vec<QuadNode>,
        range: Range<usize>,
        _normals: Normals,
        _options: &SamplingOptions,
    ) -> InFrame<Quadtree<'f>> {
        InFrame { frame: WORLD, directions: Quadtree::new(&pool[range]) }
    }

    /// The density is in proportion to the radiance, the mean of which is over the sphere.
    fn evaluator<'l>(&'l self, learnt: &'l Self::Learnt, _smoothing: f32) -> Evaluator<'l> {
        let whole = 4.0 * PI * learnt.mean;
        Box::new(move |_, w| (!learnt.known.is_empty()).then(|| whole * Quadtree::new(&learnt.known).density(w)))
    }

    fn nodes(&self, learnt: &Self::Learnt) -> usize {
        learnt.known.len()
    }

    fn bytes(&self, learnt: &Self::Learnt) -> usize {
        let snapshots = 2 * learnt.known.len().max(learnt.energy.nodes()) * size_of::<QuadNode>();
        size_of::<LearntQuadtree>() + learnt.energy.nodes() * EnergyTree::BYTES + snapshots
    }

    fn usual_bytes(&self) -> usize {
        size_of::<LearntQuadtree>() + self.untrained.nodes() * BYTES_PER_NODE
    }

    fn pool_bytes(&self, pool: &Vec<QuadNode>) -> usize {
        size_of_val(&pool[..])
    }

    fn is_sound(&self, learnt: &Self::Learnt) -> bool {
        let known = learnt.known.is_empty() || QuadNode::are_sound(&learnt.known);
        learnt.energy.is_sound() && known && is_amount(learnt.samples) && (0.0..=MAX_MEAN).contains(&learnt.mean)
    }
}
