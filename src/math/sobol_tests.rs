//! Points against what Sobol' and Owen promise of them. Random seeds are fixed, so that a test passes always or never; the
//! bounds are five standard errors or a level of 10⁻⁶, for whoever changes them.

use super::*;
use crate::math::hash::hash4;
use crate::math::rng::Rng;
use crate::stats::chi2_discrete;

const LEVEL: f64 = 1e-6;

fn seeds<const N: usize>(rng: &mut Rng) -> Seeds<N> {
    let mut row = || std::array::from_fn(|_| rng.next_u32());
    Seeds { shuffle: row(), scramble: [row(), row(), row(), row()] }
}

/// One point, in steps of 2⁻³².
fn point(number: u32, seeds: &Seeds<1>) -> [u32; DIMENSIONS] {
    points::<4, 1>(&[number], 32, seeds).map(|[x]| x)
}

fn unit(x: u32) -> f64 {
    (f64::from(x) + 0.5) / 4_294_967_296.0
}

#[test]
fn the_sequence_is_that_of_joe_and_kuo() {
    // their points 1 to 7, which come in the order of the Gray code
    let theirs = [
        [0.5, 0.5, 0.5, 0.5],
        [0.75, 0.25, 0.25, 0.25],
        [0.25, 0.75, 0.75, 0.75],
        [0.375, 0.375, 0.625, 0.875],
        [0.875, 0.875, 0.125, 0.375],
        [0.625, 0.125, 0.875, 0.625],
        [0.125, 0.625, 0.375, 0.125],
    ];
    for (n, theirs) in (1u32..).zip(theirs) {
        let gray = n ^ n >> 1;
        for d in 0..DIMENSIONS {
            let x = (0..32).filter(|bit| gray >> bit & 1 == 1).fold(0, |x, bit| x ^ DIRECTIONS[d][bit]);
            assert_eq!(f64::from(x.reverse_bits()) / 4_294_967_296.0, theirs[d], "point {n}, dimension {d}");
        }
    }
}

#[test]
fn points_side_by_side_are_those_alone_and_depend_on_their_numbers_and_seeds_only() {
    let mut rng = Rng::new(1);
    for round in 0..200 {
        let seeds = seeds::<16>(&mut rng);
        let bits = round % 33;
        let number: [u32; 16] = std::array::from_fn(|_| rng.next_u32().checked_shr(32 - bits).unwrap_or(0));
        let together = points::<4, 16>(&number, bits, &seeds);
        for k in 0..16 {
            let own = Seeds { shuffle: [seeds.shuffle[k]], scramble: seeds.scramble.map(|row| [row[k]]) };
            assert_eq!(together.map(|row| row[k]), point(number[k], &own));
        }
        let [x, y] = points::<2, 16>(&number, (bits + 3).min(32), &seeds);
        assert_eq!([x, y], [together[0], together[1]], "as many dimensions as are asked for");
        assert_eq!(points::<1, 16>(&number, bits, &seeds), [together[0]]);
    }
}

/// How a nested uniform scramble is defined: a bit is flipped or not by a random function of its place and the bits above it.
#[test]
fn scrambles_are_nested() {
    let mut rng = Rng::new(2);
    for _ in 0..1000 {
        let (a, seed, shared) = (rng.next_u32(), rng.next_u32(), rng.next_u32() % 32);
        // the lowest bits, which come first in a number that is turned round, are the same; the next differs
        let b = (a ^ 1 << shared) ^ rng.next_u32().checked_shl(shared + 1).unwrap_or(0);
        let differ = scrambled(a, seed) ^ scrambled(b, seed);
        assert_eq!(differ.trailing_zeros(), shared);
    }
}

/// The most points by which a count in an elementary interval of volume 2ᵗ⁻ᵐ differs from 2ᵗ, over all shapes of two or four
/// dimensions, where `x` are 2ᵐ points.
fn unevenness(x: &[[u32; DIMENSIONS]], dimensions: &[usize], t: u32) -> usize {
    let m = x.len().ilog2();
    let Some(halvings) = m.checked_sub(t) else { return 0 };
    let mut worst = 0;
    let mut shape = vec![0; dimensions.len()];
    for code in 0..(halvings + 1).pow(dimensions.len() as u32 - 1) {
        let (mut rest, mut code) = (Some(halvings), code);
        for cuts in shape.iter_mut().skip(1) {
            (*cuts, code) = (code % (halvings + 1), code / (halvings + 1));
            rest = rest.and_then(|rest| rest.checked_sub(*cuts));
        }
        let Some(rest) = rest else { continue };
        shape[0] = rest;
        let mut counts = vec![0usize; 1 << halvings];
        for point in x {
            let cell = dimensions.iter().zip(&shape).fold(0, |cell, (&d, &cuts)| {
                let high = point[d].checked_shr(32 - cuts).unwrap_or(0) as usize;
                cell << cuts | high
            });
            counts[cell] += 1;
        }
        worst = counts.iter().fold(worst, |worst, count| worst.max(count.abs_diff(1 << t)));
    }
    worst
}

