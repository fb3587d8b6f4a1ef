//! What guided roulette weighs paths against: the picture so far and what it cost.

use super::noise::{Noise, OUTLIERS};
use crate::integrator::{Counters, RouletteNormalisation};

/// Samples per pixel before picture and guide say enough.
const MIN_SAMPLES: u32 = 7;

/// How much more is split than the averages ask for. Those lag one iteration behind while the variance falls; at equal
/// time, 1.5 did better than 0.5 and 1 on the scenes with an ajar door.
const BOLDNESS: f64 = 1.5;

/// The guide learnt from so many samples per pixel; `counters` are those of the iteration that made the newest part of the
/// picture.
pub fn efficiency(noise: &Noise, learnt: u32, counters: &Counters) -> Option<RouletteNormalisation> {
    if learnt < MIN_SAMPLES {
        return None;
    }
    let rays = (counters.rays as f64 / counters.paths.max(1) as f64).max(1.0);
    Some(RouletteNormalisation {
        // finite also where a picture is darker than the lights by more than an `f32` tells
        inverse_luminance: noise.squares.iter().map(|square| (square.sqrt().recip() as f32).min(f32::MAX)).collect(),
        scale: (BOLDNESS * (rays / noise.variance(OUTLIERS)).sqrt()) as f32,
    })
}

#[cfg(test)]
#[path = "efficiency_tests.rs"]
mod tests;
