//! From files to samples.

use super::formats::{EXR_MAGIC, RADIANCE_MAGIC, guess, pixels_per_byte};
use super::transfer::{self, Transfer};
use super::{FORMATS, Picture, Samples};
use crate::image::exr::{ExrFile, read_limited};
use crate::io::contain::{check_size, contain};
use crate::io::memory::{self, Shortage};
use crate::{Error, Result};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, ErrorKind, Seek};
use std::path::{Path, PathBuf};

/// Decoded pictures above this are refused.
const MAX_BYTES: u64 = 1 << 30;

/// So are profiles and texts above this.
const MAX_METADATA: u64 = 64 << 20;

/// Reads a picture. `file.exr:LAYER` chooses a layer of an OpenEXR file.
///
/// # Errors
/// All name the file: unreadable, of another format, damaged, a side above 2¹⁶ pixels, above 1 GiB when decoded, floats that are
/// not finite.
pub(crate) fn load(path: &Path) -> Result<Picture> {
    let (path, layer) = split_layer(path);
    let path = &*path;
    let file = File::open(path).map_err(Error::io(path))?;
    let length = file.metadata().map_err(Error::io(path))?.len();
    let mut file = BufReader::new(file);
    let head = file.fill_buf().map_err(Error::io(path))?;
    if head.starts_with(&EXR_MAGIC) {
        return from_exr(path, read_limited(path, MAX_BYTES)?, layer.as_deref());
    }
    if head.starts_with(RADIANCE_MAGIC) {
        return contain(path, || from_radiance(path, file, length));
    }
    let format = guess(head).ok_or_else(|| Error::file(path, format!("no picture that can be read: not {FORMATS}")))?;
    contain(path, || decode(path, file, format, length))
}

/// As [`load`], of a file whose bytes are in memory; `path` names it in errors. OpenEXR is not read so.
///
/// # Errors
/// As of [`load`].
pub(crate) fn load_bytes(path: &Path, bytes: &[u8]) -> Result<Picture> {
    let (length, file) = (bytes.len() as u64, Cursor::new(bytes));
    if bytes.starts_with(RADIANCE_MAGIC) {
        return contain(path, || from_radiance(path, file, length));
    }
    let unknown = || Error::file(path, format!("no picture that can be read: not {FORMATS}"));
    let format = guess(bytes).filter(|_| !bytes.starts_with(&EXR_MAGIC)).ok_or_else(unknown)?;
    contain(path, || decode(path, file, format, length))
}

/// The file and the layer in it that `path` names.
pub(crate) fn split_layer(path: &Path) -> (PathBuf, Option<String>) {
    let whole = || (path.to_path_buf(), None);
    let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|_| !path.exists()) else { return whole() };
    let Some((file, layer)) = name.split_once(':') else { return whole() };
    (path.with_file_name(file), Some(layer.to_string()))
}

fn fault(path: &Path) -> impl Fn(ImageError) -> Error {
    move |error| match error {
        ImageError::IoError(source) if source.kind() == ErrorKind::UnexpectedEof => {
            Error::file(path, "damaged: the file ends before the picture does")
        }
        ImageError::IoError(source) => Error::io(path)(source),
        error => Error::file(path, format!("no picture that can be read: {error}")),
    }
}

/// `length`: bytes of the file.
fn decode(path: &Path, file: impl BufRead + Seek, format: ImageFormat, length: u64) -> Result<Picture> {
    let mut reader = ImageReader::with_format(file, format);
    // Sizes of pictures are checked below, with messages of our own; this is for what else there is in a file.
    let mut limits = Limits::no_limits();
    let apart = matches!(format, ImageFormat::Png | ImageFormat::Jpeg);
    limits.max_alloc = Some(if apart { MAX_METADATA } else { 2 * MAX_BYTES + MAX_METADATA });
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(fault(path))?;
    check_room(path, &decoder)?;
    let (width, height) = decoder.dimensions();
    check_contents(path, pixels_per_byte(format), u64::from(width) * u64::from(height), length)?;
    let mut notes = Vec::new();
    let profile = decoder.icc_profile().ok().flatten();
    let header = if format == ImageFormat::Png { transfer::of_png(path, &mut notes) } else { None };
    let transfer = header.or_else(|| transfer::of_profile(&profile?, &mut notes)).unwrap_or(Transfer::Srgb);
    let mut picture = from_pixels(path, DynamicImage::from_decoder(decoder).map_err(fault(path))?, &transfer)?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Tiff | ImageFormat::Tga) {
        drop_alpha(&mut picture);
    }
    Ok(Picture { notes, ..picture })
}

/// Refuses what is too large, rows on their way through the decoder included.
fn check_room(path: &Path, decoder: &impl ImageDecoder) -> Result<()> {
    let (width, height) = decoder.dimensions();
    check_size(path, (width.into(), height.into()), decoder.total_bytes(), MAX_BYTES)?;
    memory::check(2 * decoder.total_bytes()).map_err(|shortage| too_large(path, shortage))
}

