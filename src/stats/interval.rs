//! Confidence intervals from independent runs.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// An interval that holds the unknown quantity with the confidence asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// Mean and spread of independent runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    pub runs: usize,
    pub mean: f64,
    /// Unbiased sample variance of one run.
    pub variance: f64,
}

impl Summary {
    /// `None` for fewer than two runs, or where a value is not finite.
    pub fn of(values: &[f64]) -> Option<Summary> {
        let n = values.len();
        if n < 2 || values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Some(Summary { runs: n, mean, variance: squares / (n - 1) as f64 })
    }

    /// Standard error of the mean.
    pub fn std_error(&self) -> f64 {
        (self.variance / self.runs as f64).sqrt()
    }

    /// Student's t interval of the mean with confidence `level` in (0, 1): exact for normal runs.
    pub(crate) fn confidence(&self, level: f64) -> Option<Interval> {
        let half = t_quantile(level, (self.runs - 1) as f64)? * self.std_error();
        Some(Interval { low: self.mean - half, high: self.mean + half })
    }
}

/// Confidence interval of the ratio of the expectations of two independent sets of runs, `a` over `b`, by the delta method on the
/// logarithm: var ln(ā/b̄) ≈ se_a²/ā² + se_b²/b̄² (Hedges, Gurevitch & Curtis 1999), Student's t with
/// Welch's degrees of freedom (1947). `None` where a mean is not positive.
pub fn ratio_interval(a: &Summary, b: &Summary, level: f64) -> Option<Interval> {
    if a.mean <= 0.0 || b.mean <= 0.0 {
        return None;
    }
    let relative = |s: &Summary| (s.std_error() / s.mean).powi(2);
    let (va, vb) = (relative(a), relative(b));
    let ratio = a.mean / b.mean;
    if va + vb == 0.0 {
        return Some(Interval { low: ratio, high: ratio });
    }
    let freedom = (va + vb).powi(2) / (va * va / (a.runs - 1) as f64 + vb * vb / (b.runs - 1) as f64);
    let half = t_quantile(level, freedom)? * (va + vb).sqrt();
    Some(Interval { low: ratio * (-half).exp(), high: ratio * half.exp() })
}

/// The t that |T| stays below with probability `level`; `None` unless `level` is in (0, 1).
fn t_quantile(level: f64, freedom: f64) -> Option<f64> {
    if !(level > 0.0 && level < 1.0) {
        return None;
    }
    StudentsT::new(0.0, 1.0, freedom).ok().map(|t| t.inverse_cdf(0.5 + 0.5 * level))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn quantiles_of_the_t_table() {
        for (freedom, level, t) in [(1.0, 0.95, 12.7062), (4.0, 0.95, 2.7764), (9.0, 0.99, 3.2498), (30.0, 0.9, 1.6973)]
        {
            let got = t_quantile(level, freedom).unwrap();
            assert!((got - t).abs() < 1e-4, "{got} for {freedom}");
        }
        assert!(t_quantile(1.0, 3.0).is_none() && t_quantile(0.0, 3.0).is_none());
    }

    #[test]
    fn five_runs_by_hand() {
        let s = Summary::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!((s.mean, s.variance), (3.0, 2.5));
        let c = s.confidence(0.95).unwrap();
        // 3 ± 2.7764·√0.5
        assert!((c.low - 1.036_757).abs() < 1e-5 && (c.high - 4.963_243).abs() < 1e-5, "{c:?}");
        assert!(Summary::of(&[1.0]).is_none() && Summary::of(&[1.0, f64::NAN]).is_none());
    }

    #[test]
    fn ratio_by_hand() {
        let a = Summary { runs: 5, mean: 2.0, variance: 0.2 };
        let b = Summary { runs: 5, mean: 1.0, variance: 0.05 };
        // relative variances 0.01 and 0.01: eight degrees of freedom, t = 2.3060, half width 0.32612
        let c = ratio_interval(&a, &b, 0.95).unwrap();
        assert!((c.high / 2.0 - 0.326_120_f64.exp()).abs() < 1e-4, "{c:?}");
        assert!((c.low * c.high - 4.0).abs() < 1e-9);
        assert!(ratio_interval(&a, &Summary { mean: 0.0, ..b }, 0.95).is_none());
        let exact = Summary { variance: 0.0, ..b };
        assert_eq!(ratio_interval(&exact, &exact, 0.9), Some(Interval { low: 1.0, high: 1.0 }));
    }

    /// Share of 4 000 experiments with eight runs a side in which `level` intervals hold the truth.
    fn coverage(level: f64, claimed_truth: f64) -> f64 {
        let mut rng = Rng::new(11);
        let mut runs = |scale: f64| -> Vec<f64> {
            let one = |rng: &mut Rng| (0..12).map(|_| rng.f32() as f64).sum::<f64>() / 6.0;
            (0..8).map(|_| scale * one(&mut rng)).collect()
        };
        let hits = (0..4000).filter(|_| {
            let (a, b) = (Summary::of(&runs(3.0)).unwrap(), Summary::of(&runs(1.5)).unwrap());
            let c = ratio_interval(&a, &b, level).unwrap();
            c.low <= claimed_truth && claimed_truth <= c.high
        });
        hits.count() as f64 / 4000.0
    }

    #[test]
    fn ratio_intervals_cover_the_truth_and_not_a_lie() {
        // binomial standard deviation 0.005; ± 0.025 is five of them (false alarm 1 in 1.7 million)
        let right = coverage(0.9, 2.0);
        assert!((right - 0.9).abs() < 0.025, "{right}");
        let lie = coverage(0.9, 2.5);
        assert!(lie < 0.6, "{lie}");
    }
}
