//! What the guide proposes at one path vertex.

use crate::guiding::directional::bins::strata::Strata;
use crate::guiding::directional::hemitree::{self, LeafIndex, Node};
use crate::guiding::directional::quadtree::frozen::Quadtree;
use crate::guiding::settings::GuideSampling;
use crate::guiding::snapshot::WHOLE;
use crate::math::Frame;
use crate::math::ONE_MINUS_EPSILON;
use glam::Vec3;

/// Distribution over directions at one path vertex, frozen for this iteration.
///
/// Directions are unit, in world space, away from the surface; densities are per steradian. For every `wi`, `pdf(wi)`
/// is the density with which `sample` returns it. It covers the hemisphere of the state's normal, an SD-tree's the
/// whole sphere, and not the BSDF's support: the mixture does that.
#[derive(Clone, Debug)]
pub struct GuidingDistribution<'f> {
    frame: Frame,
    directions: Directions<'f>,
}

#[derive(Clone, Debug)]
pub(in crate::guiding) enum Directions<'f> {
    /// A row as in `Field::rows`.
    Strata {
        strata: &'f Strata,
        row: &'f [u16],
    },
    Tree(&'f [Node]),
    /// Over the sphere.
    Quadtree(Quadtree<'f>),
    /// Strata drawn in proportion to weights of this very vertex: where each ends, the last at the sum of all.
    Weighed {
        strata: &'f Strata,
        ends: Box<[f32]>,
    },
    /// The same for the leaves of a tree. Boxed, so that distributions without are small.
    WeighedTree(Box<WeighedTree<'f>>),
}

#[derive(Clone, Debug)]
pub(in crate::guiding) struct WeighedTree<'f> {
    nodes: &'f [Node],
    leaves: LeafIndex,
    ends: Vec<f32>,
}

/// The frame of directions in world space.
const WORLD: Frame = Frame { s: Vec3::X, t: Vec3::Y, n: Vec3::Z };

impl<'f> GuidingDistribution<'f> {
    #[inline]
    pub(in crate::guiding) fn new(normal: Vec3, directions: Directions<'f>) -> GuidingDistribution<'f> {
        GuidingDistribution { frame: Frame::from_normal(normal), directions }
    }

    /// The hemisphere about `n` is taken out of a table over the sphere, stratum by stratum: what the paper blames for
    /// the sphere's cost.
    pub(in crate::guiding) fn on_sphere(
        n: Vec3,
        strata: &'f Strata,
        q: &[f32],
        sampling: GuideSampling,
    ) -> GuidingDistribution<'f> {
        let mut sum = 0.0;
        let ends = (0..q.len()).map(|k| {
            let cos = strata.direction(k, [0.5; 2]).dot(n).max(0.0);
            sum += q[k] * if sampling == GuideSampling::Q { (cos > 0.0) as u32 as f32 } else { cos };
            sum
        });
        let ends = ends.collect();
        GuidingDistribution { frame: WORLD, directions: Directions::Weighed { strata, ends } }
    }

    /// The product with `value`, of which the centre of each stratum or cell is taken: of the BSDF, without its cosine.
    pub fn times(&self, value: impl Fn(Vec3) -> f32) -> GuidingDistribution<'f> {
        let (frame, mut sum) = (self.frame, 0.0);
        let mut ends = Vec::new();
        let mut add = |pmf: f32, local: Vec3| {
            sum += if pmf > 0.0 { pmf * value(frame.to_world(local)) } else { 0.0 };
            ends.push(sum);
        };
        let directions = match &self.directions {
            // its cells reach beyond any lobe's width, and it is the published method, which knows no product
            Directions::Quadtree(quadtree) => Directions::Quadtree(*quadtree),
            Directions::Tree(nodes) => {
                hemitree::leaves(nodes, &mut add);
                Directions::WeighedTree(Box::new(WeighedTree { nodes, leaves: LeafIndex::new(nodes), ends }))
            }
            Directions::WeighedTree(tree) => {
                let WeighedTree { nodes, ref leaves, .. } = **tree;
                hemitree::leaves(nodes, &mut add);
                Directions::WeighedTree(Box::new(WeighedTree { nodes, leaves: leaves.clone(), ends }))
            }
            Directions::Strata { strata, row } => {
                (0..strata.count()).for_each(|k| add(row_pmf(strata, row, k), strata.direction(k, [0.5; 2])));
                Directions::Weighed { strata, ends: ends.into() }
            }
            Directions::Weighed { strata, ends: own } => {
                (0..strata.count()).for_each(|k| add(share(own, k), strata.direction(k, [0.5; 2])));
                Directions::Weighed { strata, ends: ends.into() }
            }
        };
        GuidingDistribution { frame, directions }
    }

    /// As a leaf of an SD-tree has it.
    #[inline]
    pub(in crate::guiding) fn in_leaf(quadtree: Quadtree<'f>) -> GuidingDistribution<'f> {
        GuidingDistribution { frame: WORLD, directions: Directions::Quadtree(quadtree) }
    }

    /// A direction in world space and its density, that of `pdf` but where rounding takes it over the border of a cell.
    /// `u` chooses where to look, `inside` where within; in a quadtree `inside` is for both.
    #[inline(always)]
    pub fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let (local, pdf) = match &self.directions {
            // the default's, in place; the others by a call
            Directions::Tree(nodes) => hemitree::sample(nodes, u, inside),
            directions => directions.sample(u, inside),
        };
        (self.frame.to_world(local), pdf)
    }

    /// Density per steradian of `sample` at the unit direction `w`; 0 below the horizon of the state's frame.
    #[inline(always)]
    pub fn pdf(&self, w: Vec3) -> f32 {
        let local = self.frame.to_local(w);
        match &self.directions {
            Directions::Tree(nodes) => hemitree::pdf(nodes, local),
            directions => directions.pdf(local),
        }
    }
}

