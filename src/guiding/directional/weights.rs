//! Drawing by weights of which the running sums are known.

use crate::math::ONE_MINUS_EPSILON;
use glam::Vec3;

/// Probability of the `k`-th by the weights that end at `ends`; each alike where there is none.
#[inline]
pub fn pmf(ends: &[f32], k: usize) -> f32 {
    let whole = ends[ends.len() - 1];
    if whole > 0.0 { weight(ends, k) / whole } else { 1.0 / ends.len() as f32 }
}

/// Weight of the `k`-th.
#[inline]
pub fn weight(ends: &[f32], k: usize) -> f32 {
    ends[k] - if k == 0 { 0.0 } else { ends[k - 1] }
}

/// Draws in proportion to the weights; each alike where there is none.
#[inline]
pub fn draw(ends: &[f32], u: f64) -> usize {
    let whole = ends[ends.len() - 1];
    if whole > 0.0 {
        let at = (u as f32).min(ONE_MINUS_EPSILON) * whole;
        ends.partition_point(|&end| end <= at).min(ends.len() - 1)
    } else {
        (u * ends.len() as f64) as usize
    }
}

/// The running sums of weights times values, of which only those are asked for whose weight is positive.
pub struct Product<F> {
    value: F,
    sum: f32,
    pub ends: Vec<f32>,
}

impl<F: Fn(Vec3) -> f32> Product<F> {
    pub fn with(value: F) -> Product<F> {
        Product { value, sum: 0.0, ends: Vec::new() }
    }

    /// Takes the next weight, and where its value is asked for.
    pub fn add(&mut self, weight: f32, at: Vec3) {
        self.sum += if weight > 0.0 { weight * (self.value)(at) } else { 0.0 };
        self.ends.push(self.sum);
    }
}
