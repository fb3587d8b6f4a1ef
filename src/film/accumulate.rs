//! The film: sums of samples, iteration by iteration, and how iterations become one picture.

use super::group::{IterationGroup, parity};
use super::surplus::Surplus;
use super::tile::{Aovs, Tile, TileSamples};
use crate::film::{Combine, RadianceLayer};
use crate::math::Rgb;
use rayon::prelude::*;

/// Samples for which albedo, normal and depth are averaged; they have little noise.
pub(crate) const FEATURE_SAMPLES: u32 = 32;

/// Iterations are weighed in groups of at least this many samples per pixel: the variance of fewer says little.
const MIN_GROUP: u32 = 4;

/// Bytes that a render holds for each pixel, and that writing its pictures takes: 160 were measured without a
/// guide and 230 with one, which the test `a_render_takes_the_memory_that_is_said` does again.
pub const BYTES_PER_PIXEL: u64 = 256;

/// As many more for each radiance layer: sums in double precision thrice (of the group, and before it), and the mean twice.
pub(crate) const BYTES_PER_LAYER: u64 = 96;

/// Accumulates what tiles bring back. Memory is constant in the number of samples.
#[derive(Clone, Debug)]
pub(crate) struct Film {
    width: u32,
    height: u32,
    combine: Combine,
    /// Those of the groups and of the picture.
    layers: Vec<RadianceLayer>,
    group: IterationGroup,
    /// State of the group at the start of the current iteration, if the group spans several iterations.
    before: Option<IterationGroup>,
    /// The previous group. Its weight is computed once the next group exists, against whose picture its noise is measured.
    pending: Option<IterationGroup>,
    /// Of the groups before these.
    picture: Picture,
    features: Vec<Aovs>,
    feature_samples: u32,
    feature_surplus: Surplus,
}

/// Groups weighed together.
#[derive(Clone, Debug, Default)]
struct Picture {
    mean: Vec<Rgb>,
    /// Of the means.
    variance: Vec<Rgb>,
    /// Means by radiance layer.
    layers: Vec<Vec<Rgb>>,
    /// Sum of weights, for the black and the white squares of a checkerboard over the pixels. They are counts of samples
    /// where all groups so far told nothing of their noise.
    weight: [f64; 2],
    /// Whether a group has told something.
    told: [bool; 2],
    /// Per pixel, those that all have, and what some have beyond.
    samples: u32,
    surplus: Surplus,
}

/// A picture with what is known of its noise.
#[derive(Clone, Debug)]
pub struct Estimate {
    pub width: u32,
    pub height: u32,
    pub mean: Vec<Rgb>,
    /// Variance of `mean`, estimated from the samples; zero where there were fewer than two.
    pub variance: Vec<Rgb>,
    /// Samples per pixel that the picture holds; where pixels differ, on average, rounded down.
    pub samples: u32,
    /// The same pixel by pixel, where they differ because rendering ended in the middle of a pass; else empty. A pixel
    /// without any is black.
    pub counts: Vec<u32>,
    /// Means of the light in each radiance layer, in the order in which they were asked for.
    pub layers: Vec<(RadianceLayer, Vec<Rgb>)>,
    /// Means of what the camera sees first.
    pub features: Vec<Aovs>,
}

impl Estimate {
    /// Samples of a pixel.
    pub fn count(&self, pixel: usize) -> u32 {
        self.counts.get(pixel).copied().unwrap_or(self.samples)
    }

    /// The fewest samples of a pixel, the most, and how many pixels have none.
    pub fn spread(&self) -> (u32, u32, usize) {
        let all = || (0..self.mean.len()).map(|i| self.count(i));
        (all().min().unwrap_or(0), all().max().unwrap_or(0), all().filter(|&n| n == 0).count())
    }
}

