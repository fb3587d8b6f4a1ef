//! The normalisation of guided roulette: the picture so far, its noise and its cost.

use super::noise::{Noise, OUTLIERS};
use crate::integrator::{Counters, RouletteNormalisation};

/// Samples per pixel, or camera paths in a large picture, that the guide must have learnt from before it says enough: the lessons
/// and iterations in which its cells are refined three times.
const MIN_SAMPLES: u32 = 7;
const MIN_PATHS: u64 = 7 << 15;

/// Factor on the number of paths that the averages ask for. They lag one iteration behind while the variance falls. Fitted
/// at equal time, on scenes lit through a gap: better than 0.5 and 1.
const SPLIT_BIAS: f64 = 1.5;

/// Whether a guide that has learnt from so many samples per pixel, and camera paths in all, knows enough.
pub fn knows_enough(samples: u32, paths: u64) -> bool {
    samples >= MIN_SAMPLES || paths >= MIN_PATHS
}

/// Goes by the newest picture; `counters` are those of the iteration that made the newest part of it.
pub fn normalisation(noise: &Noise, counters: &Counters) -> RouletteNormalisation {
    let rays = (counters.rays as f64 / counters.paths.max(1) as f64).max(1.0);
    RouletteNormalisation {
        // finite also where a picture is darker than the lights by more than an `f32` tells
        inverse_luminance: noise.squares.iter().map(|square| (square.sqrt().recip() as f32).min(f32::MAX)).collect(),
        scale: (SPLIT_BIAS * (rays / noise.variance(OUTLIERS)).sqrt()) as f32,
    }
}

#[cfg(test)]
#[path = "roulette_tests.rs"]
mod tests;
