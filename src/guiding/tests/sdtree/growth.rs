//! How both trees grow, and how much memory they take.

use super::*;

/// Light that differs from place to place.
fn field(p: Vec3, w: Vec3) -> f32 {
    lobe(w, (p - 0.5).normalize_or(Vec3::X), 30) + 0.01
}

#[test]
fn leaves_split_by_the_root_of_the_samples_per_pixel() {
    for (spp, visits, expected) in [(4, 999, 1), (4, 1001, 2), (4, 2001, 4), (16, 1999, 1), (16, 2001, 2), (1, 501, 2)]
    {
        let mut tree = tree(|s| s.split = 1000.0);
        let samples = uniform_samples(&tree, &mut Rng::new(1), visits, field);
        tree.fold(&[&samples]);
        tree.end_iteration(spp);
        assert_eq!(tree.leaves(), expected, "{visits} samples at {spp} spp");
        let sum: f64 = tree.numbers().into_iter().map(|leaf| tree.visits(leaf)).sum();
        assert_eq!(sum, visits as f64, "halves share the samples of the whole");
    }
}

#[test]
fn halves_inherit_what_the_whole_knew() {
    let (mut rng, mut tree) = (Rng::new(2), tree(|s| s.split = 5000.0));
    train(&mut tree, &mut rng, 1, 40_000, field);
    assert!(tree.leaves() >= 8);
    let answers: Vec<_> = tree
        .numbers()
        .into_iter()
        .map(|leaf| (tree.distribution(leaf).map(|q| q.density(Vec3::Y)), tree.mean_radiance(leaf)))
        .collect();
    assert!(answers.iter().all(|a| *a == answers[0] && a.0.is_some()));
    // then each goes its own way
    train(&mut tree, &mut rng, 1, 40_000, field);
    let [a, b] = [Vec3::new(0.1, 0.5, 0.5), Vec3::new(0.9, 0.5, 0.5)].map(|p| tree.leaf_at(p));
    let pdf = |leaf, w| tree.distribution(leaf).expect("it is trained").density(w);
    assert!(pdf(a, Vec3::NEG_X) > 2.0 * pdf(b, Vec3::NEG_X) && pdf(b, Vec3::X) > 2.0 * pdf(a, Vec3::X));
}

#[test]
fn quadtrees_follow_the_energy() {
    let mut rng = Rng::new(3);
    // evenly spread energy: cells of 1/64 are above ρ = 1/100, those of 1/256 are not
    let mut even = single(|_| ());
    assert_eq!(even.learning_nodes(0), 1 + 4 + 16 + 64);
    train(&mut even, &mut rng, 1, 400_000, |_, _| 1.0);
    assert_eq!(even.learning_nodes(0), 85);
    // one direction only: as deep as it goes there, and nowhere else
    let mut spot = single(|_| ());
    for _ in 0..2 {
        spot.fold(&[&[sample(0, Vec3::new(0.6, 0.0, 0.8), 1.0, 1.0, 1.0)]]);
        spot.end_iteration(1);
    }
    let nodes = spot.learning_nodes(0);
    println!("a single direction: {nodes} nodes");
    assert!((16..=4 * 16 * 4).contains(&nodes));
    // light that goes away takes the cells along
    train(&mut spot, &mut rng, 1, 400_000, |_, _| 1.0);
    assert_eq!(spot.learning_nodes(0), 85);
}

#[test]
fn memory_stays_within_its_bound_and_is_used() {
    let mut rng = Rng::new(4);
    for memory in [1u64, 300, 1_000, 10_000, 100_000, 1_000_000, 10_000_000] {
        let settings = SdTreeSettings { split: 100.0, ..SdTreeSettings::default() };
        let mut tree = SdTree::new(Vec3::ZERO, Vec3::ONE, settings, memory);
        let mut most = tree.bytes();
        for _ in 0..5 {
            let samples = uniform_samples(&tree, &mut rng, 60_000, field);
            tree.fold(&[&samples]);
            tree.end_iteration(1);
            most = most.max(tree.bytes());
        }
        println!("{memory} bytes: {} leaves, at most {most} bytes", tree.leaves());
        // the smallest tree there is takes more than a few bytes
        assert!(most <= memory.max(500), "{most} bytes of {memory}");
        assert!(!(10_000..=1_000_000).contains(&memory) || 3 * most > memory, "{most} bytes of {memory}");
        assert!(tree.distribution(tree.leaf_at(Vec3::splat(0.3))).is_some());
    }
}

#[test]
fn wild_settings_are_survived() {
    let mut rng = Rng::new(5);
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let settings = SdTreeSettings { split: bad, rho: bad, levels: 99, ..SdTreeSettings::default() };
        let mut tree = SdTree::new(Vec3::ZERO, Vec3::ONE, settings, 2_000_000);
        train(&mut tree, &mut rng, 3, 2_000, field);
        assert!(tree.bytes() <= 2_000_000, "{bad}: {} bytes", tree.bytes());
        let (leaf, w) = (tree.leaf_at(Vec3::splat(0.3)), square_to_uniform_sphere(rng.f32x2()));
        assert!(tree.distribution(leaf).is_some_and(|q| q.density(w).is_finite()));
    }
}
