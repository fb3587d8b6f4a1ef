//! A material as it is understood: each of its parameters, and who says so.

use crate::document::{Bounds, Key};
use crate::fields::{Choice, FieldVisitor, Fields};
use crate::math::Rgb;
use crate::scene::description::{BlendDescription, BlendPart, MaterialDescription};
use crate::scene::{DescribedMaterial, MaterialSource};
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use glam::{Affine3A, DVec3, Vec3};
use serde::Serialize;
use serde_json::{Value, json};
use std::convert::Infallible;
use std::path::PathBuf;

/// A value, and where it comes from.
#[derive(Serialize)]
pub(super) struct Parameter {
    pub(super) key: &'static str,
    pub(super) value: Value,
    /// `scene file` or `library`, else `default`: the value is the one that its type has where nothing is said.
    pub(super) from: &'static str,
}

/// Who describes a material.
pub(super) fn source(source: MaterialSource) -> &'static str {
    match source {
        MaterialSource::SceneFile => "scene file",
        MaterialSource::Library => "library",
        MaterialSource::Nobody => "default",
    }
}

/// All parameters of a material, by the keys of a scene file.
pub(super) fn parameters(material: &DescribedMaterial) -> Vec<Parameter> {
    let described = &material.description;
    let usual = MaterialDescription {
        bsdf: described.bsdf.bsdf_type().bsdf(),
        blend: described
            .blend
            .as_ref()
            .map(|blend| BlendDescription { weight: ScalarTexture::Constant(0.5), ..blend.clone() }),
        ..Default::default()
    };
    let from = source(material.source);
    let pairs = all_values(described).into_iter().zip(all_values(&usual));
    pairs
        .map(|((key, value), (_, usual))| {
            let from = if value == usual { "default" } else { from };
            Parameter { key, value, from }
        })
        .collect()
}

/// The parameters of anything that has fields.
pub(super) fn values(fields: &mut impl Fields) -> Vec<(&'static str, Value)> {
    let mut listing = Listing::default();
    let Ok(()) = fields.fields(&mut listing);
    listing.0
}

fn all_values(material: &MaterialDescription) -> Vec<(&'static str, Value)> {
    let mut all = match &material.blend {
        Some(blend) => vec![("materials", parts(blend)), ("weight", scalar(&blend.weight))],
        None => values(&mut material.bsdf.clone()),
    };
    if material.blend.is_none() {
        all.push(("two_sided", json!(material.two_sided)));
    }
    all.push(("opacity", material.opacity.as_ref().map_or(json!(1.0), scalar)));
    all.push((
        "emission",
        material.emission_map.as_ref().map_or(rgb(material.emission), |map| glow(material.emission, map)),
    ));
    all.push(("emission_two_sided", json!(material.emission_two_sided)));
    all.extend(material.relief.iter().map(relief));
    all
}

/// What it is mixed of: each by its name and type.
fn parts(blend: &BlendDescription) -> Value {
    let part = |part: &BlendPart| json!({ "name": part.name, "type": part.material.type_name() });
    blend.parts.iter().map(part).collect()
}

/// The pictures of a material.
pub(super) fn pictures(material: &MaterialDescription) -> Vec<PathBuf> {
    let mut found = Vec::new();
    if let Some(blend) = &material.blend {
        found.extend(blend.weight.image().map(|image| image.path.clone()));
        found.extend(blend.parts.iter().flat_map(|part| pictures(&part.material)));
    }
    crate::fields::each_texture(&mut material.bsdf.clone(), |texture| {
        if let ColorTexture::Image(image) = texture {
            found.push(image.path.clone());
        }
    });
    crate::fields::each_share(&mut material.bsdf.clone(), |_, map| {
        found.extend(map.as_ref().and_then(ScalarTexture::image).map(|image| image.path.clone()));
    });
    let opacity = material.opacity.as_ref().and_then(ScalarTexture::image);
    let others = opacity.into_iter().chain(&material.emission_map).chain(material.relief.iter().map(|r| &r.image));
    found.extend(others.map(|image| image.path.clone()));
    found
}

/// With the digits of single precision, and no more.
fn number(x: f32) -> Value {
    x.to_string().parse::<f64>().map_or(Value::Null, |x| json!(x))
}

fn numbers<const N: usize>(values: [f32; N]) -> Value {
    values.into_iter().map(number).collect()
}

/// A place, with the digits of single precision where that is all it has.
pub(super) fn place(v: DVec3) -> Value {
    let coordinate = |x: f64| if f64::from(x as f32) == x { number(x as f32) } else { json!(x) };
    v.to_array().into_iter().map(coordinate).collect()
}

