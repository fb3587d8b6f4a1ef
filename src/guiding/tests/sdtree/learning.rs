//! What is learnt from known light.

use super::*;

/// Mean |pdf/target − 1| weighted by the target, over the sphere, where the target is ∝ `light`.
fn distance(quadtree: Quadtree, light: impl Fn(Vec3) -> f32) -> f64 {
    let side = 512;
    let directions = (0..side * side).map(|i| {
        let centre = |k: usize| (k as f32 + 0.5) / side as f32;
        square_to_uniform_sphere([centre(i / side), centre(i % side)])
    });
    let directions: Vec<Vec3> = directions.collect();
    let whole: f64 = directions.iter().map(|&w| light(w) as f64).sum();
    let target = |w: Vec3| light(w) as f64 / whole;
    let share = |w: Vec3| quadtree.pdf(w) as f64 * 4.0 * PI / directions.len() as f64;
    directions.iter().map(|&w| (share(w) - target(w)).abs()).sum()
}

#[test]
fn distributions_converge_to_the_radiance() {
    let light = |w: Vec3| 0.1 + 2.0 * lobe(w, Vec3::new(0.48, 0.64, -0.6), 40) + lobe(w, Vec3::NEG_X, 10);
    for filter in [true, false] {
        let (mut rng, mut tree) = (Rng::new(1), single(|s| (s.rho, s.directional_filter) = (0.002, filter)));
        let distances: Vec<f64> = (0..5)
            .map(|k| {
                let samples = uniform_samples(&tree, &mut rng, 1000 << (2 * k), |_, w| light(w));
                tree.fold(&[&samples]);
                tree.end_iteration(1);
                distance(tree.distribution(0).expect("it is trained"), light)
            })
            .collect();
        println!("filter {filter}: distances {distances:.3?}");
        assert!(distances[1..].windows(2).all(|d| d[1] < 0.9 * d[0]), "{distances:?}");
        // what is left is the size of cells
        assert!(distances[4] < 0.12, "{distances:?}");
    }
}

/// Directions drawn from the guide itself teach it the same as uniform ones.
#[test]
fn learning_from_its_own_directions_keeps_the_radiance() {
    let light = |w: Vec3| 0.1 + 2.0 * lobe(w, Vec3::new(0.48, 0.64, -0.6), 40);
    let (mut rng, mut tree) = (Rng::new(2), single(|_| ()));
    train(&mut tree, &mut rng, 1, 100_000, |_, w| light(w));
    for _ in 0..3 {
        let quadtree = tree.distribution(0).expect("it is trained");
        let mut draw = || {
            let guided = rng.f32() < 0.5;
            let w = if guided { quadtree.draw(rng.f32x2()) } else { square_to_uniform_sphere(rng.f32x2()) };
            sample(0, w, light(w), 0.5 * quadtree.pdf(w) + 0.5 * UNIFORM_SPHERE_PDF, 1.0)
        };
        let samples: Vec<Sample> = (0..100_000).map(|_| draw()).collect();
        tree.fold(&[&samples]);
        tree.end_iteration(1);
    }
    // ∫ ((1 + cos)/2)⁴⁰ dω / 4π = 1/41
    let mean = 0.1 + 2.0 / 41.0;
    let found = tree.mean_radiance(0);
    println!("mean radiance {found}, expected {mean}; distance {}", distance(tree.distribution(0).unwrap(), light));
    // the standard error is below 0.1 %
    assert!((found / mean - 1.0).abs() < 0.01, "{found}, not {mean}");
    assert!(distance(tree.distribution(0).expect("it is trained"), light) < 0.15);
}

