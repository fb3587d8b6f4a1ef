//! What halves of samples say of the noise of their mean. Seeds are fixed; bounds are five standard errors, where nothing else is
//! said.

use super::*;
use crate::film::Combine;
use crate::film::accumulate::Film;
use crate::film::tile::TileSamples;
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::math::sobol::{self, Seeds};

const SIDE: u32 = 64;
const PIXELS: usize = (SIDE * SIDE) as usize;

fn whole() -> Tile {
    Tile { x: 0, y: 0, width: SIDE, height: SIDE }
}

/// A film whose pixels see the same with other random numbers: `light` of a point that is the next of a Sobol' sequence, or
/// independent of all others.
struct Known<'a> {
    film: Film,
    seeds: Vec<Seeds<1>>,
    taken: u32,
    even: bool,
    light: &'a dyn Fn([f64; 4]) -> f64,
}

impl<'a> Known<'a> {
    fn new(even: bool, seed: u64, light: &'a dyn Fn([f64; 4]) -> f64) -> Known<'a> {
        let mut rng = Rng::new(seed);
        let mut word = || [rng.next_u32()];
        let seeds =
            (0..PIXELS).map(|_| Seeds { shuffle: word(), scramble: [word(), word(), word(), word()] }).collect();
        let film = Film::new(SIDE, SIDE, Combine::All, &[]).of_even_samples(true);
        Known { film, seeds, taken: 0, even, light }
    }

    fn sample(&self, pixel: usize, number: u32) -> Rgb {
        let mut rng = Rng::for_place(u64::from(number), pixel as u32, number);
        let [x, y, u, v] =
            sobol::points::<4, 1>(&[number], 32, &self.seeds[pixel]).map(|[x]| f64::from(x) / 2f64.powi(32));
        let point = if self.even { [x, y, u, v] } else { [rng.f64(), rng.f64(), rng.f64(), rng.f64()] };
        Rgb::splat((self.light)(point) as f32)
    }

    /// A pass over a part of the pixels.
    fn add(&mut self, tile: &Tile, samples: u32) {
        let numbers = self.taken..self.taken + samples;
        let pixel = |k: usize| {
            (tile.y as usize + k / tile.width as usize) * SIDE as usize + tile.x as usize + k % tile.width as usize
        };
        let sums = |of: fn(Rgb) -> Rgb| -> Vec<Rgb> {
            (0..tile.pixels()).map(|k| numbers.clone().map(|n| of(self.sample(pixel(k), n))).sum()).collect()
        };
        let (sum, sum_squares) = (sums(|x| x), sums(|x| x * x));
        self.film.add(tile, &TileSamples { numbers, sum, sum_squares, ..TileSamples::default() });
    }

    fn passes(&mut self, passes: &[u32]) {
        for &samples in passes {
            self.add(&whole(), samples);
            self.film.add_samples(samples, false);
            self.taken += samples;
        }
    }

    /// Mean over the pixels: of the squared error; of what halves say of it; of what independent samples would have.
    fn variances(&self, truth: f64) -> [f64; 3] {
        let estimate = self.film.resolve();
        let mean = |of: &dyn Fn(usize) -> f64| (0..PIXELS).map(of).sum::<f64>() / PIXELS as f64;
        let (by_halves, n) = (self.film.sample_variances().unwrap(), f64::from(self.taken));
        [
            mean(&|i| (f64::from(estimate.mean[i].x) - truth).powi(2)),
            mean(&|i| by_halves[i] / n),
            mean(&|i| f64::from(estimate.variance[i].x)),
        ]
    }
}

/// Whether a point is within a quarter of a disk.
fn disk(x: [f64; 4]) -> f64 {
    f64::from(u8::from(x[0] * x[0] + x[1] * x[1] < 1.0))
}

const DISK: f64 = std::f64::consts::FRAC_PI_4;

/// Ways to take 64 samples: aligned with powers of two or not.
const PASSES: [&[u32]; 3] = [&[4; 16], &[1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 1], &[1; 64]];

#[test]
fn halves_of_independent_samples_say_what_the_samples_say() {
    for passes in PASSES {
        let mut known = Known::new(false, 1, &disk);
        known.passes(passes);
        let [real, by_halves, by_samples] = known.variances(DISK);
        // 4 096 squares of normal numbers, and as many of differences: 2.2 % each
        assert!((by_samples / real - 1.0).abs() < 0.11, "{by_samples:e} by samples and {real:e} seen");
        assert!((by_halves / real - 1.0).abs() < 0.16, "{by_halves:e} by halves and {real:e} seen");
    }
}

#[test]
fn halves_of_even_samples_are_nearer_to_the_truth_and_on_its_safe_side() {
    for (k, passes) in PASSES.into_iter().enumerate() {
        let mut known = Known::new(true, 2, &disk);
        known.passes(passes);
        let [real, by_halves, by_samples] = known.variances(DISK);
        println!("{passes:?}: {real:e} seen, {by_halves:e} by halves, {by_samples:e} by samples");
        assert!(by_samples > 5.0 * real, "samples by themselves say far too much");
        // an edge has r = 1.5: 2¹·⁵ − 1 = 1.8; halves that are not aligned say somewhat more
        let most = if k == 1 { 3.0 } else { 2.2 };
        assert!((1.2..most).contains(&(by_halves / real)), "{passes:?}: {}", by_halves / real);
    }
}

#[test]
fn what_only_some_numbers_help_with_is_in_between() {
    // an edge, and beyond it noise of numbers that are not spread: of four dimensions together
    let both = |x: [f64; 4]| disk(x) + f64::from(u8::from((1e4 * (x[2] + x[3])).fract() < 0.5));
    let mut known = Known::new(true, 3, &both);
    known.passes(PASSES[0]);
    let [real, by_halves, by_samples] = known.variances(DISK + 0.5);
    assert!(
        by_samples > 1.4 * real && (0.84..1.35).contains(&(by_halves / real)),
        "{real:e}, {by_halves:e}, {by_samples:e}"
    );
}

#[test]
fn the_newest_iteration_has_halves_of_its_own() {
    let mut known = Known::new(true, 4, &disk);
    for passes in [&[1][..], &[1, 1]] {
        known.passes(passes);
        known.film.end_iteration();
    }
    // sequences begin anew with each iteration
    (known.taken, known.seeds) = (3, Known::new(true, 5, &disk).seeds);
    known.passes(&[2, 2]);
    let newest = known.film.newest_variances().unwrap();
    let mean = newest.iter().sum::<f64>() / PIXELS as f64;
    let spread = DISK * (1.0 - DISK);
    assert!(mean > 0.0 && (mean / spread - 1.0).abs() > 0.02, "{mean} is what the samples say: {spread}");
    let group = known.film.sample_variances().unwrap();
    assert_ne!(group, newest);
}

#[test]
fn a_pass_that_was_cut_leaves_pixels_with_halves_of_different_length() {
    let mut known = Known::new(true, 6, &disk);
    known.passes(&[4; 4]);
    let upper = Tile { height: SIDE / 2, ..whole() };
    known.add(&upper, 16);
    known.film.add_samples_in(&upper, 16, false);
    let variances = known.film.sample_variances().unwrap();
    let (upper, lower) = variances.split_at(PIXELS / 2);
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    // per sample, of an edge: 16 | 16 above and 8 | 8 below, where evenness gains less; were all parts alike, both would be equal to
    // some 4 %
    assert!(mean(upper) < 0.9 * mean(lower), "{} and {}", mean(upper), mean(lower));
}

#[test]
fn light_beyond_all_bounds_is_left_to_the_samples() {
    let mut halves = Halves::new(1);
    halves.keep((&Tile { x: 0, y: 0, width: 1, height: 1 }, 1), |_| DVec3::splat(1e300), 4..8, 0);
    assert_eq!(halves.difference(0, DVec3::splat(2e300), 8), None);
    assert_eq!(halves.variances(vec![7.0], |_| (DVec3::splat(2e300), 8), |_| true, 1), [7.0]);
}

#[test]
fn no_part_is_much_larger_than_the_other() {
    // in passes of so many samples, the first of which may be shorter
    for (first, pass) in [(1, 1), (4, 4), (1, 4), (2, 4), (3, 4)] {
        let (mut halves, mut taken) = (Halves::new(1), 0u32);
        while taken < 300 {
            let numbers = taken..taken + if taken == 0 { first } else { pass };
            halves.keep((&Tile { x: 0, y: 0, width: 1, height: 1 }, 1), |_| DVec3::ZERO, numbers.clone(), 0);
            taken = numbers.end;
            let share = f64::from(halves.nearest_to_half(0, taken).samples) / f64::from(taken);
            // passes that are not aligned come up to three samples too soon
            let few = taken <= 2 * pass.max(first);
            assert!(few || (0.24..0.76).contains(&share), "{share} of {taken} samples, in passes of {pass}");
            assert!(taken < 32 || (0.31..0.69).contains(&share), "{share} of {taken} samples, in passes of {pass}");
        }
    }
}
