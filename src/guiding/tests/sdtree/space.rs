//! The spatial tree: which leaf a point is in.

use super::*;
use crate::guiding::spatial::LeafBox;
use crate::math::rng::Rng;
use proptest::prelude::*;

/// A tree over a box, with `splits` random leaves halved.
fn grown(rng: &mut Rng, low: Vec3, high: Vec3, splits: u32) -> KdTree {
    let mut tree = KdTree::new(low, high, true, false);
    let mut leaves = vec![(0, 0)];
    for _ in 0..splits {
        let leaf = rng.next_u32() as usize % leaves.len();
        let (node, depth) = leaves[leaf];
        if depth < 40 {
            let [lower, upper] = tree.divide(node).map(|halves| [halves.start, halves.start + 1]).expect("a leaf");
            leaves[leaf] = (lower, depth + 1);
            leaves.push((upper, depth + 1));
        }
    }
    tree
}

fn holds(cell: &LeafBox, p: Vec3, tolerance: f32) -> bool {
    p.cmpge(cell.low - tolerance).all() && p.cmplt(cell.high + tolerance).all()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_point_is_in_the_one_leaf_that_holds_it(seed: u64, splits in 0u32..400, size in -20i32..20) {
        let mut rng = Rng::new(seed);
        let scale = 2f32.powi(size);
        let high = scale * Vec3::new(1.0, 0.3, 0.7);
        let tree = grown(&mut rng, Vec3::ZERO, high, splits);
        let cells: Vec<LeafBox> = tree.leaves().collect();
        let mut numbers: Vec<u32> = cells.iter().map(|c| c.leaf).collect();
        numbers.sort_unstable();
        numbers.dedup();
        prop_assert!(numbers.len() == cells.len() && numbers.iter().all(|&leaf| tree.holds(RegionId(leaf as u64))));
        let volume: f64 = cells.iter().map(|c| (c.high - c.low).as_dvec3().element_product()).sum();
        let side = 1.0291 * scale as f64;
        prop_assert!((volume / side.powi(3) - 1.0).abs() < 1e-4, "leaves fill {} of the cube", volume);
        for _ in 0..200 {
            let p = point(&mut rng) * high;
            // a coordinate is kept in 21 bits; only at a border that close may the neighbour hold the point
            let step = side as f32 * 2f32.powi(-20);
            let leaf = tree.leaf(p);
            let inside: Vec<u32> = cells.iter().filter(|c| holds(c, p, -step)).map(|c| c.leaf).collect();
            let near = cells.iter().filter(|c| holds(c, p, step)).any(|c| c.leaf == leaf);
            prop_assert!(near && inside.len() <= 1 && inside.iter().all(|&l| l == leaf), "{} in {} and {:?}", p, leaf, inside);
        }
    }

    /// Far away, infinite or not a number: still a leaf.
    #[test]
    fn any_point_has_a_leaf(seed: u64, x: f32, y: f32, z: f32) {
        let mut rng = Rng::new(seed);
        let tree = grown(&mut rng, Vec3::splat(-3.0), Vec3::splat(5.0), 50);
        let leaves: Vec<u32> = tree.leaves().map(|leaf| leaf.leaf).collect();
        prop_assert!(leaves.contains(&tree.leaf(Vec3::new(x, y, z))));
        prop_assert!(leaves.contains(&tree.leaf_jittered(Vec3::new(x, y, z), [rng.f32(), rng.f32(), rng.f32()])));
    }
}

#[test]
fn degenerate_boxes_have_a_leaf() {
    for (low, high) in [(Vec3::ZERO, Vec3::ZERO), (Vec3::splat(1e6), Vec3::splat(1e6)), (Vec3::NAN, Vec3::NAN)] {
        let tree = KdTree::new(low, high, true, false);
        assert_eq!(tree.leaf(low), 0);
    }
}

/// The filter: a box as large as the leaf about the point.
#[test]
fn jitter_reaches_half_a_leaf_to_either_side() {
    let mut rng = Rng::new(5);
    let mut tree = KdTree::new(Vec3::ZERO, Vec3::ONE, true, false);
    assert_eq!(tree.divide(0), Some(1..3));
    let border = tree.leaves().find(|c| c.leaf == 1).map(|c| c.high.x).expect("the lower half");
    let extent = 0.5 * 1.0291;
    for (distance, expected) in [(0.01, 0.48), (0.25 * extent, 0.25), (0.49 * extent, 0.01), (0.51 * extent, 0.0)] {
        let p = Vec3::new(border - distance, 0.5, 0.5);
        let n = 20_000;
        let over = (0..n).filter(|_| tree.leaf_jittered(p, [rng.f32(), rng.f32(), rng.f32()]) == 2).count();
        let share = over as f32 / n as f32;
        // six standard errors of a share are at most 0.0212
        assert!((share - expected).abs() < 0.0212, "{share} for {expected}");
        assert!(expected > 0.0 || over == 0);
    }
    assert_eq!(tree.leaf_jittered(Vec3::new(border + 0.01, 0.5, 0.5), [0.5; 3]), 2);
}
