//! The film: sums of samples, iteration by iteration, and how iterations become one picture.

use super::group::{Group, parity};
use super::tile::{Features, Tile, TileSamples};
use crate::math::Rgb;
use crate::scene::description::Combine;
use rayon::prelude::*;

/// Samples for which albedo, normal and depth are averaged; they have little noise.
pub const FEATURE_SAMPLES: u32 = 32;

/// Iterations are weighed in groups of at least this many samples per pixel: the variance of fewer says little.
const MIN_GROUP: u32 = 4;

/// Bytes that a render holds for each pixel, and that writing its pictures takes: 160 were measured without a
/// guide and 230 with one, which the test `a_render_takes_the_memory_that_is_said` does again.
pub const BYTES_PER_PIXEL: u64 = 256;

/// Accumulates what tiles bring back. Memory is constant in the number of samples.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    combine: Combine,
    group: Group,
    /// What it held when the newest iteration began, where it is not all of that.
    before: Option<Group>,
    /// The group before, until there is a better picture than its own to hold its noise against.
    pending: Option<Group>,
    /// Of the groups before these.
    picture: Picture,
    features: Vec<Features>,
    feature_samples: u32,
    /// Pixels that received none of the samples.
    blank: Vec<bool>,
}

/// Groups weighed together.
#[derive(Clone, Debug, Default)]
struct Picture {
    mean: Vec<Rgb>,
    /// Of the means.
    variance: Vec<Rgb>,
    /// Sum of weights, for the black and the white squares of a checkerboard over the pixels.
    weight: [f64; 2],
    samples: u32,
}

/// A picture with what is known of its noise.
#[derive(Clone, Debug)]
pub struct Estimate {
    pub width: u32,
    pub height: u32,
    pub mean: Vec<Rgb>,
    /// Variance of `mean`, estimated from the samples; zero where there were fewer than two.
    pub variance: Vec<Rgb>,
    /// Samples per pixel that the picture holds.
    pub samples: u32,
    /// Pixels that hold none of them, because rendering ended before their turn came.
    pub blank: Vec<bool>,
    /// Means of what the camera sees first.
    pub features: Vec<Features>,
}

impl Film {
    pub fn new(width: u32, height: u32, combine: Combine) -> Film {
        let pixels = width as usize * height as usize;
        Film {
            width,
            height,
            combine,
            group: Group::new(pixels),
            before: None,
            pending: None,
            picture: Picture::new(pixels),
            features: vec![Features::default(); pixels],
            feature_samples: 0,
            blank: vec![false; pixels],
        }
    }

