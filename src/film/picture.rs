//! Groups of iterations as one picture.

use super::group::{IterationGroup, parity};
use super::surplus::Surplus;
use crate::film::RadianceLayer;
use crate::film::accumulate::{Estimate, PictureIds};
use crate::math::Rgb;
use rayon::prelude::*;

/// Groups weighed together.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Picture {
    pub(super) mean: Vec<Rgb>,
    /// Of the means.
    pub(super) variance: Vec<Rgb>,
    /// Of the luminance of the means, by halves of the samples; empty where nobody asks.
    pub(super) halved_variance: Vec<f32>,
    /// Means by radiance layer.
    pub(super) layers: Vec<Vec<Rgb>>,
    /// Sum of weights, for the black and the white squares of a checkerboard over the pixels. They are counts of samples
    /// where all groups so far told nothing of their noise.
    weight: [f64; 2],
    /// Whether a group has told something.
    told: [bool; 2],
    /// Per pixel, those that all have, and what some have beyond.
    pub(super) samples: u32,
    pub(super) surplus: Surplus,
}

impl Picture {
    pub(super) fn new(pixels: usize, layers: usize) -> Picture {
        Picture {
            mean: vec![Rgb::ZERO; pixels],
            variance: vec![Rgb::ZERO; pixels],
            halved_variance: Vec::new(),
            layers: vec![vec![Rgb::ZERO; pixels]; layers],
            weight: [0.0; 2],
            told: [false; 2],
            samples: 0,
            surplus: Surplus::default(),
        }
    }

    /// The same, which tells how its means vary by halves of their samples too if `tells`.
    pub(super) fn that_tells_its_error(mut self, tells: bool) -> Picture {
        self.halved_variance = if tells { vec![0.0; self.mean.len()] } else { Vec::new() };
        self
    }

    pub(super) fn tells_error(&self) -> bool {
        !self.halved_variance.is_empty()
    }

    /// Samples of a pixel.
    pub(super) fn count(&self, i: usize) -> u32 {
        self.samples + self.surplus.of(i)
    }

    /// Says how many samples each pixel has.
    pub(super) fn set_counts(&mut self, counts: Vec<u32>) {
        self.surplus = Surplus::of_counts(counts);
        self.samples = self.surplus.level();
    }

    /// Whether it is of so many pixels and layers.
    pub(super) fn fits(&self, pixels: usize, layers: usize) -> bool {
        let all = [self.mean.len(), self.variance.len()].into_iter().chain(self.layers.iter().map(Vec::len));
        let halved = [0, pixels].contains(&self.halved_variance.len());
        all.into_iter().all(|n| n == pixels) && halved && self.layers.len() == layers && self.surplus.fits(pixels)
    }

    /// As an estimate without features.
    pub(super) fn estimate(self, [width, height]: [u32; 2], layers: &[RadianceLayer]) -> Estimate {
        let Picture { samples, surplus, mean, variance, .. } = self;
        let counts = (0..mean.len()).map(|i| samples + surplus.of(i));
        Estimate {
            width,
            height,
            samples: samples + surplus.mean() as u32,
            counts: if surplus.is_empty() { Vec::new() } else { counts.collect() },
            mean,
            variance,
            layers: layers.iter().copied().zip(self.layers).collect(),
            features: Vec::new(),
            ids: PictureIds::default(),
        }
    }

    /// Samples of a pixel on average.
    fn mean_count(&self) -> f64 {
        f64::from(self.samples) + self.surplus.mean()
    }

    /// Joins the picture of another render, by the weights that both have for each colour of the checkerboard: sums over
    /// their groups, to which a pixel's own noise has added nothing. By their numbers of samples, if `by_samples` or one of
    /// them knows nothing of its noise. A pixel's own number of samples counts unless all are `alike`.
    pub(super) fn join(&mut self, other: &Picture, width: u32, [by_samples, alike]: [bool; 2]) {
        let counts = [self.mean_count(), other.mean_count()];
        let weights = [0, 1].map(|colour| match by_samples || !(self.told[colour] && other.told[colour]) {
            true => counts,
            false => [self.weight[colour], other.weight[colour]],
        });
        // a pixel with more samples than others counts as much more
        let share = |count: u32, mean: f64| match alike {
            true => f64::from(count.min(1)),
            false if mean > 0.0 => f64::from(count) / mean,
            false => 0.0,
        };
        let shares: Vec<f32> = (0..self.mean.len())
            .into_par_iter()
            .map(|i| {
                let [old, new] = weights[parity(i, width as usize)];
                let old = old * share(self.count(i), counts[0]);
                let new = new * share(other.count(i), counts[1]);
                if new > 0.0 { (new / (old + new)) as f32 } else { 0.0 }
            })
            .collect();
        let mix = |own: &mut [Rgb], others: &[Rgb]| {
            let pixels = own.par_iter_mut().zip(others).zip(&shares);
            pixels.for_each(|((own, other), share)| *own += (*other - *own) * *share);
        };
        mix(&mut self.mean, &other.mean);
        self.layers.iter_mut().zip(&other.layers).for_each(|(own, other)| mix(own, other));
        let variances = self.variance.par_iter_mut().zip(&other.variance).zip(&shares);
        variances.for_each(|((own, other), share)| *own = *own * (1.0 - share).powi(2) + *other * share.powi(2));
        for colour in [0, 1] {
            self.told[colour] &= other.told[colour];
            self.weight[colour] =
                if self.told[colour] { self.weight[colour] + other.weight[colour] } else { counts[0] + counts[1] };
        }
        self.samples += other.samples;
        self.surplus.add_all(&other.surplus);
    }

