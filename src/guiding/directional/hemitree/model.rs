//! The tree as a directional model: in the frame about the region's normal.

use super::product::{CellCentres, TreeProduct};
use super::square::{CellCoords, coordinates_of};
use super::{LearntTree, Node, TreeDirections, TreeShape, bytes_per_node};
use crate::guiding::directional::{
    DirectionalModel, Entry, Evaluator, GlossyLobe, InFrame, Normals, PROFILE, SamplingOptions, Totals,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::Rate;
use crate::math::Frame;
use crate::simd::Vec3Lanes;
use glam::Vec3;
use std::ops::Range;

/// Nodes of most trees.
const USUAL_NODES: usize = 4;

#[derive(Clone, Debug)]
pub struct HemisphereTree {
    shape: TreeShape,
    /// Boxed, so that models are small.
    centres: Box<CellCentres>,
}

impl HemisphereTree {
    /// LearntTree are cut that hold more than `share` of a region's irradiance and were visited at least `visits` times.
    pub fn new(share: f32, visits: f32) -> HemisphereTree {
        HemisphereTree { shape: TreeShape::new(share, visits), centres: Box::new(CellCentres::new()) }
    }
}

impl DirectionalModel for HemisphereTree {
    type Learnt = LearntTree;
    type Located = CellCoords;
    type Frozen = Vec<Node>;
    type Pool = Vec<Node>;
    type Directions<'f> = TreeDirections<'f>;

    fn untrained(&self) -> LearntTree {
        LearntTree::new()
    }

    #[inline(always)]
    fn locate(&self, about: &Vec3Lanes, wi: &Vec3Lanes) -> CellCoords {
        coordinates_of(about, wi)
    }

    #[inline(always)]
    fn record(&self, learnt: &mut LearntTree, at: &CellCoords, k: usize, transition: &Transition, rate: Rate) {
        if let Some(entry) = at.get(k).and_then(|at| learnt.entry_at(at)) {
            entry.learn(transition.target, rate);
        }
    }

    fn entries_mut<'l>(&self, learnt: &'l mut LearntTree) -> &'l mut [Entry] {
        &mut learnt.entries
    }

    fn entry_index(&self, learnt: &LearntTree, at: &CellCoords, k: usize) -> Option<usize> {
        learnt.index_at(at.get(k)?)
    }

    fn decay(&self, learnt: &mut LearntTree, share: f32) {
        learnt.entries.iter_mut().for_each(|entry| entry.visits *= share);
    }

    fn is_informed(&self, learnt: &LearntTree) -> bool {
        learnt.entries.iter().any(|entry| entry.q > 0.0)
    }

    fn refined(&self, learnt: &LearntTree, coarseness: f32) -> Option<LearntTree> {
        Some(self.shape.coarser(coarseness).refine(learnt))
    }

    fn is_coarsest(&self, coarseness: f32) -> bool {
        self.shape.coarser(coarseness).is_coarsest()
    }

    fn profile(&self, learnt: &LearntTree) -> [f32; PROFILE] {
        self.shape.profile(learnt)
    }

    fn freeze(&self, learnt: &LearntTree, options: &SamplingOptions, fraction: f32) -> (Vec<Node>, Totals) {
        // it takes as long as freezing does
        let irradiance = if options.compensation { self.shape.totals(learnt).irradiance } else { 0.0 };
        let mut nodes = Vec::with_capacity(learnt.nodes());
        let totals = self.shape.freeze(learnt, &options.weight(irradiance, fraction), &mut nodes);
        (nodes, totals)
    }

    fn append(&self, frozen: Vec<Node>, pool: &mut Vec<Node>) -> Range<u32> {
        let first = pool.len() as u32;
        pool.extend(frozen);
        first..pool.len() as u32
    }

    #[inline(always)]
    fn directions<'f>(
        &'f self,
        pool: &'f Vec<Node>,
        range: Range<usize>,
        normals: Normals,
        _options: &SamplingOptions,
    ) -> InFrame<TreeDirections<'f>> {
        InFrame { frame: Frame::from_normal(normals.about), directions: TreeDirections::Nodes(&pool[range]) }
    }

    #[inline(always)]
    fn tree<'f>(&self, pool: &'f Vec<Node>, range: Range<usize>) -> Option<&'f [Node]> {
        Some(&pool[range])
    }

    fn product<'f>(
        &'f self,
        pool: &'f Vec<Node>,
        range: Range<usize>,
        about: Vec3,
        lobe: &GlossyLobe,
    ) -> Option<InFrame<TreeDirections<'f>>> {
        let frame = Frame::from_normal(about);
        let product = TreeProduct::new(&pool[range], &self.centres, lobe.in_frame(&frame));
        Some(InFrame { frame, directions: TreeDirections::Product(product) })
    }

    fn evaluator<'l>(&'l self, learnt: &'l LearntTree, _smoothing: f32) -> Evaluator<'l> {
        Box::new(|about, w| learnt.estimate(Frame::from_normal(about).to_local(w)))
    }

    fn nodes(&self, learnt: &LearntTree) -> usize {
        learnt.nodes()
    }

    fn bytes(&self, learnt: &LearntTree) -> usize {
        learnt.bytes()
    }

    fn usual_bytes(&self) -> usize {
        USUAL_NODES * bytes_per_node()
    }

    fn pool_bytes(&self, pool: &Vec<Node>) -> usize {
        size_of_val(&pool[..])
    }

    fn is_sound(&self, learnt: &LearntTree) -> bool {
        learnt.is_sound() && learnt.entries.iter().all(|entry| entry.is_sound())
    }
}