impl Film {
    /// A film with these radiance layers, which `TileSamples` bring in the same order.
    pub(crate) fn new(width: u32, height: u32, combine: Combine, layers: &[RadianceLayer]) -> Film {
        let pixels = width as usize * height as usize;
        Film {
            width,
            height,
            combine,
            layers: layers.to_vec(),
            group: IterationGroup::new(pixels, layers.len()),
            before: None,
            pending: None,
            picture: Picture::new(pixels, layers.len()),
            features: vec![Aovs::default(); pixels],
            feature_samples: 0,
            feature_surplus: Surplus::default(),
        }
    }

    /// Adds what was sampled in a tile. Call `add_samples` once all pixels have theirs, or `add_samples_in` for the tile.
    pub(crate) fn add(&mut self, tile: &Tile, samples: &TileSamples) {
        for y in 0..tile.height {
            let from = (y * tile.width) as usize..((y + 1) * tile.width) as usize;
            let to = ((tile.y + y) * self.width + tile.x) as usize;
            for (k, i) in from.enumerate() {
                self.group.sum[to + k] += samples.sum[i].as_dvec3();
                self.group.sum_squares[to + k] += samples.sum_squares[i];
                for (layer, sums) in self.group.layers.iter_mut().zip(&samples.layers) {
                    layer[to + k] += sums[i].as_dvec3();
                }
                if let Some(&features) = samples.features.get(i) {
                    self.features[to + k] += features;
                }
            }
        }
    }

    /// Says that every pixel has received `samples` more, with their features or without.
    pub(crate) fn add_samples(&mut self, samples: u32, features: bool) {
        self.group.samples += samples;
        self.feature_samples += if features { samples } else { 0 };
    }

    /// Says the same of the pixels of a tile alone.
    pub(crate) fn add_samples_in(&mut self, tile: &Tile, samples: u32, features: bool) {
        let pixels = self.pixels();
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            let row = first..first + tile.width as usize;
            if features {
                self.feature_surplus.add(row.clone(), samples, pixels);
            }
            self.group.surplus.add(row, samples, pixels);
        }
    }

    /// Ends an iteration: its samples are weighed into the picture once there are enough of them.
    pub(crate) fn end_iteration(&mut self) {
        self.group.samples += self.group.surplus.level();
        self.feature_samples += self.feature_surplus.level();
        if self.group.samples >= MIN_GROUP {
            self.close_group();
            self.before = None;
        } else {
            self.before = Some(self.group.clone());
        }
    }

    /// As [`Self::sample_variances`], of the newest iteration alone.
    pub(crate) fn newest_variances(&self) -> Option<Vec<f64>> {
        let Some(before) = &self.before else { return self.sample_variances() };
        self.group.since(before).sample_variances()
    }

    /// Variance of the luminance of one sample of the current group, pixel by pixel; `None` where there are fewer than
    /// two.
    pub(crate) fn sample_variances(&self) -> Option<Vec<f64>> {
        self.group.sample_variances()
    }

    /// Adds to the group before it a rest that is too small to be weighed by its own variance. Such a rest is left where
    /// rendering ends before it was planned to; without this the picture would not hold it.
    pub(crate) fn join_rest(&mut self) {
        if self.group.samples >= MIN_GROUP || self.group.is_empty() {
            return;
        }
        if let Some(before) = self.pending.take() {
            let new = self.empty_group();
            let rest = std::mem::replace(&mut self.group, new);
            self.pending = Some(before.joined(&rest));
        }
    }

    /// The picture so far.
    pub(crate) fn resolve(&self) -> Estimate {
        let mut picture = self.picture.clone();
        // a rest too small to be weighed by its own variance joins only where there is nothing else
        let alone = picture.samples == 0 && picture.surplus.is_empty() && self.pending.is_none();
        let joins = self.group.samples >= MIN_GROUP || alone || self.combine != Combine::InverseVariance;
        let newest = Some(&self.group).filter(|group| joins && !group.is_empty());
        if let Some(newest) = newest {
            self.weigh_in(&mut picture, self.pending.as_ref(), newest);
        }
        if let Some(last) = newest.or(self.pending.as_ref()).filter(|_| self.combine == Combine::InverseVariance) {
            picture.weigh_in(self.width, last, last.weights(self.width as usize, last));
        }
        let share = |i| 1.0 / (self.feature_samples + self.feature_surplus.of(i)).max(1) as f32;
        let Picture { samples, surplus, .. } = &picture;
        let counts = (0..self.pixels()).map(|i| samples + surplus.of(i));
        Estimate {
            width: self.width,
            height: self.height,
            samples: samples + surplus.mean() as u32,
            counts: if surplus.is_empty() { Vec::new() } else { counts.collect() },
            mean: picture.mean,
            variance: picture.variance,
            layers: self.layers.iter().copied().zip(picture.layers).collect(),
            features: self.features.iter().enumerate().map(|(i, &f)| f * share(i)).collect(),
        }
    }

    fn pixels(&self) -> usize {
        self.features.len()
    }

    fn empty_group(&self) -> IterationGroup {
        IterationGroup::new(self.pixels(), self.layers.len())
    }

    fn close_group(&mut self) {
        let new = self.empty_group();
        let closed = std::mem::replace(&mut self.group, new);
        let (mut picture, pending) = (std::mem::take(&mut self.picture), self.pending.take());
        self.weigh_in(&mut picture, pending.as_ref(), &closed);
        self.picture = picture;
        self.pending = (self.combine == Combine::InverseVariance).then_some(closed);
    }

    /// Weighs the newest group into a picture; by inverse variance the one before it, as that has now a better picture than
    /// its own to be held against.
    fn weigh_in(&self, picture: &mut Picture, pending: Option<&IterationGroup>, newest: &IterationGroup) {
        match self.combine {
            Combine::Last => {
                let new = Picture::new(self.pixels(), self.layers.len());
                let before = std::mem::replace(picture, new);
                picture.weigh_in(self.width, newest, [Some(1.0); 2]);
                picture.fill_in(before, newest);
            }
            Combine::All => picture.weigh_in(self.width, newest, [Some(newest.mean_count()); 2]),
            Combine::InverseVariance => {
                if let Some(before) = pending {
                    picture.weigh_in(self.width, before, before.weights(self.width as usize, newest));
                }
            }
        }
    }
}