#[test]
fn elementary_intervals_hold_as_many_points_as_each_other() {
    let mut rng = Rng::new(3);
    // degrees of the primitive polynomials less one add up to t (Sobol' 1967)
    let pairs: [(&[usize], u32); 7] =
        [(&[0, 1], 0), (&[0, 2], 1), (&[1, 2], 1), (&[0, 3], 2), (&[1, 3], 2), (&[2, 3], 3), (&[0, 1, 2, 3], 3)];
    for m in 0..=9 {
        for _ in 0..4 {
            let seeds = seeds(&mut rng);
            for first in [0, 1, 5] {
                let x: Vec<_> = (first << m..(first + 1) << m).map(|n| point(n, &seeds)).collect();
                for (dimensions, t) in pairs {
                    assert_eq!(unevenness(&x, dimensions, t), 0, "2^{m} points from {first}, {dimensions:?}");
                }
                for d in 0..DIMENSIONS {
                    assert_eq!(unevenness(&x, &[d], 0), 0, "2^{m} points from {first}, {d}");
                }
            }
        }
    }
    let random: Vec<_> = (0..256).map(|_| [(); 4].map(|()| rng.next_u32())).collect();
    assert!(pairs.iter().all(|(dimensions, t)| unevenness(&random, dimensions, *t) > 0), "independent ones do not");
}

#[test]
fn every_point_is_uniform_over_the_seeds() {
    let mut rng = Rng::new(4);
    for number in [0, 1, 2, 3, 7, 16, 63, 100, 4097, u32::MAX] {
        for [a, b] in [[0, 1], [0, 2], [1, 3], [2, 3]] {
            let mut counts = [0u64; 256];
            for _ in 0..40_000 {
                let x = point(number, &seeds(&mut rng));
                counts[(x[a] >> 28 << 4 | x[b] >> 28) as usize] += 1;
            }
            let report = chi2_discrete(&counts, &[1.0 / 256.0; 256]);
            assert!(report.passes(LEVEL), "number {number}, dimensions {a} and {b}: {report}");
        }
        // and in its lower bits
        for d in 0..DIMENSIONS {
            let mut counts = [0u64; 256];
            (0..40_000).for_each(|_| counts[(point(number, &seeds(&mut rng))[d] >> 8 & 255) as usize] += 1);
            let report = chi2_discrete(&counts, &[1.0 / 256.0; 256]);
            assert!(report.passes(LEVEL), "number {number}, low bits of dimension {d}: {report}");
        }
    }
}

/// Mean of `f` over the first `n` points, over many seeds: mean and variance, relative to what independent points have.
fn over_seeds(n: u32, rng: &mut Rng, f: impl Fn([f64; DIMENSIONS]) -> f64) -> (f64, f64) {
    const SETS: u32 = 4000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..SETS {
        let seeds = seeds(rng);
        let mean = (0..n).map(|i| f(point(i, &seeds).map(unit))).sum::<f64>() / f64::from(n);
        (sum, squares) = (sum + mean, squares + mean * mean);
    }
    let mean = sum / f64::from(SETS);
    (mean, squares / f64::from(SETS) - mean * mean)
}

#[test]
fn a_line_has_the_variance_that_owen_found() {
    let mut rng = Rng::new(5);
    for (m, d) in [(0, 0), (1, 1), (2, 2), (3, 3), (4, 0), (5, 1), (6, 2), (6, 3)] {
        // strata of width 1/n, each with one uniform point, independent of the others
        let n = f64::from(1 << m);
        let (mean, variance) = over_seeds(1 << m, &mut rng, |x| x[d]);
        let expected = 1.0 / (12.0 * n.powi(3));
        assert!((mean - 0.5).abs() < 5.0 * (expected / 4000.0).sqrt(), "2^{m} points: {mean}");
        // a variance of 4 000 numbers, about normal: 2.2 % each standard error
        assert!((variance / expected - 1.0).abs() < 0.112, "2^{m} points, dimension {d}: {}", variance / expected);
    }
}