/// The fraction after iterations in which directions come from a mixture of a BSDF lobe and the guide, and
/// contribute `light` times what the BSDF scatters.
fn learnt_fraction(bsdf_axis: Vec3, sharpness: i32, scale: f32, light: impl Fn(Vec3) -> f32) -> f32 {
    let (mut rng, mut tree) = (Rng::new(3), single(|_| ()));
    train(&mut tree, &mut rng, 1, 50_000, |_, w| scale * light(w));
    let bsdf_pdf = |w: Vec3| (sharpness + 1) as f32 * UNIFORM_SPHERE_PDF * lobe(w, bsdf_axis, sharpness);
    let frame = crate::math::Frame::from_normal(bsdf_axis);
    for _ in 0..3 {
        let (quadtree, fraction) = (tree.distribution(0).expect("it is trained"), tree.fraction(0));
        let mut draw = || {
            let w = if rng.f32() < fraction {
                let cos = 2.0 * rng.f32().powf(1.0 / (sharpness + 1) as f32) - 1.0;
                let (sin, phi) = ((1.0 - cos * cos).max(0.0).sqrt(), std::f32::consts::TAU * rng.f32());
                frame.to_world(Vec3::new(sin * phi.cos(), sin * phi.sin(), cos))
            } else {
                quadtree.draw(rng.f32x2())
            };
            let pdf = fraction * bsdf_pdf(w) + (1.0 - fraction) * quadtree.pdf(w);
            Sample {
                bsdf_pdf: bsdf_pdf(w),
                guide_pdf: quadtree.pdf(w),
                ..sample(0, w, scale * light(w), pdf, bsdf_pdf(w))
            }
        };
        let samples: Vec<Sample> = (0..20_000).map(|_| draw()).collect();
        tree.fold(&[&samples]);
        tree.end_iteration(1);
    }
    tree.fraction(0)
}

#[test]
fn the_fraction_goes_to_whichever_is_of_use() {
    // a sharp lobe in even light: the guide knows nothing that helps
    let bsdf = learnt_fraction(Vec3::Z, 300, 1.0, |_| 1.0);
    // a smooth lobe, light from one spot
    let guide = learnt_fraction(Vec3::Z, 0, 1.0, |w| lobe(w, Vec3::new(0.6, 0.0, 0.8), 300));
    println!("fraction of the BSDF: {bsdf:.3} in even light, {guide:.3} where light comes from a spot");
    assert!(bsdf > 0.9 && guide < 0.15);
    // neither alone will do
    let both = learnt_fraction(Vec3::Z, 20, 1.0, |w| 0.003 + lobe(w, Vec3::new(0.8, 0.0, 0.6), 100));
    println!("and {both:.3} where both are of use");
    assert!((0.2..0.8).contains(&both));
    // the unit of light has no say
    for scale in [2f32.powi(-20), 2f32.powi(20)] {
        // without a floor, some of it would be too dark for single precision
        let light = |w: Vec3| 1e-3 + lobe(w, Vec3::new(0.6, 0.0, 0.8), 300);
        assert_eq!(learnt_fraction(Vec3::Z, 0, scale, light), learnt_fraction(Vec3::Z, 0, 1.0, light));
    }
}

#[test]
fn a_fraction_that_is_not_learnt_stays() {
    let mut tree = single(|s| (s.learned_fraction, s.fraction) = (false, 0.3));
    train(&mut tree, &mut Rng::new(4), 3, 5_000, |_, w| lobe(w, Vec3::X, 300));
    assert_eq!(tree.fraction(0), 0.3);
    // and one that is learnt starts there: without a guide's density there is nothing to learn
    let mut tree = single(|s| s.fraction = 0.3);
    train(&mut tree, &mut Rng::new(4), 1, 5_000, |_, w| lobe(w, Vec3::X, 300));
    assert!((tree.fraction(0) - 0.3).abs() < 1e-6);
}

/// Light that differs from place to place, from 2⁻⁴⁰ to 2⁴⁰, and a third of it black.
fn wild(p: Vec3, w: Vec3) -> f32 {
    if p.x + w.x < 0.3 { 0.0 } else { (80.0 * p.y - 40.0).exp2() * (1.1 + w.z) }
}

#[test]
fn threads_and_batches_change_nothing() {
    let learnt = |threads: usize, batch: usize, reverse: bool| {
        let (mut rng, mut tree) = (Rng::new(5), tree(|s| s.split = 2000.0));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        for k in 0..4 {
            let mut samples = uniform_samples(&tree, &mut rng, 40_000 << k, wild);
            if reverse {
                samples.reverse();
            }
            let batches: Vec<&[Sample]> = samples.chunks(batch).collect();
            pool.install(|| {
                tree.fold(&batches);
                tree.end_iteration(1 << k);
            });
        }
        let means: Vec<u32> = tree.numbers().into_iter().map(|leaf| tree.mean_radiance(leaf).to_bits()).collect();
        (contents(&tree), means)
    };
    let one = learnt(1, usize::MAX, false);
    assert!(one == learnt(3, usize::MAX, false), "three threads");
    assert!(one == learnt(3, 777, false), "batches of 777");
    // the order, in contrast, is seen in the last bits
    assert!(one != learnt(1, usize::MAX, true));
}

