//! Reading of OpenEXR files that any program wrote.

use super::{Attribute, DENOISED, LAYER};
use crate::image::{self, Image};
use crate::io::contain::{check_size, contain};
use crate::io::memory::{self, text};
use crate::math::Rgb;
use crate::{Error, Result};
use ::exr::compression::Compression;
use ::exr::image::{AnyChannels, FlatImage, FlatSamples, Layer};
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::{ReadChannels, ReadLayers};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Decoded pictures above this are refused: a film of 4096 × 2160 pixels with a hundred channels is 3.3 GiB.
const MAX_BYTES: u64 = 4 << 30;

/// Channels of a picture itself, in their usual order.
const MAIN: [&str; 4] = ["R", "G", "B", "A"];

/// All channels of a file, as large as its display window. What lies outside of a data window is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrFile {
    pub width: usize,
    pub height: usize,
    /// By full name, row 0 on top.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// Text, integer and float attributes of the first part, without those that the format itself defines.
    pub attributes: BTreeMap<String, Attribute>,
}

impl ExrFile {
    /// The channels by what they belong to: the name before the last full stop. Colours and vectors are in their usual order,
    /// all else by name; the layer without a name comes first.
    pub(crate) fn layers(self) -> Vec<image::Layer> {
        let mut layers: BTreeMap<String, Vec<(String, Vec<f32>)>> = BTreeMap::new();
        for (channel, values) in self.channels {
            let (name, suffix) = match channel.rsplit_once('.') {
                Some((name, suffix)) => (name, suffix),
                None if MAIN.contains(&&*channel) => ("", &*channel),
                // Such as the depth `Z`, which is a layer of its own.
                None => (&*channel, ""),
            };
            layers.entry(name.into()).or_default().push((suffix.into(), values));
        }
        let order = |suffix: &str| MAIN.iter().position(|own| *own == suffix).unwrap_or(MAIN.len());
        let sorted = |(name, mut channels): (String, Vec<(String, Vec<f32>)>)| {
            channels.sort_by_key(|(suffix, _)| order(suffix));
            image::Layer { name, channels }
        };
        layers.into_iter().map(sorted).collect()
    }

    /// Whether a denoiser made the colours of `layer`, or of the picture itself.
    fn is_denoised(&self, layer: Option<&str>) -> bool {
        let copied = self.attributes.get(LAYER) == Some(&Attribute::Text(DENOISED.into()));
        layer.map_or(copied, |name| name == DENOISED)
    }

    /// The channels `R`, `G`, `B` together, or the names of those that are missing.
    fn rgb(&self) -> std::result::Result<Image, String> {
        let missing: Vec<&str> =
            ["R", "G", "B"].into_iter().filter(|&name| !self.channels.contains_key(name)).collect();
        if !missing.is_empty() {
            let has: Vec<&str> = self.channels.keys().map(String::as_str).collect();
            return Err(format!("lacks channel {}; has {}", missing.join(", "), has.join(", ")));
        }
        memory::check(12 * (self.width * self.height) as u64).map_err(|shortage| format!("its pixels {shortage}"))?;
        let [r, g, b] = ["R", "G", "B"].map(|name| &self.channels[name]);
        let data = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Rgb::new(r, g, b)).collect();
        Ok(Image { width: self.width, height: self.height, data })
    }
}

/// Reads every channel of the file at its largest resolution; half and integer samples become floats.
///
/// The channels of further parts get the part's name as prefix, unless they have it already.
///
/// # Errors
/// All name the file: not an OpenEXR file, damaged or incomplete, deep or subsampled data, a side above 2¹⁶ pixels,
/// more than 4 GiB when decoded, more than a file of its length can hold or than there is memory for, two channels of
/// one name.
pub fn read_layers(path: &Path) -> Result<ExrFile> {
    read_limited(path, MAX_BYTES)
}

/// Reads the unprefixed channels `R`, `G` and `B`: a reference or an environment map.
///
/// # Errors
/// As [`read_layers`], and where one of the channels is missing.
pub fn read_rgb(path: &Path) -> Result<Image> {
    read_layers(path)?.rgb().map_err(|message| Error::file(path, message))
}

