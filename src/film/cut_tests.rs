//! A pass that was cut: some pixels have its samples, others do not.

use super::*;
use crate::math::rng::Rng;

const SIDE: u32 = 64;
const PIXELS: usize = (SIDE * SIDE) as usize;
const COMBINES: [Combine; 3] = [Combine::All, Combine::Last, Combine::InverseVariance];

/// The film, and all samples that each pixel was given, iteration by iteration.
struct Known {
    film: Film,
    samples: Vec<Vec<Vec<f32>>>,
    rng: Rng,
}

impl Known {
    fn new(combine: Combine, seed: u64) -> Known {
        Known { film: Film::new(SIDE, SIDE, combine, &[]), samples: Vec::new(), rng: Rng::new(seed) }
    }

    /// One sample more in each pixel of a tile, of uniform noise about 1.
    fn sample(&mut self, tile: &Tile, width: f32) {
        let sum: Vec<Rgb> = (0..tile.pixels()).map(|_| Rgb::splat(1.0 + width * (self.rng.f32() - 0.5))).collect();
        for (k, value) in sum.iter().enumerate() {
            let (x, y) = (tile.x as usize + k % tile.width as usize, tile.y as usize + k / tile.width as usize);
            self.samples.last_mut().unwrap()[y * SIDE as usize + x].push(value.x);
        }
        let features = vec![Aovs { depth: 2.0, ..Aovs::default() }; sum.len()];
        let sum_squares = sum.iter().map(|&v| v * v).collect();
        self.film.add(tile, &TileSamples { sum, sum_squares, features, ..TileSamples::default() });
    }

    /// An iteration of `whole` samples in all pixels and `more` in those of the upper half.
    fn iterate(&mut self, whole: u32, more: u32, width: f32) {
        self.samples.push(vec![Vec::new(); PIXELS]);
        (0..whole).for_each(|_| self.sample(&tile(SIDE), width));
        self.film.add_samples(whole, true);
        for _ in 0..more {
            let half = tile(SIDE / 2);
            self.sample(&half, width);
            self.film.add_samples_in(&half, 1, true);
        }
        self.film.end_iteration();
    }

    /// Mean, and variance of the mean, of all samples of a pixel.
    fn of(&self, i: usize) -> (f32, f32) {
        let all: Vec<f64> = self.samples.iter().flat_map(|s| &s[i]).map(|&v| f64::from(v)).collect();
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        let variance = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean as f32, (variance / n) as f32)
    }
}

/// The rows of the upper part of the picture.
fn tile(height: u32) -> Tile {
    Tile { x: 0, y: 0, width: SIDE, height }
}

fn halves(estimate: &Estimate) -> [Vec<usize>; 2] {
    let (upper, lower) = (0..PIXELS).partition(|&i| i < PIXELS / 2);
    assert_eq!(estimate.mean.len(), PIXELS);
    [upper, lower]
}

fn mean(pixels: &[usize], of: impl Fn(usize) -> f32) -> f64 {
    pixels.iter().map(|&i| f64::from(of(i))).sum::<f64>() / pixels.len() as f64
}

#[test]
fn a_pixel_has_mean_and_variance_of_its_own_samples() {
    for combine in COMBINES {
        let mut known = Known::new(combine, 1);
        known.iterate(5, 3, 1.0);
        let estimate = known.film.clone().finish();
        assert_eq!((estimate.samples, estimate.spread()), (6, (5, 8, 0)), "{combine:?}");
        for i in 0..PIXELS {
            let (mean, variance) = known.of(i);
            assert_eq!(estimate.count(i), if i < PIXELS / 2 { 8 } else { 5 });
            assert!((estimate.mean[i].x / mean - 1.0).abs() < 1e-6, "{combine:?}, pixel {i}");
            assert!((estimate.variance[i].x / variance - 1.0).abs() < 1e-3, "{combine:?}, pixel {i}");
            assert_eq!(estimate.features[i].depth, 2.0);
        }
    }
}

#[test]
fn all_samples_count_alike_where_iterations_do() {
    let mut known = Known::new(Combine::All, 2);
    for (whole, more) in [(4, 0), (8, 0), (0, 1)] {
        known.iterate(whole, more, 1.0);
    }
    let estimate = known.film.resolve();
    assert_eq!(estimate.spread(), (12, 13, 0));
    for i in 0..PIXELS {
        assert!((estimate.mean[i].x / known.of(i).0 - 1.0).abs() < 1e-6, "pixel {i}");
    }
    // the thirteenth sample alone does not tell how it varies, and the variance is not less for that
    let [upper, lower] = halves(&estimate).map(|half| mean(&half, |i| estimate.variance[i].x));
    assert!((upper / lower * 13.0 / 12.0 - 1.0).abs() < 0.03, "{upper} and {lower}");
}

