//! Pictures in few bytes, for pages that show them: Ward's shared-exponent pixels (1991, "Real Pixels", Graphics Gems II),
//! compressed.

use crate::image::Image;
use crate::math::Rgb;
use crate::{Error, Result};
use base64::Engine as _;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::Write;

/// RGBE bytes of the picture, row by row from the top, as a raw DEFLATE stream (RFC 1951) in base64.
///
/// # Errors
/// [`Error::Scene`] where the compressor fails.
pub(crate) fn encode(image: &Image) -> Result<String> {
    let mut bytes = DeflateEncoder::new(Vec::new(), Compression::best());
    let pixels: Vec<u8> = image.data.iter().flat_map(|&c| pixel(c)).collect();
    let deflated = bytes.write_all(&pixels).and_then(|()| bytes.finish());
    let deflated = deflated.map_err(|e| Error::Scene(format!("a picture could not be compressed: {e}")))?;
    Ok(base64::engine::general_purpose::STANDARD.encode(deflated))
}

/// Three mantissas m and an exponent e for m/256 · 2^(e − 128), rounded to the nearest; all 0 for black. What is negative
/// or no number is 0, what is too large as large as can be.
fn pixel(color: Rgb) -> [u8; 4] {
    let color = color.map(|x| if x > 0.0 { x.min(f32::MAX) } else { 0.0 });
    let largest = f64::from(color.max_element());
    // a largest mantissa of 255.5 or more would be rounded to 256
    let exponent = (largest * 512.0 / 511.0).log2().floor() as i32 + 1;
    if largest == 0.0 || exponent < -127 {
        return [0; 4];
    }
    let exponent = exponent.min(127);
    let mantissa = |x: f32| (f64::from(x) * 256.0 * 2f64.powi(-exponent)).round() as u8;
    [mantissa(color.x), mantissa(color.y), mantissa(color.z), (exponent + 128) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn value([r, g, b, e]: [u8; 4]) -> [f64; 3] {
        [r, g, b].map(|m| f64::from(m) / 256.0 * 2f64.powi(i32::from(e) - 128))
    }

    #[test]
    fn pixels_come_back_within_half_a_step_of_the_largest_channel() {
        let colors = [[1.0, 0.5, 0.25], [0.999, 0.0, 1e-9], [3e-5, 1e-5, 2e-5], [12_345.0, 1.0, 600.0], [0.998_1; 3]];
        for color in colors {
            let back = value(pixel(Rgb::from_array(color)));
            let largest = color.iter().fold(0.0f32, |a, &b| a.max(b)) as f64;
            for (a, b) in back.iter().zip(color) {
                assert!((a - b as f64).abs() <= largest / 255.0, "{color:?} became {back:?}");
            }
        }
        assert_eq!(pixel(Rgb::ONE), [128, 128, 128, 129]);
        assert_eq!(pixel(Rgb::new(0.0, f32::NAN, -1.0)), [0; 4]);
        assert_eq!(pixel(Rgb::splat(1e-40)), [0; 4]);
        assert_eq!(pixel(Rgb::new(f32::INFINITY, 0.0, 0.0)), [255, 0, 0, 255]);
    }

    #[test]
    fn the_stream_is_raw_deflate_in_base64() {
        let image = Image { width: 2, height: 1, data: vec![Rgb::ONE, Rgb::ZERO] };
        let bytes = base64::engine::general_purpose::STANDARD.decode(encode(&image).unwrap()).unwrap();
        let mut pixels = Vec::new();
        flate2::read::DeflateDecoder::new(&bytes[..]).read_to_end(&mut pixels).unwrap();
        assert_eq!(pixels, [128, 128, 128, 129, 0, 0, 0, 0]);
    }
}
