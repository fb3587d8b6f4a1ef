//! The noise of samples as it counts where the guide is judged.

use super::super::super::noise::{FLOOR, Noise};
use super::pilot::Baseline;
use crate::film::blur::mean_without_largest;

/// Share of the picture's mean luminance below which darker pixels are no more important to the judgement. relMSE, by which
/// pictures are compared, has an absolute floor of 0.1, which was 0.06 to 3 times the mean of the scenes measured. Fitted: with
/// 0.1 of the mean, a guide that helps in the dark corners of a box alone seemed to win.
const JUDGED_FLOOR: f64 = 0.3;

/// Share of the pixels that may be outliers, times the samples of a pixel: such pixels have no say in the variance. Few
/// samples and many then see as much of a long tail.
const OUTLIERS_PER_SAMPLE: f64 = 1e-4;

/// Share of the pixels that are outliers at most, however many samples there are: what a guide seldom looks for is in the
/// tail of its samples, and in the picture. Fitted on a box whose guide lost a fifth and otherwise seemed to win.
const MAX_OUTLIERS: f64 = 0.05;

/// Share of the pixels that are outliers after so many samples per pixel.
pub fn outliers(samples: f64) -> f64 {
    (OUTLIERS_PER_SAMPLE * samples).min(MAX_OUTLIERS)
}

/// Guided samples against unguided ones.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Relative variance of one sample of each.
    pub unguided: f64,
    pub guided: f64,
    /// Relative standard error of their ratio.
    pub relative_error: f64,
    /// As `unguided`, with the lower floor that roulette has.
    pub spread: f64,
}

impl Comparison {
    /// `variances` are those of one guided sample, pixel by pixel, of `samples` in each.
    pub fn new(noise: &Noise, baseline: &Baseline, variances: &[f64], samples: f64) -> Comparison {
        let unguided_outliers = outliers(baseline.samples as f64);
        let guided_outliers = unguided_outliers.min(outliers(samples));
        let errors = [
            standard_error(noise, &baseline.variances, unguided_outliers),
            standard_error(noise, variances, guided_outliers),
        ];
        Comparison {
            unguided: relative_variance(noise, &baseline.variances, unguided_outliers),
            guided: relative_variance(noise, variances, guided_outliers),
            relative_error: errors[0].hypot(errors[1]),
            spread: mean_without_largest(relative(noise, &baseline.variances, 0.0), unguided_outliers),
        }
    }
}

/// Average over the pixels of `variances`, those of one sample, relative to the picture, with the judgement's floor.
pub fn relative_variance(noise: &Noise, variances: &[f64], outliers: f64) -> f64 {
    mean_without_largest(relative(noise, variances, extra_floor(noise)), outliers)
}

/// Relative standard error of [`relative_variance`], pixels being independent: large where a few pixels carry most of it, as
/// where few paths find the light. 0 where nothing varies.
fn standard_error(noise: &Noise, variances: &[f64], outliers: f64) -> f64 {
    let relative = relative(noise, variances, extra_floor(noise));
    let squares = relative.iter().map(|v| v * v).collect();
    let count = relative.len() as f64;
    let mean = mean_without_largest(relative, outliers);
    if mean == 0.0 {
        return 0.0;
    }
    (mean_without_largest(squares, outliers) / (mean * mean) - 1.0).max(0.0).sqrt() / count.sqrt()
}

/// What the judgement's floor adds to the squared luminances of `noise`, which have roulette's.
fn extra_floor(noise: &Noise) -> f64 {
    (JUDGED_FLOOR.powi(2) - FLOOR.powi(2)) * noise.mean * noise.mean
}

fn relative(noise: &Noise, variances: &[f64], floor: f64) -> Vec<f64> {
    variances.iter().zip(&noise.squares).map(|(v, square)| v / (square + floor)).collect()
}
