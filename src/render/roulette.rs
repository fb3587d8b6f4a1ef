//! The normalisation of guided roulette: the picture so far, its noise and its cost.

use super::noise::{Noise, OUTLIERS};
use crate::integrator::{Counters, RouletteNormalisation};

/// Samples per pixel that the guide must have learnt from before it and the picture say enough.
const MIN_SAMPLES: u32 = 7;

/// Factor on the number of paths that the averages ask for. They lag one iteration behind while the variance falls. Fitted
/// at equal time, on scenes lit through a gap: better than 0.5 and 1.
const SPLIT_BIAS: f64 = 1.5;

/// The guide learnt from so many samples per pixel; `counters` are those of the iteration that made the newest part of the
/// picture.
pub fn normalisation(noise: &Noise, learnt: u32, counters: &Counters) -> Option<RouletteNormalisation> {
    of(&noise.squares, || noise.variance(OUTLIERS), learnt, counters)
}

/// The same by the squared luminance that is expected of each pixel (or block of pixels), and the variance of one sample relative
/// to it, on average.
pub fn of(
    squares: &[f64],
    variance: impl FnOnce() -> f64,
    learnt: u32,
    counters: &Counters,
) -> Option<RouletteNormalisation> {
    if learnt < MIN_SAMPLES {
        return None;
    }
    let rays = (counters.rays as f64 / counters.paths.max(1) as f64).max(1.0);
    Some(RouletteNormalisation {
        // finite also where a picture is darker than the lights by more than an `f32` tells
        inverse_luminance: squares.iter().map(|square| (square.sqrt().recip() as f32).min(f32::MAX)).collect(),
        scale: (SPLIT_BIAS * (rays / variance()).sqrt()) as f32,
    })
}

#[cfg(test)]
#[path = "roulette_tests.rs"]
mod tests;
