//! How noisy one sample of the picture is, by the picture so far.

use crate::film::accumulate::{Estimate, Film};
use crate::film::alike::mean_of_alike;
use crate::film::blur::mean_without_largest;
use crate::math::luminance;

/// Share of the picture's mean luminance below which darker pixels are no more important.
const FLOOR: f64 = 0.1;

/// The same where guides are judged. relMSE, by which pictures are, has a floor of 0.1, which was 0.06 to 3 of the mean of the
/// scenes measured; a floor of 0.1 of it made a guide that is good at the dark corners of a box alone seem to win.
const JUDGED_FLOOR: f64 = 0.3;

/// Share of the pixels, the noisiest, that have no say in what roulette goes by.
pub const OUTLIERS: f64 = 0.005;

/// What the newest samples say.
pub struct Noise {
    /// Per pixel, the squared luminance that is expected there.
    pub squares: Vec<f64>,
    /// Per pixel, the variance of one sample relative to it.
    pub(super) relative: Vec<f64>,
    /// What is added to `squares` where guides are judged.
    pub(super) floor: f64,
    /// Samples per pixel that the picture holds.
    pub samples: u32,
}

impl Noise {
    /// `None` for a picture that is black, not finite, without noise, or of too few samples to show any.
    pub fn of(film: &Film) -> Option<Noise> {
        let (picture, variances) = rayon::join(|| film.resolve(), || film.sample_variances());
        Noise::weigh(&picture, &variances?)
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
        let floor = (JUDGED_FLOOR.powi(2) - FLOOR.powi(2)) * mean * mean;
        let noise = Noise { squares, relative, floor, samples: estimate.samples };
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

    /// How much samples vary, of which the variance in each pixel is given; with the floor of roulette.
    pub fn spread(&self, variances: &[f64], outliers: f64) -> f64 {
        mean_without_largest(self.relative_to(variances, 0.0), outliers)
    }

    /// The same as it counts where guides are judged.
    pub fn variance_of(&self, variances: &[f64], outliers: f64) -> f64 {
        mean_without_largest(self.relative_to(variances, self.floor), outliers)
    }

    /// Relative standard error of [`Self::variance_of`], pixels being independent: large where a few carry most of it, as
    /// where few paths find the light. 0 where nothing varies.
    pub fn doubt(&self, variances: &[f64], outliers: f64) -> f64 {
        let relative = self.relative_to(variances, self.floor);
        let squares = relative.iter().map(|v| v * v).collect();
        let count = relative.len() as f64;
        let mean = mean_without_largest(relative, outliers);
        if mean == 0.0 {
            return 0.0;
        }
        (mean_without_largest(squares, outliers) / (mean * mean) - 1.0).max(0.0).sqrt() / count.sqrt()
    }

    fn relative_to(&self, variances: &[f64], floor: f64) -> Vec<f64> {
        variances.iter().zip(&self.squares).map(|(v, square)| v / (square + floor)).collect()
    }
}
