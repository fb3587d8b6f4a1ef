//! A tree of directions: the hemisphere's square cut into 4×4 cells, and a cell that holds much of the light cut again.
//!
//! It is the quadtree of Müller et al. (2017) two levels at a time: a node of 16 cells is drawn from with one vector
//! comparison, and what sampling reads of it is one cache line.

mod directions;
mod lanes;
mod leaf_index;
mod learnt;
mod model;
mod product;
mod shape;
mod square;

pub(crate) use directions::TreeDirections;
pub(crate) use lanes::{densities, draw as draw_lanes};
pub(crate) use learnt::LearntTree;
pub(crate) use model::HemisphereTree;
pub(crate) use shape::TreeShape;

use super::Entry;
use crate::math::warp;
use crate::simd::Lanes;
use glam::Vec3;
use square::{SquareCell, cell_at, cells_of};
use std::f32::consts::TAU;

/// LearntTree along the side of a node.
const SIDE: u32 = 4;
/// LearntTree of a node.
pub const FAN: usize = (SIDE * SIDE) as usize;
/// Nodes on the way to the smallest cells: 64×64 over the hemisphere.
const DEPTH: usize = 3;
/// Nodes of a state at most, so that their numbers fit.
const MAX_NODES: usize = 1 << 12;
/// Parts into which a node divides the unit interval.
const WHOLE: u32 = 1 << 16;

/// What sampling reads of a node: where each cell begins in the unit interval, in units of 1/`WHOLE`, and the node that
/// cuts it, counted from the state's first; 0 for none. Draws and densities both go by the rounded numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Node {
    starts: [u16; FAN],
    children: [u16; FAN],
}

impl Node {
    /// The cells' parts of the unit interval, in units of 1/`WHOLE`.
    #[inline(always)]
    fn shares(&self) -> Lanes {
        let mut starts = [WHOLE as f32; FAN + 1];
        for k in 0..FAN {
            starts[k] = self.starts[k] as f32;
        }
        std::array::from_fn(|k| starts[k + 1] - starts[k])
    }

    /// The cell's part of the unit interval. The first begins with it, and the last ends with it.
    #[inline(always)]
    fn range(&self, k: usize) -> (u32, u32) {
        let next = k + 1;
        (self.starts[k] as u32, self.starts[next % FAN] as u32 + (next / FAN) as u32 * WHOLE)
    }

    /// The cell whose part of the unit interval holds `u`, that part, and where in it `u` is. (`starts[0]` is 0, so one cell has always begun.)
    #[inline(always)]
    fn draw(&self, u: f64) -> (usize, (u32, u32), f64) {
        let at = u * WHOLE as f64;
        // a remainder in place of the minimum would have compilers count bit by bit
        let k = (begun(&self.starts, at as u16) - 1).min(FAN - 1);
        let (from, to) = self.range(k);
        let rest = (at - from as f64) / (to - from) as f64;
        (k, (from, to), rest.min(crate::math::ONE_MINUS_EPSILON_F64))
    }
}

/// How many of the numbers are at most `at`. Counting instead of searching: there is no branch to guess wrong. Without a
/// comparison in the text, of which compilers make sixteen tests, it is one vector comparison and a population count.
#[inline(always)]
pub fn begun(starts: &[u16], at: u16) -> usize {
    starts.len() - starts.iter().map(|start| start.saturating_sub(at).min(1)).sum::<u16>() as usize
}

/// Bytes that a node takes, learnt and frozen.
pub fn bytes_per_node() -> usize {
    FAN * (size_of::<Entry>() + size_of::<u16>()) + size_of::<Node>()
}

/// Draws a direction in the region's frame from the nodes of a state; with its density per steradian, as [`pdf`] gives it.
#[inline(always)]
pub fn sample(nodes: &[Node], u: f64, inside: [f32; 2]) -> (Vec3, f32) {
    let (cell, density) = draw(nodes, u);
    (cell.direction(inside), density)
}

/// Draws a cell; with its density per steradian.
#[inline(always)]
pub fn draw(nodes: &[Node], mut u: f64) -> (SquareCell, f32) {
    let (mut node, mut place, mut density) = (&nodes[0], SquareCell::ROOT, 1.0 / TAU);
    loop {
        let (k, range, rest) = node.draw(u);
        (place, u) = (place.cell(k), rest);
        density *= concentration(range);
        match node.children[k] as usize {
            0 => return (place, density),
            child => node = &nodes[child],
        }
    }
}

/// How many times as dense as its node a cell is that has this part of the unit interval.
#[inline(always)]
fn concentration((from, to): (u32, u32)) -> f32 {
    (to - from) as f32 * (FAN as f32 / WHOLE as f32)
}

/// Density per steradian of [`sample`] at a direction in the region's frame; 0 below the horizon.
#[inline(always)]
pub fn pdf(nodes: &[Node], local: Vec3) -> f32 {
    if local.z >= 0.0 { density(nodes, warp::uniform_hemisphere_to_square(local)) } else { 0.0 }
}

/// The same at the direction of a point of the hemisphere's square.
#[inline(always)]
pub fn density(nodes: &[Node], square: [f32; 2]) -> f32 {
    let [x, y] = cells_of(square);
    let mut density = 1.0 / TAU;
    let mut node = &nodes[0];
    for depth in 1..=DEPTH {
        let k = cell_at(x, y, depth);
        density *= concentration(node.range(k));
        match node.children[k] as usize {
            0 => break,
            child => node = &nodes[child],
        }
    }
    density
}
