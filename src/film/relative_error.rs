//! How far the picture is from what infinitely many samples would show, as far as its samples tell.
//!
//! Where all samples count alike, two halves of them tell it. Else groups of iterations are weighed, whose means are uncorrelated:
//! whatever a guide has learnt from the groups before, a group's mean is right on average. So the variance of their weighted mean is
//! the sum of theirs, each times the square of its weight. Both are right on average where variances are known but roughly; the
//! inverse of the sum of the weights, which are inverse variances, would be too small then.

use super::accumulate::Film;
use super::alike::mean_of_alike;
use super::blur::mean_without_largest;
use super::group::FLOOR;
use super::halves::wide_luminance;
use crate::film::Combine;

/// Share of the pixels, the noisiest, that are left out of the picture's error: very few very bright samples would else decide alone.
/// Those are left out by what was found of their noise, so that it is too low what is said of those that are kept; the more, the more
/// are left out.
pub(crate) const LEFT_OUT: f64 = 0.001;

impl Film {
    /// Standard error of the picture so far, relative to it: the root of the mean square over its pixels but for the noisiest.
    /// `None` for a picture that is black or not finite, or of a film that was not asked to tell.
    pub(crate) fn relative_error(&self) -> Option<f64> {
        let square = mean_without_largest(self.relative_variances()?, LEFT_OUT);
        (square > 0.0 && square.is_finite()).then(|| square.sqrt())
    }

    /// Variance of each pixel's luminance over its square, which has a floor of [`FLOOR`].
    pub(crate) fn relative_variances(&self) -> Option<Vec<f64>> {
        if !self.tells_error || self.allotted.is_some() {
            return None;
        }
        let (picture, width) = (self.picture_so_far(), self.width as usize);
        let light: Vec<f64> = picture.mean.iter().map(|c| wide_luminance(c.as_dvec3())).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let variances = match self.combine {
            Combine::All => {
                let spread = picture.variance.iter().map(|v| wide_luminance(v.as_dvec3())).collect();
                let sum = |i: usize| picture.mean[i].as_dvec3() * f64::from(picture.count(i));
                self.halves.variances(spread, |i| (sum(i), picture.count(i)), |_| true, width)
            }
            _ => picture.halved_variance.iter().map(|&v| v.into()).collect(),
        };
        let expected = expected(&light, &variances, mean, width);
        let relative = |(v, l): (&f64, &f64)| v / (l * l + (FLOOR * mean).powi(2));
        Some(variances.iter().zip(&expected).map(relative).collect())
    }
}

/// What pixels show, of which `light` is seen with these variances: the mean of those about each that show the same, or as much more
/// or less as noise does not explain (W. James, C. Stein, "Estimation with quadratic loss", 1961, with a factor that is not negative).
/// The light itself would not do: bright samples that a pixel has by chance are in its variance too, which would seem small beside
/// them. The mean alone would not either: where noise hides edges, pixels on a lamp's border would seem as dark as the wall.
fn expected(light: &[f64], variances: &[f64], mean: f64, width: usize) -> Vec<f64> {
    let mut expected = mean_of_alike(light, variances, mean, width);
    for ((expected, light), variance) in expected.iter_mut().zip(light).zip(variances) {
        let departs = light - *expected;
        if departs * departs > *variance {
            *expected += departs * (1.0 - variance / (departs * departs));
        }
    }
    expected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_shows_what_its_neighbours_do_and_what_noise_does_not_explain() {
        let (mut light, mut variances) = (vec![1.0; 81], vec![1e-4; 81]);
        // a lamp's border, and a bright sample by chance
        (light[10], variances[10]) = (9.0, 9.0);
        (light[70], variances[70]) = (9.0, 64.0);
        let expected = expected(&light, &variances, 1.0, 9);
        assert!((7.0..9.0).contains(&expected[10]), "{}", expected[10]);
        assert!(expected[70] < 1.5 && (expected[0] - 1.0).abs() < 0.1, "{} {}", expected[70], expected[0]);
    }
}