    pub(super) fn weigh_in(&mut self, width: u32, group: &IterationGroup, weights: [Option<f64>; 2]) {
        let (held, mean_count) = (self.samples, group.mean_count());
        let shares = [0, 1].map(|colour| self.add_weight(colour, weights[colour], mean_count));
        self.mean.par_iter_mut().zip(&mut self.variance).enumerate().for_each(|(i, (mean, variance))| {
            let (old, new) = group.shares(i, mean_count, shares[parity(i, width as usize)]);
            let (newer, mut newer_variance) = group.moments(i);
            if group.count(i) == 1 {
                // one sample does not tell how it varies; those before it do, where they are several
                newer_variance = (*variance * held as f32).min(Rgb::MAX);
            }
            // steps towards the new mean: equal ones stay what they are to the last bit
            *mean += (newer - *mean) * new;
            *variance = *variance * old.powi(2) + newer_variance * new.powi(2);
        });
        if self.tells_error() {
            self.weigh_in_halves(width, group, shares);
        }
        for (layer, means) in self.layers.iter_mut().enumerate() {
            means.par_iter_mut().enumerate().for_each(|(i, mean)| {
                let (_, new) = group.shares(i, mean_count, shares[parity(i, width as usize)]);
                *mean += (group.layer_mean(layer, i) - *mean) * new;
            });
        }
        self.samples += group.samples;
        self.surplus.add_all(&group.surplus);
    }

    /// As [`Self::weigh_in`], how the mean varies: groups are weighed by the pixels of the other colour, so that those of a pixel are
    /// weights that its own noise has no say in, and the variance of a weighted mean is known.
    fn weigh_in_halves(&mut self, width: u32, group: &IterationGroup, shares: [(f32, f32); 2]) {
        let (held, mean_count) = (self.samples, group.mean_count());
        let newest = group.mean_variances(width as usize, |_| true);
        self.halved_variance.par_iter_mut().zip(newest).enumerate().for_each(|(i, (variance, newer))| {
            let (old, new) = group.shares(i, mean_count, shares[parity(i, width as usize)]);
            // one sample does not tell how it varies; those before it do, where they are several
            let newer = if group.count(i) == 1 { *variance * held as f32 } else { newer as f32 };
            *variance = *variance * old.powi(2) + newer.min(f32::MAX) * new.powi(2);
        });
    }

    /// Adds the weight of a group to that of the groups before it, and returns the shares of those and of the group in both
    /// together; `samples` are its samples of a pixel on average. A group that tells nothing of its noise counts as if its
    /// samples varied as those of the others do on average.
    fn add_weight(&mut self, colour: usize, weight: Option<f64>, samples: f64) -> (f32, f32) {
        let before = self.samples as f64 + self.surplus.mean();
        let new = match (weight, self.told[colour]) {
            (Some(weight), true) => weight,
            (Some(weight), false) => {
                self.weight[colour] = before * weight / samples;
                weight
            }
            (None, true) => samples * self.weight[colour] / before,
            (None, false) => samples,
        };
        self.told[colour] |= weight.is_some();
        let (old, total) = (self.weight[colour], self.weight[colour] + new);
        self.weight[colour] = total;
        ((old / total) as f32, (new / total) as f32)
    }

    /// Takes the pixels of an earlier picture where the newest group, all that it holds, has no samples.
    pub(super) fn fill_in(&mut self, before: Picture, newest: &IterationGroup) {
        if newest.surplus.is_empty() {
            return;
        }
        let pixels = self.mean.len();
        for i in (0..pixels).filter(|&i| newest.count(i) == 0) {
            (self.mean[i], self.variance[i]) = (before.mean[i], before.variance[i]);
            if let Some((own, variance)) = self.halved_variance.get_mut(i).zip(before.halved_variance.get(i)) {
                *own = *variance;
            }
            self.layers.iter_mut().zip(&before.layers).for_each(|(means, before)| means[i] = before[i]);
            self.surplus.add(i..i + 1, before.samples, pixels);
        }
    }
}
