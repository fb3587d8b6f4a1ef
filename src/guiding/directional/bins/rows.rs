//! From what is known of a region's strata to the row that sampling reads.

use super::Strata;
use crate::guiding::directional::Entry;

/// Parts into which a row divides the unit interval.
pub const WHOLE: u32 = 1 << 16;

/// Estimates of Q by stratum: what few visits say leans towards the mean of what is known, and then each towards its
/// neighbours in the square.
pub fn estimates(entries: &[Entry], strata: &Strata, smoothing: f32) -> Vec<f32> {
    let known = entries.iter().filter(|e| e.visits > 0.0);
    let (sum, n) = known.fold((0.0, 0), |(sum, n), e| (sum + e.q, n + 1));
    let prior = if n > 0 { sum / n as f32 } else { 0.0 };
    let own: Vec<f32> = entries.iter().map(|e| e.shrunk(prior)).collect();
    if smoothing == 0.0 {
        return own;
    }
    let (columns, lines) = (strata.columns(), strata.lines());
    let neighbours = |k: usize| {
        let (x, y) = (k % columns, k / columns);
        let near = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        near.into_iter().filter(move |&(x, y)| x < columns && y < lines).map(move |(x, y)| y * columns + x)
    };
    let smoothed = |k: usize| {
        let (sum, n) = neighbours(k).fold((0.0, 0), |(sum, n), i| (sum + own[i], n + 1));
        if n == 0 { own[k] } else { (1.0 - smoothing) * own[k] + smoothing * sum / n as f32 }
    };
    (0..own.len()).map(smoothed).collect()
}

/// A row for drawing strata in proportion to `weights`.
pub fn strata_row(strata: &Strata, weights: &[f64]) -> Vec<u16> {
    let whole: f64 = weights.iter().sum();
    let (columns, lines) = (strata.columns(), strata.lines());
    let mut row = vec![0; lines + weights.len()];
    let mut begun = 0.0;
    for (k, weight) in weights.iter().enumerate() {
        let share = if whole > 0.0 { begun / whole } else { k as f64 / weights.len() as f64 };
        row[lines + k] = (share * WHOLE as f64).round().min((WHOLE - 1) as f64) as u16;
        begun += weight;
    }
    (0..lines).for_each(|line| row[line] = row[lines + line * columns]);
    row
}
