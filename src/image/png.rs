//! 8-bit PNG for looking at.

use super::packed::{Packed, Packing};
use super::{Image, ViewTransform};
use crate::Result;
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};
use std::io;
use std::path::Path;

/// Writes linear radiance as sRGB with 8 bits, as `view` shows it. Chunks of text name the program, exposure (stops) and tone,
/// and what `texts` adds (a keyword of 1 to 79 Latin-1 characters, and what it says). An existing file is replaced as a whole
/// or not at all.
///
/// # Errors
/// An empty picture, and all failures to write.
pub(crate) fn write(path: &Path, image: &Image, view: &ViewTransform, texts: &[(&str, &str)]) -> Result<()> {
    pack(image, view, texts, Packing::Tight).write(path)
}

/// The bytes that [`write`] writes, or more of them.
pub(crate) fn pack(image: &Image, view: &ViewTransform, texts: &[(&str, &str)], packing: Packing) -> Packed {
    let size = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
    let (Some(width), Some(height)) = (size(image.width), size(image.height)) else {
        return Packed(Err(format!("a PNG cannot have {} × {} pixels", image.width, image.height)));
    };
    let bytes = view.bytes(image);
    let (stops, program) = (view.stops.to_string(), format!("phototaxis {}", env!("CARGO_PKG_VERSION")));
    let own = [("Software", &*program), ("Exposure", &stops), ("Tone", view.tone.name())];
    let texts: Vec<(&str, &str)> = own.into_iter().chain(texts.iter().copied()).collect();
    Packed(encode((width, height), &bytes, &texts, packing).map_err(|error| error.to_string()))
}

fn encode(
    (width, height): (u32, u32),
    bytes: &[u8],
    texts: &[(&str, &str)],
    packing: Packing,
) -> std::result::Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Faster settings store noise as it is.
    let (compression, filter) = match packing {
        Packing::Tight => (Compression::Balanced, Filter::Adaptive),
        Packing::Loose => (Compression::Fastest, Filter::Up),
    };
    encoder.set_compression(compression);
    encoder.set_filter(filter);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    for (keyword, text) in texts {
        encoder.add_itxt_chunk((*keyword).to_owned(), (*text).to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

/// What a chunk of text of a PNG says; `None` where there is no such chunk, or no readable PNG.
pub fn text(path: &Path, keyword: &str) -> Option<String> {
    let file = io::BufReader::new(std::fs::File::open(path).ok()?);
    let reader = ::png::Decoder::new(file).read_info().ok()?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == keyword)?;
    chunk.get_text().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Tone;
    use crate::math::Rgb;

    fn written(image: &Image, exposure: f32) -> ::image::RgbImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write(&path, image, &ViewTransform { stops: exposure, tone: Tone::Srgb }, &[]).unwrap();
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
    fn a_loosely_packed_picture_is_the_same() {
        let mut image = Image::new(9, 7);
        image.data.iter_mut().enumerate().for_each(|(k, pixel)| *pixel = Rgb::new(0.01 * k as f32, 0.3, 0.5));
        let [tight, loose] = [Packing::Tight, Packing::Loose].map(|packing| {
            let bytes = pack(&image, &ViewTransform::default(), &[], packing).0.unwrap();
            ::image::load_from_memory(&bytes).unwrap().into_rgb8()
        });
        assert!(tight == loose);
    }

    #[test]
    fn an_empty_picture_is_refused() {
        let error = write(Path::new("empty.png"), &Image::new(0, 4), &ViewTransform::default(), &[]).unwrap_err();
        assert!(error.to_string().contains("empty.png: a PNG cannot have 0 × 4"), "{error}");
    }

    #[test]
    fn the_view_and_the_scene_are_written_beside_the_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let image = Image { width: 1, height: 1, data: vec![Rgb::splat(2.0)] };
        let view = ViewTransform { stops: -1.25, tone: Tone::Agx };
        write(&path, &image, &view, &[("Scene", "Küche.toml")]).unwrap();
        let says = |keyword| text(&path, keyword);
        assert_eq!((says("Exposure").as_deref(), says("Tone").as_deref()), (Some("-1.25"), Some("agx")));
        assert_eq!((says("Scene").as_deref(), says("Other")), (Some("Küche.toml"), None));
        assert_eq!(::image::open(&path).unwrap().into_rgb8().into_raw(), view.bytes(&image));
        assert_eq!(text(&folder.path().join("none.png"), "Tone"), None);
    }
}
