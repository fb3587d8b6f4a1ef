//! Averages over pixels: over the neighbourhood of each, and over all but the noisiest.

use rayon::prelude::*;

/// Pixels to either side over which a picture is averaged.
const REACH: usize = 3;

/// Means over a square of pixels, of those that count; 0 where none does.
pub fn blur(values: &[f64], counts: impl Fn(usize) -> bool, width: usize) -> Vec<f64> {
    let masked = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..values.len()).map(|i| if counts(i) { value(i) } else { 0.0 }).collect()
    };
    let (sums, weights) = (box_sums(&masked(&|i| values[i]), width), box_sums(&masked(&|_| 1.0), width));
    sums.iter().zip(weights).map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 0.0 }).collect()
}

fn box_sums(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    transpose(&line_sums(&transpose(&line_sums(values, width), width), height), height)
}

fn line_sums(values: &[f64], width: usize) -> Vec<f64> {
    let near = |line: &[f64], x: usize| line[x.saturating_sub(REACH)..(x + REACH + 1).min(line.len())].iter().sum();
    let lines = values.par_chunks_exact(width);
    lines.flat_map_iter(|line| (0..width).map(move |x| near(line, x))).collect()
}

fn transpose(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    (0..width).into_par_iter().flat_map_iter(|x| (0..height).map(move |y| values[y * width + x])).collect()
}

/// Mean of all but a share of the largest.
pub fn mean_without_largest(mut values: Vec<f64>, share: f64) -> f64 {
    let kept = values.len() - (share * values.len() as f64) as usize;
    if kept < values.len() {
        values.select_nth_unstable_by(kept, f64::total_cmp);
    }
    values[..kept].iter().sum::<f64>() / kept.max(1) as f64
}
