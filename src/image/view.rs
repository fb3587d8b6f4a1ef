//! The view transform: what becomes of linear radiance before it is shown.

use super::Image;
use super::srgb;
use super::tone::Tone;
use crate::math::{Rgb, luminance};
use std::fmt;
use std::str::FromStr;

/// How much a picture is brightened.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Exposure {
    /// By what the picture shows: see [`automatic_stops`].
    Auto,
    /// By this many stops: times 2 to that power.
    Stops(f32),
}

impl Default for Exposure {
    fn default() -> Exposure {
        Exposure::Stops(0.0)
    }
}

/// Stops beyond these are refused where a user writes them.
pub(crate) const MOST_STOPS: f32 = 64.0;

impl Exposure {
    /// Stops by which `image` is brightened, if `tone` is to follow.
    pub(crate) fn stops(self, image: &Image, tone: Tone) -> f32 {
        match self {
            Exposure::Auto => automatic_stops(image, tone),
            Exposure::Stops(stops) => stops,
        }
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Exposure, String> {
        match text.parse::<f32>() {
            _ if text == "auto" => Ok(Exposure::Auto),
            Ok(stops) if stops.abs() <= MOST_STOPS => Ok(Exposure::Stops(stops)),
            _ => Err(format!("expected auto or a number of stops between -{MOST_STOPS} and {MOST_STOPS}")),
        }
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Exposure::Auto => f.write_str("auto"),
            Exposure::Stops(stops) => stops.fmt(f),
        }
    }
}

/// What the log-average luminance of a picture is shown as: mid grey, or down to the lowest key of Reinhard et al. 2002 where
/// that keeps highlights.
const KEY: f64 = 0.18;
const LOWEST_KEY: f64 = 0.045;
/// Pixels along a side of the blocks whose mean luminances are averaged. Single pixels are as noisy as the picture, and the
/// logarithm of noise is below that of its mean.
const BLOCK: usize = 8;
/// Share of the pixels that are not black, no brighter channel of which is shown brighter than white.
const KEPT: f64 = 0.97;
/// Steps to a stop: what is printed with two digits makes the same picture again.
const STEPS: f64 = 100.0;
/// 2 to this power is still a number in single precision, and so is its inverse.
const FINITE_STOPS: f64 = 126.0;

/// Stops by which a picture is brightened so that its log-average luminance is shown as mid grey, 0.18 (Reinhard, Stark,
/// Shirley, Ferwerda 2002, "Photographic Tone Reproduction for Digital Images", equations 1 and 2). Where more than 3 % of the
/// pixels that are not black would exceed the white of `tone` in any channel, by fewer stops: as many as keep to that, but
/// the average is shown as 0.045 at least, the lowest key of that paper. A window is then white and the room is not black.
/// Rounded down to hundredths.
///
/// The average is over blocks of 8 × 8 pixels; black blocks, where the camera sees nothing, are left out, which takes the place
/// of the paper's offset for black. Scaling all light scales nothing that is shown. A picture without light has 0.
pub(crate) fn automatic_stops(image: &Image, tone: Tone) -> f32 {
    let Some(average) = log_average(image) else { return 0.0 };
    let highlight = brightest_kept(image);
    let kept = f64::from(tone.white()) / highlight;
    let gain = kept.clamp(LOWEST_KEY / average, KEY / average);
    ((gain.log2() * STEPS).floor() / STEPS).clamp(-FINITE_STOPS, FINITE_STOPS) as f32
}

/// Geometric mean of the blocks' luminances; `None` where all are black.
fn log_average(image: &Image) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for top in (0..image.height).step_by(BLOCK) {
        for left in (0..image.width).step_by(BLOCK) {
            let mean = block_mean(image, left, top);
            if mean > 0.0 {
                sum += mean.ln();
                count += 1;
            }
        }
    }
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

/// Mean luminance of the block with this corner; pixels that are not finite are left out.
fn block_mean(image: &Image, left: usize, top: usize) -> f64 {
    let (right, bottom) = ((left + BLOCK).min(image.width), (top + BLOCK).min(image.height));
    let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| image.pixel(x, y)));
    let (mut sum, mut count) = (0.0, 0);
    for pixel in pixels.filter(|pixel| pixel.is_finite()) {
        sum += f64::from(luminance(pixel.max(Rgb::ZERO)));
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// The largest channel of the brightest of the pixels that are not to be clipped.
fn brightest_kept(image: &Image) -> f64 {
    let lit = image.data.iter().filter(|pixel| pixel.is_finite()).map(|pixel| pixel.max_element());
    let mut lit: Vec<f32> = lit.filter(|&x| x > 0.0).collect();
    let rank = (lit.len() as f64 * KEPT).ceil() as usize;
    let (_, kept, _) = lit.select_nth_unstable_by(rank.saturating_sub(1), f32::total_cmp);
    f64::from(*kept)
}

/// From linear radiance to stored bytes: exposure, tone curve, sRGB's transfer curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ViewTransform {
    /// Light is multiplied by 2 to this power.
    pub(crate) stops: f32,
    pub(crate) tone: Tone,
}

