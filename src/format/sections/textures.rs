//! Colours and numbers that a picture may replace.

use crate::document::{FINITE, Fault, Key, NOT_NEGATIVE, Node, Reader, UNIT, Value, key};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use std::path::Path;

/// A reflectance: a grey number, `[r, g, b]`, `{ texture = … }` or `{ vertex_color = true }`, each channel in [0, 1].
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
                _ => None,
            };
            let written = |key: &str| matches!(&node.value, Value::Table(entries) if entries.contains_key(key));
            let tint = match slot {
                ColorTexture::Vertex(tint) if !written("texture") => Some(*tint),
                _ => written("vertex_color").then_some(Rgb::ONE),
            };
            let mut t = Reader::new(texture_label(t, name), node)?;
            if let Some(tint) = tint {
                *slot = vertex_color(&mut t, tint)?;
                return t.finish();
            }
            ColorTexture::Image(color_image(&mut t, current, base).and_then(|i| finish(t, i))?)
        }
        Value::String(_) => {
            return Err(node.mismatch(name, "a number, [r, g, b] or { texture = \"file\" }"));
        }
        _ => ColorTexture::Constant(node.color(name, UNIT)?),
    };
    Ok(())
}

/// The colours of the mesh, times `tint`.
fn vertex_color(t: &mut Reader, mut tint: Rgb) -> Result<ColorTexture, Fault> {
    let mut on = true;
    t.flag(VERTEX_COLOR, &mut on)?;
    if !on {
        return Err(Fault::new(t.place(&[VERTEX_COLOR.name]), "`vertex_color` is true, or left out"));
    }
    t.color(key("tint", ""), UNIT, &mut tint)?;
    Ok(ColorTexture::Vertex(tint))
}

/// What stands in the place of `texture`.
pub(in crate::format) const VERTEX_COLOR: Key = Key {
    default: Some("none"),
    ..key(
        "vertex_color",
        "`true`: the colours of the mesh's vertices or faces, in the place of a picture; not for `opacity`",
    )
};
/// A radiance: a grey number, `[r, g, b]` or `{ texture = … }`, of which `tint` is the radiance of white.
pub(in crate::format) fn emission(
    t: &mut Reader,
    key: Key,
    base: &Path,
    material: &mut MaterialDescription,
) -> Result<(), Fault> {
    let default = shown(&ColorTexture::Constant(material.emission));
    let Some(node) = t.ask(key, "colour or texture", default, NOT_NEGATIVE.range())? else { return Ok(()) };
    if !matches!(node.value, Value::Table(_)) {
        (material.emission, material.emission_map) = (node.color(key.name, NOT_NEGATIVE)?, None);
        return Ok(());
    }
    let mut table = Reader::new(texture_label(t, key.name), node)?;
    let old = material.emission_map.take();
    // of a surface that does not glow by a picture yet, white is 1
    let mut radiance = if old.is_some() { material.emission } else { Rgb::ONE };
    let map = emission_image(&mut table, old, base, &mut radiance)?;
    (material.emission, material.emission_map) = (radiance, Some(finish(table, map)?));
    Ok(())
}

pub(in crate::format) fn emission_image(
    t: &mut Reader,
    current: Option<ImageTexture>,
    base: &Path,
    radiance: &mut Rgb,
) -> Result<ImageTexture, Fault> {
    let image = image(t, current, base)?;
    let meaning = "radiance where the picture is white (1)";
    t.color(key("tint", meaning).unit("W/(sr·m²)"), NOT_NEGATIVE, radiance)?;
    Ok(image)
}

/// `normal_map` or `bump_map`: what turns normals.
pub(in crate::format) fn relief(t: &mut Reader, base: &Path, slot: &mut Option<ReliefTexture>) -> Result<(), Fault> {
    let normals = key(
        "normal_map",
        "a picture of normals, `{ texture = … }`; surfaces without texture coordinates stay as they are",
    );
    let heights = key("bump_map", "the same of heights; not together with `normal_map`");
    let normals = t.ask(normals.optional(), "texture", "", "")?;
    let heights = t.ask(heights.optional(), "texture", "", "")?;
    let (node, name, kind) = match (normals, heights) {
        (None, None) => return Ok(()),
        (Some(_), Some(node)) => {
            return Err(Fault::new(node.at, "`normal_map` and `bump_map` exclude each other"));
        }
        (Some(node), None) => (node, "normal_map", ReliefKind::Normals),
        (None, Some(node)) => (node, "bump_map", ReliefKind::Heights),
    };
    let mut table = Reader::new(texture_label(t, name), node)?;
    let current = slot.take().filter(|relief| relief.kind == kind);
    let relief = relief_image(&mut table, current, kind, base)?;
    table.finish()?;
    *slot = Some(relief);
    Ok(())
}

pub(in crate::format) fn relief_image(
    t: &mut Reader,
    current: Option<ReliefTexture>,
    kind: ReliefKind,
    base: &Path,
) -> Result<ReliefTexture, Fault> {
    let (old, mut strength) = current.map_or((None, 1.0), |relief| (Some(relief.image), relief.strength));
    let image = image(t, old, base)?;
    match kind {
        ReliefKind::Normals => {
            t.number(key("strength", "multiplies the tilt of the normals"), FINITE, &mut strength)?
        }
        _ => t.number(key("height", "of white over black").unit("length"), FINITE, &mut strength)?,
    }
    Ok(ReliefTexture { image, kind, strength })
}

