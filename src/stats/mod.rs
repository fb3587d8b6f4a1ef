//! Tests and intervals: whether a sampler follows its density, whether two renderings agree, how sure a mean is.

#[cfg(test)]
pub(crate) mod chi2;
pub(crate) mod interval;
#[cfg(feature = "lab")]
pub(crate) mod median;
#[cfg(test)]
pub(crate) mod quadrature;
pub mod ztest;

#[cfg(test)]
pub(crate) use chi2::{Chi2Report, DirectionTest, Domain, chi2_discrete};
pub use interval::{Interval, Summary, ratio_interval};
#[cfg(feature = "lab")]
pub(crate) use interval::{LogSpread, log_ratio};
#[cfg(feature = "lab")]
pub(crate) use median::Median;
pub use ztest::{ImageMoments, ImageZTest, z_test_images};

/// The level of each of `tests` independent tests at which all of them together raise a false alarm with
/// probability `level`: 1 − (1 − level)^(1/tests) (Šidák 1967).
pub fn sidak(level: f64, tests: usize) -> f64 {
    // expm1 and ln_1p keep the digits that 1 − (1 − level) would lose
    -((-level).ln_1p() / tests.max(1) as f64).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::sidak;

    #[test]
    fn sidak_of_all_tests_together_gives_the_level_back() {
        assert_eq!(sidak(0.05, 1), 0.05);
        assert!((sidak(0.01, 2) - 0.005_012_562_893_38).abs() < 1e-12);
        let each = sidak(1e-6, 1000);
        assert!((each / 1.000_000_5e-9 - 1.0).abs() < 1e-6, "{each}");
    }
}
