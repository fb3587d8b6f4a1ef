//! Drawing from a tree, or from its product with a BSDF.

use super::leaf_index::{LeafIndex, leaves};
use super::product::TreeProduct;
use super::{Node, pdf, sample};
use crate::guiding::directional::Directions;
use crate::guiding::directional::weights::{self, Product};
use glam::Vec3;

#[derive(Clone, Debug)]
pub enum TreeDirections<'f> {
    Nodes(&'f [Node]),
    /// Times a glossy reflection.
    Product(TreeProduct<'f>),
    /// Boxed, so that directions without are small.
    Weighed(Box<WeighedLeaves<'f>>),
}

/// Leaves drawn in proportion to weights of this very vertex.
#[derive(Clone, Debug)]
pub struct WeighedLeaves<'f> {
    nodes: &'f [Node],
    leaves: LeafIndex,
    /// Where each leaf's weight ends, the last at the sum of all.
    ends: Vec<f32>,
}

impl Directions for TreeDirections<'_> {
    #[inline(always)]
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        match self {
            // the default's, in place; the product's by a call
            TreeDirections::Nodes(nodes) => sample(nodes, u, inside),
            TreeDirections::Product(product) => product.sample(u, inside),
            TreeDirections::Weighed(leaves) => leaves.sample(u, inside),
        }
    }

    #[inline(always)]
    fn pdf(&self, local: Vec3) -> f32 {
        match self {
            TreeDirections::Nodes(nodes) => pdf(nodes, local),
            TreeDirections::Product(product) => product.pdf(local),
            TreeDirections::Weighed(leaves) => leaves.pdf(local),
        }
    }

    fn times(&self, value: impl Fn(Vec3) -> f32) -> Self {
        let mut product = Product::with(value);
        let (nodes, index) = match self {
            TreeDirections::Nodes(nodes) => (*nodes, LeafIndex::new(nodes)),
            TreeDirections::Product(tree) => (tree.nodes(), LeafIndex::new(tree.nodes())),
            TreeDirections::Weighed(tree) => (tree.nodes, tree.leaves.clone()),
        };
        leaves(nodes, &mut |weight, at| product.add(weight, at));
        TreeDirections::Weighed(Box::new(WeighedLeaves { nodes, leaves: index, ends: product.ends }))
    }
}

impl WeighedLeaves<'_> {
    #[inline(never)]
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let k = weights::draw(&self.ends, u);
        (self.leaves.direction(k, inside), weights::pmf(&self.ends, k) / self.leaves.solid_angle(k))
    }

    #[inline(never)]
    fn pdf(&self, local: Vec3) -> f32 {
        let Some(k) = self.leaves.leaf(self.nodes, local) else { return 0.0 };
        weights::pmf(&self.ends, k) / self.leaves.solid_angle(k)
    }
}
