//! Z-tests: whether two estimates with known standard errors have the same expectation.

use super::sidak;
use crate::{Error, Result};
use statrs::function::erf::erfc;

/// (a − b) in units of its standard error, for independent estimates: standard normal if the expectations agree.
/// Two estimates without error are 0 apart if equal, else infinitely far.
pub(crate) fn z_two_means(a: f64, error_a: f64, b: f64, error_b: f64) -> f64 {
    let difference = a - b;
    if difference == 0.0 { 0.0 } else { difference / error_a.hypot(error_b) }
}

/// (mean − truth) in units of the mean's standard error.
pub fn z_one_mean(mean: f64, error: f64, truth: f64) -> f64 {
    z_two_means(mean, error, truth, 0.0)
}

/// Two-sided p-value: the probability of |Z| ≥ |z| for a standard normal Z; 0 for NaN.
pub fn p_value(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2) }
}

/// An image as means and the variances *of those means*, value by value (any channel order).
#[derive(Clone, Copy, Debug)]
pub struct ImageMoments<'a> {
    pub mean: &'a [f32],
    pub variance: &'a [f32],
}

/// How two independent renderings of one image compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageZTest {
    /// Number of values compared.
    pub(crate) values: usize,
    /// Share of values with a p-value of at least the level asked for: 1 − level is expected of equal images.
    pub passed: f64,
    /// The same at Šidák's level: all of them pass with probability 1 − level.
    pub(crate) passed_sidak: f64,
    /// Largest |z| of a value; infinite where a value is not finite.
    pub(crate) max_z: f64,
    /// z of the difference of the means over the image. Values count as independent of each other, which holds
    /// for a box filter of one pixel and no sharing between channels; with RGB taken together it is up to √3 too large.
    pub mean_z: f64,
}

/// Compares two independent renderings value by value. A pixel that is not finite, or has a negative variance,
/// fails. Normality is assumed: pixels with few or heavy-tailed samples fail more often than the level says.
pub fn z_test_images(a: ImageMoments, b: ImageMoments, level: f64) -> Result<ImageZTest> {
    let values = a.mean.len();
    if values == 0 || [a.variance.len(), b.mean.len(), b.variance.len()].iter().any(|&n| n != values) {
        return Err(Error::Scene("images to be compared must have the same, positive size".into()));
    }
    let strict = sidak(level, values);
    let (mut passed, mut passed_sidak, mut max_z) = (0usize, 0usize, 0.0f64);
    let (mut difference, mut variance) = (0.0f64, 0.0f64);
    for i in 0..values {
        let (ma, mb) = (a.mean[i] as f64, b.mean[i] as f64);
        let (va, vb) = (a.variance[i] as f64, b.variance[i] as f64);
        let z = z_two_means(ma, va.sqrt(), mb, vb.sqrt());
        let p = if va >= 0.0 && vb >= 0.0 { p_value(z) } else { 0.0 };
        passed += usize::from(p >= level);
        passed_sidak += usize::from(p >= strict);
        max_z = max_z.max(if z.is_nan() { f64::INFINITY } else { z.abs() });
        difference += ma - mb;
        variance += va + vb;
    }
    Ok(ImageZTest {
        values,
        passed: passed as f64 / values as f64,
        passed_sidak: passed_sidak as f64 / values as f64,
        max_z,
        mean_z: z_one_mean(difference, variance.sqrt(), 0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn known_values() {
        assert!((p_value(1.959_963_984_540_054) - 0.05).abs() < 1e-9);
        assert!((p_value(-6.0) / 1.973_175_290_075_396e-9 - 1.0).abs() < 1e-6);
        assert_eq!(z_two_means(5.0, 3.0, 0.0, 4.0), 1.0);
        assert_eq!(z_one_mean(1.2, 0.1, 1.0).round(), 2.0);
        assert_eq!((z_two_means(1.0, 0.0, 1.0, 0.0), p_value(0.0)), (0.0, 1.0));
        assert_eq!(p_value(z_two_means(1.0, 0.0, 2.0, 0.0)), 0.0);
    }

    /// A picture whose values are sums of 48 uniforms about 1, with their true variance.
    fn noise(rng: &mut Rng, n: usize, scale: f32) -> (Vec<f32>, Vec<f32>) {
        let value = |rng: &mut Rng| (0..48).map(|_| rng.f32() - 0.5).sum::<f32>() / 2.0;
        ((0..n).map(|_| scale + 0.1 * value(rng)).collect(), vec![0.01; n])
    }

    #[test]
    fn equal_images_pass_as_often_as_they_should_and_unequal_ones_do_not() {
        let (mut rng, n, level) = (Rng::new(7), 10_000, 0.05);
        let (am, av) = noise(&mut rng, n, 1.0);
        let (bm, bv) = noise(&mut rng, n, 1.0);
        let a = ImageMoments { mean: &am, variance: &av };
        let same = z_test_images(a, ImageMoments { mean: &bm, variance: &bv }, level).unwrap();
        // five standard deviations of a binomial share of 0.95: false alarms once in two million
        assert!((same.passed - 0.95).abs() < 5.0 * (0.95 * 0.05 / n as f64).sqrt(), "{same:?}");
        assert!(same.mean_z.abs() < 5.0 && same.passed_sidak > 0.999, "{same:?}");
        // one per cent brighter is invisible per pixel (0.07 standard errors), plain over the image
        let (cm, cv) = noise(&mut rng, n, 1.01);
        let off = z_test_images(a, ImageMoments { mean: &cm, variance: &cv }, level).unwrap();
        assert!(off.passed > 0.93 && off.mean_z < -4.0, "{off:?}");
        // ten per cent are seen by the share of pixels too
        let (dm, dv) = noise(&mut rng, n, 1.1);
        let far = z_test_images(a, ImageMoments { mean: &dm, variance: &dv }, level).unwrap();
        assert!(far.passed < 0.92 && far.mean_z < -40.0, "{far:?}");
    }

    #[test]
    fn faults_fail() {
        let good = ImageMoments { mean: &[1.0, 1.0], variance: &[0.1, 0.1] };
        let bad = ImageMoments { mean: &[f32::NAN, 1.0], variance: &[0.1, -0.1] };
        let test = z_test_images(good, bad, 0.05).unwrap();
        assert_eq!((test.passed, test.max_z), (0.0, f64::INFINITY));
        let short = ImageMoments { mean: &[1.0], variance: &[0.1] };
        assert!(z_test_images(good, short, 0.05).is_err());
    }
}