#[test]
fn the_unit_of_light_changes_nothing_but_the_mean() {
    let learnt = |scale: f32| {
        let (mut rng, mut tree) = (Rng::new(6), tree(|s| s.split = 500.0));
        train(&mut tree, &mut rng, 4, 10_000, |p, w| scale * wild(p, w));
        let means: Vec<f32> = tree.numbers().into_iter().map(|leaf| tree.mean_radiance(leaf) / scale).collect();
        (contents(&tree), means)
    };
    let one = learnt(1.0);
    for exponent in [-20, 20] {
        assert!(one == learnt(2f32.powi(exponent)), "2^{exponent}");
    }
}

#[test]
fn samples_without_sense_are_left_out() {
    let mut tree = single(|_| ());
    let good = sample(0, Vec3::X, 2.0, 0.5, 1.0);
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let samples = [
            Sample { radiance: bad, ..good },
            Sample { pdf: bad, ..good },
            Sample { bsdf_pdf: bad, ..good },
            Sample { scattered: bad, ..good },
            Sample { pdf: 0.0, ..good },
        ];
        tree.fold(&[&samples]);
    }
    let samples = |tree: &SdTree| tree.0.store.get(RegionId(0)).map(|region| region.directions.samples());
    assert_eq!(samples(&tree), Some(0.0));
    tree.end_iteration(1);
    assert!(tree.distribution(0).is_none() && tree.mean_radiance(0) == 0.0);
    // black is a finding; three of four samples halve the mean twice
    tree.fold(&[&[good], &[Sample { radiance: 0.0, ..good }; 3]]);
    assert_eq!(samples(&tree), Some(4.0));
    tree.end_iteration(1);
    let expected = 2.0 / 0.5 / 4.0 / (4.0 * PI as f32);
    assert!((tree.mean_radiance(0) / expected - 1.0).abs() < 1e-6);
}

#[test]
fn extremes_stay_finite() {
    let mut tree = tree(|s| s.split = 10.0);
    let mut rng = Rng::new(7);
    for _ in 0..4 {
        let mut samples = uniform_samples(&tree, &mut rng, 3000, |p, _| if p.x < 0.5 { f32::MAX } else { 1e-45 });
        samples.iter_mut().for_each(|s| s.pdf = if rng.f32() < 0.5 { f32::MIN_POSITIVE } else { f32::MAX });
        samples.iter_mut().for_each(|s| s.scattered = f32::MAX);
        tree.fold(&[&samples]);
        tree.end_iteration(1);
    }
    for leaf in tree.numbers() {
        if tree.distribution(leaf).is_none() {
            continue;
        }
        let (mean, fraction) = (tree.mean_radiance(leaf), tree.fraction(leaf));
        assert!(mean.is_finite() && mean >= 0.0 && (0.0..=1.0).contains(&fraction));
        let Some(quadtree) = tree.distribution(leaf) else { continue };
        let w = quadtree.draw(rng.f32x2());
        assert!(w.is_normalized() && quadtree.pdf(w).is_finite());
    }
}

#[test]
fn a_leaf_that_finds_no_light_keeps_what_it_knew() {
    let (mut rng, mut tree) = (Rng::new(8), tree(|s| s.split = 2000.0));
    train(&mut tree, &mut rng, 2, 10_000, |_, w| lobe(w, Vec3::X, 20));
    let answers = |tree: &SdTree| {
        let answer = |leaf| tree.distribution(leaf).map(|q| (q.density(Vec3::X), q.nodes(), tree.mean_radiance(leaf)));
        tree.numbers().into_iter().map(answer).collect::<Vec<_>>()
    };
    let before = answers(&tree);
    for _ in 0..3 {
        train(&mut tree, &mut rng, 1, 1_000, |_, _| 0.0);
        assert_eq!(before, answers(&tree));
    }
    assert!(before.iter().all(Option::is_some));
}

#[test]
fn folding_leaves_the_snapshot_alone() {
    let (mut rng, mut tree) = (Rng::new(9), tree(|s| s.split = 2000.0));
    train(&mut tree, &mut rng, 2, 10_000, wild);
    let before = format!("{:?}", contents(&tree));
    let samples = uniform_samples(&tree, &mut rng, 50_000, wild);
    tree.fold(&[&samples]);
    assert_eq!(before, format!("{:?}", contents(&tree)));
    tree.end_iteration(4);
    assert_ne!(before, format!("{:?}", contents(&tree)));
}
