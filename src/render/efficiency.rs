//! What guided roulette weighs paths against: the picture so far and what it cost.

use crate::film::accumulate::{Estimate, Film};
use crate::integrator::{Counters, Efficiency};
use crate::math::luminance;

/// Samples per pixel before a picture says enough.
const MIN_SAMPLES: u32 = 7;

/// Pixels to either side over which the picture is averaged.
const REACH: usize = 3;

/// Share of the picture's mean luminance below which darker pixels are no more important.
const FLOOR: f64 = 0.1;

/// Share of the pixels, the noisiest, that have no say in the average variance.
const OUTLIERS: f64 = 0.005;

/// How much more is split than the averages ask for. Those lag one iteration behind while the variance falls; at equal
/// time, 1.5 did better than 0.5 and 1 on the scenes with an ajar door.
const BOLDNESS: f64 = 1.5;

/// `counters` are those of the iteration that made the newest part of the picture.
pub fn efficiency(film: &Film, counters: &Counters) -> Option<Efficiency> {
    weigh(&film.develop(), &film.sample_variances()?, counters)
}

/// `variances` are those of one sample of each pixel.
fn weigh(estimate: &Estimate, variances: &[f64], counters: &Counters) -> Option<Efficiency> {
    let (width, height) = (estimate.width as usize, estimate.height as usize);
    let light: Vec<f64> = estimate.mean.iter().map(|&c| luminance(c) as f64).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    if estimate.samples < MIN_SAMPLES || !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    let blurred = transpose(&blur(&transpose(&blur(&light, width), width), height), height);
    let squares: Vec<f64> = blurred.iter().map(|l| l * l + (FLOOR * mean).powi(2)).collect();
    let mut relative: Vec<f64> = variances.iter().zip(&squares).map(|(v, square)| v / square).collect();
    relative.sort_unstable_by(f64::total_cmp);
    let kept = ((1.0 - OUTLIERS) * relative.len() as f64).ceil() as usize;
    let variance = relative[..kept].iter().sum::<f64>() / kept as f64;
    if variance == 0.0 {
        return None;
    }
    let rays = (counters.rays as f64 / counters.paths.max(1) as f64).max(1.0);
    Some(Efficiency {
        inverse_luminance: squares.iter().map(|square| square.sqrt().recip() as f32).collect(),
        scale: (BOLDNESS * (rays / variance).sqrt()) as f32,
    })
}

/// Means over `REACH` values to either side in each line.
fn blur(values: &[f64], width: usize) -> Vec<f64> {
    let mean = |line: &[f64], x: usize| {
        let near = &line[x.saturating_sub(REACH)..(x + REACH + 1).min(line.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    values.chunks_exact(width).flat_map(|line| (0..width).map(move |x| mean(line, x))).collect()
}

fn transpose(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    (0..values.len()).map(|i| values[(i % height) * width + i / height]).collect()
}

#[cfg(test)]
#[path = "efficiency_tests.rs"]
mod tests;