impl ViewTransform {
    /// What shows `image`.
    pub(crate) fn of(exposure: Exposure, tone: Tone, image: &Image) -> ViewTransform {
        ViewTransform { stops: exposure.stops(image, tone), tone }
    }

    /// The bytes of a picture, three for each pixel.
    pub(crate) fn bytes(&self, image: &Image) -> Vec<u8> {
        let gain = self.stops.exp2();
        let byte = |shown: f32| (srgb::encode(shown) * 255.0).round() as u8;
        image.data.iter().flat_map(|&pixel| self.tone.apply(pixel * gain).to_array().map(byte)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, pixels: impl IntoIterator<Item = f32>) -> Image {
        let data: Vec<Rgb> = pixels.into_iter().map(Rgb::splat).collect();
        Image { width, height: data.len() / width, data }
    }

    #[test]
    fn a_grey_picture_becomes_mid_grey_whatever_its_light() {
        for light in [1e-30, 1e-3, 0.18, 7.0, 1e30] {
            let stops = automatic_stops(&picture(16, [light; 256]), Tone::Srgb);
            let shown = f64::from(light) * f64::from(stops).exp2();
            assert!((0.178..=0.180_01).contains(&shown), "{light}: {stops} stops show {shown}");
        }
    }

    #[test]
    fn the_average_is_of_logarithms_and_leaves_black_out() {
        // Two blocks of 0.01 and 1, whose geometric mean is 0.1, and two of nothing.
        let pixels = (0..32 * 8).map(|i| [0.01, 1.0, 0.0, 0.0][i % 32 / 8]);
        let average = log_average(&picture(32, pixels)).unwrap();
        assert!((average - 0.1).abs() < 1e-6, "{average}");
        assert_eq!(automatic_stops(&picture(8, [0.0; 64]), Tone::Agx), 0.0);
    }

    #[test]
    fn noise_does_not_change_the_exposure() {
        // The same light in one pixel of sixteen, four in each block.
        let smooth = automatic_stops(&picture(64, [0.1; 4096]), Tone::Agx);
        let light = |i: usize| if i.is_multiple_of(4) && (i / 64).is_multiple_of(4) { 1.6 } else { 0.0 };
        let noisy = automatic_stops(&picture(64, (0..4096).map(light)), Tone::Agx);
        assert!((smooth - noisy).abs() < 0.02, "{smooth} and {noisy}");
    }

    #[test]
    fn at_most_three_pixels_of_a_hundred_are_clipped() {
        for tone in [Tone::Srgb, Tone::Agx, Tone::Aces] {
            // One block in ten is brighter than the others, so that mid grey would clip it.
            let bright = |i: usize| (4.0 + 4.0 * (i % 1000) as f32 / 1000.0) * tone.white();
            let light = |i: usize| if i % 100 / 10 == 0 { bright(i) } else { 0.3 };
            let image = picture(100, (0..10_000).map(light));
            let gain = automatic_stops(&image, tone).exp2();
            let clipped = image.data.iter().filter(|pixel| pixel.max_element() * gain > tone.white()).count();
            assert!((200..=300).contains(&clipped), "{tone:?}: {clipped} of 10000");
        }
    }

    #[test]
    fn a_window_does_not_make_the_room_black() {
        // A tenth of the picture is 10⁶ times as bright as the rest.
        let image = picture(80, (0..80 * 80).map(|i| if i % 80 < 8 { 1e5 } else { 0.1 }));
        let average = log_average(&image).unwrap();
        for tone in [Tone::Srgb, Tone::Agx, Tone::Aces] {
            let shown = average * f64::from(automatic_stops(&image, tone)).exp2();
            assert!((0.0446..=0.045_01).contains(&shown), "{tone:?}: {shown}");
        }
    }

    #[test]
    fn undefined_pixels_say_nothing() {
        let mut image = picture(16, [0.5; 256]);
        let plain = automatic_stops(&image, Tone::Srgb);
        (image.data[0], image.data[1]) = (Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY));
        assert_eq!(automatic_stops(&image, Tone::Srgb), plain);
        image.data.fill(Rgb::splat(f32::NAN));
        assert_eq!(automatic_stops(&image, Tone::Srgb), 0.0);
    }

    #[test]
    fn exposures_are_read_and_written() {
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("-1.5".parse(), Ok(Exposure::Stops(-1.5)));
        for text in ["", "nan", "65", "bright"] {
            assert!(text.parse::<Exposure>().is_err(), "{text}");
        }
        assert_eq!((Exposure::Auto.to_string(), Exposure::Stops(0.25).to_string()), ("auto".into(), "0.25".into()));
    }
}