impl Directions<'_> {
    #[inline(never)]
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        match self {
            Directions::Tree(nodes) => hemitree::sample(nodes, u, inside),
            Directions::Quadtree(quadtree) => {
                let w = quadtree.sample(inside);
                (w, quadtree.pdf(w))
            }
            Directions::Strata { strata, row } => {
                let k = stratum(strata, row, u);
                (strata.direction(k, inside), strata.density(row_pmf(strata, row, k)))
            }
            Directions::Weighed { strata, ends } => {
                let k = weighed(ends, u);
                (strata.direction(k, inside), strata.density(pmf(ends, k)))
            }
            Directions::WeighedTree(tree) => {
                let k = weighed(&tree.ends, u);
                (tree.leaves.direction(k, inside), pmf(&tree.ends, k) / tree.leaves.solid_angle(k))
            }
        }
    }

    #[inline(never)]
    fn pdf(&self, local: Vec3) -> f32 {
        match self {
            Directions::Tree(nodes) => hemitree::pdf(nodes, local),
            Directions::Quadtree(quadtree) => quadtree.pdf(local),
            Directions::Strata { strata, row } => {
                let Some(k) = strata.index(local) else { return 0.0 };
                strata.density(row_pmf(strata, row, k))
            }
            Directions::Weighed { strata, ends } => {
                let Some(k) = strata.index(local) else { return 0.0 };
                strata.density(pmf(ends, k))
            }
            Directions::WeighedTree(tree) => {
                let Some(k) = tree.leaves.leaf(tree.nodes, local) else { return 0.0 };
                pmf(&tree.ends, k) / tree.leaves.solid_angle(k)
            }
        }
    }
}

/// Draws a stratum from a row of `Field::rows`.
#[inline]
fn stratum(strata: &Strata, row: &[u16], u: f64) -> usize {
    let columns = strata.columns();
    let (lines, starts) = row.split_at(strata.lines());
    let at = (u * WHOLE as f64) as u16;
    let line = hemitree::begun(&lines[1..], at);
    line * columns + hemitree::begun(&starts[line * columns + 1..(line + 1) * columns], at)
}

/// Probability of stratum `k` in a row of `Field::rows`.
#[inline]
fn row_pmf(strata: &Strata, row: &[u16], k: usize) -> f32 {
    let starts = &row[strata.lines()..];
    let end = starts.get(k + 1).map_or(WHOLE, |&start| start as u32);
    (end - starts[k] as u32) as f32 / WHOLE as f32
}

/// Probability of the `k`-th by the weights that end at `ends`; each alike where there is none.
#[inline]
fn pmf(ends: &[f32], k: usize) -> f32 {
    let whole = ends[ends.len() - 1];
    if whole > 0.0 { share(ends, k) / whole } else { 1.0 / ends.len() as f32 }
}

/// Weight of stratum `k`.
#[inline]
fn share(ends: &[f32], k: usize) -> f32 {
    ends[k] - if k == 0 { 0.0 } else { ends[k - 1] }
}

/// Draws a stratum in proportion to its weight; each alike where there is none.
#[inline]
fn weighed(ends: &[f32], u: f64) -> usize {
    let whole = ends[ends.len() - 1];
    if whole > 0.0 {
        let at = (u as f32).min(ONE_MINUS_EPSILON) * whole;
        ends.partition_point(|&end| end <= at).min(ends.len() - 1)
    } else {
        (u * ends.len() as f64) as usize
    }
}
