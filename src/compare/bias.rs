//! Whether a method's pictures have the reference's mean: one test over all blocks of the picture at once.
//!
//! Runs are independent, the pixels of one run are not (they share a guide, and iterations are weighed together), so
//! that only what differs *between* runs counts as noise. With d_i the vector of the blocks' relative differences from the
//! reference in run i of n, d their mean, S their covariance matrix, and R that of the reference's own error,
//!
//! F = |d|² / (tr S/n + tr R)
//!
//! has expectation 1 if there is no bias, whatever the blocks' correlation. Dempster (1958, "A High Dimensional Two Sample
//! Significance Test"; Bai & Saranadasa 1996, §2) compares it with Fisher's distribution of r and (n − 1)r degrees of
//! freedom, r = (tr S)²/tr S² being the number of blocks that vary independently; there are more blocks than runs, so
//! that Hotelling's test does not exist.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal};

/// Probability with which an unbiased cell is called biased (where runs are about normal; see docs/compare.md).
pub const ALARM: f64 = 0.001;

/// Fewest runs for a test: with two there is no telling how many blocks vary independently.
const MIN_RUNS: usize = 3;

/// What the test found; all `None` where it cannot be made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bias {
    /// The standard normal number with this p-value, with the sign of the picture's mean difference.
    pub z: Option<f64>,
    pub p: Option<f64>,
    /// Whether p is below [`ALARM`].
    pub biased: Option<bool>,
}

/// Block means of the reference, and the variances of these means.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceBlocks {
    pub mean: Vec<f64>,
    pub variance: Vec<f64>,
}

/// Tests `runs`, the block means of each run, against the reference.
pub fn test(runs: &[&[f64]], reference: &ReferenceBlocks) -> Bias {
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
    let mean: Vec<f64> = (0..blocks).map(|k| differences.iter().map(|d| d[k]).sum::<f64>() / n as f64).collect();
    let own: f64 = reference.variance.iter().zip(&scale).map(|(v, s)| v * s * s).sum();
    let (trace, freedom) = spread(&differences, &mean);
    let noise = trace / n as f64 + own;
    let found = mean.iter().map(|d| d * d).sum::<f64>() / noise;
    let p = match FisherSnedecor::new(freedom, (n - 1) as f64 * freedom) {
        Ok(law) if noise > 0.0 => law.sf(found),
        _ if found.is_nan() => 1.0, // no difference and no noise
        _ => 0.0,
    };
    let sign = mean.iter().sum::<f64>().signum();
    Bias { z: Some(sign * normal(p)), p: Some(p), biased: Some(p < ALARM) }
}

/// tr S, and how many blocks vary independently: (tr S)²/tr S², with the unbiased estimate of tr S² of Bai & Saranadasa
/// (1996), which lies between (tr S)²/blocks and (tr S)² like what it estimates.
fn spread(differences: &[Vec<f64>], mean: &[f64]) -> (f64, f64) {
    let freedom = (differences.len() - 1) as f64;
    let centred: Vec<Vec<f64>> = differences.iter().map(|d| d.iter().zip(mean).map(|(d, m)| d - m).collect()).collect();
    let dot = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let trace = centred.iter().map(|c| dot(c, c)).sum::<f64>() / freedom;
    let pairs = centred.iter().flat_map(|a| centred.iter().map(move |b| dot(a, b).powi(2)));
    let of_square = pairs.sum::<f64>() / (freedom * freedom);
    let unbiased = freedom * freedom / ((freedom + 2.0) * (freedom - 1.0)) * (of_square - trace * trace / freedom);
    if trace <= 0.0 {
        return (0.0, 1.0);
    }
    (trace, (trace * trace / unbiased.max(0.0)).clamp(1.0, mean.len() as f64))
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
                mean: picture(&mut rng, |_| 0.0, 0.002),
                variance: exact.iter().map(|m| (0.002 * m).powi(2) * (1.0 + 0.0625)).collect(),
            };
            let pictures: Vec<Vec<f64>> = (0..runs).map(|_| picture(&mut rng, bias, 0.02)).collect();
            let views: Vec<&[f64]> = pictures.iter().map(Vec::as_slice).collect();
            test(&views, &reference).biased == Some(true)
        });
        hits.count() as f64 / experiments as f64
    }

    #[test]
    fn no_bias_is_found_about_as_often_as_said() {
        // 0.1 % is claimed. Twice that in 8 000 experiments is 16 alarms where 8 are expected, and up to 24 of at most
        // 12 expected would be a claim wrong by half; beyond 24 with 8 expected: false alarm about 1 in 500 000.
        for runs in [3, 5, 10] {
            let share = alarms(8000, runs, |_| 0.0);
            assert!(share <= 24.0 / 8000.0, "{share} of false alarms with {runs} runs");
        }
    }

    #[test]
    fn a_bias_of_one_per_cent_is_found() {
        let share = alarms(500, 5, |_| 0.01);
        assert!(share > 0.5, "{share} of one per cent everywhere");
        let sure = alarms(500, 10, |_| 0.01);
        assert!(sure > 0.95, "{sure} with ten runs");
        // brighter here and darker there: the picture's mean shows nothing of it
        let patchy = alarms(500, 10, |k| if k % 2 == 0 { 0.015 } else { -0.015 });
        assert!(patchy > 0.95, "{patchy} of a bias that cancels");
    }

    #[test]
    fn what_cannot_be_tested_is_not() {
        let reference = ReferenceBlocks { mean: vec![1.0; 4], variance: vec![0.0; 4] };
        let runs = [[1.0, 1.1, 0.9, 1.0], [1.1, 1.0, 1.0, 0.9], [0.9, 1.0, 1.1, 1.0]];
        let views: Vec<&[f64]> = runs.iter().map(|r| &r[..]).collect();
        assert_eq!(test(&views[..2], &reference), Bias::default());
        assert_eq!(test(&views, &ReferenceBlocks { mean: vec![0.0; 4], ..reference.clone() }), Bias::default());
        assert!(test(&views, &reference).p.unwrap() > 0.9);
        let equal = [&[1.0; 4][..]; 3];
        assert_eq!(test(&equal, &reference).p, Some(1.0));
        let off = [&[1.5; 4][..]; 3];
        let found = test(&off, &reference);
        assert_eq!((found.biased, found.z), (Some(true), Some(38.0)));
    }
}
