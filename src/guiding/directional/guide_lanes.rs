//! What the guide proposes at the vertices of a packet, side by side.

use super::hemitree::{self, Node, TreeDirections};
use super::{AnyDirections, GuidingDistribution, InFrame};
use crate::math::Frame;
use crate::math::warp;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, mask};
use glam::Vec3;

/// The trees of a packet: what [`GuidingDistribution`] gives one by one, to the last bit. What is arithmetic is done for all, and
/// trees are walked level by level.
pub struct GuideLanes<'f> {
    /// Any where there is no tree.
    nodes: [&'f [Node]; LANES],
    is: Mask,
    frame: [Vec3Lanes; 3],
}

impl<'f> GuideLanes<'f> {
    pub fn new() -> GuideLanes<'f> {
        GuideLanes { nodes: [&[]; LANES], is: Mask::NONE, frame: [Vec3Lanes::ZERO; 3] }
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.is = Mask::NONE;
    }

    /// Takes the tree of vertex `k`, over the hemisphere of `normal`.
    #[inline(always)]
    pub fn set(&mut self, k: usize, normal: Vec3, nodes: &'f [Node]) {
        self.nodes[k] = nodes;
        self.is.set(k, true);
        self.frame[2].set(k, normal);
    }

    /// Finds the frames of all that were taken.
    #[inline(always)]
    pub fn resolve(&mut self) {
        for k in 0..LANES {
            let Frame { s, t, n: _ } = Frame::from_normal(self.frame[2].get(k));
            self.frame[0].set(k, s);
            self.frame[1].set(k, t);
        }
    }

    /// What vertex `k` has by itself, where it has a tree.
    #[inline(always)]
    pub fn get(&self, k: usize) -> Option<GuidingDistribution<'f>> {
        self.is.has(k).then(|| InFrame {
            frame: Frame::from_normal(self.frame[2].get(k)),
            directions: AnyDirections::Tree(TreeDirections::Nodes(self.nodes[k])),
        })
    }

    /// The vertices that have a tree.
    #[inline(always)]
    pub fn are(&self) -> Mask {
        self.is
    }

    #[inline(always)]
    pub fn any(&self) -> bool {
        self.is.any()
    }

    /// As [`GuidingDistribution::pdf`]; 0 where it is not asked for, or there is no tree.
    #[inline(never)]
    pub fn pdf(&self, asked: Mask, w: &Vec3Lanes, pdf: &mut Lanes) {
        let (mut square, mut z) = ([[0.0; LANES]; 2], [0.0; LANES]);
        for k in 0..LANES {
            let local = self.frame(k).to_local(w.get(k));
            [square[0][k], square[1][k]] = warp::uniform_hemisphere_to_square(local);
            z[k] = local.z;
        }
        hemitree::densities(&self.nodes, &square, asked & self.is & mask(|k| z[k] >= 0.0), pdf);
    }

    /// As [`GuidingDistribution::sample`] for the vertices that are to draw, which have trees; `w` of others is any direction.
    #[inline(never)]
    pub fn sample(&self, draws: Mask, u: &[f64; LANES], inside: &[Lanes; 2], w: &mut Vec3Lanes, pdf: &mut Lanes) {
        let cells = hemitree::draw_lanes(&self.nodes, draws, *u, pdf);
        let mut square = [[0.0; LANES]; 2];
        for k in 0..LANES {
            [square[0][k], square[1][k]] = cells[k].point([inside[0][k], inside[1][k]]);
        }
        for k in 0..LANES {
            let local = warp::square_to_uniform_hemisphere([square[0][k], square[1][k]]);
            w.set(k, self.frame(k).to_world(local));
        }
    }

    #[inline(always)]
    fn frame(&self, k: usize) -> Frame {
        Frame { s: self.frame[0].get(k), t: self.frame[1].get(k), n: self.frame[2].get(k) }
    }
}

impl Default for GuideLanes<'_> {
    fn default() -> Self {
        GuideLanes::new()
    }
}
