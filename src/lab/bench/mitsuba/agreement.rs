//! Whether two renderers made the same picture, but for noise.

use crate::film::accumulate::Estimate;
#[cfg(test)]
use crate::film::accumulate::PictureIds;
use crate::image::Image;
use crate::math::{Rgb, luminance};
use crate::{Error, Result};
use serde::Serialize;

/// How far two pictures agree.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Agreement {
    /// Mean luminance of Phototaxis' picture over that of the other.
    pub(crate) brightness: f64,
    /// Standard error of that ratio, by Phototaxis' own variances, which are taken for the other's too.
    pub(crate) noise: f64,
    /// The largest difference in units of what is tolerated: of the whole picture's channels, and of the luminance of
    /// each of its regions.
    pub(crate) worst: f64,
}

/// Tolerated differences of the whole picture's mean, as a share of it.
const WHOLE: f64 = 0.02;

/// Of a region's mean, as a share of it; and as a share of the whole picture's.
const REGION: [f64; 2] = [0.05, 0.01];

/// Regions in each direction.
const REGIONS: usize = 4;

/// Standard errors tolerated beyond that. Of 19 normal deviates one exceeds them in 90,000 pictures.
const DEVIATIONS: f64 = 5.0;

/// With more noise than this, the picture's mean says too little.
const MOST_NOISE: f64 = 0.05;

/// The mean of pictures, with variances where they are known.
#[derive(Clone, Debug)]
pub(crate) struct Mean {
    pub(crate) image: Image,
    variance: Vec<Rgb>,
    count: f32,
}

impl Mean {
    pub(crate) fn new(width: usize, height: usize) -> Mean {
        Mean { image: Image::new(width, height), variance: vec![Rgb::ZERO; width * height], count: 0.0 }
    }

    pub(crate) fn add_estimate(&mut self, estimate: &Estimate) {
        self.add(&estimate.mean);
        let weight = 1.0 / (self.count * self.count);
        let kept = ((self.count - 1.0) / self.count).powi(2);
        for (variance, &more) in self.variance.iter_mut().zip(&estimate.variance) {
            *variance = *variance * kept + more * weight;
        }
    }

    pub(crate) fn add(&mut self, pixels: &[Rgb]) {
        self.count += 1.0;
        for (mean, &more) in self.image.data.iter_mut().zip(pixels) {
            *mean += (more - *mean) / self.count;
        }
    }
}

/// Sums over some pixels.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: f64,
    ours: [f64; 4],
    theirs: [f64; 4],
    variance: [f64; 4],
}

/// The channels and the luminance.
fn figures(c: Rgb) -> [f64; 4] {
    [c.x, c.y, c.z, luminance(c)].map(f64::from)
}

impl Sums {
    fn add(&mut self, ours: Rgb, theirs: Rgb, variance: Rgb) {
        // as if channels had nothing to do with each other; they vary together, so that the luminance gets their sum
        let deviation = luminance(variance.map(f32::sqrt));
        let variance = [variance.x, variance.y, variance.z, deviation * deviation].map(f64::from);
        let (ours, theirs) = (figures(ours), figures(theirs));
        self.pixels += 1.0;
        for k in 0..4 {
            self.ours[k] += ours[k];
            self.theirs[k] += theirs[k];
            self.variance[k] += variance[k];
        }
    }

    /// Standard error of the difference of sums.
    fn error(&self, k: usize) -> f64 {
        (2.0 * self.variance[k]).sqrt()
    }

    /// The difference in units of what is tolerated.
    fn excess(&self, k: usize, tolerated: f64) -> f64 {
        let allowed = tolerated + DEVIATIONS * self.error(k);
        let difference = (self.ours[k] - self.theirs[k]).abs();
        if difference == 0.0 { 0.0 } else { difference / allowed }
    }
}

