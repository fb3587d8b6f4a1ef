//! `type = "blend"`: a surface of two materials that stand in the same file.

use super::materials::{OPACITY, emission};
use super::textures::{scalar, share};
use crate::document::suggest::unknown;
use crate::document::{At, Fault, Key, Reader, Value, key};
use crate::math::Rgb;
use crate::scene::description::{BlendDescription, BlendPart, MaterialDescription};
use crate::texture::ScalarTexture;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// The type's name.
pub(in crate::format) const NAME: &str = "blend";

/// Blends may be within each other so deep.
const DEEPEST: usize = 8;

const MATERIALS: Key =
    key("materials", "the names of two materials of this file that the surface is mixed of; what they emit must be 0");
const WEIGHT: Key =
    key("weight", "the share w of the second: f = (1 − w) f₁ + w f₂; both have their own sides, normals and opacity");

/// The keys that no other type has.
pub(super) const KEYS: [&str; 2] = [MATERIALS.name, WEIGHT.name];

type Materials = BTreeMap<String, MaterialDescription>;

/// A material that a blend is said to be mixed of, and where.
pub(in crate::format) struct NamedPart {
    name: String,
    at: At,
}

/// A blend, over what the material was. Its parts are only named: [`resolve`] finds them.
pub(super) fn material(
    t: &mut Reader,
    current: Option<&MaterialDescription>,
    base: &Path,
    named: &mut Vec<NamedPart>,
) -> Result<MaterialDescription, Fault> {
    let current = current.cloned().unwrap_or_default();
    let mut m = MaterialDescription {
        opacity: current.opacity,
        emission: current.emission,
        emission_map: current.emission_map,
        emission_two_sided: current.emission_two_sided,
        light_group: current.light_group,
        ..MaterialDescription::default()
    };
    m.blend = Some(own_keys(t, current.blend, base, named)?);
    scalar(t, OPACITY, base, &mut m.opacity)?;
    emission(t, &mut m, base)?;
    Ok(m)
}

/// The keys that no other type has. A table without `materials` is refused where it ends.
pub(in crate::format) fn own_keys(
    t: &mut Reader,
    current: Option<BlendDescription>,
    base: &Path,
    named: &mut Vec<NamedPart>,
) -> Result<BlendDescription, Fault> {
    let written = if current.is_some() { MATERIALS.optional() } else { MATERIALS.required() };
    let nothing = || BlendDescription { weight: ScalarTexture::Constant(0.5), parts: Arc::new(["", ""].map(part)) };
    let mut blend = current.unwrap_or_else(nothing);
    if let Some(node) = t.ask(written, "two strings", "", "")? {
        let wrong = || node.mismatch(MATERIALS.name, "the names of two materials");
        let Value::Array(items) = &node.value else { return Err(wrong()) };
        let [first, second] = &items[..] else { return Err(wrong()) };
        for item in [first, second] {
            named.push(NamedPart { name: item.string(MATERIALS.name)?.into(), at: item.at });
        }
        blend.parts = Arc::new([part(first.string(MATERIALS.name)?), part(second.string(MATERIALS.name)?)]);
    }
    let (mut number, mut map) = match blend.weight {
        ScalarTexture::Constant(number) => (number, None),
        picture => (0.5, Some(picture)),
    };
    share(t, WEIGHT, base, &mut number, &mut map)?;
    blend.weight = map.unwrap_or(ScalarTexture::Constant(number));
    Ok(blend)
}

fn part(name: &str) -> BlendPart {
    BlendPart { name: Some(name.to_string()), material: MaterialDescription::default() }
}

/// Puts into all blends what the materials are that they name. `named` are those that the document at hand names, `places` where it
/// describes materials.
///
/// # Errors
/// Names of no material, or of one that emits; blends within themselves.
pub(super) fn resolve(
    materials: &mut Materials,
    named: &[NamedPart],
    places: &BTreeMap<String, At>,
) -> Result<(), Fault> {
    for NamedPart { name, at } in named {
        let subject = format!("there is no material `{name}` with a `type` in this file");
        let known = materials.keys().map(String::as_str);
        materials.get(name).map(drop).ok_or_else(|| Fault::new(*at, unknown(&subject, name, known)))?;
    }
    let place = |name: &str| {
        let said = named.iter().find(|part| part.name == name).map(|part| part.at);
        said.or(places.get(name).copied()).unwrap_or(At::Text(0))
    };
    let blends: Vec<String> =
        materials.iter().filter(|(_, material)| material.blend.is_some()).map(|(name, _)| name.clone()).collect();
    for name in blends {
        let whole = with_parts(&materials[&name], materials, &place, 0)?;
        materials.insert(name, whole);
    }
    Ok(())
}

/// The material with the parts that it names.
fn with_parts(
    material: &MaterialDescription,
    materials: &Materials,
    place: &dyn Fn(&str) -> At,
    depth: usize,
) -> Result<MaterialDescription, Fault> {
    let mut whole = material.clone();
    for part in whole.blend.iter_mut().flat_map(|blend| Arc::make_mut(&mut blend.parts)) {
        let Some(name) = &part.name else { continue };
        let named = materials.get(name).unwrap_or(&part.material);
        if depth == DEEPEST && named.blend.is_some() {
            let message = format!("`{name}` is a blend within itself, or more than {DEEPEST} are within each other");
            return Err(Fault::new(place(name), message));
        }
        if named.emission != Rgb::ZERO {
            let message =
                format!("`{name}` is mixed with another material and emits: `emission` is a key of the blend");
            return Err(Fault::new(place(name), message));
        }
        part.material = with_parts(named, materials, place, depth + 1)?;
    }
    Ok(whole)
}