/// Refuses sizes that a damaged header makes up.
fn check_contents(path: &Path, pixels_per_byte: Option<u64>, pixels: u64, length: u64) -> Result<()> {
    let least = pixels_per_byte.map_or(0, |most| pixels / most);
    if least <= length {
        return Ok(());
    }
    let (least, length) = (memory::text(least), memory::text(length));
    Err(Error::file(path, format!("damaged: its pixels need at least {least}, and the file has {length}")))
}

fn too_large(path: &Path, shortage: Shortage) -> Error {
    Error::file(path, format!("the decoded picture would {shortage}"))
}

fn from_pixels(path: &Path, picture: DynamicImage, transfer: &Transfer) -> Result<Picture> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let channels = usize::from(picture.color().channel_count());
    let eight = |values| Samples::U8(values, transfer.table_8());
    let sixteen = |values| Samples::U16(values, transfer.table_16());
    let samples = match picture {
        DynamicImage::ImageLuma8(pixels) => eight(pixels.into_raw()),
        DynamicImage::ImageLumaA8(pixels) => eight(pixels.into_raw()),
        DynamicImage::ImageRgb8(pixels) => eight(pixels.into_raw()),
        DynamicImage::ImageRgba8(pixels) => eight(pixels.into_raw()),
        DynamicImage::ImageLuma16(pixels) => sixteen(pixels.into_raw()),
        DynamicImage::ImageLumaA16(pixels) => sixteen(pixels.into_raw()),
        DynamicImage::ImageRgb16(pixels) => sixteen(pixels.into_raw()),
        DynamicImage::ImageRgba16(pixels) => sixteen(pixels.into_raw()),
        DynamicImage::ImageRgb32F(pixels) => Samples::F32(pixels.into_raw()),
        DynamicImage::ImageRgba32F(pixels) => Samples::F32(pixels.into_raw()),
        other => {
            return Err(Error::file(path, format!("cannot use texels of {:?}", other.color())));
        }
    };
    let picture = Picture { width, height, channels, samples, notes: Vec::new() };
    check_finite(path, &picture)?;
    Ok(picture)
}

/// Some decoders add an alpha channel to every picture. One that says nothing must not hide the colours, which count as a mask where
/// there is none.
fn drop_alpha(picture: &mut Picture) {
    let Samples::U8(values, _) = &mut picture.samples else { return };
    if picture.channels == 4 && values.iter().skip(3).step_by(4).all(|&alpha| alpha == u8::MAX) {
        *values = values.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        picture.channels = 3;
    }
}

fn check_finite(path: &Path, picture: &Picture) -> Result<()> {
    let Samples::F32(values) = &picture.samples else { return Ok(()) };
    let Some(at) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let pixel = at / picture.channels;
    let (x, y) = (pixel % picture.width, pixel / picture.width);
    Err(Error::file(path, format!("the texel in column {x}, row {y} is not finite")))
}

/// Ward's shared exponents. Radiance is what the pixels say, divided by the exposure and the colour correction in the header.
fn from_radiance(path: &Path, file: impl BufRead, length: u64) -> Result<Picture> {
    let decoder = HdrDecoder::new_nonstrict(file).map_err(fault(path))?;
    check_room(path, &decoder)?;
    let (width, height) = decoder.dimensions();
    check_contents(path, Some(127), u64::from(width) * u64::from(height), length)?;
    let header = decoder.metadata();
    let mut picture = from_pixels(path, DynamicImage::from_decoder(decoder).map_err(fault(path))?, &Transfer::Linear)?;
    let (r, g, b) = header.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let divisors = [r, g, b].map(|correction| correction * header.exposure.unwrap_or(1.0));
    if divisors != [1.0; 3] && divisors.iter().all(|&d| d > 0.0 && d.is_finite()) {
        let Samples::F32(values) = &mut picture.samples else { return Ok(picture) };
        values.iter_mut().enumerate().for_each(|(i, value)| *value /= divisors[i % 3]);
        picture.notes.push(format!("its header says an exposure of {divisors:?}, by which it is divided"));
        check_finite(path, &picture)?;
    }
    Ok(picture)
}

fn from_exr(path: &Path, file: ExrFile, layer: Option<&str>) -> Result<Picture> {
    let (names, note) = file.colour_channels(layer).map_err(|message| Error::file(path, message))?;
    let planes: Vec<&[f32]> = names.iter().map(|name| file.channels[name].as_slice()).collect();
    let pixels = file.width * file.height;
    memory::check(4 * (pixels * names.len()) as u64).map_err(|shortage| too_large(path, shortage))?;
    let values: Vec<f32> = (0..pixels).flat_map(|pixel| planes.iter().map(move |plane| plane[pixel])).collect();
    let (width, height, channels) = (file.width, file.height, names.len());
    let picture = Picture { width, height, channels, samples: Samples::F32(values), notes: note.into_iter().collect() };
    check_finite(path, &picture)?;
    Ok(picture)
}
