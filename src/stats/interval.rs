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

    /// Interval of the mean of a quantity that is never negative, by Student's t on the logarithm of the mean: both its ends are
    /// positive. A mean of 0 without any spread is sure; `None` for other means that are not positive.
    pub(crate) fn confidence_of_positive(&self, level: f64) -> Option<Interval> {
        if self.mean == 0.0 && self.variance == 0.0 {
            return Some(Interval { low: 0.0, high: 0.0 });
        }
        let factor = LogSpread::of_mean(self)?.factor(level)?;
        Some(Interval { low: self.mean / factor, high: self.mean * factor })
    }

    /// Student's t interval of the mean with confidence `level` in (0, 1): exact for normal runs.
    pub(crate) fn confidence(&self, level: f64) -> Option<Interval> {
        let half = t_quantile(level, (self.runs - 1) as f64)? * self.std_error();
        Some(Interval { low: self.mean - half, high: self.mean + half })
    }
}

/// How sure a logarithm is: its variance, and the degrees of freedom that this is known by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogSpread {
    pub(crate) variance: f64,
    pub(crate) freedom: f64,
}

impl LogSpread {
    /// Of the logarithm of a mean, by the delta method: var ln x̄ ≈ se²/x̄². `None` where the mean is not positive.
    pub(crate) fn of_mean(s: &Summary) -> Option<LogSpread> {
        let variance = (s.std_error() / s.mean).powi(2);
        (s.mean > 0.0).then_some(LogSpread { variance, freedom: (s.runs - 1) as f64 })
    }

    /// Of the sum of independent logarithms, with Welch's degrees of freedom (1947).
    pub(crate) fn sum(parts: &[LogSpread]) -> LogSpread {
        let variance = parts.iter().map(|p| p.variance).sum::<f64>();
        let inverse = parts.iter().map(|p| p.variance * p.variance / p.freedom).sum::<f64>();
        let least = parts.iter().map(|p| p.freedom).fold(f64::INFINITY, f64::min);
        LogSpread { variance, freedom: if inverse > 0.0 { variance * variance / inverse } else { least } }
    }

    /// Of a logarithm whose variance is `factor` times as large.
    pub(crate) fn times(self, factor: f64) -> LogSpread {
        LogSpread { variance: factor * self.variance, ..self }
    }

    /// The factor to either side within which the quantity lies with confidence `level` in (0, 1).
    pub(crate) fn factor(&self, level: f64) -> Option<f64> {
        if self.variance == 0.0 {
            return Some(1.0);
        }
        Some((t_quantile(level, self.freedom)? * self.variance.sqrt()).exp())
    }
}

/// Confidence interval of the ratio of the expectations of two independent sets of runs, `a` over `b`, by the delta method on the
/// logarithm: var ln(ā/b̄) ≈ se_a²/ā² + se_b²/b̄² (Hedges, Gurevitch & Curtis 1999), Student's t with
/// Welch's degrees of freedom (1947). `None` where a mean is not positive.
pub fn ratio_interval(a: &Summary, b: &Summary, level: f64) -> Option<Interval> {
    let factor = log_ratio(a, b)?.factor(level)?;
    let ratio = a.mean / b.mean;
    Some(Interval { low: ratio / factor, high: ratio * factor })
}

/// How sure the logarithm of such a ratio is.
pub(crate) fn log_ratio(a: &Summary, b: &Summary) -> Option<LogSpread> {
    Some(LogSpread::sum(&[LogSpread::of_mean(a)?, LogSpread::of_mean(b)?]))
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
    fn intervals_of_positive_quantities_are_positive() {
        // by the plain rule 0.2 ± 0.248 would reach below 0; relative standard error 0.28868, t(2) = 4.3027
        let s = Summary::of(&[0.1, 0.2, 0.3]).unwrap();
        let c = s.confidence_of_positive(0.95).unwrap();
        assert!(s.confidence(0.95).unwrap().low < 0.0 && c.low > 0.0);
        assert!((c.high / 0.2 - (4.3027 * 0.288_675_f64).exp()).abs() < 1e-3 && (c.low * c.high - 0.04).abs() < 1e-12);
        let zero = Summary::of(&[0.0, 0.0]).unwrap().confidence_of_positive(0.95);
        assert_eq!(zero, Some(Interval { low: 0.0, high: 0.0 }));
        assert_eq!(Summary::of(&[-1.0, 0.5]).unwrap().confidence_of_positive(0.95), None);
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
