//! From a picture and its reference to figures.

use super::bias::ReferenceBlocks;
use super::record::RunErrors;
use crate::Result;
use crate::image::Image;
use crate::image::flip::flip;
use crate::image::metrics::{compare, relative_squares};
use crate::math::{Rgb, luminance};

/// Blocks of the picture along each side, for the test of bias.
const BLOCKS: usize = 8;

/// Share of the pixels, the worst, that the trimmed relMSE leaves out.
const TRIMMED: f64 = 0.001;

/// A picture that others are compared with.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    pub(crate) image: Image,
    /// Of the pixels' means, where it is known.
    pub(crate) variance: Option<Vec<Rgb>>,
}

impl Reference {
    /// The reference's own relMSE, where its variance is known.
    pub(crate) fn noise(&self) -> Option<f64> {
        self.variance.as_ref().map(|variance| relative_noise(&self.image, variance))
    }

    /// Block means and their variances; channels count as fully correlated, which is no less than they are.
    pub(crate) fn blocks(&self) -> Option<ReferenceBlocks> {
        let deviation = |v: &Rgb| luminance(v.max(Rgb::ZERO).map(f32::sqrt));
        let squares: Vec<f64> = self.variance.as_ref()?.iter().map(|v| f64::from(deviation(v)).powi(2)).collect();
        let (width, height) = (self.image.width, self.image.height);
        let variance = block_sums(&squares, width, height).into_iter().map(|(sum, n)| sum / (n * n)).collect();
        Some(ReferenceBlocks { mean: blocks(&self.image), variance })
    }
}

/// relMSE that a picture has by the variance of its pixels' means alone, to first order.
pub(crate) fn relative_noise(image: &Image, variance: &[Rgb]) -> f64 {
    let relative = relative_variances(image, variance);
    relative.iter().sum::<f64>() / relative.len().max(1) as f64
}

fn relative_variances(image: &Image, variance: &[Rgb]) -> Vec<f64> {
    let of_pixel = |(v, r): (&Rgb, &Rgb)| {
        let (v, r) = (v.as_dvec3(), r.as_dvec3());
        (v / (r * r + 0.01)).element_sum() / 3.0
    };
    variance.iter().zip(&image.data).map(of_pixel).collect()
}

/// Mean luminance of 8 × 8 blocks of a picture, row by row; fewer in pictures of fewer pixels.
pub(crate) fn blocks(image: &Image) -> Vec<f64> {
    let light: Vec<f64> = image.data.iter().map(|c| luminance(*c).into()).collect();
    block_sums(&light, image.width, image.height).into_iter().map(|(sum, n)| sum / n).collect()
}

/// Sum and number of pixels of each block.
fn block_sums(values: &[f64], width: usize, height: usize) -> Vec<(f64, f64)> {
    let (columns, rows) = (BLOCKS.min(width), BLOCKS.min(height));
    let mut sums = vec![(0.0, 0.0); columns * rows];
    for (i, value) in values.iter().enumerate() {
        let (x, y) = (i % width * columns / width, i / width * rows / height);
        let block = &mut sums[y * columns + x];
        *block = (block.0 + value, block.1 + 1.0);
    }
    sums
}

/// All measures of a picture. The reference's own variance is taken off MSE, relMSE and trimmed relMSE, which makes them
/// unbiased (to first order in the variance); they may then fall below 0 where a reference is as noisy as the picture.
///
/// # Errors
/// [`crate::Error::Scene`] where the sizes differ.
pub(crate) fn errors(image: &Image, reference: &Reference, exposure: f32) -> Result<RunErrors> {
    let all = compare(image, &reference.image)?;
    let relative = relative_squares(image, &reference.image)?;
    let pixels = relative.len();
    let own = |variance: &Vec<Rgb>| relative_variances(&reference.image, variance);
    let noise = reference.variance.as_ref().map_or_else(|| vec![0.0; pixels], own);
    // Without their sign NaNs are the largest in the total order.
    let mut pairs: Vec<(f64, f64)> = relative.iter().map(|e| e.abs()).zip(noise.iter().copied()).collect();
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let kept = &pairs[..pixels - (pixels as f64 * TRIMMED) as usize];
    let trimmed = kept.iter().map(|(error, noise)| error - noise).sum::<f64>() / kept.len() as f64;
    let variance = reference.variance.iter().flatten().map(|v| f64::from(v.element_sum()) / 3.0);
    Ok(RunErrors {
        mse: all.mse - variance.sum::<f64>() / pixels as f64,
        relmse: all.relmse - noise.iter().sum::<f64>() / pixels as f64,
        relmse_trimmed: trimmed,
        mape: all.mape,
        smape: all.smape,
        flip: f64::from(flip(image, &reference.image, exposure)?),
        worst_permille: kept.last().map_or(0.0, |last| last.0),
    })
}