    /// Says that a tile will have none of the samples of which `add_samples` speaks; its pixels stay black.
    pub fn leave_blank(&mut self, tile: &Tile) {
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            self.blank[first..first + tile.width as usize].fill(true);
        }
    }

    /// Adds what was sampled in a tile. Call `add_samples` once all pixels have theirs.
    pub fn add(&mut self, tile: &Tile, samples: &TileSamples) {
        for y in 0..tile.height {
            let from = (y * tile.width) as usize..((y + 1) * tile.width) as usize;
            let to = ((tile.y + y) * self.width + tile.x) as usize;
            for (k, i) in from.enumerate() {
                self.group.sum[to + k] += samples.sum[i].as_dvec3();
                self.group.sum_squares[to + k] += samples.sum_squares[i];
                if let Some(&features) = samples.features.get(i) {
                    self.features[to + k] += features;
                }
            }
        }
    }

    /// Says that every pixel has received `samples` more, with their features or without.
    pub fn add_samples(&mut self, samples: u32, features: bool) {
        self.group.samples += samples;
        self.feature_samples += if features { samples } else { 0 };
    }

    /// Ends an iteration: its samples are weighed into the picture once there are enough of them.
    pub fn end_iteration(&mut self) {
        if self.group.samples >= MIN_GROUP {
            self.close_group();
            self.before = None;
        } else {
            self.before = Some(self.group.clone());
        }
    }

    /// As [`Self::sample_variances`], of the newest iteration alone.
    pub fn newest_variances(&self) -> Option<Vec<f64>> {
        let Some(before) = &self.before else { return self.sample_variances() };
        self.group.since(before).sample_variances()
    }

    /// Variance of the luminance of one sample of the current group, pixel by pixel; `None` where there are fewer than
    /// two.
    pub fn sample_variances(&self) -> Option<Vec<f64>> {
        self.group.sample_variances()
    }

    /// The picture so far.
    pub fn develop(&self) -> Estimate {
        let mut picture = self.picture.clone();
        // a rest too small to be weighed by its own variance joins only where there is nothing else
        let alone = picture.weight == [0.0; 2] && self.pending.is_none();
        let joins = self.group.samples >= MIN_GROUP || alone || self.combine != Combine::InverseVariance;
        let newest = Some(&self.group).filter(|group| joins && group.samples > 0);
        if let Some(newest) = newest {
            self.weigh_in(&mut picture, self.pending.as_ref(), newest);
        }
        if let Some(last) = newest.or(self.pending.as_ref()).filter(|_| self.combine == Combine::InverseVariance) {
            picture.weigh_in(self.width, last, last.weights(self.width as usize, last));
        }
        let share = 1.0 / self.feature_samples.max(1) as f32;
        Estimate {
            width: self.width,
            height: self.height,
            mean: picture.mean,
            variance: picture.variance,
            samples: picture.samples,
            blank: self.blank.clone(),
            features: self.features.iter().map(|&f| f * share).collect(),
        }
    }

    fn close_group(&mut self) {
        let closed = std::mem::replace(&mut self.group, Group::new(self.blank.len()));
        let (mut picture, pending) = (std::mem::take(&mut self.picture), self.pending.take());
        self.weigh_in(&mut picture, pending.as_ref(), &closed);
        self.picture = picture;
        self.pending = (self.combine == Combine::InverseVariance).then_some(closed);
    }

    /// Weighs the newest group into a picture; by inverse variance the one before it, as that has now a better picture than
    /// its own to be held against.
    fn weigh_in(&self, picture: &mut Picture, pending: Option<&Group>, newest: &Group) {
        match self.combine {
            Combine::Last => {
                *picture = Picture::new(self.blank.len());
                picture.weigh_in(self.width, newest, [1.0; 2]);
            }
            Combine::All => picture.weigh_in(self.width, newest, [newest.samples as f64; 2]),
            Combine::InverseVariance => {
                if let Some(before) = pending {
                    picture.weigh_in(self.width, before, before.weights(self.width as usize, newest));
                }
            }
        }
    }
}

impl Picture {
    fn new(pixels: usize) -> Picture {
        Picture { mean: vec![Rgb::ZERO; pixels], variance: vec![Rgb::ZERO; pixels], weight: [0.0; 2], samples: 0 }
    }

    fn weigh_in(&mut self, width: u32, group: &Group, weights: [f64; 2]) {
        let totals = [0, 1].map(|colour| self.weight[colour] + weights[colour]);
        let new = [0, 1].map(|colour| (weights[colour] / totals[colour]) as f32);
        let old = [0, 1].map(|colour| (self.weight[colour] / totals[colour]) as f32);
        self.mean.par_iter_mut().zip(&mut self.variance).enumerate().for_each(|(i, (mean, variance))| {
            let colour = parity(i, width as usize);
            let (newer, newer_variance) = group.moments(i);
            // steps towards the new mean: equal ones stay what they are to the last bit
            *mean += (newer - *mean) * new[colour];
            *variance = *variance * old[colour].powi(2) + newer_variance * new[colour].powi(2);
        });
        self.weight = totals;
        self.samples += group.samples;
    }
}

#[cfg(test)]
#[path = "accumulate_tests.rs"]
mod tests;
