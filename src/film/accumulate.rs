//! The film: sums of samples, iteration by iteration, and how iterations become one picture.

use super::group::{Group, parity};
use super::tile::{Features, Tile, TileSamples};
use crate::math::{Rgb, luminance};
use crate::scene::description::Combine;
use rayon::prelude::*;

/// Samples for which albedo, normal and depth are averaged; they have little noise.
pub const FEATURE_SAMPLES: u32 = 32;

/// Iterations are weighed in groups of at least this many samples per pixel: the variance of fewer says little.
const MIN_GROUP: u32 = 4;

/// Accumulates what tiles bring back. Memory is constant in the number of samples.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    combine: Combine,
    group: Group,
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
        }
    }

    /// Variance of the luminance of one sample of the current group, pixel by pixel; `None` where there are fewer than
    /// two.
    pub fn sample_variances(&self) -> Option<Vec<f64>> {
        let n = self.group.samples;
        let variance = |i: usize| luminance(self.group.moments(i).1) as f64 * n as f64;
        (n >= 2).then(|| (0..self.blank.len()).into_par_iter().map(variance).collect())
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
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    fn tile(side: u32) -> Tile {
        Tile { x: 0, y: 0, width: side, height: side }
    }

    /// `spp` samples of uniform noise of the given width about 1 in every pixel.
    fn add_noise(film: &mut Film, spp: u32, width: f32, rng: &mut Rng) {
        let tile = tile(film.width);
        for _ in 0..spp {
            let sum: Vec<Rgb> = (0..tile.pixels()).map(|_| Rgb::splat(1.0 + width * (rng.f32() - 0.5))).collect();
            let sum_squares = sum.iter().map(|&v| v * v).collect();
            film.add(&tile, &TileSamples { sum, sum_squares, ..TileSamples::default() });
        }
        film.add_samples(spp, false);
        film.end_iteration();
    }

    fn mean_square_error(estimate: &Estimate) -> f32 {
        estimate.mean.iter().map(|v| (v.x - 1.0).powi(2)).sum::<f32>() / estimate.mean.len() as f32
    }

    #[test]
    fn variance_layer_is_the_variance_of_the_mean() {
        for combine in [Combine::All, Combine::InverseVariance] {
            let mut film = Film::new(64, 64, combine);
            let mut rng = Rng::new(3);
            for spp in [8, 16, 32] {
                add_noise(&mut film, spp, 1.0, &mut rng);
            }
            let estimate = film.develop();
            let (claimed, real) =
                (estimate.variance.iter().map(|v| v.x).sum::<f32>() / 4096.0, mean_square_error(&estimate));
            // 4096 pixels: the error of a variance estimated from them is √(2/4096) = 2.2 %
            assert!((claimed / real - 1.0).abs() < 0.1, "{combine:?}: {claimed} claimed, {real} seen");
        }
    }

    #[test]
    fn inverse_variance_beats_equal_weights_where_iterations_differ() {
        let error = |combine| {
            let mut film = Film::new(64, 64, combine);
            let mut rng = Rng::new(5);
            add_noise(&mut film, 32, 4.0, &mut rng);
            add_noise(&mut film, 32, 0.5, &mut rng);
            mean_square_error(&film.develop())
        };
        let (all, weighted, last) = (error(Combine::All), error(Combine::InverseVariance), error(Combine::Last));
        assert!(weighted < 0.1 * all && weighted < last, "all {all}, weighted {weighted}, last {last}");
    }

    /// Of 1000 samples one holds all the light.
    fn add_fireflies(film: &mut Film, spp: u32, rng: &mut Rng) {
        let tile = tile(film.width);
        for _ in 0..spp {
            let sample = |rng: &mut Rng| if rng.f32() < 1e-3 { 1e3 } else { 0.0 };
            let sum: Vec<Rgb> = (0..tile.pixels()).map(|_| Rgb::splat(sample(rng))).collect();
            let sum_squares = sum.iter().map(|&v| v * v).collect();
            film.add(&tile, &TileSamples { sum, sum_squares, ..TileSamples::default() });
        }
        film.add_samples(spp, false);
        film.end_iteration();
    }

    #[test]
    fn a_noisy_beginning_is_known_as_such() {
        let mut rng = Rng::new(7);
        let (mut film, mut late) = (Film::new(64, 64, Combine::InverseVariance), Film::new(64, 64, Combine::All));
        // variance of a sample: 999 first, then 0.6
        add_fireflies(&mut film, 4, &mut rng);
        for spp in [8, 16] {
            let mut again = rng;
            add_noise(&mut film, spp, 2.7, &mut rng);
            add_noise(&mut late, spp, 2.7, &mut again);
        }
        let (all, late) = (mean_square_error(&film.develop()), mean_square_error(&late.develop()));
        assert!(all < 1.05 * late, "{all} with the beginning, {late} without");
    }

    #[test]
    fn a_black_film_stays_black_and_finite() {
        let mut film = Film::new(8, 8, Combine::InverseVariance);
        let t = tile(8);
        let black =
            || TileSamples { sum: vec![Rgb::ZERO; 64], sum_squares: vec![Rgb::ZERO; 64], ..TileSamples::default() };
        for _ in 0..16 {
            film.add(&t, &black());
        }
        film.add_samples(16, false);
        film.end_iteration();
        assert!(film.develop().mean.iter().all(|&v| v == Rgb::ZERO));
    }

    #[test]
    fn scaling_the_light_scales_the_picture_and_nothing_else() {
        let picture = |scale: f32| {
            let mut film = Film::new(16, 16, Combine::InverseVariance);
            let mut rng = Rng::new(9);
            for spp in [8u32, 16] {
                for _ in 0..spp {
                    let sum: Vec<Rgb> = (0..256).map(|_| Rgb::splat(scale * rng.f32())).collect();
                    let sum_squares = sum.iter().map(|&v| v * v).collect();
                    film.add(&tile(16), &TileSamples { sum, sum_squares, ..TileSamples::default() });
                }
                film.add_samples(spp, false);
                film.end_iteration();
            }
            film.develop().mean
        };
        let (one, tiny) = (picture(1.0), picture(2.0f32.powi(-20)));
        for (a, b) in one.iter().zip(&tiny) {
            assert!((b.x * 2.0f32.powi(20) / a.x - 1.0).abs() < 1e-5);
        }
    }
}