impl Picture {
    fn new(pixels: usize, layers: usize) -> Picture {
        Picture {
            mean: vec![Rgb::ZERO; pixels],
            variance: vec![Rgb::ZERO; pixels],
            layers: vec![vec![Rgb::ZERO; pixels]; layers],
            weight: [0.0; 2],
            told: [false; 2],
            samples: 0,
            surplus: Surplus::default(),
        }
    }

    fn weigh_in(&mut self, width: u32, group: &IterationGroup, weights: [Option<f64>; 2]) {
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
        for (layer, means) in self.layers.iter_mut().enumerate() {
            means.par_iter_mut().enumerate().for_each(|(i, mean)| {
                let (_, new) = group.shares(i, mean_count, shares[parity(i, width as usize)]);
                *mean += (group.layer_mean(layer, i) - *mean) * new;
            });
        }
        self.samples += group.samples;
        self.surplus.add_all(&group.surplus);
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
    fn fill_in(&mut self, before: Picture, newest: &IterationGroup) {
        if newest.surplus.is_empty() {
            return;
        }
        let pixels = self.mean.len();
        for i in (0..pixels).filter(|&i| newest.count(i) == 0) {
            (self.mean[i], self.variance[i]) = (before.mean[i], before.variance[i]);
            self.layers.iter_mut().zip(&before.layers).for_each(|(means, before)| means[i] = before[i]);
            self.surplus.add(i..i + 1, before.samples, pixels);
        }
    }
}

#[cfg(test)]
#[path = "accumulate_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "extremes_tests.rs"]
mod extremes;

#[cfg(test)]
#[path = "cut_tests.rs"]
mod cut_tests;
