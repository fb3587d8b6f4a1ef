//! Tiles of different numbers of samples: what decides these does not bias the picture.

use super::*;
use crate::film::tile::{Aovs, TileSamples};
use crate::film::{Combine, RadianceLayer};
use crate::math::rng::Rng;

const SIDE: u32 = 64;
const PIXELS: usize = (SIDE * SIDE) as usize;

/// A film in which each pixel is a tile, and samples of exponential distribution about 1.
struct Trial {
    film: Film,
    rng: Rng,
    /// Of each pixel, sum and number of all samples of the iteration under way, and of those before that count.
    new: Vec<(f64, u32)>,
    all: Vec<(f64, u32)>,
}

impl Trial {
    fn new(seed: u64) -> Trial {
        let film = Film::new(SIDE, SIDE, Combine::All, &[RadianceLayer::Direct]);
        Trial { film, rng: Rng::new(seed), new: vec![(0.0, 0); PIXELS], all: vec![(0.0, 0); PIXELS] }
    }

    fn sample(&mut self, pixel: usize, samples: u32) {
        let tile = Tile { x: pixel as u32 % SIDE, y: pixel as u32 / SIDE, width: 1, height: 1 };
        for _ in 0..samples {
            let value = Rgb::splat(-(1.0 - self.rng.f32()).ln());
            let samples = TileSamples {
                sum: vec![value],
                sum_squares: vec![value * value],
                layers: vec![vec![2.0 * value]],
                ..TileSamples::default()
            };
            self.film.add(&tile, &samples);
            self.film.add_samples_in(&tile, 1, false);
            self.new[pixel] = (self.new[pixel].0 + f64::from(value.x), self.new[pixel].1 + 1);
        }
    }

    /// An iteration in which `plan` says how many samples a pixel gets, and what share of what is left; the share `done` of it.
    fn iterate(&mut self, plan: impl Fn(usize) -> (u32, f64), done: f64) {
        let kept = self.film.shares();
        let before = |i: usize| kept.get(i).map_or(0.0, |(share, _)| share.before);
        let tile = |i: usize| {
            let (samples, share) = plan(i);
            TileShare { before: before(i), share: (1.0 - before(i)) * share, samples, first: 0 }
        };
        self.film.allot(1, (0..PIXELS).map(tile).collect());
        self.new = vec![(0.0, 0); PIXELS];
        (0..PIXELS).for_each(|i| self.sample(i, (f64::from(plan(i).0) * done).ceil() as u32));
        self.film.say_done(done);
    }

    fn end(&mut self) {
        self.film.end_iteration();
        self.all.iter_mut().zip(&self.new).for_each(|(all, new)| *all = (all.0 + new.0, all.1 + new.1));
    }

    /// Mean of the newest samples of each pixel.
    fn newest(&self) -> Vec<f64> {
        self.new.iter().map(|(sum, n)| sum / f64::from((*n).max(1))).collect()
    }
}

/// Three iterations, of which pixels that seem dark after the first, or after the second, get no more, as far as that can be said:
/// a rule that biases the mean of all samples badly.
fn adversary(seed: u64, last: f64) -> Trial {
    let mut trial = Trial::new(seed);
    (0..PIXELS).for_each(|i| trial.sample(i, 3));
    trial.end();
    let found = trial.newest();
    trial.all = vec![(0.0, 0); PIXELS];
    // dark ones are nearly done at once
    trial.iterate(|i| if found[i] < 0.8 { (2, 0.9) } else { (4, 0.2) }, 1.0);
    trial.end();
    let found = trial.newest();
    trial.iterate(|i| if found[i] < 0.8 { (2, 1.0) } else { (16, 1.0) }, last);
    trial
}

