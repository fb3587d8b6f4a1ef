//! Emission that varies over a triangle: points follow it, by a density that is told exactly.

use super::Estimate;
use crate::light::EmitterPattern;
use crate::light::pattern::{Fineness, TrianglePattern};
use crate::math::rng::Rng;
use crate::math::{Rgb, warp};
use crate::stats::chi2::chi2_discrete;
use std::sync::Arc;

/// Bright and red about one place, dim and grey elsewhere, black along an edge.
pub(super) struct Spot;

impl EmitterPattern for Spot {
    fn factor(&self, _triangle: u32, [b, c]: [f32; 2]) -> Rgb {
        let near = (b - 0.25).hypot(c - 0.6) < 0.08;
        if near { Rgb::new(1.0, 0.4, 0.3) } else { Rgb::splat(if b < 0.1 { 0.0 } else { 0.02 }) }
    }

    fn texels(&self, _triangle: u32) -> f64 {
        400.0
    }
}

/// Black but for a place that the points of a mean do not meet.
struct Needle;

impl EmitterPattern for Needle {
    fn factor(&self, _triangle: u32, [b, c]: [f32; 2]) -> Rgb {
        if (b - 0.3).abs() < 1e-4 && (c - 0.3).abs() < 1e-4 { Rgb::ONE } else { Rgb::ZERO }
    }

    fn texels(&self, _triangle: u32) -> f64 {
        100.0
    }
}

fn pattern(pattern: impl EmitterPattern + 'static) -> TrianglePattern {
    let pattern: Arc<dyn EmitterPattern> = Arc::new(pattern);
    TrianglePattern::new(&pattern, 0, Fineness::of([pattern.texels(0)].into_iter()))
}

#[test]
fn points_are_drawn_by_the_density_that_is_told() {
    const SIDE: usize = 20;
    let (spot, mut rng) = (pattern(Spot), Rng::new(5));
    let mut counts = vec![0u64; SIDE * SIDE];
    let mut agree = 0;
    for _ in 0..200_000 {
        let (u, density) = spot.warp(rng.f32x2());
        let cell = |x: f32| ((x * SIDE as f32) as usize).min(SIDE - 1);
        counts[cell(u[1]) * SIDE + cell(u[0])] += 1;
        // rounding takes points over the edges of cells, which are a small part of all
        agree += u32::from(spot.density(warp::square_to_triangle(u)) == density);
    }
    assert!(agree > 199_000, "{agree}");
    let expected: Vec<f64> = (0..SIDE * SIDE)
        .map(|i| {
            let centre = |k: usize| (k as f32 + 0.5) / SIDE as f32;
            let density = spot.density(warp::square_to_triangle([centre(i % SIDE), centre(i / SIDE)]));
            f64::from(density) / (SIDE * SIDE) as f64
        })
        .collect();
    assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-4);
    assert!(chi2_discrete(&counts, &expected).passes(1e-6));
    assert!(!chi2_discrete(&counts, &vec![1.0 / (SIDE * SIDE) as f64; SIDE * SIDE]).passes(1e-6), "uniform would pass");
}

#[test]
fn drawing_by_the_pattern_keeps_its_mean_and_takes_most_of_its_noise() {
    let (spot, mut rng) = (pattern(Spot), Rng::new(6));
    let plain = Estimate::of(400_000, || f64::from(spot.at(rng.f32x2()).y));
    let mut rng = Rng::new(7);
    let drawn = Estimate::of(400_000, || {
        let (u, density) = spot.warp(rng.f32x2());
        f64::from(spot.at(u).y / density)
    });
    let z = (plain.mean - drawn.mean) / plain.error.hypot(drawn.error);
    assert!(z.abs() < 5.0, "{} and {}", plain.mean, drawn.mean);
    assert!(drawn.error < 0.5 * plain.error, "{} is not half of {}", drawn.error, plain.error);
    assert!((f64::from(spot.mean().y) / drawn.mean - 1.0).abs() < 0.1, "{} for {}", spot.mean(), drawn.mean);
}

#[test]
fn what_the_means_have_missed_is_still_drawn() {
    let needle = pattern(Needle);
    assert!(needle.mean().min_element() > 0.0 && needle.density([0.3, 0.3]) > 0.0);
}

/// A scene of very many patterns looks at each less closely.
#[test]
fn all_patterns_together_take_bounded_memory_and_time() {
    let shared = Fineness::of(std::iter::repeat_n(1e8, 10_000));
    assert!(10_000 * shared.sides(1e8).0.pow(2) <= 1 << 22);
    let alone = Fineness::of([1e8].into_iter());
    assert_eq!(alone.sides(1e8), (128, 16));
    assert_eq!((alone.sides(0.3), alone.sides(9.0)), ((1, 4), (3, 2)));
}

#[test]
fn numbers_of_a_point_of_a_triangle_are_found_again() {
    let mut rng = Rng::new(8);
    for _ in 0..10_000 {
        let u = rng.f32x2();
        let back = warp::triangle_to_square(warp::square_to_triangle(u));
        // near a corner all numbers are one point
        let s = u[0].sqrt();
        assert!((back[0] - u[0]).abs() < 1e-6 && (back[1] - u[1]).abs() * s < 1e-6, "{u:?} {back:?}");
    }
    assert_eq!(warp::triangle_to_square([1.0, 0.0]), [0.0, 0.0]);
}
