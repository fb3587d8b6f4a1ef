//! The samples of some iterations together, and how much they count among others.

use super::blur::{blur, mean_without_largest};
use super::halves::{Halves, wide_luminance};
use super::surplus::Surplus;
use crate::math::{Rgb, luminance};
use glam::DVec3;
use rayon::prelude::*;

/// Pictures weighed against each other must not be told apart by less than rounding.
const MIN_RELATIVE_VARIANCE: f64 = 1e-12;

/// Share of all samples that may be outliers, and as many pixels left out of the average: a few very bright samples
/// are in one group or another by chance, and say little of either. At most so many pixels.
const OUTLIERS: f64 = 1e-4;
const MOST_OUTLIERS: f64 = 0.05;

/// Share of a picture's mean luminance below which darker pixels are no more important.
pub(super) const FLOOR: f64 = 0.1;

/// The variance of a pixel at most, where squares of its samples are beyond an `f32`; the sum of three is not.
const MOST_VARIANCE: f32 = f32::MAX / 4.0;

/// Sums of samples, pixel by pixel.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct IterationGroup {
    /// In double precision: the mean of equal samples is that sample, to the last bit.
    pub(crate) sum: Vec<DVec3>,
    pub(crate) sum_squares: Vec<Rgb>,
    /// The same sums by radiance layer.
    pub(crate) layers: Vec<Vec<DVec3>>,
    /// Per pixel, those that all have, and what some have beyond.
    pub(crate) samples: u32,
    pub(crate) surplus: Surplus,
    /// Number of the first sample, counted over the whole render.
    pub(crate) first: u32,
    pub(crate) halves: Halves,
}

impl IterationGroup {
    pub(crate) fn new(pixels: usize, layers: usize) -> IterationGroup {
        IterationGroup {
            layers: vec![vec![DVec3::ZERO; pixels]; layers],
            sum: vec![DVec3::ZERO; pixels],
            sum_squares: vec![Rgb::ZERO; pixels],
            samples: 0,
            surplus: Surplus::default(),
            first: 0,
            halves: Halves::default(),
        }
    }

    /// Whether it is of so many pixels and layers.
    pub(super) fn fits(&self, pixels: usize, layers: usize) -> bool {
        let sums = [self.sum.len(), self.sum_squares.len()];
        let all = sums.into_iter().chain(self.layers.iter().map(Vec::len));
        let same = all.into_iter().all(|n| n == pixels) && self.layers.len() == layers;
        same && self.surplus.fits(pixels) && self.halves.fits(pixels)
    }

    /// Samples of a pixel.
    #[inline]
    pub(crate) fn count(&self, i: usize) -> u32 {
        self.samples + self.surplus.of(i)
    }

    /// The same on average.
    pub(crate) fn mean_count(&self) -> f64 {
        self.samples as f64 + self.surplus.mean()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.samples == 0 && self.surplus.is_empty()
    }

    /// Both together.
    pub(crate) fn joined(mut self, other: &IterationGroup) -> IterationGroup {
        let add = |sums: &mut Vec<DVec3>, more: &[DVec3]| {
            sums.par_iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        };
        add(&mut self.sum, &other.sum);
        self.layers.iter_mut().zip(&other.layers).for_each(|(sums, more)| add(sums, more));
        self.sum_squares.par_iter_mut().zip(&other.sum_squares).for_each(|(sum, more)| *sum += more);
        self.samples += other.samples;
        self.surplus.add_all(&other.surplus);
        self
    }

    /// Mean and variance of the mean of a pixel; zero without samples. Both are finite where the samples are.
    pub(crate) fn moments(&self, i: usize) -> (Rgb, Rgb) {
        let n = self.count(i).max(1) as f32;
        let mean = (self.sum[i] / n as f64).as_vec3();
        if self.count(i) < 2 {
            return (mean, Rgb::ZERO);
        }
        let spread = self.sum_squares[i] / n - mean * mean;
        let bounded = |v: f32| if v.is_finite() { v.clamp(0.0, MOST_VARIANCE) } else { MOST_VARIANCE };
        (mean, spread.map(bounded) / (n - 1.0))
    }

    /// Mean of a pixel in a radiance layer; zero without samples.
    pub(crate) fn layer_mean(&self, layer: usize, i: usize) -> Rgb {
        (self.layers[layer][i] / self.count(i).max(1) as f64).as_vec3()
    }

    /// The samples that came after those of `before`, of which all pixels had equally many; without radiance layers.
    pub(crate) fn since(&self, before: &IterationGroup) -> IterationGroup {
        IterationGroup {
            sum: self.sum.iter().zip(&before.sum).map(|(all, before)| all - before).collect(),
            sum_squares: self.sum_squares.iter().zip(&before.sum_squares).map(|(all, before)| all - before).collect(),
            layers: Vec::new(),
            samples: self.samples - before.samples,
            surplus: self.surplus.clone(),
            first: self.first + before.samples,
            halves: self.halves.since(&before.sum, before.samples),
        }
    }