/// Reads colours to be measured: those of `layer`, or of the picture itself. Denoised ones are refused unless `denoised` allows
/// them, for a denoiser trades noise for an error that no number of samples takes away.
///
/// # Errors
/// As [`read_layers`], a layer without colours, and what is refused.
pub fn read_measured(path: &Path, layer: Option<&str>, denoised: bool) -> Result<Image> {
    let file = read_layers(path)?;
    if file.is_denoised(layer) && !denoised {
        return Err(Error::file(
            path,
            "this is denoised, and its error is not noise: `error --allow-denoised` measures it all the same",
        ));
    }
    let Some(name) = layer else { return file.rgb().map_err(|message| Error::file(path, message)) };
    let (width, height) = (file.width, file.height);
    let found = file.layers().into_iter().find(|layer| layer.name == name).and_then(|layer| layer.colors());
    let data = found.ok_or_else(|| Error::file(path, format!("there is no layer `{name}` of colours")))?;
    Ok(Image { width, height, data })
}

/// Reads the attributes of the header alone, as of [`ExrFile::attributes`].
///
/// # Errors
/// A file that cannot be read or is no OpenEXR file.
pub fn read_attributes(path: &Path) -> Result<BTreeMap<String, Attribute>> {
    let file = File::open(path).map_err(Error::io(path))?;
    contain(path, || {
        let meta = ::exr::meta::MetaData::read_from_buffered(BufReader::new(file), false);
        let meta = meta.map_err(|error| Error::file(path, format!("not a readable OpenEXR file: {error}")))?;
        Ok(meta.headers.first().map(|header| readable(&header.own_attributes.other)).unwrap_or_default())
    })
}

fn readable<'a>(attributes: impl IntoIterator<Item = (&'a Text, &'a AttributeValue)>) -> BTreeMap<String, Attribute> {
    let readable = |(name, value): (&Text, &AttributeValue)| Some((name.to_string(), Attribute::from_file(value)?));
    attributes.into_iter().filter_map(readable).collect()
}

/// [`read_layers`] with at most `max_bytes` of decoded floats.
pub(crate) fn read_limited(path: &Path, max_bytes: u64) -> Result<ExrFile> {
    let file = File::open(path).map_err(Error::io(path))?;
    let length = file.metadata().map_err(Error::io(path))?.len();
    contain(path, || decode(path, BufReader::new(file), length, max_bytes))
}

/// `length`: bytes of the file.
fn decode(path: &Path, source: impl Read + Seek, length: u64, max_bytes: u64) -> Result<ExrFile> {
    let fault = |error: ::exr::error::Error| match error {
        ::exr::error::Error::Io(source) => Error::io(path)(source),
        error => Error::file(path, format!("not a readable OpenEXR file: {error}")),
    };
    let reader = ::exr::block::read(source, false).map_err(fault)?;
    let bytes = check_headers(path, reader.headers(), max_bytes)?;
    check_contents(path, reader.headers(), length)?;
    memory::check(bytes).map_err(|shortage| Error::file(path, format!("the decoded picture would {shortage}")))?;
    // One thread only: a panic in the crate's own threads would end the process.
    let picture = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_chunks(reader)
        .map_err(fault)?;
    collect(picture).map_err(|message| Error::file(path, message))
}

/// Bytes of what the file says that it holds, when decoded.
fn check_headers(path: &Path, headers: &[Header], max_bytes: u64) -> Result<u64> {
    let mut bytes = 0u64;
    for header in headers {
        if header.deep {
            return Err(Error::file(path, "deep data is not supported"));
        }
        let (display, stored) = (header.shared_attributes.display_window, header.data_window());
        let mut pixels = 0;
        for size in [display.size, stored.size] {
            let (width, height) = (size.0 as u64, size.1 as u64);
            check_size(path, (width, height), 0, max_bytes)?;
            // Equal windows share their memory.
            pixels = if display == stored { width * height } else { pixels + width * height };
        }
        bytes = bytes.saturating_add(4 * pixels * header.channels.list.len() as u64);
        check_size(path, (1, 1), bytes, max_bytes)?;
    }
    Ok(bytes)
}