fn rgb(color: Rgb) -> Value {
    numbers(color.to_array())
}

fn image(image: &ImageTexture) -> Value {
    let ImageTexture { path, scale, offset, nearest, tint, clamp } = image;
    json!({ "texture": path.display().to_string(), "scale": numbers(*scale), "offset": numbers(*offset),
            "nearest": nearest, "clamp": clamp, "tint": rgb(*tint) })
}

/// Radiance where the picture is white, with the picture.
fn glow(emission: Rgb, map: &ImageTexture) -> Value {
    let mut value = image(map);
    value["tint"] = rgb(emission);
    value
}

/// What turns the normals.
fn relief(relief: &ReliefTexture) -> (&'static str, Value) {
    let (key, strength) = match relief.kind {
        ReliefKind::Normals => ("normal_map", "strength"),
        ReliefKind::NormalsDown => ("normal_map_with_green_down", "strength"),
        ReliefKind::Heights => ("bump_map", "height"),
        ReliefKind::TexelHeights => ("bump_map", "height_in_texels"),
        ReliefKind::NormalsOrTexelHeights => ("normal_or_bump_map", "strength"),
    };
    let mut value = image(&relief.image);
    value[strength] = number(relief.strength);
    (key, value)
}

fn scalar(texture: &ScalarTexture) -> Value {
    match texture {
        ScalarTexture::Constant(value) => number(*value),
        ScalarTexture::Image(picture) => image(picture),
        ScalarTexture::Luminance(picture) => of_channel(picture, "luminance"),
        ScalarTexture::Channel(picture, channel) => of_channel(picture, ["red", "green", "blue"][*channel]),
    }
}

fn of_channel(picture: &ImageTexture, channel: &str) -> Value {
    let mut value = image(picture);
    value["channel"] = json!(channel);
    value
}

/// Keys and values in the order of the fields.
#[derive(Default)]
struct Listing(Vec<(&'static str, Value)>);

impl Listing {
    fn add(&mut self, key: Key, value: Value) -> Result<(), Infallible> {
        self.0.push((key.name, value));
        Ok(())
    }
}

impl FieldVisitor for Listing {
    type Error = Infallible;

    fn flag(&mut self, key: Key, slot: &mut bool) -> Result<(), Infallible> {
        self.add(key, json!(*slot))
    }

    fn number(&mut self, key: Key, _: Bounds, slot: &mut f32) -> Result<(), Infallible> {
        self.add(key, number(*slot))
    }

    fn share(&mut self, key: Key, constant: &mut f32, map: &mut Option<ScalarTexture>) -> Result<(), Infallible> {
        self.add(key, map.as_ref().map_or_else(|| number(*constant), scalar))
    }

    fn color(&mut self, key: Key, _: Bounds, slot: &mut Rgb) -> Result<(), Infallible> {
        self.add(key, rgb(*slot))
    }

    fn choice<T: Choice>(&mut self, key: Key, slot: &mut T) -> Result<(), Infallible> {
        let name = T::NAMES.get(slot.number()).map_or("", |(name, _)| name);
        self.add(key, json!(name))
    }

    fn texture(&mut self, key: Key, slot: &mut ColorTexture) -> Result<(), Infallible> {
        let value = match slot {
            ColorTexture::Constant(color) => rgb(*color),
            ColorTexture::Vertex(tint) => json!({ "vertex_color": true, "tint": tint.to_array() }),
            ColorTexture::Image(picture) => image(picture),
        };
        self.add(key, value)
    }

    fn color_pair(&mut self, keys: [(Key, Bounds); 2], slot: &mut Option<(Rgb, Rgb)>) -> Result<(), Infallible> {
        let [first, second] = keys.map(|(key, _)| key);
        self.add(first, json!(slot.map(|(first, _)| rgb(first))))?;
        self.add(second, json!(slot.map(|(_, second)| rgb(second))))
    }

    fn position(&mut self, key: Key, slot: &mut DVec3) -> Result<(), Infallible> {
        self.add(key, json!(slot.to_array()))
    }

    fn direction(&mut self, key: Key, slot: &mut Vec3) -> Result<(), Infallible> {
        self.add(key, rgb(*slot))
    }

    fn orientation(&mut self, _: Key, matrix: Key, slot: &mut Affine3A) -> Result<(), Infallible> {
        self.add(
            matrix,
            glam::Mat3::from(slot.matrix3).transpose().to_cols_array_2d().map(numbers).into_iter().collect(),
        )
    }

    fn picture(&mut self, key: Key, slot: &mut PathBuf) -> Result<(), Infallible> {
        self.add(key, json!(slot.display().to_string()))
    }
}
