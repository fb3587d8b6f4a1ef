//! Drawing from strata.

use super::Strata;
use super::rows::WHOLE;
use crate::guiding::directional::Directions;
use crate::guiding::directional::hemitree::begun;
use crate::guiding::directional::weights::{self, Product};
use glam::Vec3;

/// Strata with their probabilities.
#[derive(Clone, Debug)]
pub enum BinDirections<'f> {
    /// By a row of a snapshot.
    Row { strata: &'f Strata, row: &'f [u16] },
    /// In proportion to weights of this very vertex: where each ends, the last at the sum of all.
    Weighed { strata: &'f Strata, ends: Box<[f32]> },
}

impl Directions for BinDirections<'_> {
    #[inline(never)]
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        match self {
            BinDirections::Row { strata, row } => {
                let k = draw(strata, row, u);
                (strata.direction(k, inside), strata.density(pmf(strata, row, k)))
            }
            BinDirections::Weighed { strata, ends } => {
                let k = weights::draw(ends, u);
                (strata.direction(k, inside), strata.density(weights::pmf(ends, k)))
            }
        }
    }

    #[inline(never)]
    fn pdf(&self, local: Vec3) -> f32 {
        match self {
            BinDirections::Row { strata, row } => {
                let Some(k) = strata.index(local) else { return 0.0 };
                strata.density(pmf(strata, row, k))
            }
            BinDirections::Weighed { strata, ends } => {
                let Some(k) = strata.index(local) else { return 0.0 };
                strata.density(weights::pmf(ends, k))
            }
        }
    }

    fn times(&self, value: impl Fn(Vec3) -> f32) -> Self {
        let mut product = Product::with(value);
        let (BinDirections::Row { strata, .. } | BinDirections::Weighed { strata, .. }) = *self;
        for k in 0..strata.count() {
            let weight = match self {
                BinDirections::Row { row, .. } => pmf(strata, row, k),
                BinDirections::Weighed { ends, .. } => weights::weight(ends, k),
            };
            product.add(weight, strata.direction(k, [0.5; 2]));
        }
        BinDirections::Weighed { strata, ends: product.ends.into() }
    }
}

/// Draws a stratum from a row.
#[inline]
fn draw(strata: &Strata, row: &[u16], u: f64) -> usize {
    let columns = strata.columns();
    let (lines, starts) = row.split_at(strata.lines());
    let at = (u * WHOLE as f64) as u16;
    let line = begun(&lines[1..], at);
    line * columns + begun(&starts[line * columns + 1..(line + 1) * columns], at)
}

/// Probability of stratum `k` in a row.
#[inline]
fn pmf(strata: &Strata, row: &[u16], k: usize) -> f32 {
    let starts = &row[strata.lines()..];
    let end = starts.get(k + 1).map_or(WHOLE, |&start| start as u32);
    (end - starts[k] as u32) as f32 / WHOLE as f32
}