/// Standard errors by which a mean over all pixels is off.
fn off(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

/// Two-sided, once in 15,000 by chance.
const LIMIT: f64 = 4.0;

#[test]
fn what_decides_how_many_samples_a_tile_gets_does_not_bias_it() {
    let trials: Vec<Trial> = (0..6).map(|seed| adversary(seed, 1.0)).collect();
    let all = || trials.iter().flat_map(|trial| trial.film.so_far().mean).map(|mean| f64::from(mean.x));
    assert!(off(all()).abs() < LIMIT, "{} standard errors", off(all()));
    let ended = trials.iter().flat_map(|trial| {
        let mut film = trial.film.clone();
        film.end_iteration();
        film.finish().mean
    });
    assert_eq!(ended.map(|mean| f64::from(mean.x)).collect::<Vec<_>>(), all().collect::<Vec<_>>());
    // each sample alike, as if nothing had been decided
    let alike = trials.iter().flat_map(|trial| {
        let sums = trial.all.iter().zip(&trial.new);
        sums.map(|((a, n), (b, m))| (a + b) / f64::from(n + m))
    });
    assert!(off(alike) < -3.0 * LIMIT, "the mean of all samples seems unbiased: the test sees nothing");
}

#[test]
fn the_picture_is_unbiased_wherever_an_iteration_ends() {
    for done in [0.0, 0.1, 0.5] {
        let trials = (0..6).map(|seed| adversary(100 + seed, done));
        let off = off(trials.flat_map(|trial| trial.film.so_far().mean).map(|mean| f64::from(mean.x)));
        assert!(off.abs() < LIMIT, "{off} standard errors where {done} is done");
    }
}

#[test]
fn layers_and_variances_are_those_of_the_picture() {
    let trials: Vec<Trial> = (0..4).map(|seed| adversary(200 + seed, 1.0)).collect();
    let (mut squares, mut said) = (0.0, 0.0);
    for estimate in trials.iter().map(|trial| trial.film.so_far()) {
        for i in 0..PIXELS {
            assert!((estimate.layers[0].1[i] / estimate.mean[i] - 2.0).abs().max_element() < 1e-5);
            squares += (f64::from(estimate.mean[i].x) - 1.0).powi(2);
            said += f64::from(estimate.variance[i].x);
        }
        assert_eq!(estimate.spread(), (2 + 2, 4 + 16, 0));
    }
    // two samples of an exponential distribution tell its variance badly, and right on average
    assert!((said / squares - 1.0).abs() < 0.2, "{said} is said, and {squares} seen");
}

#[test]
fn equal_samples_stay_what_they_are_and_features_are_those_of_the_pilot() {
    let mut film = Film::new(2, 1, Combine::All, &[]).of_even_samples(true);
    let tile = |x: u32| Tile { x, y: 0, width: 1, height: 1 };
    let value = Rgb::new(0.1, 0.7, 1e-5);
    let add = |film: &mut Film, x: u32, n: u32, features: bool| {
        for _ in 0..n {
            let (sum, sum_squares) = (vec![value], vec![value * value]);
            let met = vec![Aovs { depth: 3.0, ..Aovs::default() }; usize::from(features)];
            film.add(&tile(x), &TileSamples { sum, sum_squares, features: met, ..TileSamples::default() });
            film.add_samples_in(&tile(x), 1, features);
        }
    };
    [0, 1].into_iter().for_each(|x| add(&mut film, x, 5, true));
    film.end_iteration();
    for share in [0.3, 0.7, 1.0] {
        let before: Vec<f64> = film.shares().iter().map(|(tile, _)| tile.before).chain([0.0; 2]).take(2).collect();
        let shares =
            before.iter().map(|&before| TileShare { before, share: (1.0 - before) * share, samples: 7, first: 0 });
        film.allot(1, shares.collect());
        add(&mut film, 0, 7, false);
        add(&mut film, 1, 3, false);
        film.say_done(if share < 1.0 { 0.4 } else { 1.0 });
        assert_eq!(film.so_far().mean, [value; 2]);
        film.end_iteration();
    }
    let estimate = film.finish();
    assert_eq!(estimate.mean, [value; 2]);
    assert_eq!(estimate.features.iter().map(|f| f.depth).collect::<Vec<_>>(), [3.0; 2]);
    assert_eq!([estimate.count(0), estimate.count(1)], [21, 9]);
}
