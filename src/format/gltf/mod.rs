//! Scenes in glTF 2.0, as text or binary. docs/gltf.md says what is read.

mod buffers;
mod materials;
mod mesh;
mod nodes;
#[cfg(test)]
mod tests;

use super::SceneFile;
use crate::film::FilmSettings;
use crate::image::{Exposure, Tone};
use crate::io::contain::contain;
use crate::io::memory;
use crate::scene::description::SceneDescription;
use crate::{Error, Result};
use buffers::Buffers;
use gltf::{Document, Gltf};
use materials::Materials;
use nodes::Nodes;
use std::path::Path;

/// Extensions whose meaning is known here, as far as it goes.
const EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_texture_transform",
];

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    // the crate may panic where accessors contradict themselves in a way that is not seen before
    contain(path, || read_contained(path))
}

fn read_contained(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    let bytes = memory::read_file(path, u64::MAX)?;
    let Gltf { document, blob } =
        Gltf::from_slice(&bytes).map_err(|error| Error::file(path, format!("no glTF 2.0: {error}")))?;
    drop(bytes);
    let mut warnings = Warnings { path, found: Vec::new() };
    extensions(&document, &mut warnings);
    let buffers = Buffers::read(&document, blob, path)?;
    let materials = Materials::read(&document, &buffers, &mut warnings)?;
    let mut nodes = Nodes { document: &document, buffers: &buffers, materials: &materials, warnings, scene: scene() };
    nodes.read()?;
    let Nodes { mut scene, warnings, .. } = nodes;
    (scene.materials, scene.pictures) = materials.into_used(&scene);
    Ok((SceneFile { scene, ..SceneFile::default() }, warnings.found))
}

/// Nobody has said how bright its lights are for a picture.
fn scene() -> SceneDescription {
    let film = FilmSettings { exposure: Exposure::Auto, tone: Tone::Agx, ..FilmSettings::default() };
    SceneDescription { film, sky_where_dark: true, ..SceneDescription::default() }
}

/// What a user should know, each once.
struct Warnings<'a> {
    path: &'a Path,
    found: Vec<String>,
}

impl Warnings<'_> {
    fn add(&mut self, message: impl std::fmt::Display) {
        let warning = format!("{}: {message}", self.path.display());
        if !self.found.contains(&warning) {
            self.found.push(warning);
        }
    }
}

/// Warns of what is not known; an extension that the file cannot be read without was refused with it.
fn extensions(document: &Document, warnings: &mut Warnings) {
    for name in document.extensions_used().filter(|name| !EXTENSIONS.contains(name)) {
        warnings.add(format!("the extension `{name}` is not known here and means nothing"));
    }
    if document.animations().len() + document.skins().len() > 0 {
        warnings.add("animations and skins mean nothing here: meshes are as they are in rest");
    }
}
