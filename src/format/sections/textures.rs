//! Colours and numbers that a picture may replace.

use crate::document::{FINITE, Fault, Node, Reader, UNIT, Value};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};
use std::path::Path;

/// A reflectance: a grey number, `[r, g, b]` or `{ texture = … }`, each channel in [0, 1].
pub(in crate::format) fn color(
    t: &mut Reader,
    key: &'static str,
    base: &Path,
    slot: &mut ColorTexture,
) -> Result<(), Fault> {
    let Some(node) = t.take(key) else { return Ok(()) };
    *slot = match &node.value {
        Value::Table(_) => {
            let current = match slot {
                ColorTexture::Image(image) => Some(image.clone()),
                ColorTexture::Constant(_) => None,
            };
            let mut t = Reader::new(texture_label(t, key), node)?;
            ColorTexture::Image(color_image(&mut t, current, base).and_then(|i| finish(t, i))?)
        }
        Value::String(_) => {
            return Err(node.mismatch(key, "a number, [r, g, b] or { texture = \"file\" }"));
        }
        _ => ColorTexture::Constant(node.color(key, UNIT)?),
    };
    Ok(())
}

/// A number in [0, 1] or `{ texture = … }`.
pub(in crate::format) fn scalar(
    t: &mut Reader,
    key: &'static str,
    base: &Path,
    slot: &mut Option<ScalarTexture>,
) -> Result<(), Fault> {
    let Some(node) = t.take(key) else { return Ok(()) };
    *slot = Some(match &node.value {
        Value::Table(_) => {
            let (current, mut channel): (_, Channel) = match slot {
                Some(ScalarTexture::Image(image)) => (Some(image.clone()), ScalarTexture::Image),
                Some(ScalarTexture::Luminance(image)) => (Some(image.clone()), ScalarTexture::Luminance),
                _ => (None, ScalarTexture::Image),
            };
            let mut t = Reader::new(texture_label(t, key), node)?;
            let image = scalar_image(&mut t, current, &mut channel, base)?;
            channel(finish(t, image)?)
        }
        Value::Integer(_) | Value::Float(_) => ScalarTexture::Constant(node.number(key, UNIT)?),
        _ => return Err(node.mismatch(key, "a number or { texture = \"file\" }")),
    });
    Ok(())
}

/// Which number of a picture counts.
pub(in crate::format) type Channel = fn(ImageTexture) -> ScalarTexture;

pub(in crate::format) fn scalar_image(
    t: &mut Reader,
    current: Option<ImageTexture>,
    channel: &mut Channel,
    base: &Path,
) -> Result<ImageTexture, Fault> {
    let channels: [(_, Channel); 2] = [("alpha", ScalarTexture::Image), ("luminance", ScalarTexture::Luminance)];
    let image = image(t, current, base)?;
    t.choice("channel", &channels, channel)?;
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
    t.color("tint", UNIT, &mut image.tint)?;
    Ok(image)
}

/// A new picture where `texture` is given, else changes to the `current` one.
fn image(t: &mut Reader, current: Option<ImageTexture>, base: &Path) -> Result<ImageTexture, Fault> {
    let mut image = match t.take("texture") {
        Some(node) => plain(&node.path("texture", base)?),
        None => current.ok_or_else(|| t.missing("texture"))?,
    };
    if let Some(node) = t.take("scale") {
        image.scale = pair(&node, "scale")?;
    }
    if let Some(node) = t.take("offset") {
        image.offset = pair(&node, "offset")?;
    }
    t.flag("nearest", &mut image.nearest)?;
    Ok(image)
}

fn plain(path: &Path) -> ImageTexture {
    ImageTexture { path: path.to_path_buf(), scale: [1.0; 2], offset: [0.0; 2], nearest: false, tint: Rgb::ONE }
}

/// `[u, v]`, or one number for both.
fn pair(node: &Node, key: &str) -> Result<[f32; 2], Fault> {
    match node.value {
        Value::Array(_) => node.numbers(key, FINITE),
        _ => Ok([node.number(key, FINITE)?; 2]),
    }
}
