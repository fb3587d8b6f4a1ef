//! Medians of a few timings, with intervals that assume nothing of their law but independence.

use serde::Serialize;

/// Confidence that intervals are to have; with fewer than six values they cannot.
const LEVEL: f64 = 0.95;

/// A median, and the interval between two of the values in which the law's own median lies with [`confidence`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Median {
    pub(crate) median: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Median {
    /// `None` without values, or where one is not finite.
    pub(crate) fn of(values: &[f64]) -> Option<Median> {
        if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (n, k) = (sorted.len(), rank(sorted.len()));
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        Some(Median { median, low: sorted[k - 1], high: sorted[n - k] })
    }
}

/// Confidence of the interval of `n` values: [x₍ₖ₎, x₍ₙ₊₁₋ₖ₎] misses the median with probability 2·P(B < k), B being
/// binomial with n and ½ (David & Nagaraja, *Order Statistics*, 2003, §7.1). k is the largest with 95 % or more, else 1.
pub(crate) fn confidence(n: usize) -> f64 {
    coverage(n, rank(n))
}

fn rank(n: usize) -> usize {
    (1..=n / 2).rev().find(|k| coverage(n, *k) >= LEVEL).unwrap_or(1)
}

fn coverage(n: usize, k: usize) -> f64 {
    let mut term = 0.5f64.powi(n as i32);
    let mut below = 0.0;
    for i in 0..k {
        below += term;
        term *= (n - i) as f64 / (i + 1) as f64;
    }
    (1.0 - 2.0 * below).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn intervals_by_hand() {
        // 1 − 2/2ⁿ from the outermost values; of nine the second ones: 1 − 2·(1 + 9)/512
        for (n, expected) in [(1, 0.0), (2, 0.5), (5, 0.9375), (6, 0.968_75), (9, 1.0 - 20.0 / 512.0)] {
            assert!((confidence(n) - expected).abs() < 1e-12, "{n}: {}", confidence(n));
        }
        let of = |values: &[f64]| Median::of(values).unwrap();
        assert_eq!(of(&[3.0]), Median { median: 3.0, low: 3.0, high: 3.0 });
        assert_eq!(of(&[4.0, 1.0]), Median { median: 2.5, low: 1.0, high: 4.0 });
        assert_eq!(of(&[9., 2., 3., 4., 5., 6., 7., 8., 1.]), Median { median: 5.0, low: 2.0, high: 8.0 });
        assert!(Median::of(&[]).is_none() && Median::of(&[1.0, f64::NAN]).is_none());
    }

    /// Share of 4 000 experiments with nine values of a skewed law in which the interval holds `claimed`.
    fn share(claimed: f64) -> f64 {
        let mut rng = Rng::new(5);
        let mut experiment = || -> Vec<f64> { (0..9).map(|_| -(1.0 - rng.f32() as f64).ln()).collect() };
        let holds = |m: Median| m.low <= claimed && claimed <= m.high;
        (0..4000).filter(|_| holds(Median::of(&experiment()).unwrap())).count() as f64 / 4000.0
    }

    #[test]
    fn intervals_hold_the_median_of_a_skewed_law_and_not_another() {
        // median of the exponential law: ln 2. Binomial standard deviation 0.0031; ± 0.016 is five of them (false
        // alarm 1 in 1.7 million)
        let held = share(std::f64::consts::LN_2);
        assert!((held - confidence(9)).abs() < 0.016, "{held}");
        // above 2.5 lie 8 % of all values, so that two of nine do in 17 of 100 experiments
        assert!(share(2.5) < 0.25);
    }
}
