//! Whether a method's pictures have the reference's mean: one test over all blocks of the picture at once.
//!
//! Runs are independent, the pixels of one run are not (they share a guide, and iterations are weighed together), so
//! that only what differs *between* runs counts as noise; and there are more blocks than runs, so that their covariance
//! cannot be inverted. Läuter, Glimm & Kropf (1996, "New Multivariate Tests for Data with an Inherent Structure") reduce
//! each run to one number: with X the matrix of the blocks' relative differences from the reference, a row for each run,
//! and w the leading eigenvector of XᵀX (sums of products about zero, *not* about the mean), the numbers Xw are tested by
//! Student's t. For normal rows of mean zero that test is exact whatever their covariance, since XᵀX does not change when runs
//! are mixed by a rotation; under a bias, w turns towards it.
//!
//! The reference's own error is the same in all runs. Along a w that knows nothing of it, its variance is wᵀRw; a w that has
//! turned towards it has all of it, tr R. In between stands the share a = min(1, n tr R / |Xw|²) of what was found that
//! the reference can explain: (1 − a) wᵀRw + a tr R is added to the mean's variance. R is diagonal.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Probability with which an unbiased cell is called biased (where runs are about normal; see docs/compare.md).
pub(crate) const ALARM: f64 = 0.01;

/// Fewest runs for a test: the t of one degree of freedom has no power.
const MIN_RUNS: usize = 3;

/// Steps towards the leading eigenvector. The test is exact after any number of them.
const STEPS: usize = 64;

/// What the test found; all `None` where it cannot be made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Bias {
    /// The standard normal number with this p-value, with the sign of the picture's mean difference.
    pub(crate) z: Option<f64>,
    pub(crate) p: Option<f64>,
    /// Whether p is below [`ALARM`].
    pub(crate) biased: Option<bool>,
}

/// Block means of the reference, and the variances of these means.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReferenceBlocks {
    pub(crate) mean: Vec<f64>,
    pub(crate) variance: Vec<f64>,
}

/// Tests `runs`, the block means of each run, against the reference.
pub(crate) fn test(runs: &[&[f64]], reference: &ReferenceBlocks) -> Bias {
    let (n, blocks) = (runs.len(), reference.mean.len());
    let overall = reference.mean.iter().sum::<f64>() / blocks.max(1) as f64;
    let usable = runs.iter().all(|r| r.len() == blocks && r.iter().all(|x| x.is_finite()));
    if n < MIN_RUNS || !usable || overall.is_nan() || overall <= 0.0 {
        return Bias::default();
    }
    // Relative to the block, and not to less than the picture's mean: dark blocks have no more say than others.
    let scale: Vec<f64> = reference.mean.iter().map(|m| 1.0 / (m + overall)).collect();
    let relative =
        |run: &&[f64]| -> Vec<f64> { (0..blocks).map(|k| (run[k] - reference.mean[k]) * scale[k]).collect() };
    let differences: Vec<Vec<f64>> = runs.iter().map(relative).collect();
    let own: Vec<f64> = reference.variance.iter().zip(&scale).map(|(v, s)| v * s * s).collect();
    let p = p_value(&differences, &own);
    let sign = differences.iter().flatten().sum::<f64>().signum();
    Bias { z: Some(sign * normal(p)), p: Some(p), biased: Some(p < ALARM) }
}

/// Of no bias, by differences (a row for each run) and the variances of the reference's part in them.
fn p_value(differences: &[Vec<f64>], own: &[f64]) -> f64 {
    let n = differences.len() as f64;
    let weights = leading(differences);
    let scores: Vec<f64> = differences.iter().map(|d| dot(d, &weights)).collect();
    let length = dot(&scores, &scores);
    if length == 0.0 {
        return 1.0;
    }
    let mean = scores.iter().sum::<f64>() / n;
    let variance = scores.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let total: f64 = own.iter().sum();
    let along: f64 = own.iter().zip(&weights).map(|(v, w)| v * w * w).sum();
    let explained = (n * total / length).min(1.0);
    let noise = variance / n + (1.0 - explained) * along + explained * total;
    let t = mean.abs() / noise.sqrt();
    match StudentsT::new(0.0, 1.0, n - 1.0) {
        Ok(law) if t.is_finite() => 2.0 * law.sf(t),
        _ => 0.0,
    }
}

