//! The product of a tree with a glossy reflection, along the path that a draw takes through the tree.
//!
//! At each of the first [`LEVELS`] levels the cells' shares are multiplied by what the surface reflects from their centres; below
//! them the tree's own shares count. A cell that the tree does not cut is cut nevertheless, into cells of equal radiance: the tree is as
//! fine as the light is uneven, which may be coarser than the lobe.

use super::square::{SquareCell, cell_at, cells_of};
use super::{FAN, Node, SIDE, WHOLE, concentration};
use crate::guiding::directional::glossy::GlossyLobe;
use crate::math::{ONE_MINUS_EPSILON_F64, warp};
use crate::simd::{Lanes, Vec3Lanes};
use glam::Vec3;
use std::f32::consts::TAU;

/// Levels at which the reflection counts. Cells of the second are 0.025 sr, about as large as the lobe of α = 0.1.
const LEVELS: usize = 2;

/// The directions of the centres of cells: of the hemisphere's 4×4, then of the 4×4 in each of these.
#[derive(Clone, Debug)]
pub(super) struct CellCentres {
    root: Vec3Lanes,
    nodes: [Vec3Lanes; FAN],
}

impl CellCentres {
    pub(super) fn new() -> CellCentres {
        let of = |place: SquareCell| {
            let mut centres = Vec3Lanes::ZERO;
            (0..FAN).for_each(|k| centres.set(k, place.cell(k).direction([0.5; 2])));
            centres
        };
        CellCentres { root: of(SquareCell::ROOT), nodes: std::array::from_fn(|k| of(SquareCell::ROOT.cell(k))) }
    }

    /// Those of the node that lies at `place`.
    #[inline(always)]
    fn of(&self, place: SquareCell) -> &Vec3Lanes {
        match place.depth {
            0 => &self.root,
            _ => &self.nodes[(place.y * SIDE + place.x) as usize % FAN],
        }
    }
}

/// A tree, and what its directions are weighed by. All in the frame of the region.
#[derive(Clone, Debug)]
pub struct TreeProduct<'f> {
    nodes: &'f [Node],
    centres: &'f CellCentres,
    lobe: GlossyLobe,
    /// Of the root's cells.
    weights: Lanes,
}

impl<'f> TreeProduct<'f> {
    #[inline(never)]
    pub(super) fn new(nodes: &'f [Node], centres: &'f CellCentres, lobe: GlossyLobe) -> TreeProduct<'f> {
        let mut product = TreeProduct { nodes, centres, lobe, weights: [0.0; FAN] };
        product.weights = product.weights(Some(&nodes[0]), SquareCell::ROOT);
        product
    }

    pub(super) fn nodes(&self) -> &'f [Node] {
        self.nodes
    }

    /// What the cells of the node at `place` are drawn in proportion to. Without a node they hold equal shares.
    #[inline(always)]
    fn weights(&self, node: Option<&Node>, place: SquareCell) -> Lanes {
        let shares = node.map_or([(WHOLE / FAN as u32) as f32; FAN], Node::shares);
        let mut weights = [0.0; FAN];
        self.lobe.reflected(self.centres.of(place), place.cell(0).solid_angle(), &mut weights);
        for k in 0..FAN {
            weights[k] *= shares[k];
        }
        // where nothing is reflected from what is known, the BSDF does not help
        if weights.iter().sum::<f32>() > 0.0 { weights } else { shares }
    }

    /// The weights of the node at `place`, of which those of the root are known.
    #[inline(always)]
    fn weights_at(&self, node: Option<&Node>, place: SquareCell) -> Lanes {
        if place.depth == 0 { self.weights } else { self.weights(node, place) }
    }

    #[inline(always)]
    fn child(&self, node: &Node, k: usize) -> Option<&'f Node> {
        match node.children[k] as usize {
            0 => None,
            child => Some(&self.nodes[child]),
        }
    }

    #[inline(never)]
    pub(super) fn sample(&self, mut u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let (mut node, mut place, mut density) = (Some(&self.nodes[0]), SquareCell::ROOT, 1.0 / TAU);
        for _ in 0..LEVELS {
            let (k, share, rest) = draw(&self.weights_at(node, place), u);
            (place, u) = (place.cell(k), rest);
            density *= share * FAN as f32;
            node = node.and_then(|node| self.child(node, k));
        }
        while let Some(here) = node {
            let (k, range, rest) = here.draw(u);
            (place, u) = (place.cell(k), rest);
            density *= concentration(range);
            node = self.child(here, k);
        }
        (place.direction(inside), density)
    }

    /// Density per steradian of [`Self::sample`]; 0 below the horizon of the region.
    #[inline(never)]
    pub(super) fn pdf(&self, local: Vec3) -> f32 {
        if local.z < 0.0 {
            return 0.0;
        }
        let [x, y] = cells_of(warp::uniform_hemisphere_to_square(local));
        let (mut node, mut place, mut density) = (Some(&self.nodes[0]), SquareCell::ROOT, 1.0 / TAU);
        for depth in 1..=LEVELS {
            let k = cell_at(x, y, depth);
            let weights = self.weights_at(node, place);
            density *= weights[k] / sum(&weights) * FAN as f32;
            (place, node) = (place.cell(k), node.and_then(|node| self.child(node, k)));
        }
        while let Some(here) = node {
            let k = cell_at(x, y, place.depth + 1);
            density *= concentration(here.range(k));
            (place, node) = (place.cell(k), self.child(here, k));
        }
        density
    }
}

/// The sum from the first to the last: [`draw`] adds in this order too.
#[inline(always)]
fn sum(weights: &Lanes) -> f32 {
    weights.iter().fold(0.0, |sum, weight| sum + weight)
}

/// Draws in proportion to weights: the number drawn, its share, and where in it `u` is.
#[inline(always)]
fn draw(weights: &Lanes, u: f64) -> (usize, f32, f64) {
    let (mut ends, mut whole) = ([0.0; FAN], 0.0);
    for k in 0..FAN {
        whole += weights[k];
        ends[k] = whole;
    }
    let at = u * whole as f64;
    let begun: usize = ends.iter().map(|&end| (end as f64 <= at) as usize).sum();
    // rounding may leave `at` at the end of all, behind weights of 0
    let k = if begun < FAN { begun } else { (0..FAN).rev().find(|&k| weights[k] > 0.0).unwrap_or(0) };
    let begin = if k == 0 { 0.0 } else { ends[k - 1] };
    let rest = (at - begin as f64) / (ends[k] - begin) as f64;
    (k, weights[k] / whole, rest.clamp(0.0, ONE_MINUS_EPSILON_F64))
}
