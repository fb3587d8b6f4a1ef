//! OpenEXR files: one part, 32-bit floats, layers as prefixes of the channels' names.

mod colours;
mod read;
#[cfg(test)]
mod tests;

pub(crate) use read::read_limited;
pub use read::{ExrFile, read_attributes, read_layers, read_measured, read_rgb};

/// Name of the layer that a denoiser made of the picture.
pub(crate) const DENOISED: &str = "denoised";
/// Attribute of a file whose main channels are a copy of a layer: that layer's name.
pub(crate) const LAYER: &str = "layer";

use super::Layer;
use super::packed::{Packed, Packing};
use crate::Result;
use ::exr::image as file;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, LineOrder, Text};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::prelude::{Compression, Vec2, WritableImage};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::path::Path;

/// What is written about a picture beside its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Tells scenes apart: attribute `sceneHash`.
    pub(crate) scene_hash: String,
    /// Attribute `samplesPerPixel`.
    pub(crate) samples_per_pixel: u32,
    /// Attribute `renderTimeSeconds`.
    pub(crate) render_time_seconds: f32,
    /// Attribute `seed`, as text since 64 bits do not fit a number of this format.
    pub(crate) seed: u64,
    /// More attributes. A name is 1 to 255 printable ASCII characters and none that the format itself uses.
    pub(crate) extra: BTreeMap<String, Attribute>,
}

/// The value of an attribute in a file's header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    Text(String),
    Int(i32),
    Float(f32),
}

/// The whole picture and the part of it that is stored, in pixels. Outside of that part a picture is black.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Size of the whole picture.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Upper left pixel of the stored part, counted from the picture's upper left pixel.
    pub(crate) left: i32,
    pub(crate) top: i32,
    /// Size of the stored part.
    pub(crate) stored_width: usize,
    pub(crate) stored_height: usize,
}

impl Window {
    /// All of the picture is stored.
    pub fn full(width: usize, height: usize) -> Window {
        Window { width, height, left: 0, top: 0, stored_width: width, stored_height: height }
    }

    /// A part of the picture is stored.
    pub(crate) fn part(whole: [u32; 2], corner: [u32; 2], size: [u32; 2]) -> Window {
        let [[width, height], [stored_width, stored_height]] = [whole, size].map(|side| side.map(|n| n as usize));
        Window { width, height, left: corner[0] as i32, top: corner[1] as i32, stored_width, stored_height }
    }
}

/// Writes `layers`, whose channels hold the stored part of `window` row after row, with ZIP compression.
///
/// An existing file is replaced as a whole or not at all. Channels are sorted by name; the order of attributes in the
/// file is not fixed.
///
/// # Errors
/// A channel of the wrong length, a name that occurs twice or is not printable ASCII, a reserved attribute name, an
/// empty window, more than 2³¹ − 1 samples per pixel, and all failures to write.
pub fn write(path: &Path, window: &Window, layers: Vec<Layer>, metadata: &Metadata) -> Result<()> {
    pack(window, layers, metadata, Packing::Tight).write(path)
}

/// The bytes that [`write`] writes, or more of them: a loosely packed file has no compression.
pub(crate) fn pack(window: &Window, layers: Vec<Layer>, metadata: &Metadata, packing: Packing) -> Packed {
    Packed(attributes(metadata).and_then(|other| encode(window, layers, other, packing)))
}

/// Writes `layers` of a picture that another program may have made, with all that is known of it and nothing else.
///
/// # Errors
/// As [`write`].
pub(crate) fn write_with(
    path: &Path,
    window: &Window,
    layers: Vec<Layer>,
    known: &BTreeMap<String, Attribute>,
) -> Result<()> {
    let checked = known.keys().try_for_each(|name| check_name("attribute", name));
    Packed(checked.and_then(|()| encode(window, layers, in_file(known), Packing::Tight))).write(path)
}

type Attributes = std::collections::HashMap<Text, AttributeValue>;

fn in_file(attributes: &BTreeMap<String, Attribute>) -> Attributes {
    attributes.iter().map(|(name, value)| (name.as_str().into(), value.clone().into())).collect()
}

