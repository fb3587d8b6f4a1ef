use super::*;
use crate::film::accumulate::{Estimate, PictureIds};
use crate::math::{Rgb, luminance, rng::Rng};

/// A picture of random greys with some noise, times `scale`.
fn picture(scale: f32) -> Estimate {
    let mut rng = Rng::new(1);
    let (width, height) = (23, 17);
    let grey = |rng: &mut Rng, scale: f32| Rgb::splat(rng.f32().powi(4)) * scale;
    let mean = (0..width * height).map(|_| grey(&mut rng, scale)).collect();
    let variance = (0..width * height).map(|_| grey(&mut rng, scale * scale)).collect();
    Estimate {
        width,
        height,
        mean,
        variance,
        samples: 16,
        layers: Vec::new(),
        features: Vec::new(),
        ids: PictureIds::default(),
        counts: Vec::new(),
    }
}

fn counters() -> Counters {
    Counters { rays: 300, paths: 100, ..Counters::default() }
}

/// What a picture of 16 samples, all alike, says.
fn normalisation(picture: &Estimate, counters: &Counters) -> Option<RouletteNormalisation> {
    let variances: Vec<f64> = picture.variance.iter().map(|&v| luminance(v) as f64 * 16.0).collect();
    super::normalisation(&Noise::weigh(picture, &variances)?, picture.samples, counters)
}

#[test]
fn exposure_moves_only_the_luminance() {
    let one = normalisation(&picture(1.0), &counters()).unwrap();
    for k in [2.0f32.powi(-20), 2.0f32.powi(20)] {
        let other = normalisation(&picture(k), &counters()).unwrap();
        assert_eq!(one.scale, other.scale);
        assert!(one.inverse_luminance.iter().zip(&other.inverse_luminance).all(|(a, b)| *a == b * k));
    }
    for k in [1e-6, 1e6] {
        let other = normalisation(&picture(k), &counters()).unwrap();
        assert!((one.scale / other.scale - 1.0).abs() < 1e-5);
        let near = |(a, b): (&f32, &f32)| (a / (b * k) - 1.0).abs() < 1e-5;
        assert!(one.inverse_luminance.iter().zip(&other.inverse_luminance).all(near));
    }
}

#[test]
fn luminance_is_that_of_like_pixels_and_not_far_below_the_mean() {
    let mut even = picture(1.0);
    even.mean.fill(Rgb::splat(3.0));
    let found = normalisation(&even, &counters()).unwrap();
    let expected = 1.0 / (3.0 * 1.01f32.sqrt());
    assert!(found.inverse_luminance.iter().all(|l| (l / expected - 1.0).abs() < 1e-5));
    // one bright pixel that may be bright by chance shows seven pixels wide, one that is known to be bright by itself
    even.mean.fill(Rgb::ZERO);
    let (at, light) = (8 * 23 + 11, 23.0 * 17.0);
    even.mean[at] = Rgb::splat(light);
    for (variance, reach, shown) in [(light * light, 3, light / 49.0), (1.0, 0, light)] {
        even.variance[at] = Rgb::splat(variance);
        let found = normalisation(&even, &counters()).unwrap();
        for (i, l) in found.inverse_luminance.iter().enumerate() {
            let inside = (i % 23).abs_diff(11) <= reach && (i / 23).abs_diff(8) <= reach;
            // the picture's mean is 1: a tenth of it is the floor
            let expected = if inside { 1.0 / shown.hypot(0.1) } else { 10.0 };
            assert!((l / expected - 1.0).abs() < 1e-5, "{i}: {l}, not {expected}");
        }
    }
}

#[test]
fn the_scale_weighs_rays_against_relative_variance() {
    let mut even = picture(1.0);
    even.mean.fill(Rgb::ONE);
    even.variance.fill(Rgb::splat(0.25));
    // the variance of a sample is 16 times that of the mean, and the floor adds a hundredth to the square
    let expected = SPLIT_BIAS as f32 * (3.0f32 * 1.01 / (16.0 * 0.25)).sqrt();
    let found = normalisation(&even, &counters()).unwrap();
    assert!((found.scale / expected - 1.0).abs() < 1e-5, "{}, not {expected}", found.scale);
    // a few fireflies have no say, many do
    even.variance[5] = Rgb::splat(1e9);
    assert!((normalisation(&even, &counters()).unwrap().scale / expected - 1.0).abs() < 1e-5);
    even.variance[..40].fill(Rgb::splat(1e9));
    assert!(normalisation(&even, &counters()).unwrap().scale < 0.1 * expected);
}

#[test]
fn a_picture_that_says_nothing_gives_none() {
    let changed = |change: fn(&mut Estimate)| {
        let mut picture = picture(1.0);
        change(&mut picture);
        normalisation(&picture, &counters())
    };
    assert!(changed(|p| p.mean.fill(Rgb::ZERO)).is_none(), "black");
    assert!(changed(|p| p.samples = 6).is_none(), "too few samples");
    assert!(changed(|p| p.variance.fill(Rgb::ZERO)).is_none(), "without noise");
    assert!(changed(|p| p.mean[3] = Rgb::splat(f32::INFINITY)).is_none(), "not finite");
    let found = changed(|p| p.samples = 7).expect("seven samples are enough");
    assert!(found.scale.is_finite() && found.scale > 0.0);
    assert!(found.inverse_luminance.iter().all(|l| l.is_finite() && *l > 0.0));
}
