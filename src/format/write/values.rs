//! Materials and lights as tables, field by field.

use super::pictures::Pictures;
use crate::document::{Bounds, Key};
use crate::fields::{Choice, FieldVisitor, Fields};
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::scene::description::{BlendDescription, MaterialDescription};
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use ::toml::{Table, Value};
use glam::{Affine3A, DVec3, Mat4, Vec3};
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::path::PathBuf;

pub(super) fn double(x: f64) -> Value {
    Value::Float(x)
}

/// With the digits of single precision, and no more: it is the same number when it is read.
pub(super) fn number(x: f32) -> Value {
    Value::Float(x.to_string().parse().unwrap_or_else(|_| x.into()))
}

pub(super) fn numbers(values: &[f32]) -> Value {
    Value::Array(values.iter().map(|&x| number(x)).collect())
}

pub(super) fn doubles(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|&x| double(x)).collect())
}

/// A light with its type.
pub(super) fn light(described: &LightDescription, pictures: &mut Pictures) -> Table {
    let mut writer = Writer { table: Table::new(), pictures };
    writer.table.insert("type".into(), Value::String(described.type_name().into()));
    let Ok(()) = described.clone().fields(&mut writer);
    writer.table
}

/// Materials by name.
pub(super) struct Materials {
    pub(crate) written: Table,
    /// That are taken.
    pub(crate) names: BTreeSet<String>,
}

impl Materials {
    /// Adds a material under its name, and under other names what it is mixed of.
    ///
    /// # Errors
    /// What of it cannot be said.
    pub(crate) fn add(
        &mut self,
        name: &str,
        described: &MaterialDescription,
        pictures: &mut Pictures,
    ) -> Result<(), &'static str> {
        let table = match &described.blend {
            None => single(described, pictures)?,
            Some(blend) => self.blend(name, (described, blend), pictures)?,
        };
        self.written.insert(name.to_string(), Value::Table(table));
        Ok(())
    }

    fn blend(
        &mut self,
        name: &str,
        (described, blend): (&MaterialDescription, &BlendDescription),
        pictures: &mut Pictures,
    ) -> Result<Table, &'static str> {
        let mut names = Vec::new();
        for (k, part) in blend.parts.iter().enumerate() {
            let own = part.name.clone().unwrap_or_else(|| format!("{name}, part {}", k + 1));
            let free = (1..).map(|k| if k == 1 { own.clone() } else { format!("{own} {k}") });
            let part_name = free.into_iter().find(|name| self.names.insert(name.clone())).unwrap_or_default();
            self.add(&part_name, &MaterialDescription { emission: Rgb::ZERO, ..part.material.clone() }, pictures)?;
            names.push(Value::String(part_name));
        }
        let mut table = Table::new();
        table.insert("type".into(), Value::String("blend".into()));
        table.insert("materials".into(), Value::Array(names));
        table.insert("weight".into(), scalar(&blend.weight, pictures));
        if let Some(opacity) = &described.opacity {
            table.insert("opacity".into(), scalar(opacity, pictures));
        }
        emission(described, &mut table, pictures);
        Ok(table)
    }
}

/// A material with its type, or what of it cannot be said.
fn single(described: &MaterialDescription, pictures: &mut Pictures) -> Result<Table, &'static str> {
    let kind = described.bsdf.bsdf_type();
    let mut writer = Writer { table: Table::new(), pictures };
    writer.table.insert("type".into(), Value::String(kind.name().into()));
    let Ok(()) = described.bsdf.clone().fields(&mut writer);
    let Writer { mut table, pictures } = writer;
    if kind.is_opaque() {
        table.insert("two_sided".into(), Value::Boolean(described.two_sided));
    }
    if let Some(opacity) = described.opacity.as_ref().filter(|_| kind.is_surface()) {
        table.insert("opacity".into(), scalar(opacity, pictures));
    }
    if let Some(relief) = described.relief.as_ref().filter(|_| kind.is_surface()) {
        let (key, value) = self::relief(relief, pictures)?;
        table.insert(key.into(), Value::Table(value));
    }
    emission(described, &mut table, pictures);
    Ok(table)
}

fn emission(described: &MaterialDescription, table: &mut Table, pictures: &mut Pictures) {
    let emission = match &described.emission_map {
        None => color(described.emission),
        Some(image) => {
            let mut value = self::image(image, pictures);
            value.insert("tint".into(), color(described.emission * image.tint));
            Value::Table(value)
        }
    };
    table.insert("emission".into(), emission);
    table.insert("emission_two_sided".into(), Value::Boolean(described.emission_two_sided));
    insert_group(table, described.light_group.as_ref());
}

/// The light group of a material or a light, where it is in one.
pub(super) fn insert_group(table: &mut Table, group: Option<&String>) {
    if let Some(group) = group {
        table.insert("light_group".into(), Value::String(group.clone()));
    }
}