#[test]
fn discontinuities_and_products_are_integrated_with_less_noise_than_by_independent_points() {
    let mut rng = Rng::new(6);
    let disk = |x: [f64; 4]| f64::from(u8::from(x[0] * x[0] + x[1] * x[1] < 1.0));
    let quarter = std::f64::consts::FRAC_PI_4;
    let (mean, variance) = over_seeds(64, &mut rng, disk);
    let independent = quarter * (1.0 - quarter) / 64.0;
    assert!((mean - quarter).abs() < 5.0 * (variance / 4000.0).sqrt(), "{mean}");
    assert!(variance < independent / 5.0, "{} of it", variance / independent);
    let (mean, variance) = over_seeds(64, &mut rng, |x| x[0] * x[1] * x[2] * x[3]);
    let independent = ((1.0f64 / 3.0).powi(4) - 1.0 / 256.0) / 64.0;
    assert!((mean - 1.0 / 16.0).abs() < 5.0 * (variance / 4000.0).sqrt(), "{mean}");
    assert!(variance < independent / 20.0, "{} of it", variance / independent);
}

/// Variance of the mean of x·y over `2^levels` points, x and y from two sets and both about 0, relative to independent points'.
///
/// Two points whose numbers differ first in bit h, counted from the lowest, have c digits in common, where a shuffle makes c
/// geometric up to h; they are then in the two halves of an interval of width 2⁻ᶜ.
fn variance_of_pairs(levels: u32) -> f64 {
    let covariance = |c: u32| (1.0 - 0.25f64.powi(c as i32)) / 12.0 - 0.25f64.powi(c as i32) / 16.0;
    let of_pair = |h: u32| {
        let shorter: f64 = (0..h).map(|c| 0.5f64.powi(c as i32 + 1) * covariance(c)).sum();
        shorter + 0.5f64.powi(h as i32) * covariance(h)
    };
    1.0 + (0..levels).map(|h| f64::from(1 << h) * (12.0 * of_pair(h)).powi(2)).sum::<f64>()
}

#[test]
fn sets_with_other_seeds_know_nothing_of_each_other_but_that_neighbours_are_in_other_halves() {
    let mut rng = Rng::new(7);
    let n = 16u32;
    let product = |rng: &mut Rng, shuffled: bool| {
        let (a, mut b) = (seeds(rng), seeds(rng));
        b.shuffle = if shuffled { b.shuffle } else { a.shuffle };
        let centred = |i, seeds: &Seeds<1>| unit(point(i, seeds)[0]) - 0.5;
        (0..n).map(|i| centred(i, &a) * centred(i, &b)).sum::<f64>() / f64::from(n)
    };
    let mut squares = |shuffled| (0..20_000).map(|_| product(&mut rng, shuffled).powi(2)).sum::<f64>() / 20_000.0;
    let independent = 1.0 / (144.0 * f64::from(n));
    let (with, without, expected) =
        (squares(true) / independent, squares(false) / independent, variance_of_pairs(n.ilog2()));
    // the price of prefixes that are nets: in both sets two neighbours lie in opposite halves, always
    assert!(expected > 1.5, "{expected}");
    // a variance of 20 000 numbers, about normal: 1 % each standard error
    assert!((with / expected - 1.0).abs() < 0.05, "{with} and not {expected} of independent points' variance");
    assert!(without > 2.0 * expected, "without a shuffle {without}");
}

#[test]
fn hashes_of_counters_pass_for_independent() {
    // neighbours in each word of the input, and neighbours among the words of the output
    for word in 0..4 {
        let at = |i: u32| {
            let mut input = [[7], [1], [2], [0x9e37_79b9]];
            input[word] = [i];
            let [a, b, c, d] = &input;
            hash4::<1>([a, b, c, d]).map(|[x]| x)
        };
        for (a, b, step) in [(0, 0, 1), (1, 1, 1), (2, 2, 1), (3, 3, 1), (0, 1, 0), (1, 2, 0), (2, 3, 0), (0, 3, 0)] {
            for low in [28, 8, 0] {
                let mut counts = [0u64; 256];
                for i in 0..40_000 {
                    counts[((at(i)[a] >> low & 15) << 4 | at(i + step)[b] >> low & 15) as usize] += 1;
                }
                let report = chi2_discrete(&counts, &[1.0 / 256.0; 256]);
                assert!(report.passes(LEVEL), "word {word}, outputs {a} and {b}, bits from {low}: {report}");
            }
        }
    }
}
