//! Averages over the neighbours of a pixel that show the same as it does: they end at edges.

use super::blur::REACH;
use rayon::prelude::*;
use std::ops::Range;

/// Standard errors by which two pixels differ that show different things. Of pixels that show the same, with normal noise,
/// one pair in 370 differs by more.
const TELLING: f64 = 3.0;

/// What is averaged, in units of the picture's mean.
struct Pixels<'a> {
    values: &'a [f32],
    /// Of the values, times `TELLING`².
    variances: &'a [f32],
    width: usize,
}

/// Means over a square of pixels about each, of those alone that differ from it by no more than noise explains. `variances`
/// are those of the values, `mean` is about as large as these are on average: positive, and finite as they are.
///
/// The noise of the picture itself tells its edges, whatever makes them: another surface, a texture, an emitter or the border
/// of a shadow, which albedo, normal and depth would not show. Where noise hides an edge, the mean goes across it, as a mean
/// over the whole square would. A rare bright sample makes a pixel as uncertain as it is bright, and so is averaged with the
/// pixels about it: the mean stays that of all samples, and not of those alone that missed the light. The more samples, the
/// finer the edges that show; the limit is the pixel itself.
pub(crate) fn mean_of_alike(values: &[f64], variances: &[f64], mean: f64, width: usize) -> Vec<f64> {
    // relative, so that squares hold in single precision at any exposure
    let scaled = |of: &[f64], by: f64| -> Vec<f32> { of.par_iter().map(|v| (v * by) as f32).collect() };
    let inverse = mean.recip();
    let (values, variances) = (scaled(values, inverse), scaled(variances, (TELLING * inverse).powi(2)));
    let pixels = Pixels { values: &values, variances: &variances, width };
    let mut means = vec![0.0; values.len()];
    means.par_chunks_exact_mut(width).enumerate().for_each(|(y, means)| pixels.line(y, mean, means));
    means
}

impl Pixels<'_> {
    /// The means of line `y`.
    fn line(&self, y: usize, mean: f64, means: &mut [f64]) {
        let (mut sums, mut counts) = (vec![0.0; self.width], vec![0.0; self.width]);
        for other in y.saturating_sub(REACH)..(y + REACH + 1).min(self.values.len() / self.width) {
            for shift in -(REACH as isize)..=REACH as isize {
                self.add_alike(y, other, shift, &mut sums, &mut counts);
            }
        }
        // every pixel is at least like itself
        let relative = sums.iter().zip(&counts).map(|(sum, count)| (sum / count) as f64);
        means.iter_mut().zip(relative).for_each(|(to, relative)| *to = relative * mean);
    }

    /// Adds to the pixels of line `y` those of line `other` that stand `shift` columns further, where they are alike. Without
    /// a jump, so that pixels run side by side.
    #[inline(always)]
    fn add_alike(&self, y: usize, other: usize, shift: isize, sums: &mut [f32], counts: &mut [f32]) {
        let from = shift.min(0).unsigned_abs().min(self.width);
        let n = self.width - shift.unsigned_abs().min(self.width);
        let at =
            |line: usize, column: usize| -> Range<usize> { line * self.width + column..line * self.width + column + n };
        let (own, theirs) = (at(y, from), at(other, shift.max(0) as usize * (n > 0) as usize));
        let (a, b) = (&self.values[own.clone()], &self.values[theirs.clone()]);
        let (va, vb) = (&self.variances[own], &self.variances[theirs]);
        let (sums, counts) = (&mut sums[from..from + n], &mut counts[from..from + n]);
        for k in 0..n {
            let difference = a[k] - b[k];
            let alike = if difference * difference <= va[k] + vb[k] { 1.0 } else { 0.0 };
            sums[k] += alike * b[k];
            counts[k] += alike;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    /// About normal, mean 0 and variance 1.
    fn normal(rng: &mut Rng) -> f64 {
        (0..12).map(|_| rng.f32() as f64).sum::<f64>() - 6.0
    }

    /// The same, done pixel by pixel.
    fn plain(values: &[f64], variances: &[f64], width: usize) -> Vec<f64> {
        let height = values.len() / width;
        let near =
            |i: usize, j: usize| (i % width).abs_diff(j % width) <= REACH && (i / width).abs_diff(j / width) <= REACH;
        let alike = |i: usize, j: usize| (values[i] - values[j]).powi(2) <= 9.0 * (variances[i] + variances[j]);
        let mean = |i: usize| {
            let all: Vec<f64> = (0..width * height).filter(|&j| near(i, j) && alike(i, j)).map(|j| values[j]).collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        (0..values.len()).map(mean).collect()
    }

    #[test]
    fn means_are_those_worked_out_pixel_by_pixel() {
        let mut rng = Rng::new(3);
        for (width, height) in [(1, 1), (2, 9), (9, 2), (3, 3), (17, 11), (64, 5)] {
            for scale in [1.0, 1e-30, 1e30] {
                let mut draw = |k: f64| -> Vec<f64> { (0..width * height).map(|_| k * rng.f32() as f64).collect() };
                let (values, variances) = (draw(scale), draw(0.01 * scale * scale));
                let (found, wanted) =
                    (mean_of_alike(&values, &variances, 0.5 * scale, width), plain(&values, &variances, width));
                for (i, (a, b)) in found.iter().zip(&wanted).enumerate() {
                    assert!((a / b - 1.0).abs() < 1e-5, "{width} × {height}, pixel {i}: {a:e} and not {b:e}");
                }
            }
        }
    }

    #[test]
    fn noise_is_averaged_and_edges_stay() {
        let (mut rng, width) = (Rng::new(5), 64);
        // 1 on the left, 20 on the right, with a tenth of noise
        let level = |i: usize| if i % width < width / 2 { 1.0 } else { 20.0 };
        let values: Vec<f64> = (0..width * width).map(|i| level(i) * (1.0 + 0.1 * normal(&mut rng))).collect();
        let variances: Vec<f64> = (0..width * width).map(|i| (0.1 * level(i)).powi(2)).collect();
        let found = mean_of_alike(&values, &variances, 10.5, width);
        // beside the edge at least 4 × 4 pixels of noise 0.1 are averaged: 0.025, and five of these
        assert!(found.iter().enumerate().all(|(i, v)| (v / level(i) - 1.0).abs() < 0.125));
        // noise as large as what it hides: a mean over the square
        let hidden = mean_of_alike(&values, &vec![400.0; width * width], 10.5, width);
        assert!(hidden[32 * width + 31] > 5.0 && hidden[32 * width + 32] < 15.0);
    }

    #[test]
    fn a_rare_bright_sample_is_shared_with_the_pixels_about_it() {
        // one of 16 samples of one pixel is 160: its mean is 10, the standard error as much
        let (width, at) = (15, 7 * 15 + 7);
        let (mut values, mut variances) = (vec![0.1; 225], vec![1e-6; 225]);
        (values[at], variances[at]) = (10.0, 100.0);
        let found = mean_of_alike(&values, &variances, 0.15, width);
        for (i, v) in found.iter().enumerate() {
            let inside = (i % width).abs_diff(7) <= REACH && (i / width).abs_diff(7) <= REACH;
            let wanted = if inside { (10.0 + 48.0 * 0.1) / 49.0 } else { 0.1 };
            assert!((v / wanted - 1.0).abs() < 1e-5, "{i}: {v}");
        }
    }
}