fn relief(relief: &ReliefTexture, pictures: &mut Pictures) -> Result<(&'static str, Table), &'static str> {
    let (key, strength) = match relief.kind {
        ReliefKind::Normals => ("normal_map", "strength"),
        ReliefKind::Heights => ("bump_map", "height"),
        ReliefKind::NormalsDown => return Err("normals whose green is along −v"),
        ReliefKind::TexelHeights | ReliefKind::NormalsOrTexelHeights => {
            return Err("heights in widths of a texel (`bump` of an MTL library)");
        }
    };
    let mut table = image(&relief.image, pictures);
    table.insert(strength.into(), number(relief.strength));
    Ok((key, table))
}

fn color(c: Rgb) -> Value {
    numbers(&c.to_array())
}

fn image(image: &ImageTexture, pictures: &mut Pictures) -> Table {
    let mut t = Table::new();
    t.insert("texture".into(), Value::String(pictures.name(&image.path)));
    t.insert("scale".into(), numbers(&image.scale));
    t.insert("offset".into(), numbers(&image.offset));
    t.insert("clamp".into(), Value::Boolean(image.clamp));
    t.insert("nearest".into(), Value::Boolean(image.nearest));
    t
}

fn scalar(texture: &ScalarTexture, pictures: &mut Pictures) -> Value {
    let channel = match texture {
        ScalarTexture::Constant(x) => return number(*x),
        ScalarTexture::Image(_) => "alpha",
        ScalarTexture::Luminance(_) => "luminance",
        ScalarTexture::Channel(_, k) => ["red", "green", "blue"][*k % 3],
    };
    let mut t = texture.image().map(|found| image(found, pictures)).unwrap_or_default();
    t.insert("channel".into(), Value::String(channel.into()));
    Value::Table(t)
}

/// Puts fields into a table under their keys.
struct Writer<'a, 'b> {
    table: Table,
    pictures: &'a mut Pictures<'b>,
}

impl Writer<'_, '_> {
    /// Keys that mean nothing beside others are left out.
    fn put(&mut self, key: Key, value: Value) -> Result<(), Infallible> {
        if key.unless.is_none() {
            self.table.insert(key.name.into(), value);
        }
        Ok(())
    }
}

impl FieldVisitor for Writer<'_, '_> {
    type Error = Infallible;

    fn flag(&mut self, key: Key, slot: &mut bool) -> Result<(), Infallible> {
        self.put(key, Value::Boolean(*slot))
    }

    fn number(&mut self, key: Key, _: Bounds, slot: &mut f32) -> Result<(), Infallible> {
        self.put(key, number(*slot))
    }

    fn share(&mut self, key: Key, slot: &mut f32, map: &mut Option<ScalarTexture>) -> Result<(), Infallible> {
        let value = map.as_ref().map_or_else(|| number(*slot), |map| scalar(map, self.pictures));
        self.put(key, value)
    }

    fn color(&mut self, key: Key, _: Bounds, slot: &mut Rgb) -> Result<(), Infallible> {
        self.put(key, color(*slot))
    }

    fn choice<T: Choice>(&mut self, key: Key, slot: &mut T) -> Result<(), Infallible> {
        let name = T::NAMES.iter().find(|(_, value)| value == slot).map_or("", |(name, _)| name);
        self.put(key, Value::String(name.into()))
    }

    fn texture(&mut self, key: Key, slot: &mut ColorTexture) -> Result<(), Infallible> {
        let value = match slot {
            ColorTexture::Constant(constant) => color(*constant),
            ColorTexture::Image(found) => {
                let mut t = image(found, self.pictures);
                t.insert("tint".into(), color(found.tint));
                Value::Table(t)
            }
            ColorTexture::Vertex(tint) => {
                let mut t = Table::new();
                t.insert("vertex_color".into(), Value::Boolean(true));
                t.insert("tint".into(), color(*tint));
                Value::Table(t)
            }
        };
        self.put(key, value)
    }

    fn color_pair(&mut self, keys: [(Key, Bounds); 2], slot: &mut Option<(Rgb, Rgb)>) -> Result<(), Infallible> {
        let Some((first, second)) = slot else { return Ok(()) };
        self.put(keys[0].0, color(*first))?;
        self.put(keys[1].0, color(*second))
    }

    fn position(&mut self, key: Key, slot: &mut DVec3) -> Result<(), Infallible> {
        self.put(key, doubles(&slot.to_array()))
    }

    fn direction(&mut self, key: Key, slot: &mut Vec3) -> Result<(), Infallible> {
        self.put(key, numbers(&slot.to_array()))
    }

    fn orientation(&mut self, _: Key, matrix: Key, slot: &mut Affine3A) -> Result<(), Infallible> {
        let rows = Mat4::from(*slot).transpose().to_cols_array();
        self.put(matrix, numbers(&rows))
    }

    fn picture(&mut self, key: Key, slot: &mut PathBuf) -> Result<(), Infallible> {
        let name = self.pictures.name(slot);
        self.put(key, Value::String(name))
    }
}
