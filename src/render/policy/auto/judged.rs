//! The noise of samples as it counts where the guide is judged.

use super::super::super::noise::Noise;
use super::pilot::Baseline;
use crate::film::blur::mean_without_largest;

/// Share of the pixels, the noisiest, that have no say in the variance: as in comparisons of pictures, where a few fireflies are not
/// to decide.
const OUTLIERS: f64 = 0.001;

/// Guided samples against unguided ones.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Relative variance of one sample of each.
    pub unguided: f64,
    pub guided: f64,
    /// Relative standard error of their ratio.
    pub relative_error: f64,
}

impl Comparison {
    /// `variances` are those of one guided sample, pixel by pixel.
    pub fn new(noise: &Noise, baseline: &Baseline, variances: &[f64]) -> Comparison {
        let errors = [standard_error(noise, &baseline.variances), standard_error(noise, variances)];
        Comparison {
            unguided: relative_variance(noise, &baseline.variances),
            guided: relative_variance(noise, variances),
            relative_error: errors[0].hypot(errors[1]),
        }
    }
}

/// Average over the pixels of `variances`, those of one sample, relative to the picture.
pub fn relative_variance(noise: &Noise, variances: &[f64]) -> f64 {
    mean_without_largest(relative(noise, variances), OUTLIERS)
}

/// Relative standard error of [`relative_variance`], pixels being independent: large where a few pixels carry most of it, as
/// where few paths find the light. 0 where nothing varies.
fn standard_error(noise: &Noise, variances: &[f64]) -> f64 {
    let relative = relative(noise, variances);
    let squares = relative.iter().map(|v| v * v).collect();
    let count = relative.len() as f64;
    let mean = mean_without_largest(relative, OUTLIERS);
    if mean == 0.0 {
        return 0.0;
    }
    (mean_without_largest(squares, OUTLIERS) / (mean * mean) - 1.0).max(0.0).sqrt() / count.sqrt()
}

fn relative(noise: &Noise, variances: &[f64]) -> Vec<f64> {
    variances.iter().zip(&noise.squares).map(|(v, square)| v / square).collect()
}
