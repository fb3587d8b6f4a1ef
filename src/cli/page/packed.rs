//! Pictures as the page takes them: linear light in half precision, so that it can change the exposure by itself.

use crate::image::{Image, ViewTransform};
use crate::math::Rgb;
use half::f16;

/// Pixels that a page takes at most; a larger picture is made smaller for it.
const MOST_PIXELS: usize = 1 << 21;
/// Powers of two that numbers in single precision have.
const LARGEST_EXPONENT: f32 = 120.0;

/// Width, height (`u32`), stops by which it is brightened at first (`f32`), power of two by which the numbers were multiplied
/// (`i32`); then red, green and blue of each pixel in half precision (IEEE 754 binary16), row 0 on top. All little-endian.
///
/// That power is about those stops, so that what is shown as grey is about 1 here: 11 bits are then more than the 8 of a screen
/// over all exposures that the page offers. What is brighter than half precision holds is its brightest, and shown as white.
pub(super) fn picture(image: &Image, view: &ViewTransform) -> Vec<u8> {
    let smaller = smaller(image);
    let image = smaller.as_ref().unwrap_or(image);
    let exponent = view.stops.round().clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT);
    let gain = exponent.exp2();
    let half = |light: f32| f16::from_f32((light * gain).clamp(-65504.0, 65504.0)).to_le_bytes();
    let mut packed = Vec::with_capacity(16 + 6 * image.data.len());
    packed.extend((image.width as u32).to_le_bytes());
    packed.extend((image.height as u32).to_le_bytes());
    packed.extend(view.stops.to_le_bytes());
    packed.extend((exponent as i32).to_le_bytes());
    packed.extend(image.data.iter().flat_map(|pixel| pixel.to_array()).flat_map(half));
    packed
}

/// The picture with means of blocks as its pixels, where it has too many for a page.
fn smaller(image: &Image) -> Option<Image> {
    let side = (1..).find(|side| image.width.div_ceil(*side) * image.height.div_ceil(*side) <= MOST_PIXELS)?;
    let (width, height) = (image.width.div_ceil(side), image.height.div_ceil(side));
    let block = |x: usize, y: usize| {
        let (right, bottom) = (((x + 1) * side).min(image.width), ((y + 1) * side).min(image.height));
        let pixels = (y * side..bottom).flat_map(|y| (x * side..right).map(move |x| image.pixel(x, y)));
        let count = (right - x * side) * (bottom - y * side);
        pixels.fold(Rgb::ZERO, |sum, pixel| sum + pixel) / count as f32
    };
    let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| block(x, y)).collect();
    (side > 1).then_some(Image { width, height, data })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Tone;

    fn halves(packed: &[u8]) -> Vec<f32> {
        packed[16..].chunks_exact(2).map(|half| f16::from_le_bytes([half[0], half[1]]).to_f32()).collect()
    }

    #[test]
    fn light_of_any_strength_keeps_eleven_bits() {
        for light in [1e-25f32, 0.3, 7e20] {
            let image = Image { width: 1, height: 1, data: vec![Rgb::new(light, 0.001 * light, f32::INFINITY)] };
            let stops = (0.18 / light).log2();
            let packed = picture(&image, &ViewTransform { stops, tone: Tone::Srgb });
            let word = |at: usize| <[u8; 4]>::try_from(&packed[at..at + 4]).unwrap();
            assert_eq!((u32::from_le_bytes(word(0)), u32::from_le_bytes(word(4))), (1, 1));
            assert_eq!(f32::from_le_bytes(word(8)), stops);
            let gain = (-i32::from_le_bytes(word(12)) as f32).exp2();
            let found = halves(&packed);
            assert!((found[0] * gain / light - 1.0).abs() < 1.0 / 2048.0, "{light}: {found:?}");
            assert!((found[1] * gain / light - 0.001).abs() < 0.001 / 2048.0, "{light}: {found:?}");
            assert_eq!(found[2], 65504.0);
        }
    }

    #[test]
    fn a_large_picture_is_made_smaller() {
        let (width, height) = (2501, 1000);
        let data = (0..width * height).map(|i| Rgb::splat((i % width) as f32)).collect();
        let packed = picture(&Image { width, height, data }, &ViewTransform::default());
        let found = halves(&packed);
        assert_eq!(found.len(), 3 * 1251 * 500);
        assert_eq!((found[0], found[3], found[3 * 1250]), (0.5, 2.5, 2500.0));
    }
}
