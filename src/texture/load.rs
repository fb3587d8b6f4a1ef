//! From picture files to texels.

use super::texels::{Samples, Texels};
use crate::image::exr::{ExrFile, read_limited};
use crate::io::contain::{check_size, contain};
use crate::io::memory::{self, Shortage};
use crate::{Error, Result};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

/// Decoded textures above this are refused.
const MAX_BYTES: u64 = 1 << 30;

/// So are profiles and texts above this.
const MAX_METADATA: u64 = 64 << 20;

/// The first bytes of every OpenEXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

pub(super) fn load(path: &Path) -> Result<Texels> {
    let file = File::open(path).map_err(Error::io(path))?;
    let length = file.metadata().map_err(Error::io(path))?.len();
    let mut file = BufReader::new(file);
    if file.fill_buf().map_err(Error::io(path))?.starts_with(&EXR_MAGIC) {
        return from_exr(path, read_limited(path, MAX_BYTES)?);
    }
    contain(path, || decode(path, file, length))
}

/// `length`: bytes of the file.
fn decode(path: &Path, file: impl BufRead + Seek, length: u64) -> Result<Texels> {
    let fault = |error: ImageError| match error {
        ImageError::IoError(source) => Error::io(path)(source),
        ImageError::Unsupported(error) => {
            Error::file(path, format!("not a PNG, JPEG or OpenEXR file that can be read: {error}"))
        }
        error => Error::file(path, error.to_string()),
    };
    let mut reader = ImageReader::new(file).with_guessed_format().map_err(Error::io(path))?;
    // Sizes of pictures are checked below, with messages of our own; this is for what else there is in a file.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_METADATA);
    reader.limits(limits);
    let format = reader.format();
    let decoder = reader.into_decoder().map_err(fault)?;
    let (width, height) = decoder.dimensions();
    check_size(path, (width.into(), height.into()), decoder.total_bytes(), MAX_BYTES)?;
    check_contents(path, format, u64::from(width) * u64::from(height), length)?;
    // rows on their way through the decoder included
    memory::check(2 * decoder.total_bytes()).map_err(|shortage| too_large(path, shortage))?;
    from_picture(path, DynamicImage::from_decoder(decoder).map_err(fault)?)
}

/// Refuses sizes that a damaged header makes up.
fn check_contents(path: &Path, format: Option<ImageFormat>, pixels: u64, length: u64) -> Result<()> {
    let pixels_per_byte = match format {
        // a bit is a block of 8 × 8 pixels at most
        Some(ImageFormat::Jpeg) => 8 * 64,
        // PNG: a byte of DEFLATE is 1032 at most (RFC 1951), and a byte of those eight pixels
        _ => 1032 * 8,
    };
    let least = pixels / pixels_per_byte;
    if least <= length {
        return Ok(());
    }
    let (least, length) = (memory::text(least), memory::text(length));
    Err(Error::file(path, format!("damaged: its pixels need at least {least}, and the file has {length}")))
}

fn too_large(path: &Path, shortage: Shortage) -> Error {
    Error::file(path, format!("the decoded picture would {shortage}"))
}

fn from_picture(path: &Path, picture: DynamicImage) -> Result<Texels> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let channels = usize::from(picture.color().channel_count());
    let data = match picture {
        DynamicImage::ImageLuma8(pixels) => Samples::U8(pixels.into_raw()),
        DynamicImage::ImageLumaA8(pixels) => Samples::U8(pixels.into_raw()),
        DynamicImage::ImageRgb8(pixels) => Samples::U8(pixels.into_raw()),
        DynamicImage::ImageRgba8(pixels) => Samples::U8(pixels.into_raw()),
        DynamicImage::ImageLuma16(pixels) => Samples::U16(pixels.into_raw()),
        DynamicImage::ImageLumaA16(pixels) => Samples::U16(pixels.into_raw()),
        DynamicImage::ImageRgb16(pixels) => Samples::U16(pixels.into_raw()),
        DynamicImage::ImageRgba16(pixels) => Samples::U16(pixels.into_raw()),
        other => {
            return Err(Error::file(path, format!("cannot use texels of {:?}", other.color())));
        }
    };
    Ok(Texels { width, height, channels, data })
}

fn from_exr(path: &Path, file: ExrFile) -> Result<Texels> {
    let has = |name: &&str| file.channels.contains_key(*name);
    let mut names = if has(&"Y") && !has(&"R") { vec!["Y"] } else { vec!["R", "G", "B"] };
    if let Some(missing) = names.iter().find(|name| !has(name)) {
        return Err(Error::file(path, format!("lacks channel {missing}")));
    }
    names.extend(Some("A").filter(has));
    let planes: Vec<&[f32]> = names.iter().map(|&name| file.channels[name].as_slice()).collect();
    let pixels = file.width * file.height;
    memory::check(4 * (pixels * names.len()) as u64).map_err(|shortage| too_large(path, shortage))?;
    let data: Vec<f32> = (0..pixels).flat_map(|pixel| planes.iter().map(move |plane| plane[pixel])).collect();
    if let Some(at) = data.iter().position(|value| !value.is_finite()) {
        let pixel = at / names.len();
        let (x, y) = (pixel % file.width, pixel / file.width);
        return Err(Error::file(path, format!("the texel in column {x}, row {y} is not finite")));
    }
    let (width, height) = (file.width, file.height);
    Ok(Texels { width, height, channels: names.len(), data: Samples::F32(data) })
}