/// Mean of the pixels.
pub(crate) fn mean(image: &Image) -> [f64; 3] {
    let sum = image.data.iter().fold(glam::DVec3::ZERO, |sum, c| sum + c.as_dvec3());
    (sum / image.data.len().max(1) as f64).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    fn grey(width: usize, height: usize, value: impl Fn(usize) -> f32) -> Image {
        Image { width, height, data: (0..width * height).map(|i| Rgb::splat(value(i))).collect() }
    }

    #[test]
    fn measures_by_hand() {
        // 2 000 pixels of 1 against 2, of which two are far off: those are left out, the next is the worst
        let image = grey(50, 40, |i| {
            if i < 2 {
                12.0
            } else if i == 2 {
                4.0
            } else {
                1.0
            }
        });
        let reference = Reference { image: grey(50, 40, |_| 2.0), variance: Some(vec![Rgb::splat(0.5); 2000]) };
        let errors = errors(&image, &reference, 0.0).unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs(), "{a} is not {b}");
        close(errors.mse, (2.0 * 100.0 + 4.0 + 1997.0) / 2000.0 - 0.5);
        close(errors.relmse, (2.0 * 100.0 + 4.0 + 1997.0) / 2000.0 / 4.01 - 0.5 / 4.01);
        close(errors.relmse_trimmed, (4.0 + 1997.0) / 1998.0 / 4.01 - 0.5 / 4.01);
        close(errors.worst_permille, 4.0 / 4.01);
        close(errors.mape, (2.0 * 10.0 + 2.0 + 1997.0) / 2000.0 / 2.01);
        close(reference.noise().unwrap(), 0.5 / 4.01);
        let exact = Reference { variance: None, ..reference };
        close(super::errors(&image, &exact, 0.0).unwrap().mse, (2.0 * 100.0 + 4.0 + 1997.0) / 2000.0);
        assert!(exact.noise().is_none() && exact.blocks().is_none());
    }

    #[test]
    fn a_noisy_reference_adds_nothing_on_average() {
        let mut rng = Rng::new(1);
        let mut noisy = |spread: f32| {
            let values: Vec<f32> = (0..10_000).map(|_| 1.0 + spread * (rng.f32() - 0.5)).collect();
            grey(100, 100, |i| values[i])
        };
        // uniform noise of width 0.6 has the variance 0.03, the reference's of width 0.3 a quarter of that
        let (image, reference) = (noisy(0.6), noisy(0.3));
        let known = Reference { image: reference.clone(), variance: Some(vec![Rgb::splat(0.0075); 10_000]) };
        let errors = |r: &Reference| errors(&image, r, 0.0).unwrap().mse;
        // relative deviation of a mean of 10 000 squares about 1 %; five of them: false alarm 1 in 1.7 million
        assert!((errors(&known) / 0.03 - 1.0).abs() < 0.05, "{}", errors(&known));
        let unknown = errors(&Reference { image: reference, variance: None });
        assert!((unknown / 0.0375 - 1.0).abs() < 0.05, "{unknown}");
    }

    #[test]
    fn blocks_cover_the_picture_once() {
        let image = grey(17, 9, |i| i as f32);
        let sums = block_sums(&[1.0; 17 * 9], 17, 9);
        assert_eq!(sums.len(), 64);
        assert_eq!(sums.iter().map(|s| s.1).sum::<f64>(), 153.0);
        assert!(sums.iter().all(|s| s.1 >= 2.0));
        // rows 0 and 1, columns 0 to 2
        assert!((blocks(&image)[0] - 9.5).abs() < 1e-5, "{}", blocks(&image)[0]);
        assert_eq!(blocks(&grey(3, 2, |_| 1.0)).len(), 6);
        let reference = Reference { image: grey(16, 16, |_| 1.0), variance: Some(vec![Rgb::splat(0.04); 256]) };
        let found = reference.blocks().unwrap();
        assert!(found.variance.iter().all(|v| (v - 0.01).abs() < 1e-6), "four pixels a block");
        assert_eq!(mean(&image)[0], 76.0);
    }
}
