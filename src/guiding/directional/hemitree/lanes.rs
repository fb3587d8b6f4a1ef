//! The trees of a packet, walked level by level, each for all before the next: how deep a tree is cannot be guessed, and
//! one guess for all lanes is lost less often than one for each.

use super::square::{SquareCell, cell_at, cells_of};
use super::{DEPTH, Node, concentration};
use crate::simd::{LANES, Lanes, Mask, each, pick};
use std::f32::consts::TAU;

/// [`super::density`] at points of the squares of trees; 0 for those that are not asked for.
#[inline(always)]
pub fn densities(trees: &[&[Node]; LANES], square: &[Lanes; 2], asked: Mask, densities: &mut Lanes) {
    let (mut x, mut y, mut node) = ([0; LANES], [0; LANES], [0; LANES]);
    let is = asked.lanes();
    for k in 0..LANES {
        [x[k], y[k]] = cells_of([square[0][k], square[1][k]]);
        densities[k] = pick(is.has(k), 1.0 / TAU, 0.0);
    }
    let mut under = asked;
    for depth in 1..=DEPTH {
        let mut deeper = Mask::NONE;
        for k in each(under) {
            let (here, cell) = (&trees[k][node[k]], cell_at(x[k], y[k], depth));
            densities[k] *= concentration(here.range(cell));
            node[k] = here.children[cell] as usize;
            deeper.set(k, node[k] != 0);
        }
        under = deeper;
    }
}

/// [`super::draw`] from the trees that are to draw; others get any place and no density.
#[inline(always)]
pub fn draw(trees: &[&[Node]; LANES], draws: Mask, mut u: [f64; LANES], densities: &mut Lanes) -> [SquareCell; LANES] {
    let (mut node, mut places) = ([0; LANES], [SquareCell::ROOT; LANES]);
    *densities = [1.0 / TAU; LANES];
    let mut under = draws;
    while under.any() {
        let mut deeper = Mask::NONE;
        for k in each(under) {
            let here = &trees[k][node[k]];
            let (cell, range, rest) = here.draw(u[k]);
            (places[k], u[k]) = (places[k].cell(cell), rest);
            densities[k] *= concentration(range);
            node[k] = here.children[cell] as usize;
            deeper.set(k, node[k] != 0);
        }
        under = deeper;
    }
    places
}
