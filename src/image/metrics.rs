//! How far a picture is from a reference: one number over all pixels and channels, 0 for equal pictures.
//!
//! Sums are taken in double precision. A value that is not a number makes every measure that includes it NaN.

use super::Image;
use crate::math::Rgb;
use crate::{Error, Result};

/// Keeps relative measures finite where the reference is black.
const EPSILON: f64 = 0.01;

/// Share of pixels that [`Errors::relmse_trimmed`] leaves out.
const TRIMMED: f64 = 0.001;

/// All measures of one picture x against one reference r.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Mean of (x − r)².
    pub(crate) mse: f64,
    /// Mean of (x − r)² / (r² + 0.01) (Rousselle et al. 2011, "Adaptive Sampling and Reconstruction using Greedy Error
    /// Minimization", who divide by r² + ε).
    pub(crate) relmse: f64,
    /// `relmse` without the worst 0.1 % of the pixels, rounded down, so that a few fireflies do not decide. A pixel
    /// goes with all of its channels; one that is not a number counts as the worst.
    pub relmse_trimmed: f64,
    /// Mean of |x − r| / (|r| + 0.01).
    pub(crate) mape: f64,
    /// Mean of 2|x − r| / (|x| + |r| + 0.01), in [0, 2).
    pub(crate) smape: f64,
}

/// Compares `image` with `reference`.
///
/// # Errors
/// [`Error::Scene`] where the sizes differ or the pictures are empty.
pub fn compare(image: &Image, reference: &Image) -> Result<Errors> {
    check_sizes(image, reference)?;
    Ok(Errors {
        mse: mean(image, reference, |x, r| (x - r).powi(2)),
        relmse: mean(image, reference, relative_square),
        relmse_trimmed: trimmed_mean(image, reference, relative_square),
        mape: mean(image, reference, |x, r| (x - r).abs() / (r.abs() + EPSILON)),
        smape: mean(image, reference, |x, r| 2.0 * (x - r).abs() / (x.abs() + r.abs() + EPSILON)),
    })
}

pub(super) fn check_sizes(image: &Image, reference: &Image) -> Result<()> {
    let (size, wanted) = ((image.width, image.height), (reference.width, reference.height));
    if size != wanted || image.data.len() != reference.data.len() {
        return Err(Error::Scene(format!(
            "pictures of {} × {} and {} × {} pixels cannot be compared",
            size.0, size.1, wanted.0, wanted.1
        )));
    }
    if image.data.is_empty() {
        return Err(Error::Scene("empty pictures cannot be compared".to_owned()));
    }
    Ok(())
}

/// (x − r)² / (r² + 0.01) of each pixel, mean of its channels: what relMSE is the mean of.
///
/// # Errors
/// As [`compare`].
pub(crate) fn relative_squares(image: &Image, reference: &Image) -> Result<Vec<f64>> {
    check_sizes(image, reference)?;
    Ok(per_pixel(image, reference, relative_square).collect())
}

fn relative_square(x: f64, r: f64) -> f64 {
    (x - r).powi(2) / (r * r + EPSILON)
}

/// Mean of `error` over the channels of each pixel.
fn per_pixel<'a>(
    image: &'a Image,
    reference: &'a Image,
    error: impl Fn(f64, f64) -> f64 + 'a,
) -> impl Iterator<Item = f64> + 'a {
    let of_pixel = move |(x, r): (&Rgb, &Rgb)| {
        let (x, r) = (x.as_dvec3(), r.as_dvec3());
        (error(x.x, r.x) + error(x.y, r.y) + error(x.z, r.z)) / 3.0
    };
    image.data.iter().zip(&reference.data).map(of_pixel)
}

fn mean(image: &Image, reference: &Image, error: impl Fn(f64, f64) -> f64) -> f64 {
    per_pixel(image, reference, error).sum::<f64>() / image.data.len() as f64
}

fn trimmed_mean(image: &Image, reference: &Image, error: impl Fn(f64, f64) -> f64) -> f64 {
    // Without their sign NaNs are the largest in the total order.
    let mut errors: Vec<f64> = per_pixel(image, reference, error).map(f64::abs).collect();
    errors.sort_unstable_by(f64::total_cmp);
    errors.truncate(errors.len() - (errors.len() as f64 * TRIMMED) as usize);
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(pixels: &[[f32; 3]]) -> Image {
        let data = pixels.iter().map(|&p| Rgb::from_array(p)).collect();
        Image { width: pixels.len(), height: 1, data }
    }

    fn assert_close(value: f64, wanted: f64) {
        assert!((value - wanted).abs() <= 1e-12 * wanted.abs(), "{value} is not {wanted}");
    }

    #[test]
    fn measures_match_values_worked_out_by_hand() {
        // Exact in binary, so that the expected fractions hold to double precision.
        let image = row(&[[1.5, 0.0, 2.0], [0.5, 0.5, 0.0]]);
        let reference = row(&[[1.0, 0.0, 4.0], [0.0, 0.5, 0.25]]);
        let errors = compare(&image, &reference).unwrap();
        assert_close(errors.mse, (0.25 + 4.0 + 0.25 + 0.0625) / 6.0);
        let relative = 0.25 / 1.01 + 4.0 / 16.01 + 0.25 / 0.01 + 0.0625 / 0.0725;
        assert_close(errors.relmse, relative / 6.0);
        assert_close(errors.mape, (0.5 / 1.01 + 2.0 / 4.01 + 0.5 / 0.01 + 0.25 / 0.26) / 6.0);
        let symmetric = 1.0 / 2.51 + 4.0 / 6.01 + 1.0 / 0.51 + 0.5 / 0.26;
        assert_close(errors.smape, symmetric / 6.0);
        // Fewer than a thousand pixels: none is left out.
        assert_close(errors.relmse_trimmed, errors.relmse);
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let image = row(&[[1.5, -2.0, 0.0]]);
        let zero = Errors { mse: 0.0, relmse: 0.0, relmse_trimmed: 0.0, mape: 0.0, smape: 0.0 };
        assert_eq!(compare(&image, &image).unwrap(), zero);
    }

    #[test]
    fn trimming_drops_whole_pixels_and_no_more_than_a_thousandth() {
        let mut image = Image { width: 100, height: 30, data: vec![Rgb::splat(1.5); 3000] };
        let reference = Image { width: 100, height: 30, data: vec![Rgb::ONE; 3000] };
        let base = 0.25 / 1.01;
        for (i, firefly) in [1e6, f32::NAN, 1e3].into_iter().enumerate() {
            image.data[700 * i] = Rgb::new(firefly, 1.5, 1.5);
        }
        let errors = compare(&image, &reference).unwrap();
        assert!(errors.relmse.is_nan());
        assert!((errors.relmse_trimmed - base).abs() < 1e-9);
        // The fourth outlier stays.
        image.data[2999] = Rgb::splat(11.0);
        let wanted = (2996.0 * base + 100.0 / 1.01) / 2997.0;
        let trimmed = compare(&image, &reference).unwrap().relmse_trimmed;
        assert!((trimmed - wanted).abs() < 1e-9, "{trimmed} is not {wanted}");
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, high) = (Image::new(2, 1), Image::new(1, 2));
        let message = compare(&wide, &high).unwrap_err().to_string();
        assert!(message.contains("2 × 1 and 1 × 2"), "{message}");
        assert!(compare(&Image::new(0, 0), &Image::new(0, 0)).is_err());
    }
}
