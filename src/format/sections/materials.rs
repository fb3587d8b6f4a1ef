//! `[material.NAME]`: what every material has. The kinds of scattering are in [`super::scattering`].

use super::blend::{self, NamedPart};
use super::scattering::{KINDS, Kind, kinds_with};
use super::textures::{self, scalar};
use crate::document::suggest::list;
use crate::document::{Entry, Fault, Key, Node, Reader, Source, Value, key};
use crate::scene::description::{MaterialChange, MaterialDescription, SceneDescription};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Reads `[material]`: new materials, and changes to those that are there already or that models will bring.
pub(in crate::format) fn materials(node: Node, source: &Source, scene: &mut SceneDescription) -> Result<(), Fault> {
    let (mut parts, mut places) = (Vec::new(), BTreeMap::new());
    for (name, entry) in Reader::new("[material]", node)?.into_entries() {
        let Entry { key, node } = entry;
        places.insert(name.clone(), key);
        scene.named_materials.push((name.clone(), source.place(key)));
        let current = scene.materials.get(&name);
        let t = Reader::new(label(&name), node.clone())?;
        if current.is_none() && t.left_over().iter().all(|(key, _)| *key != "type") {
            scene.material_changes.push(change(name, node, source));
            continue;
        }
        if let Some(read) = whole(t, current, source.folder(), &mut parts)? {
            scene.material_changes.retain(|change| change.name != name);
            scene.materials.insert(name, read);
        }
    }
    blend::resolve(&mut scene.materials, &parts, &places)
}

fn label(name: &str) -> String {
    format!("[material.{name}]")
}

/// A material whose keys are all read. Into `parts` goes what it is said to be mixed of.
fn whole(
    mut t: Reader,
    current: Option<&MaterialDescription>,
    base: &Path,
    parts: &mut Vec<NamedPart>,
) -> Result<Option<MaterialDescription>, Fault> {
    let chosen = chosen_type(&mut t)?;
    let is_blend = current.is_some_and(|current| current.blend.is_some());
    let (read, name) = match chosen {
        None if is_blend => (blend::material(&mut t, current, base, parts)?, blend::NAME),
        Some(Type::Blend) => (blend::material(&mut t, current, base, parts)?, blend::NAME),
        other => {
            let kind = other.and_then(Type::single);
            let Some((kind, read)) = material(&mut t, kind, current, base)? else { return Ok(None) };
            (read, kind.name())
        }
    };
    refuse_keys_of_others(&t, name)?;
    t.finish()?;
    Ok(Some(read))
}

/// A change to what a model's own library says of a material.
fn change(name: String, node: Node, source: &Source) -> MaterialChange {
    let (label, owned) = (label(&name), source.to_owned());
    let apply = move |current: &MaterialDescription| {
        let (node, source) = (with_base_color(node.clone(), current.bsdf.bsdf_type()), owned.borrow());
        let read = Reader::new(&*label, node).and_then(|t| whole(t, Some(current), source.folder(), &mut Vec::new()));
        read.map(|changed| changed.unwrap_or_else(|| current.clone())).map_err(|fault| source.error(fault))
    };
    MaterialChange { name, apply: Arc::new(apply) }
}

/// Nobody who changes the colour of a library's material knows of which type it is understood to be: `reflectance` is the colour
/// of metals, too.
fn with_base_color(mut node: Node, kind: Kind) -> Node {
    let base_color = match kind {
        Kind::Principled => "base_color",
        Kind::Conductor | Kind::Mirror => "specular_reflectance",
        _ => return node,
    };
    if let Value::Table(entries) = &mut node.value
        && !entries.contains_key(base_color)
        && let Some(entry) = entries.remove("reflectance")
    {
        entries.insert(base_color.to_string(), entry);
    }
    node
}

/// A material's keys, up to `finish`. `None`: there is neither a `chosen` type nor a `current` material to change.
/// A type that is given starts from that type's defaults.
pub(in crate::format) fn material(
    t: &mut Reader,
    chosen: Option<Kind>,
    current: Option<&MaterialDescription>,
    base: &Path,
) -> Result<Option<(Kind, MaterialDescription)>, Fault> {
    let Some(kind) = chosen.or(current.map(|m| m.bsdf.bsdf_type())) else { return Ok(None) };
    let mut m = current.cloned().unwrap_or_default();
    if chosen.is_some() {
        (m.bsdf, m.blend) = (kind.bsdf(), None);
    }
    kind.read(t, &mut m.bsdf, base)?;
    common(t, kind, &mut m, base)?;
    Ok(Some((kind, m)))
}

/// What a material may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::format) enum Type {
    Single(Kind),
    /// Two others, mixed.
    Blend,
}

impl Type {
    fn single(self) -> Option<Kind> {
        match self {
            Type::Single(kind) => Some(kind),
            Type::Blend => None,
        }
    }
}

/// `type`, which must be there for a material that no model brings.
pub(in crate::format) fn chosen_type(t: &mut Reader) -> Result<Option<Type>, Fault> {
    let singles = KINDS.iter().map(|(name, kind)| (*name, Type::Single(*kind)));
    let types: Vec<(&str, Type)> = singles.chain([(blend::NAME, Type::Blend)]).collect();
    t.chosen(TYPE, &types)
}

/// The key of a material's type.
pub(in crate::format) const TYPE: Key = Key {
    default: Some("none"),
    ..key(
        "type",
        "how it scatters: one of the types below; without it, the keys change what the model's own library says",
    )
};

pub(super) const OPACITY: Key = key(
    "opacity",
    "share of light that is stopped, the rest goes straight on; of the emission, the same share is seen",
);

/// The keys that every type has, or nearly so.
pub(in crate::format) fn common(
    t: &mut Reader,
    kind: Kind,
    m: &mut MaterialDescription,
    base: &Path,
) -> Result<(), Fault> {
    if kind.is_opaque() {
        let meaning = "of opaque types: scatters alike on both sides; else its back is black";
        t.flag(key("two_sided", meaning), &mut m.two_sided)?;
    }
    if kind.is_surface() {
        scalar(t, OPACITY, base, &mut m.opacity)?;
    }
    if kind.is_surface() {
        textures::relief(t, base, &mut m.relief)?;
    }
    emission(t, m, base)
}

/// What every material may emit.
pub(super) fn emission(t: &mut Reader, m: &mut MaterialDescription, base: &Path) -> Result<(), Fault> {
    let emission = key("emission", "radiance that leaves the side from which the face winds counter-clockwise");
    textures::emission(t, emission.unit("W/(sr·m²)"), base, m)?;
    t.flag(key("emission_two_sided", "the other side emits too"), &mut m.emission_two_sided)?;
    light_group(t, &mut m.light_group)
}

/// `light_group`, of materials and lights.
pub(super) fn light_group(t: &mut Reader, slot: &mut Option<String>) -> Result<(), Fault> {
    let meaning = "the group that its light is in, which `render.layers` may keep apart; without one, `default`";
    let named = t.string(key("light_group", meaning).optional())?;
    *slot = named.or(slot.take());
    Ok(())
}

/// A key of another type is known, so it deserves a better word than "unknown".
fn refuse_keys_of_others(t: &Reader, kind: &str) -> Result<(), Fault> {
    for (key, entry) in t.left_over() {
        let mut owners = kinds_with(key);
        owners.extend(blend::KEYS.contains(&key).then_some(blend::NAME));
        if !owners.is_empty() {
            let owners = list(&owners);
            let message = format!("`{key}` is not a key of type `{kind}`, but of {owners}");
            return Err(Fault::new(entry.key, message));
        }
    }
    Ok(())
}