/// Compares `theirs` with our picture, of the same size.
///
/// # Errors
/// Black pictures, and too much noise to tell.
pub(crate) fn agreement(ours: &Mean, theirs: &Image) -> Result<Agreement> {
    const LUMINANCE: usize = 3;
    let Image { width, height, .. } = ours.image;
    let (mut whole, mut regions) = (Sums::default(), [Sums::default(); REGIONS * REGIONS]);
    for (i, (&own, &other)) in ours.image.data.iter().zip(&theirs.data).enumerate() {
        let region = (i / width) * REGIONS / height * REGIONS + (i % width) * REGIONS / width;
        whole.add(own, other, ours.variance[i]);
        regions[region].add(own, other, ours.variance[i]);
    }
    let mean = whole.theirs[LUMINANCE];
    let (brightness, noise) = (whole.ours[LUMINANCE] / mean, whole.error(LUMINANCE) / mean);
    if !brightness.is_finite() {
        return Err(Error::Scene("Mitsuba's picture is black, or no picture".into()));
    }
    if noise > MOST_NOISE {
        let percent = 100.0 * noise;
        let message =
            format!("the picture's mean is known to {percent:.0} % only: more samples are needed to compare it");
        return Err(Error::Scene(message));
    }
    let channels = (0..3).map(|k| whole.excess(k, WHOLE * whole.theirs[k]));
    let [of_region, of_whole] = REGION;
    let parts = regions.iter().filter(|region| region.pixels > 0.0).map(|region| {
        let share = region.pixels / whole.pixels;
        region.excess(LUMINANCE, of_region * region.theirs[LUMINANCE] + of_whole * share * mean)
    });
    // a difference that is not a number is none that is tolerated
    let worst = channels.chain(parts).fold(0.0, |worst: f64, x| if x <= worst { worst } else { x });
    Ok(Agreement { brightness, noise, worst })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    /// A picture that is brighter to the right, with noise of a tenth.
    fn picture(seed: u64, of: impl Fn(usize, usize) -> f32) -> Estimate {
        let mut rng = Rng::new(seed);
        let mut noisy = |i: usize| {
            let radiance = of(i % 32, i / 32);
            Rgb::new(1.0, 0.8, 0.5) * (radiance * (1.0 + 0.1 * 12f32.sqrt() * (rng.f32() - 0.5)))
        };
        let mean: Vec<Rgb> = (0..32 * 24).map(&mut noisy).collect();
        let variance = (0..32 * 24).map(|i| (Rgb::new(1.0, 0.8, 0.5) * (0.1 * of(i % 32, i / 32))).powf(2.0)).collect();
        let (counts, features) = (Vec::new(), Vec::new());
        Estimate {
            width: 32,
            height: 24,
            mean,
            variance,
            samples: 4,
            counts,
            layers: Vec::new(),
            features,
            ids: PictureIds::default(),
        }
    }

    fn ramp(x: usize, y: usize) -> f32 {
        1.0 + 0.1 * x as f32 + 0.01 * y as f32
    }

    fn compared(theirs: impl Fn(usize, usize) -> f32) -> Result<Agreement> {
        let mut ours = Mean::new(32, 24);
        (0..4).for_each(|seed| ours.add_estimate(&picture(seed, ramp)));
        let mut other = Mean::new(32, 24);
        (10..14).for_each(|seed| other.add(&picture(seed, &theirs).mean));
        agreement(&ours, &other.image)
    }

    #[test]
    fn the_same_picture_agrees_but_for_noise() {
        let same = compared(ramp).unwrap();
        // a tenth of noise a pixel, 4 pictures, 768 pixels, two of them: √2·0.1/√(4·768) = 0.0026, somewhat more where
        // it is brighter
        assert!((0.0025..0.003).contains(&same.noise), "{same:?}");
        assert!((same.brightness - 1.0).abs() < 5.0 * same.noise && same.worst < 1.0, "{same:?}");
    }

    #[test]
    fn another_brightness_colour_or_view_does_not() {
        let of = |theirs: fn(usize, usize) -> f32| compared(theirs).unwrap();
        let dimmer = of(|x, y| 0.95 * ramp(x, y));
        assert!(dimmer.worst > 1.0 && (dimmer.brightness - 1.0 / 0.95).abs() < 0.02, "{dimmer:?}");
        // the same mean: only regions tell
        let mirrored = of(|x, y| ramp(31 - x, y));
        assert!(mirrored.worst > 1.0 && (mirrored.brightness - 1.0).abs() < 0.02, "{mirrored:?}");
        let mut ours = Mean::new(32, 24);
        ours.add_estimate(&picture(1, ramp));
        let mut swapped = ours.image.clone();
        swapped.data.iter_mut().for_each(|c| *c = Rgb::new(c.z, c.y, c.x));
        assert!(agreement(&ours, &swapped).unwrap().worst > 1.0);
    }

    #[test]
    fn black_undefined_and_noisy_pictures_are_refused() {
        assert!(compared(|_, _| 0.0).unwrap_err().to_string().contains("black"));
        assert!(compared(|x, _| if x == 3 { f32::NAN } else { 1.0 }).is_err());
        let mut ours = Mean::new(32, 24);
        let mut noisy = picture(1, ramp);
        noisy.variance.iter_mut().for_each(|v| *v = Rgb::splat(100.0));
        ours.add_estimate(&noisy);
        let image = ours.image.clone();
        assert!(agreement(&ours, &image).unwrap_err().to_string().contains("more samples"));
    }
}
