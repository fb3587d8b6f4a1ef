//! Averages over pixels: over the neighbourhood of each, and over all but the noisiest.

use rayon::prelude::*;
use std::ops::Range;

/// Pixels to either side over which a picture is averaged.
pub(super) const REACH: usize = 3;

/// Means over a square of pixels, of those that count; 0 where none does.
pub(crate) fn blur(values: &[f64], counts: impl Fn(usize) -> bool + Sync, width: usize) -> Vec<f64> {
    let of_those = |value: &(dyn Fn(usize) -> f64 + Sync)| -> Vec<f64> {
        (0..values.len()).into_par_iter().map(|i| if counts(i) { value(i) } else { 0.0 }).collect()
    };
    let (mut sums, weights) = (box_sums(of_those(&|i| values[i]), width), box_sums(of_those(&|_| 1.0), width));
    sums.par_iter_mut().zip(weights).for_each(|(sum, weight)| *sum = if weight > 0.0 { *sum / weight } else { 0.0 });
    sums
}

/// In place of the values: memory that is new costs more than the sums.
fn box_sums(mut values: Vec<f64>, width: usize) -> Vec<f64> {
    let lines = line_sums(&values, width);
    column_sums(&lines, width, &mut values);
    values
}

fn line_sums(values: &[f64], width: usize) -> Vec<f64> {
    let near = |line: &[f64], x: usize| line[neighbours(x, width)].iter().sum();
    let mut sums = vec![0.0; values.len()];
    sums.par_chunks_exact_mut(width).zip(values.par_chunks_exact(width)).for_each(|(sums, line)| {
        sums.iter_mut().enumerate().for_each(|(x, sum)| *sum = near(line, x));
    });
    sums
}

/// Line by line: columns side by side run in vectors.
fn column_sums(values: &[f64], width: usize, sums: &mut [f64]) {
    sums.par_chunks_exact_mut(width).enumerate().for_each(|(y, sums)| {
        sums.fill(0.0);
        for line in neighbours(y, values.len() / width).map(|y| &values[y * width..][..width]) {
            sums.iter_mut().zip(line).for_each(|(sum, value)| *sum += value);
        }
    });
}

fn neighbours(at: usize, size: usize) -> Range<usize> {
    at.saturating_sub(REACH)..(at + REACH + 1).min(size)
}

/// Mean of all but a share of the largest.
pub(crate) fn mean_without_largest(mut values: Vec<f64>, share: f64) -> f64 {
    let kept = values.len() - (share * values.len() as f64) as usize;
    if kept < values.len() {
        values.select_nth_unstable_by(kept, f64::total_cmp);
    }
    values[..kept].iter().sum::<f64>() / kept.max(1) as f64
}
