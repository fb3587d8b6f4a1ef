//! The tree without a renderer: light fields are known, so what is learnt can be held against them.

mod directions;
mod growth;
mod learning;
mod space;

use super::*;
use crate::guiding::directional::quadtree::frozen::Branch;
use crate::math::rng::Rng;
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};

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
    Sample { leaf, direction: encode(w), radiance, pdf, bsdf_pdf: UNIFORM_SPHERE_PDF, scattered }
}

/// `n` samples of the field `light`, uniform over the sphere and over the cube.
fn uniform_samples(tree: &SdTree, rng: &mut Rng, n: usize, light: impl Fn(Vec3, Vec3) -> f32) -> Vec<Sample> {
    let one = |rng: &mut Rng| {
        let (p, w) = (point(rng), square_to_uniform_sphere(rng.f32x2()));
        let leaf = tree.leaf(p, [rng.f32(), rng.f32(), rng.f32()]);
        sample(leaf, w, light(p, w), UNIFORM_SPHERE_PDF, 1.0)
    };
    (0..n).map(|_| one(rng)).collect()
}

/// Trains for `iterations`, the first with `n` samples, each of the others with twice those of the one before.
fn train(tree: &mut SdTree, rng: &mut Rng, iterations: u32, n: usize, light: impl Fn(Vec3, Vec3) -> f32) {
    for k in 0..iterations {
        let samples = uniform_samples(tree, rng, n << k, &light);
        tree.fold(&[&samples]);
        tree.end_iteration((1 << k) as f32);
    }
}

/// Light from about `axis`: (1 + cos)ⁿ, the stronger the higher n.
fn lobe(w: Vec3, axis: Vec3, n: i32) -> f32 {
    (0.5 + 0.5 * w.dot(axis)).powi(n)
}

/// All that a tree knows, to the bit.
fn contents(tree: &SdTree) -> impl PartialEq + std::fmt::Debug + use<> {
    let leaf = |l: LeafInfo| {
        let frozen = tree.frozen[l.leaf as usize];
        (l.low.to_array(), l.visits, frozen.first, frozen.nodes, frozen.mean.to_bits(), frozen.fraction.to_bits())
    };
    (tree.inspect().map(leaf).collect::<Vec<_>>(), tree.nodes.clone())
}
