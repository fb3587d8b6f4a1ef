//! How noisy one sample of the picture is, by the picture so far.

use crate::film::accumulate::{Estimate, Film};
use crate::film::alike::mean_of_alike;
use crate::film::blur::mean_without_largest;
use crate::math::luminance;

/// Share of the picture's mean luminance below which darker pixels are no more important.
pub const FLOOR: f64 = 0.1;

/// Share of the pixels, the noisiest, that are left out of the average that roulette uses.
pub const OUTLIERS: f64 = 0.005;

/// What the newest samples say.
pub struct Noise {
    /// Per pixel, the squared luminance that is expected there, with a floor of [`FLOOR`].
    pub squares: Vec<f64>,
    /// Per pixel, the variance of one sample relative to it.
    pub relative: Vec<f64>,
    /// Mean luminance of the picture.
    pub mean: f64,
    /// Samples per pixel that the picture holds.
    pub samples: u32,
}

impl Noise {
    /// `None` for a picture that is black, not finite, without noise, or of too few samples to show any.
    pub fn of(film: &Film) -> Option<Noise> {
        let (picture, variances) = rayon::join(|| film.resolve(), || film.sample_variances());
        Noise::weigh(&picture, &variances?)
    }

    /// The same with the variance of samples by themselves, however they are spread: what a part of their light can be held
    /// against of which no more is known.
    pub fn of_samples(film: &Film) -> Option<Noise> {
        Noise::weigh(&film.resolve(), &film.sample_spreads()?)
    }

    /// `variances` are those of one sample of each pixel.
    pub(super) fn weigh(estimate: &Estimate, variances: &[f64]) -> Option<Noise> {
        let light: Vec<f64> = estimate.mean.iter().map(|&c| luminance(c) as f64).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let own: Vec<f64> = estimate.variance.iter().map(|&v| luminance(v) as f64).collect();
        let expected = mean_of_alike(&light, &own, mean, estimate.width as usize);
        let squares: Vec<f64> = expected.iter().map(|l| l * l + (FLOOR * mean).powi(2)).collect();
        let relative = variances.iter().zip(&squares).map(|(v, square)| v / square).collect();
        let noise = Noise { squares, relative, mean, samples: estimate.samples };
        (noise.variance(OUTLIERS) > 0.0).then_some(noise)
    }

    /// Variance of one sample, relative to the picture, on average over the pixels but for a share of the noisiest.
    pub fn variance(&self, outliers: f64) -> f64 {
        mean_without_largest(self.relative.clone(), outliers)
    }

    /// Variance of one sample of the picture, pixel by pixel.
    pub fn variances(&self) -> Vec<f64> {
        self.relative.iter().zip(&self.squares).map(|(v, square)| v * square).collect()
    }
}