#[test]
fn the_variance_layer_is_that_of_the_mean_in_either_half() {
    for (whole, more) in [(9, 4), (4, 2), (0, 3), (2, 1)] {
        let mut known = Known::new(Combine::InverseVariance, 3);
        known.iterate(8, 0, 2.0);
        known.iterate(16, 0, 1.0);
        known.iterate(whole, more, 1.0);
        known.film.join_rest();
        let estimate = known.film.resolve();
        assert_eq!(estimate.spread(), (24 + whole, 24 + whole + more, 0));
        for half in halves(&estimate) {
            let claimed = mean(&half, |i| estimate.variance[i].x);
            let seen = mean(&half, |i| (estimate.mean[i].x - 1.0).powi(2));
            // 2048 pixels: either tells the variance to 3 %
            assert!((claimed / seen - 1.0).abs() < 0.15, "{whole} and {more}: {claimed} claimed, {seen} seen");
            let bias = mean(&half, |i| estimate.mean[i].x - 1.0);
            assert!(bias.abs() < 5.0 * (seen / half.len() as f64).sqrt(), "{whole} and {more}: a bias of {bias}");
        }
        let [upper, lower] = halves(&estimate).map(|half| mean(&half, |i| estimate.variance[i].x));
        assert!(upper < lower, "{whole} and {more}: more samples vary less");
    }
}

#[test]
fn a_rest_too_small_to_be_weighed_is_part_of_the_picture() {
    let mut known = Known::new(Combine::InverseVariance, 4);
    known.iterate(8, 0, 1.0);
    known.iterate(0, 3, 1.0);
    assert_eq!(known.film.resolve().spread(), (8, 8, 0), "in the middle of a render it may still grow");
    known.film.join_rest();
    let estimate = known.film.resolve();
    assert_eq!(estimate.spread(), (8, 11, 0));
    for i in 0..PIXELS {
        assert!((estimate.mean[i].x / known.of(i).0 - 1.0).abs() < 1e-6, "pixel {i}");
    }
}

#[test]
fn pixels_without_samples_are_black_and_said_to_be() {
    for combine in COMBINES {
        let mut known = Known::new(combine, 5);
        known.iterate(0, 1, 1.0);
        known.film.join_rest();
        let estimate = known.film.resolve();
        assert_eq!((estimate.samples, estimate.spread()), (0, (0, 1, PIXELS / 2)), "{combine:?}");
        for i in 0..PIXELS {
            let expected = if i < PIXELS / 2 { known.of(i).0 } else { 0.0 };
            assert_eq!((estimate.mean[i], estimate.variance[i]), (Rgb::splat(expected), Rgb::ZERO), "{combine:?}");
        }
    }
}

#[test]
fn the_last_iteration_replaces_the_one_before_only_where_it_has_samples() {
    let mut known = Known::new(Combine::Last, 6);
    known.iterate(8, 0, 4.0);
    known.iterate(0, 2, 1.0);
    let estimate = known.film.resolve();
    assert_eq!(estimate.spread(), (2, 8, 0));
    for i in 0..PIXELS {
        let newest = &known.samples[if i < PIXELS / 2 { 1 } else { 0 }][i];
        let mean = newest.iter().sum::<f32>() / newest.len() as f32;
        assert!((estimate.mean[i].x / mean - 1.0).abs() < 1e-5, "pixel {i}");
        assert!(estimate.variance[i].x > 0.0);
    }
}

#[test]
fn tiles_that_all_have_their_samples_are_as_a_whole_pass() {
    let film = |by_tiles: bool| {
        let mut known = Known::new(Combine::InverseVariance, 7);
        for _ in 0..2 {
            known.samples.push(vec![Vec::new(); PIXELS]);
            (0..6).for_each(|_| known.sample(&tile(SIDE), 1.0));
            match by_tiles {
                true => (0..6).for_each(|_| known.film.add_samples_in(&tile(SIDE), 1, true)),
                false => known.film.add_samples(6, true),
            }
            known.film.end_iteration();
        }
        let Estimate { mean, variance, samples, counts, .. } = known.film.resolve();
        (mean, variance, samples, counts)
    };
    assert_eq!(film(true), film(false));
}
