//! `[material.NAME]`: what every material has. The kinds of scattering are in [`super::scattering`].

use super::scattering::{KINDS, Kind, kinds_with};
use super::textures::{self, scalar};
use crate::document::suggest::list;
use crate::document::{Entry, Fault, Key, Node, Reader, Source, Value, key};
use crate::scene::description::{MaterialChange, MaterialDescription, SceneDescription};
use std::path::Path;
use std::sync::Arc;

/// Reads `[material]`: new materials, and changes to those that are there already or that models will bring.
pub(in crate::format) fn materials(node: Node, source: &Source, scene: &mut SceneDescription) -> Result<(), Fault> {
    for (name, entry) in Reader::new("[material]", node)?.into_entries() {
        let Entry { key, node } = entry;
        scene.named_materials.push((name.clone(), source.place(key)));
        let current = scene.materials.get(&name);
        let t = Reader::new(label(&name), node.clone())?;
        if current.is_none() && t.left_over().iter().all(|(key, _)| *key != "type") {
            scene.material_changes.push(change(name, node, source));
            continue;
        }
        if let Some(read) = whole(t, current, source.folder())? {
            scene.material_changes.retain(|change| change.name != name);
            scene.materials.insert(name, read);
        }
    }
    Ok(())
}

fn label(name: &str) -> String {
    format!("[material.{name}]")
}

/// A material whose keys are all read.
fn whole(
    mut t: Reader,
    current: Option<&MaterialDescription>,
    base: &Path,
) -> Result<Option<MaterialDescription>, Fault> {
    let Some((kind, read)) = material(&mut t, current, base)? else { return Ok(None) };
    refuse_keys_of_others(&t, kind)?;
    t.finish()?;
    Ok(Some(read))
}

/// A change to what a model's own library says of a material.
fn change(name: String, node: Node, source: &Source) -> MaterialChange {
    let (label, owned) = (label(&name), source.to_owned());
    let apply = move |current: &MaterialDescription| {
        let (node, source) = (with_base_color(node.clone(), current.bsdf.bsdf_type()), owned.borrow());
        let read = Reader::new(&*label, node).and_then(|t| whole(t, Some(current), source.folder()));
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

/// A material's keys, up to `finish`. `None`: there is neither a `type` nor a `current` material to change.
/// A `type` that is given starts from that type's defaults.
pub(in crate::format) fn material(
    t: &mut Reader,
    current: Option<&MaterialDescription>,
    base: &Path,
) -> Result<Option<(Kind, MaterialDescription)>, Fault> {
    let chosen = chosen_type(t)?;
    let Some(kind) = chosen.or(current.map(|m| m.bsdf.bsdf_type())) else { return Ok(None) };
    let mut m = current.cloned().unwrap_or_default();
    if chosen.is_some() {
        m.bsdf = kind.bsdf();
    }
    kind.read(t, &mut m.bsdf, base)?;
    common(t, kind, &mut m, base)?;
    Ok(Some((kind, m)))
}

/// `type`, which must be there for a material that no model brings.
pub(in crate::format) fn chosen_type(t: &mut Reader) -> Result<Option<Kind>, Fault> {
    let meaning =
        "how it scatters: one of the types below; without it, the keys change what the model's own library says";
    let key = Key { default: Some("none"), ..key("type", meaning) };
    t.chosen(key, KINDS)
}

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
        let meaning =
            "share of light that is stopped, the rest goes straight on; of the emission, the same share is seen";
        scalar(t, key("opacity", meaning), base, &mut m.opacity)?;
    }
    if kind.is_surface() {
        textures::relief(t, base, &mut m.relief)?;
    }
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
fn refuse_keys_of_others(t: &Reader, kind: Kind) -> Result<(), Fault> {
    for (key, entry) in t.left_over() {
        let owners = kinds_with(key);
        if !owners.is_empty() {
            let (kind, owners) = (kind.name(), list(&owners));
            let message = format!("`{key}` is not a key of type `{kind}`, but of {owners}");
            return Err(Fault::new(entry.key, message));
        }
    }
    Ok(())
}
