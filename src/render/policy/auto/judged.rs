//! The noise of samples as it counts where the guide is judged.

use super::super::super::noise::{self, Noise};
use super::evenness::evenness;
use super::pilot::Baseline;
use crate::film::accumulate::Film;
use crate::film::blur::mean_without_largest;

/// Share of the pixels, the noisiest, that have no say in the variance: as in comparisons of pictures, where a few fireflies are not
/// to decide.
const OUTLIERS: f64 = 0.001;

/// Share of the picture's mean luminance below which darker pixels are no more important: that of comparisons by relMSE, whose
/// denominator is (x² + 0.1²), in a picture that is shown with its mean at middle grey, 0.18.
const FLOOR: f64 = 0.1 / 0.18;

/// How the samples of an iteration vary, pixel by pixel.
pub struct Varying {
    /// Variance of the luminance of one, by itself.
    pub spreads: Vec<f64>,
    /// The same of their mean, times their number.
    pub variances: Vec<f64>,
    pub samples: u32,
}

impl Varying {
    /// The newest iteration of a film, of so many samples a pixel; not earlier ones, with which the film may weigh a short one.
    pub fn newest(film: &Film, samples: u32) -> Option<Varying> {
        Some(Varying { spreads: film.newest_spreads()?, variances: film.newest_variances()?, samples })
    }
}

/// Guided samples against unguided ones.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Relative variance of one sample of each, by itself.
    pub unguided: f64,
    pub guided: f64,
    /// Relative standard error of their ratio.
    pub relative_error: f64,
    /// How evenly guided samples are spread.
    pub evenness: f64,
}

impl Comparison {
    pub fn new(noise: &Noise, baseline: &Baseline, guided: &Varying) -> Comparison {
        let errors = [standard_error(noise, &baseline.spreads), standard_error(noise, &guided.spreads)];
        let by_themselves = relative_variance(noise, &guided.spreads);
        Comparison {
            unguided: relative_variance(noise, &baseline.spreads),
            guided: by_themselves,
            relative_error: errors[0].hypot(errors[1]),
            evenness: evenness(relative_variance(noise, &guided.variances) / by_themselves, guided.samples),
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
    let higher = noise.mean.powi(2) * (FLOOR.powi(2) - noise::FLOOR.powi(2));
    variances.iter().zip(&noise.squares).map(|(v, square)| v / (square + higher)).collect()
}