    /// The shares of what is before the group and of the group in a pixel, by those of a pixel that has `mean` of its
    /// samples, as many as all have on average. So each sample counts as much, wherever it is.
    #[inline]
    pub(crate) fn shares(&self, i: usize, mean: f64, (old, new): (f32, f32)) -> (f32, f32) {
        match self.count(i) {
            _ if self.surplus.is_empty() => (old, new),
            0 => (1.0, 0.0),
            count => {
                let new = new * (f64::from(count) / mean) as f32;
                (old / (old + new), new / (old + new))
            }
        }
    }

    /// Variance of the luminance of the mean times the number of samples, pixel by pixel; `None` where there are fewer than two.
    /// Where samples are independent it is the variance of one.
    pub(crate) fn sample_variances(&self, width: usize) -> Option<Vec<f64>> {
        let of_one = |(i, v): (usize, f64)| v * self.count(i) as f64;
        (self.samples >= 2).then(|| self.mean_variances(width, |_| true).into_iter().enumerate().map(of_one).collect())
    }

    /// Variance of the luminance of one sample, pixel by pixel; `None` where there are fewer than two. Samples that are spread
    /// evenly have a mean that varies less than this says. Red, green and blue are taken to vary together, as they do in
    /// light of one colour; where they do not it is too much, never too little.
    pub(crate) fn sample_spreads(&self) -> Option<Vec<f64>> {
        let variance = |i: usize| {
            let deviation = wide_luminance(self.moments(i).1.as_dvec3().map(f64::sqrt));
            deviation * deviation * self.count(i) as f64
        };
        (self.samples >= 2).then(|| (0..self.sum.len()).into_par_iter().map(variance).collect())
    }

    /// Variances of the luminance of the means, by those pixels alone that count.
    pub(super) fn mean_variances(&self, width: usize, counts: impl Fn(usize) -> bool + Sync) -> Vec<f64> {
        let spread = (0..self.sum.len()).into_par_iter().map(|i| luminance(self.moments(i).1) as f64).collect();
        self.halves.variances(spread, |i| (self.sum[i], self.count(i)), counts, width)
    }

    /// Inverse of the mean relative variance (Müller 2019 weighs iterations so), for either colour of the
    /// checkerboard from the pixels of the *other*: a pixel's own noise has no say in how much its samples count,
    /// which would bias the picture.
    ///
    /// Relative to `picture`, the best there is: against a mean of its own few samples, one of them very bright, a
    /// pixel would seem hardly noisy at all, and what is noisiest would count far too much.
    ///
    /// `None` where the pixels of the other colour are all black in the group or in `picture`. Such samples have found no
    /// light and tell nothing of how much it varies; their variance of zero is no sign of a good picture.
    pub(crate) fn weights(&self, width: usize, picture: &IterationGroup) -> [Option<f64>; 2] {
        let weight = |colour: usize| {
            let of_colour = |i: &usize| parity(*i, width) == colour;
            if !(0..self.sum.len()).filter(of_colour).any(|i| self.sum[i] != DVec3::ZERO) {
                return None;
            }
            let squares = picture.squares(width, of_colour)?;
            let variances = self.mean_variances(width, |i| of_colour(&i));
            let relative = |i: usize| match variances[i] {
                0.0 => 0.0,
                variance => variance / squares[i],
            };
            let all: Vec<f64> = (0..self.sum.len()).filter(of_colour).map(relative).collect();
            Some(1.0 / mean_without_largest(all, outliers(self.samples.into())).max(MIN_RELATIVE_VARIANCE))
        };
        rayon::join(|| weight(1), || weight(0)).into()
    }

    /// Squares of the luminance about each of the pixels that count, by these alone. They are positive; `None` where all of
    /// these pixels are black.
    fn squares(&self, width: usize, counts: impl Fn(&usize) -> bool + Sync) -> Option<Vec<f64>> {
        let mean = |(i, &sum): (usize, &DVec3)| wide_luminance(sum / f64::from(self.count(i).max(1)));
        let light: Vec<f64> = self.sum.iter().enumerate().map(mean).collect();
        let pixels = (0..light.len()).filter(&counts).count();
        let mean = (0..light.len()).filter(&counts).map(|i| light[i]).sum::<f64>() / pixels.max(1) as f64;
        let square = |l: &f64| l * l + (FLOOR * mean).powi(2);
        (mean > 0.0).then(|| blur(&light, |i| counts(&i), width).iter().map(square).collect())
    }
}

/// Share of the pixels, the noisiest, that are left out of averages, where each has so many samples.
pub(super) fn outliers(samples: f64) -> f64 {
    (OUTLIERS * samples).min(MOST_OUTLIERS)
}

/// Colour of pixel `i` on a checkerboard.
pub(super) fn parity(i: usize, width: usize) -> usize {
    (i % width + i / width) % 2
}