/// A constant colour as one would write it.
fn shown(texture: &ColorTexture) -> String {
    match texture {
        ColorTexture::Constant(c) if c.x == c.y && c.y == c.z => c.x.to_string(),
        ColorTexture::Constant(c) => format!("[{}, {}, {}]", c.x, c.y, c.z),
        ColorTexture::Image(_) | ColorTexture::Vertex(_) => String::new(),
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
        Value::Table(_) => scalar_table(t, key, node, base, slot.as_ref(), Channel::Alpha)?,
        Value::Integer(_) | Value::Float(_) => ScalarTexture::Constant(node.number(key.name, UNIT)?),
        _ => return Err(node.mismatch(key.name, "a number or { texture = \"file\" }")),
    });
    Ok(())
}

/// A number in [0, 1], or `{ texture = … }` in its place.
pub(in crate::format) fn share(
    t: &mut Reader,
    key: Key,
    base: &Path,
    number: &mut f32,
    map: &mut Option<ScalarTexture>,
) -> Result<(), Fault> {
    let Some(node) = t.ask(key, "number or texture", number.to_string(), UNIT.range())? else { return Ok(()) };
    match &node.value {
        Value::Table(_) => *map = Some(scalar_table(t, key, node, base, map.as_ref(), Channel::Luminance)?),
        Value::Integer(_) | Value::Float(_) => (*number, *map) = (node.number(key.name, UNIT)?, None),
        _ => return Err(node.mismatch(key.name, "a number or { texture = \"file\" }")),
    }
    Ok(())
}

/// The table of a picture of numbers; `usual` is which of them counts where nothing says so.
fn scalar_table(
    t: &Reader,
    key: Key,
    node: Node,
    base: &Path,
    current: Option<&ScalarTexture>,
    usual: Channel,
) -> Result<ScalarTexture, Fault> {
    let mut channel = match current {
        Some(ScalarTexture::Image(_)) => Channel::Alpha,
        Some(ScalarTexture::Luminance(_)) => Channel::Luminance,
        Some(ScalarTexture::Channel(_, channel)) => Channel::Color(*channel),
        _ => usual,
    };
    let mut t = Reader::new(texture_label(t, key.name), node)?;
    let image = scalar_image(&mut t, current.and_then(ScalarTexture::image).cloned(), &mut channel, base)?;
    Ok(channel.of(finish(t, image)?))
}

/// Which number of a picture counts.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::format) enum Channel {
    Alpha,
    Luminance,
    /// Red, green or blue.
    Color(usize),
}

impl Channel {
    fn of(self, image: ImageTexture) -> ScalarTexture {
        match self {
            Channel::Alpha => ScalarTexture::Image(image),
            Channel::Luminance => ScalarTexture::Luminance(image),
            Channel::Color(channel) => ScalarTexture::Channel(image, channel),
        }
    }
}

pub(in crate::format) fn scalar_image(
    t: &mut Reader,
    current: Option<ImageTexture>,
    channel: &mut Channel,
    base: &Path,
) -> Result<ImageTexture, Fault> {
    let channels = [
        ("alpha", Channel::Alpha),
        ("luminance", Channel::Luminance),
        ("red", Channel::Color(0)),
        ("green", Channel::Color(1)),
        ("blue", Channel::Color(2)),
    ];
    let image = image(t, current, base)?;
    let meaning = "of the picture: its alpha channel (its luminance where it has none), its luminance or one of its colours, as \
                   stored, not decoded from sRGB; `\"alpha\"` of an `opacity`, `\"luminance\"` elsewhere";
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
    let tint = "multiplies the picture, or the vertices' colours; not for `opacity` and maps of normals";
    t.color(key("tint", tint), UNIT, &mut image.tint)?;
    Ok(image)
}

const PICTURE: &str = "a picture: PNG, JPEG, OpenEXR (`file.exr:LAYER` for one of several layers), TGA, BMP, TIFF, GIF, WebP, Radiance HDR, \
    DDS, PNM, ICO, QOI or farbfeld; its content says which";

/// A new picture where `texture` is given, else changes to the `current` one.
fn image(t: &mut Reader, current: Option<ImageTexture>, base: &Path) -> Result<ImageTexture, Fault> {
    let file = key("texture", PICTURE);
    let file = if current.is_none() { file.required() } else { file };
    let mut image = match t.path(file, base)? {
        Some(path) => ImageTexture::new(path),
        None => current.unwrap_or_else(|| ImageTexture::new(base.to_path_buf())),
    };
    let scale = key("scale", "multiplies texture coordinates; v points up, (0, 0) is the lower left corner");
    pair(t, scale, "1", &mut image.scale)?;
    let offset = key("offset", "is then added; outside of 0 to 1 the picture repeats, unless `clamp`");
    pair(t, offset, "0", &mut image.offset)?;
    t.flag(key("clamp", "the picture does not repeat: its edge goes on"), &mut image.clamp)?;
    t.flag(key("nearest", "nearest texel instead of bilinear interpolation"), &mut image.nearest)?;
    Ok(image)
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