/// The unit vector that XᵀX stretches most, by powers of it. They begin with the same weight for all blocks: a function of XᵀX
/// alone, as the test asks for.
fn leading(rows: &[Vec<f64>]) -> Vec<f64> {
    let blocks = rows[0].len();
    let mut weights = vec![1.0; blocks];
    for _ in 0..STEPS {
        let scores: Vec<f64> = rows.iter().map(|row| dot(row, &weights)).collect();
        let next: Vec<f64> = (0..blocks).map(|k| rows.iter().zip(&scores).map(|(row, s)| row[k] * s).sum()).collect();
        let length = dot(&next, &next).sqrt();
        if length == 0.0 {
            break;
        }
        weights = next.into_iter().map(|w| w / length).collect();
    }
    weights
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The z that a standard normal number exceeds in size with probability `p`; at most 38, where doubles end.
fn normal(p: f64) -> f64 {
    let law = Normal::standard();
    if p <= 0.0 { 38.0 } else { -law.inverse_cdf(0.5 * p) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    const BLOCKS: usize = 64;

    /// About normal, variance 1.
    fn noise(rng: &mut Rng) -> f64 {
        (0..12).map(|_| rng.f32() as f64).sum::<f64>() - 6.0
    }

    /// A run's blocks: brightnesses from 0.2 to 5, 2 % of noise of their own and 0.5 % that all share.
    fn picture(rng: &mut Rng, bias: impl Fn(usize) -> f64, spread: f64) -> Vec<f64> {
        let shared = 0.25 * noise(rng);
        let level = |k: usize| 0.2 * 25f64.powf(k as f64 / BLOCKS as f64);
        (0..BLOCKS).map(|k| level(k) * (1.0 + bias(k) + spread * (noise(rng) + shared))).collect()
    }

    /// Share of experiments with `runs` runs in which a bias is found.
    fn alarms(experiments: usize, runs: usize, bias: impl Fn(usize) -> f64 + Copy) -> f64 {
        let mut rng = Rng::new(3);
        let hits = (0..experiments).filter(|_| {
            let exact: Vec<f64> = picture(&mut rng, |_| 0.0, 0.0);
            let reference = ReferenceBlocks {
                mean: picture(&mut rng, |_| 0.0, 0.001),
                variance: exact.iter().map(|m| (0.001 * m).powi(2) * (1.0 + 0.0625)).collect(),
            };
            let pictures: Vec<Vec<f64>> = (0..runs).map(|_| picture(&mut rng, bias, 0.02)).collect();
            let views: Vec<&[f64]> = pictures.iter().map(Vec::as_slice).collect();
            test(&views, &reference).biased == Some(true)
        });
        hits.count() as f64 / experiments as f64
    }

    #[test]
    fn no_bias_is_found_about_as_often_as_said() {
        // 1 % is claimed; five standard deviations of a share of 2 000 are 1.1 %: false alarm 1 in 1.7 million each
        for runs in [3, 5, 10] {
            let share = alarms(2000, runs, |_| 0.0);
            assert!((0.0005..=0.021).contains(&share), "{share} of false alarms with {runs} runs");
        }
    }

    #[test]
    fn a_bias_of_one_per_cent_is_found() {
        let few = alarms(500, 5, |_| 0.01);
        assert!(few > 0.3, "{few} with five runs");
        let sure = alarms(500, 10, |_| 0.01);
        assert!(sure > 0.8, "{sure} with ten runs");
        // brighter here and darker there: the picture's mean shows nothing of it
        let patchy = alarms(500, 10, |k| if k % 2 == 0 { 0.015 } else { -0.015 });
        assert!(patchy > 0.95, "{patchy} of a bias that cancels");
    }

    #[test]
    fn an_error_of_the_reference_is_not_taken_for_bias() {
        let mut rng = Rng::new(9);
        let level = picture(&mut rng, |_| 0.0, 0.0);
        let found = |variance: f64, rng: &mut Rng| {
            let mean = level.iter().map(|m| m * (1.0 + 0.01 * noise(rng))).collect();
            let reference = ReferenceBlocks { mean, variance: level.iter().map(|m| (variance * m).powi(2)).collect() };
            let pictures: Vec<Vec<f64>> = (0..20).map(|_| picture(rng, |_| 0.0, 0.002)).collect();
            let views: Vec<&[f64]> = pictures.iter().map(Vec::as_slice).collect();
            test(&views, &reference).biased == Some(true)
        };
        // 500 pictures at the claimed 1 %: 5 ± 2.2, five standard deviations above is 16
        let known = (0..500).filter(|_| found(0.01, &mut rng)).count();
        let unknown = (0..500).filter(|_| found(0.0, &mut rng)).count();
        assert!(known <= 16 && unknown > 450, "{known} alarms where its noise is known, {unknown} where not");
    }

    #[test]
    fn what_cannot_be_tested_is_not() {
        let reference = ReferenceBlocks { mean: vec![1.0; 4], variance: vec![0.0; 4] };
        let runs = [[1.0, 1.1, 0.9, 1.0], [1.1, 1.0, 1.0, 0.9], [0.9, 0.9, 1.1, 1.1]];
        let views: Vec<&[f64]> = runs.iter().map(|r| &r[..]).collect();
        assert_eq!(test(&views[..2], &reference), Bias::default());
        assert_eq!(test(&views, &ReferenceBlocks { mean: vec![0.0; 4], ..reference.clone() }), Bias::default());
        assert!(test(&views, &reference).p.unwrap() > 0.9);
        let equal = [&[1.0; 4][..]; 3];
        assert_eq!(test(&equal, &reference).p, Some(1.0));
        let off = [&[1.5; 4][..]; 3];
        let found = test(&off, &reference);
        assert_eq!((found.biased, found.z), (Some(true), Some(38.0)));
        // three numbers of one block: mean 0.1, standard error 0.05/√3, t = 2√3 with two degrees of freedom
        let rows = [vec![0.05], vec![0.1], vec![0.15]];
        assert!((p_value(&rows, &[0.0]) - 0.074_18).abs() < 1e-5, "{}", p_value(&rows, &[0.0]));
    }
}
