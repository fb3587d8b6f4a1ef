//! Whatever samples a film is given, its picture is finite; and black groups have no say in how noise is weighed.

use super::*;
use crate::film::group::parity;
use proptest::prelude::*;

const COMBINES: [Combine; 3] = [Combine::InverseVariance, Combine::All, Combine::Last];

/// A film of `width` columns after iterations, each of which gives every pixel its samples: `samples` says which.
fn film(combine: Combine, size: [u32; 2], iterations: &[u32], mut sample: impl FnMut(usize, u32) -> Rgb) -> Film {
    let mut film = Film::new(size[0], size[1], combine, &[]);
    let tile = Tile { x: 0, y: 0, width: size[0], height: size[1] };
    let mut taken = 0;
    for &spp in iterations {
        for _ in 0..spp {
            let sum: Vec<Rgb> = (0..tile.pixels()).map(|pixel| sample(pixel, taken)).collect();
            let sum_squares = sum.iter().map(|&v| v * v).collect();
            film.add(&tile, &TileSamples { sum, sum_squares, ..TileSamples::default() });
            taken += 1;
        }
        film.add_samples(spp, false);
        film.end_iteration();
    }
    film
}

fn check_finite(film: &Film) {
    let Estimate { mean, variance, .. } = film.resolve();
    assert!(mean.iter().chain(&variance).all(|v| v.is_finite() && v.min_element() >= 0.0), "{mean:?} ± {variance:?}");
    let variances = film.newest_variances().into_iter().chain(film.sample_variances()).flatten();
    assert!(variances.into_iter().all(|v| v.is_finite() && v >= 0.0));
}

/// Zero, subnormal, ordinary and huge numbers. Their sums over the samples of one tile stay within an `f32`.
fn value() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => Just(0.0f32),
        1 => (1u32..1 << 23).prop_map(f32::from_bits),
        2 => (-126i32..127).prop_map(|e| 1.5 * (e as f32).exp2()),
        1 => Just(f32::MAX / 4.0),
        2 => 0.0f32..2.0,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_samples_give_a_finite_picture(
        values in proptest::collection::vec(value(), 64),
        black in proptest::collection::vec(any::<bool>(), 4),
        size in [1u32..5, 1u32..5],
        combine in 0usize..3,
    ) {
        // whole iterations are black now and then, for one colour of the checkerboard or for both
        let sample = |pixel: usize, taken: u32| {
            let iteration = (taken / 4).min(3) as usize;
            let colour = parity(pixel, size[0] as usize);
            let at = |k: usize| values[(7 * pixel + 13 * taken as usize + k) % values.len()];
            if black[iteration] && (colour == 0 || black[3 - iteration]) { Rgb::ZERO } else { Rgb::new(at(0), at(1), at(2)) }
        };
        for lengths in [&[1u32][..], &[4], &[1, 2, 4], &[4, 4, 4, 4], &[4, 4, 4, 2]] {
            check_finite(&film(COMBINES[combine], size, lengths, sample));
        }
    }
}

/// A pixel of each colour that has light in an iteration; all others are black there.
fn lit(iterations: [[bool; 2]; 4]) -> impl Fn(usize, u32) -> Rgb {
    move |pixel, taken| {
        // half of the samples hold it, so that they vary
        let light = taken % 2 == 0 && pixel < 2 && iterations[(taken / 4) as usize][pixel];
        Rgb::splat(if light { 1.0 } else { 0.0 })
    }
}

#[test]
fn groups_that_are_black_in_a_colour_give_a_finite_picture() {
    for pattern in 0..256u32 {
        let iterations = [0, 1, 2, 3].map(|k| [0, 1].map(|colour| pattern >> (2 * k + colour) & 1 == 1));
        let film = film(Combine::InverseVariance, [6, 4], &[4, 4, 4, 4], lit(iterations));
        check_finite(&film);
        let mean = film.resolve().mean;
        for colour in [0, 1] {
            let any = iterations.iter().any(|lit| lit[colour]);
            assert_eq!(mean[colour] != Rgb::ZERO, any, "{iterations:?}: what an iteration found is in the picture");
        }
    }
}

/// The variance of a black group is 0: taken at its word, it would count for everything, and the light for nothing.
#[test]
fn a_black_group_counts_as_much_as_its_samples() {
    for black in [0, 2, 3] {
        let mut iterations = [[true; 2]; 4];
        iterations[black] = [false; 2];
        let film = film(Combine::InverseVariance, [6, 4], &[4, 4, 4, 4], lit(iterations));
        let mean = film.resolve().mean[0].x;
        assert!((mean - 0.5 * 0.75).abs() < 1e-6, "iteration {black} of 4 is black: {mean}");
    }
    let nothing = film(Combine::InverseVariance, [6, 4], &[4, 4], |_, _| Rgb::ZERO).resolve();
    assert!(nothing.mean.iter().chain(&nothing.variance).all(|&v| v == Rgb::ZERO));
}

#[test]
fn noiseless_groups_are_weighed_alike() {
    let film = film(Combine::InverseVariance, [6, 4], &[4, 4, 8], |pixel, _| Rgb::splat(1.0 + pixel as f32));
    assert!(film.resolve().mean.iter().enumerate().all(|(pixel, &v)| v == Rgb::splat(1.0 + pixel as f32)));
}
