use super::*;
use crate::math::Frame;
use crate::math::rng::Rng;
use crate::math::warp::*;

/// False-alarm rate of every test here that expects a pass.
const LEVEL: f64 = 1e-6;

#[test]
fn a_die_has_its_textbook_statistic() {
    // 10 expected of each face: (25 + 4 + 1 + 4 + 0 + 100)/10 = 13.4
    let report = chi2_discrete(&[5, 8, 9, 8, 10, 20], &[1.0 / 6.0; 6]);
    assert!((report.statistic - 13.4).abs() < 1e-9);
    assert_eq!(report.degrees_of_freedom, 5);
    assert!((report.p_value - 0.019_905_220_334_774).abs() < 1e-9, "{report}");
}

#[test]
fn small_cells_are_pooled_and_nothing_is_lost() {
    let pmf = [0.001, 0.002, 0.003, 0.494, 0.5];
    let report = chi2_discrete(&[1, 2, 3, 494, 500], &pmf);
    assert_eq!((report.pooled, report.degrees_of_freedom), (3, 2));
    assert!(report.statistic < 1e-12 && report.p_value > 0.999, "{report}");
}

#[test]
fn draws_where_the_pmf_is_zero_fail() {
    let report = chi2_discrete(&[1, 5000, 5000], &[0.0, 0.5, 0.5]);
    assert!(report.failure.is_some() && !report.passes(LEVEL), "{report}");
    assert!(!chi2_discrete(&[500, 500], &[0.6, 0.6]).passes(LEVEL), "mass above 1");
    assert!(!chi2_discrete(&[500, 500], &[0.4, 0.4]).passes(LEVEL), "a fifth is missing");
}

#[test]
fn a_pmf_that_lies_by_five_per_cent_is_caught() {
    let mut rng = Rng::new(1);
    let mut counts = [0u64; 16];
    for _ in 0..1_000_000 {
        counts[(rng.f32() * 16.0) as usize] += 1;
    }
    let truth = chi2_discrete(&counts, &[1.0 / 16.0; 16]);
    assert!(truth.passes(LEVEL), "{truth}");
    let mut lie = [1.0 / 16.0; 16];
    (lie[3], lie[4]) = (1.05 / 16.0, 0.95 / 16.0);
    let report = chi2_discrete(&counts, &lie);
    assert!(report.p_value < 1e-6, "{report}");
}

#[test]
fn a_density_with_a_peak_passes_and_its_mirror_image_does_not() {
    let lobe = Frame::from_normal(Vec3::new(0.6, 0.0, 0.8));
    // powered cosine: (n + 1)/2π cosⁿ
    let exponent = 400.0;
    let draw = |u: [f32; 2]| {
        let cos = (1.0 - u[0]).powf(1.0 / (exponent + 1.0));
        let (sin, phi) = ((1.0 - cos * cos).sqrt(), std::f32::consts::TAU * u[1]);
        lobe.to_world(Vec3::new(sin * phi.cos(), sin * phi.sin(), cos))
    };
    let pdf = |w: Vec3, axis: Vec3| (exponent + 1.0) / std::f32::consts::TAU * w.dot(axis).max(0.0).powf(exponent);
    let test = DirectionTest::new(Domain::Sphere);
    let mut rng = Rng::new(2);
    let right = test.run(|| Some(draw(rng.f32x2())), |w| pdf(w, lobe.n));
    assert!(right.passes(LEVEL), "{right}");
    assert!((right.mass - 1.0).abs() < 1e-4, "{right}");
    let turned = Vec3::new(0.599, 0.02, 0.8).normalize();
    let wrong = test.run(|| Some(draw(rng.f32x2())), |w| pdf(w, turned));
    assert!(wrong.p_value < 1e-6, "{wrong}");
}

#[test]
fn a_sampler_in_a_rotated_frame_is_caught() {
    let test = DirectionTest::new(Domain::Sphere);
    let frame = Frame::from_normal(Vec3::new(0.05, 0.0, 1.0).normalize());
    let mut rng = Rng::new(3);
    let report =
        test.run(|| Some(frame.to_world(square_to_cosine_hemisphere(rng.f32x2()))), square_to_cosine_hemisphere_pdf);
    assert!(report.p_value < 1e-6, "{report}");
}

#[test]
fn densities_five_per_cent_off_are_caught_either_way() {
    let test = DirectionTest::new(Domain::Hemisphere);
    let mut rng = Rng::new(4);
    for scale in [1.05, 0.95] {
        let report = test
            .run(|| Some(square_to_uniform_hemisphere(rng.f32x2())), |w| scale * square_to_uniform_hemisphere_pdf(w));
        assert!(report.p_value < 1e-6, "{report}");
    }
}

#[test]
fn lost_samples_must_be_what_the_density_leaves() {
    let test = DirectionTest::new(Domain::Hemisphere);
    let mut rng = Rng::new(5);
    let mut lossy = || {
        let keep = rng.f32() < 0.75;
        keep.then(|| square_to_cosine_hemisphere(rng.f32x2()))
    };
    let right = test.run(&mut lossy, |w| 0.75 * square_to_cosine_hemisphere_pdf(w));
    assert!(right.passes(LEVEL), "{right}");
    let wrong = test.run(&mut lossy, |w| 0.76 * square_to_cosine_hemisphere_pdf(w));
    assert!(wrong.p_value < 1e-6, "{wrong}");
}

#[test]
fn what_is_no_direction_of_the_domain_fails() {
    let test = DirectionTest { samples: 1000, ..DirectionTest::new(Domain::Hemisphere) };
    for bad in [Vec3::NAN, Vec3::ZERO, -Vec3::Z] {
        assert!(test.run(|| Some(bad), square_to_uniform_hemisphere_pdf).failure.is_some());
    }
    assert!(test.run(|| Some(Vec3::Z), |_| f32::NAN).failure.is_some());
}