/// The bytes of the file, or what cannot be stored.
fn encode(
    window: &Window,
    layers: Vec<Layer>,
    other: Attributes,
    packing: Packing,
) -> std::result::Result<Vec<u8>, String> {
    let picture = file::Image {
        attributes: ImageAttributes::new(IntegerBounds::from_dimensions((window.width, window.height))),
        layer_data: file::Layer {
            channel_data: channels(window, layers)?,
            attributes: LayerAttributes {
                layer_position: Vec2(window.left, window.top),
                other,
                ..LayerAttributes::default()
            },
            size: Vec2(window.stored_width, window.stored_height),
            encoding: file::Encoding {
                compression: match packing {
                    Packing::Tight => Compression::ZIP16,
                    Packing::Loose => Compression::Uncompressed,
                },
                blocks: file::Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
        },
    };
    let mut bytes = Cursor::new(Vec::new());
    picture.write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

type FlatChannels = file::AnyChannels<file::FlatSamples>;

fn channels(window: &Window, layers: Vec<Layer>) -> std::result::Result<FlatChannels, String> {
    let pixels = window.stored_width * window.stored_height;
    if window.width == 0 || window.height == 0 || pixels == 0 || layers.is_empty() {
        return Err("there is nothing to store".to_owned());
    }
    let mut names = BTreeSet::new();
    let mut list = Vec::new();
    for mut layer in layers {
        for (suffix, values) in std::mem::take(&mut layer.channels) {
            let name = layer.channel_name(&suffix);
            check_name("channel", &name)?;
            if values.len() != pixels {
                let has = values.len();
                return Err(format!("channel {name} has {has} values for {pixels} pixels"));
            }
            if !names.insert(name.clone()) {
                return Err(format!("channel {name} occurs twice"));
            }
            list.push(file::AnyChannel::new(name.as_str(), file::FlatSamples::F32(values)));
        }
    }
    Ok(file::AnyChannels::sort(list.into_iter().collect()))
}

fn attributes(metadata: &Metadata) -> std::result::Result<Attributes, String> {
    let samples = i32::try_from(metadata.samples_per_pixel)
        .map_err(|_| "the number of samples per pixel is too large for this format".to_owned())?;
    let own = [
        ("generatedBy", Attribute::Text(format!("phototaxis {}", env!("CARGO_PKG_VERSION")))),
        ("sceneHash", Attribute::Text(metadata.scene_hash.clone())),
        ("samplesPerPixel", Attribute::Int(samples)),
        ("renderTimeSeconds", Attribute::Float(metadata.render_time_seconds)),
        ("seed", Attribute::Text(metadata.seed.to_string())),
    ];
    for name in metadata.extra.keys() {
        check_name("attribute", name)?;
        if own.iter().any(|(own, _)| own == name) {
            return Err(format!("attribute {name} occurs twice"));
        }
    }
    let extra = metadata.extra.iter().map(|(name, value)| (name.as_str(), value.clone()));
    Ok(own.into_iter().chain(extra).map(|(name, value)| (name.into(), value.into())).collect())
}

fn check_name(kind: &str, name: &str) -> std::result::Result<(), String> {
    let printable = name.bytes().all(|byte| (b' '..=b'~').contains(&byte));
    match name.len() {
        1..=255 if printable => Ok(()),
        _ => Err(format!("{name:?} cannot name a {kind}: 1 to 255 printable ASCII characters can")),
    }
}

impl From<Attribute> for AttributeValue {
    fn from(attribute: Attribute) -> AttributeValue {
        match attribute {
            // Strings of the format are UTF-8, which the crate's own conversions from `str` do not write.
            Attribute::Text(text) => AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())),
            Attribute::Int(value) => AttributeValue::I32(value),
            Attribute::Float(value) => AttributeValue::F32(value),
        }
    }
}

impl Attribute {
    /// `None` for the kinds of attributes that Phototaxis has no use for.
    fn from_file(value: &AttributeValue) -> Option<Attribute> {
        match value {
            AttributeValue::Text(text) => Some(Attribute::Text(String::from_utf8_lossy(text.as_slice()).into_owned())),
            AttributeValue::I32(value) => Some(Attribute::Int(*value)),
            AttributeValue::F32(value) => Some(Attribute::Float(*value)),
            _ => None,
        }
    }
}