/// Refuses sizes that a damaged header makes up: compression has its bounds.
fn check_contents(path: &Path, headers: &[Header], length: u64) -> Result<()> {
    let least: u64 = headers.iter().map(|header| decoded_bytes(header) / densest(header.compression)).sum();
    if least <= length {
        return Ok(());
    }
    let (least, length) = (text(least), text(length));
    Err(Error::file(path, format!("damaged: its pixels need at least {least}, and the file has {length}")))
}

/// Bytes of all samples as they are stored before compression.
fn decoded_bytes(header: &Header) -> u64 {
    let size = header.data_window().size;
    let samples = |sampling: (usize, usize)| (size.0 / sampling.0.max(1)) as u64 * (size.1 / sampling.1.max(1)) as u64;
    let channels = header.channels.list.iter();
    channels.map(|c| samples((c.sampling.0, c.sampling.1)) * c.sample_type.bytes_per_sample() as u64).sum()
}

/// How many bytes of samples one byte of a file stands for at most.
fn densest(compression: Compression) -> u64 {
    // 258 bytes take at least two bits (RFC 1951)
    const DEFLATE: u64 = 1032;
    match compression {
        Compression::Uncompressed => 1,
        // 128 equal bytes are two
        Compression::RLE => 64,
        Compression::ZIP1 | Compression::ZIP16 => DEFLATE,
        // 255 equal numbers of two bytes are a code of a bit or more and a count of eight
        Compression::PIZ => 510 * 8 / 9 + 1,
        // three of the four bytes of a float are kept
        Compression::PXR24 => DEFLATE * 4 / 3,
        // sixteen equal numbers of two bytes are three
        Compression::B44 | Compression::B44A => 11,
        // a block of 8 × 8 floats has two numbers of two bytes at least
        _ => DEFLATE * 64,
    }
}

fn collect(picture: FlatImage) -> std::result::Result<ExrFile, String> {
    let window = picture.attributes.display_window;
    let mut file =
        ExrFile { width: window.size.0, height: window.size.1, channels: BTreeMap::new(), attributes: BTreeMap::new() };
    for (part, layer) in picture.layer_data.into_iter().enumerate() {
        if part == 0 {
            file.attributes = readable(&layer.attributes.other);
        }
        add_channels(&mut file, part, window, layer)?;
    }
    Ok(file)
}

fn add_channels(
    file: &mut ExrFile,
    part: usize,
    window: IntegerBounds,
    layer: Layer<AnyChannels<FlatSamples>>,
) -> std::result::Result<(), String> {
    let stored = layer.absolute_bounds();
    let prefix = match (part, &layer.attributes.layer_name) {
        (1.., Some(name)) => format!("{name}."),
        _ => String::new(),
    };
    for channel in layer.channel_data.list {
        let mut name = channel.name.to_string();
        if !name.starts_with(&prefix) {
            name.insert_str(0, &prefix);
        }
        let values = place(into_floats(channel.sample_data), stored, window);
        if file.channels.insert(name.clone(), values).is_some() {
            return Err(format!("channel {name} occurs twice"));
        }
    }
    Ok(())
}

fn into_floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|value| value.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|value| value as f32).collect(),
    }
}

/// Moves the values of the window `stored` to where they lie in `window`: cropped, or surrounded by 0.
fn place(values: Vec<f32>, stored: IntegerBounds, window: IntegerBounds) -> Vec<f32> {
    if stored == window {
        return values;
    }
    let mut placed = vec![0.0; window.size.area()];
    // Offsets of the stored window from the other one; they fit, since either window ends below 2³⁰.
    let (dx, dy) =
        (stored.position.0 as i64 - window.position.0 as i64, stored.position.1 as i64 - window.position.1 as i64);
    let left = dx.max(0);
    let right = (dx + stored.size.0 as i64).min(window.size.0 as i64);
    if left >= right {
        return placed;
    }
    for y in dy.max(0)..(dy + stored.size.1 as i64).min(window.size.1 as i64) {
        let from = (y - dy) as usize * stored.size.0 + (left - dx) as usize;
        let to = y as usize * window.size.0 + left as usize;
        let count = (right - left) as usize;
        placed[to..to + count].copy_from_slice(&values[from..from + count]);
    }
    placed
}
