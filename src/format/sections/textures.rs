//! Colours and numbers that a picture may replace.

use crate::document::{FINITE, Fault, Key, Reader, UNIT, Value, key};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};
use std::path::Path;

/// A reflectance: a grey number, `[r, g, b]` or `{ texture = … }`, each channel in [0, 1].
pub(in crate::format) fn color(
    t: &mut Reader,
    key: impl Into<Key>,
    base: &Path,
    slot: &mut ColorTexture,
) -> Result<(), Fault> {
    let key = key.into();
    let (default, name) = (shown(slot), key.name);
    let Some(node) = t.ask(key, "colour or texture", default, UNIT.range())? else { return Ok(()) };
    *slot = match &node.value {
        Value::Table(_) => {
            let current = match slot {
                ColorTexture::Image(image) => Some(image.clone()),
                ColorTexture::Constant(_) => None,
            };
            let mut t = Reader::new(texture_label(t, name), node)?;
            ColorTexture::Image(color_image(&mut t, current, base).and_then(|i| finish(t, i))?)
        }
        Value::String(_) => {
            return Err(node.mismatch(name, "a number, [r, g, b] or { texture = \"file\" }"));
        }
        _ => ColorTexture::Constant(node.color(name, UNIT)?),
    };
    Ok(())
}

/// A constant colour as one would write it.
fn shown(texture: &ColorTexture) -> String {
    match texture {
        ColorTexture::Constant(c) if c.x == c.y && c.y == c.z => c.x.to_string(),
        ColorTexture::Constant(c) => format!("[{}, {}, {}]", c.x, c.y, c.z),
        ColorTexture::Image(_) => String::new(),
    }
}

/// A number in [0, 1] or `{ texture = … }`.
pub(in crate::format) fn scalar(
    t: &mut Reader,
    key: impl Into<Key>,
    base: &Path,
    slot: &mut Option<ScalarTexture>,
) -> Result<(), Fault> {
    let key = key.into();
    let Some(node) = t.ask(key.optional(), "number or texture", "", UNIT.range())? else { return Ok(()) };
    *slot = Some(match &node.value {
        Value::Table(_) => {
            let (current, mut channel) = match slot {
                Some(ScalarTexture::Image(image)) => (Some(image.clone()), Channel::Alpha),
                Some(ScalarTexture::Luminance(image)) => (Some(image.clone()), Channel::Luminance),
                _ => (None, Channel::Alpha),
            };
            let mut t = Reader::new(texture_label(t, key.name), node)?;
            let image = scalar_image(&mut t, current, &mut channel, base)?;
            channel.of(finish(t, image)?)
        }
        Value::Integer(_) | Value::Float(_) => ScalarTexture::Constant(node.number(key.name, UNIT)?),
        _ => return Err(node.mismatch(key.name, "a number or { texture = \"file\" }")),
    });
    Ok(())
}

/// Which number of a picture counts.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::format) enum Channel {
    Alpha,
    Luminance,
}

impl Channel {
    fn of(self, image: ImageTexture) -> ScalarTexture {
        match self {
            Channel::Alpha => ScalarTexture::Image(image),
            Channel::Luminance => ScalarTexture::Luminance(image),
        }
    }
}

pub(in crate::format) fn scalar_image(
    t: &mut Reader,
    current: Option<ImageTexture>,
    channel: &mut Channel,
    base: &Path,
) -> Result<ImageTexture, Fault> {
    let channels = [("alpha", Channel::Alpha), ("luminance", Channel::Luminance)];
    let image = image(t, current, base)?;
    let meaning = "of the picture: its alpha channel (its luminance where it has none), or its luminance, both as stored, not \
                   decoded from sRGB";
    t.choice(key("channel", meaning), &channels, channel)?;
    Ok(image)
}

fn texture_label(t: &Reader, key: &str) -> String {
    format!("`{key}` of {}", t.label())
}

fn finish(t: Reader, image: ImageTexture) -> Result<ImageTexture, Fault> {
    t.finish().map(|()| image)
}

pub(in crate::format) fn color_image(
    t: &mut Reader,
    current: Option<ImageTexture>,
    base: &Path,
) -> Result<ImageTexture, Fault> {
    let mut image = image(t, current, base)?;
    t.color(key("tint", "multiplies the picture; not for `opacity`"), UNIT, &mut image.tint)?;
    Ok(image)
}

const PICTURE: &str = "a picture: PNG, JPEG, OpenEXR (`file.exr:LAYER` for one of several layers), TGA, BMP, TIFF, GIF, WebP, Radiance HDR, \
    DDS, PNM, ICO, QOI or farbfeld; its content says which";

/// A new picture where `texture` is given, else changes to the `current` one.
fn image(t: &mut Reader, current: Option<ImageTexture>, base: &Path) -> Result<ImageTexture, Fault> {
    let file = key("texture", PICTURE);
    let file = if current.is_none() { file.required() } else { file };
    let mut image = match t.path(file, base)? {
        Some(path) => plain(&path),
        None => current.unwrap_or_else(|| plain(base)),
    };
    let scale = key("scale", "multiplies texture coordinates; v points up, (0, 0) is the lower left corner");
    pair(t, scale, "1", &mut image.scale)?;
    let offset = key("offset", "is then added; outside of 0 to 1 the picture repeats");
    pair(t, offset, "0", &mut image.offset)?;
    t.flag(key("nearest", "nearest texel instead of bilinear interpolation"), &mut image.nearest)?;
    Ok(image)
}

fn plain(path: &Path) -> ImageTexture {
    ImageTexture { path: path.to_path_buf(), scale: [1.0; 2], offset: [0.0; 2], nearest: false, tint: Rgb::ONE }
}

/// `[u, v]`, or one number for both.
fn pair(t: &mut Reader, key: Key, default: &str, slot: &mut [f32; 2]) -> Result<(), Fault> {
    let Some(node) = t.ask(key, "number or `[u, v]`", default, "")? else { return Ok(()) };
    *slot = match node.value {
        Value::Array(_) => node.numbers(key.name, FINITE)?,
        _ => [node.number(key.name, FINITE)?; 2],
    };
    Ok(())
}
