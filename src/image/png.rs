//! 8-bit PNG for looking at.

use super::Image;
use super::srgb;
use crate::io::atomic::write_atomically;
use crate::{Error, Result};
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder};
use std::io;
use std::path::Path;

/// Writes linear radiance as sRGB with 8 bits, brightened by `exposure` stops (times 2^`exposure`), without tone mapping:
/// what exceeds [0, 1] is clamped, NaN becomes black. An existing file is replaced as a whole or not at all.
pub fn write(path: &Path, image: &Image, exposure: f32) -> Result<()> {
    let size = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
    let (Some(width), Some(height)) = (size(image.width), size(image.height)) else {
        let message = format!("a PNG cannot have {} × {} pixels", image.width, image.height);
        return Err(Error::file(path, message));
    };
    let bytes = quantise(image, exposure);
    write_atomically(path, |file| {
        // The encoder's fast default stores noise as it is.
        let encoder = PngEncoder::new_with_quality(file, CompressionType::Default, FilterType::Adaptive);
        encoder.write_image(&bytes, width, height, ExtendedColorType::Rgb8).map_err(into_io)
    })
}

fn quantise(image: &Image, exposure: f32) -> Vec<u8> {
    let gain = exposure.exp2();
    let byte = |linear: f32| (srgb::encode(linear * gain) * 255.0).round() as u8;
    image.data.iter().flat_map(|&pixel| pixel.to_array().map(byte)).collect()
}

fn into_io(error: ::image::ImageError) -> io::Error {
    match error {
        ::image::ImageError::IoError(error) => error,
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn written(image: &Image, exposure: f32) -> ::image::RgbImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write(&path, image, exposure).unwrap();
        ::image::open(&path).unwrap().into_rgb8()
    }

    #[test]
    fn pixels_are_encoded_and_stay_in_place() {
        let mut image = Image::new(2, 2);
        image.data[1] = Rgb::new(0.215_861, 1.0, 0.002);
        image.data[2] = Rgb::new(f32::NAN, f32::INFINITY, -3.0);
        let png = written(&image, 0.0);
        assert_eq!(png.get_pixel(0, 0).0, [0, 0, 0]);
        assert_eq!(png.get_pixel(1, 0).0, [128, 255, 7]);
        assert_eq!(png.get_pixel(0, 1).0, [0, 255, 0]);
    }

    #[test]
    fn a_stop_doubles_the_light() {
        let at = |value: f32, exposure| {
            let image = Image { width: 1, height: 1, data: vec![Rgb::splat(value)] };
            written(&image, exposure).get_pixel(0, 0).0
        };
        assert_eq!(at(0.1, 2.0), at(0.4, 0.0));
        assert_eq!(at(0.4, -1.0), at(0.2, 0.0));
        assert_ne!(at(0.1, 2.0), at(0.1, 0.0));
    }

    #[test]
    fn an_empty_picture_is_refused() {
        let error = write(Path::new("empty.png"), &Image::new(0, 4), 0.0).unwrap_err();
        assert!(error.to_string().contains("empty.png: a PNG cannot have 0 × 4"), "{error}");
    }
}
