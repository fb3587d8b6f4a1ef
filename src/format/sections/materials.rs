//! `[material.NAME]`: what every material has. The kinds of scattering are in [`super::scattering`].

use super::scattering::{KINDS, Kind, kinds_with};
use super::textures::{self, scalar};
use crate::document::suggest::{list, nearest};
use crate::document::{At, Entry, Fault, Key, Node, Reader, key};
use crate::scene::description::MaterialDescription;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads `[material]`: new materials, and changes to those that are in `materials` already.
pub(in crate::format) fn materials(
    node: Node,
    base: &Path,
    materials: &mut BTreeMap<String, MaterialDescription>,
) -> Result<(), Fault> {
    for (name, entry) in Reader::new("[material]", node)?.into_entries() {
        let Entry { key, node } = entry;
        let mut t = Reader::new(format!("[material.{name}]"), node)?;
        let read = material(&mut t, materials.get(&name), base)?;
        let (kind, read) = read.ok_or_else(|| without_type(&t, &name, key, materials))?;
        refuse_keys_of_others(&t, kind)?;
        t.finish()?;
        materials.insert(name, read);
    }
    Ok(())
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

/// `type`, which must be there for a material that is new.
pub(in crate::format) fn chosen_type(t: &mut Reader) -> Result<Option<Kind>, Fault> {
    let key = Key { default: Some("required"), ..key("type", "how it scatters: one of the types below") };
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
    t.flag(key("emission_two_sided", "the other side emits too"), &mut m.emission_two_sided)
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

fn without_type(t: &Reader, name: &str, key: At, known: &BTreeMap<String, MaterialDescription>) -> Fault {
    let At::Set(_) = key else { return t.missing("type") };
    let names: Vec<&str> = known.keys().map(String::as_str).collect();
    let hint = match nearest(name, &names) {
        Some(best) => format!("did you mean `{best}`?"),
        None => format!("set `material.{name}.type` too"),
    };
    Fault::new(key, format!("the scene file describes no material `{name}`: {hint}"))
}
