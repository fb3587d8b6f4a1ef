//! The stability gallery: small scenes in which guides are known to fail, or have nothing to gain. What each is for is told
//! in scenes/gallery/gallery.toml, the comparison that renders them all; several of its rows share a scene.

mod corners;
mod furnace;
mod keyhole;
mod lights;
mod plain;
mod plastic;
mod rooms;
mod shiny;
mod slivers;

#[cfg(test)]
mod tests;

use super::SceneFiles;
use super::obj_writer::{Material, Model, number, toml_vector};
use crate::{Error, Result};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The comparison of all of them.
const PLAN: &str = include_str!("../../../../scenes/gallery/gallery.toml");

/// What the plan's file is called.
const PLAN_NAME: &str = "gallery.toml";

type Maker = (&'static str, fn() -> SceneFiles);

/// By name. Some have no geometry of their own and use that of another.
const MAKERS: [Maker; 15] = [
    ("bumps", corners::bumps),
    ("corners", corners::corners),
    ("direct", plain::direct),
    ("far-away", corners::far_away),
    ("keyhole", keyhole::keyhole),
    ("keyhole-plugged", keyhole::plugged),
    ("many-lights", lights::many_lights),
    ("oven", furnace::oven),
    ("oven-known", furnace::known),
    ("plastic-door", plastic::plastic_door),
    ("shiny", shiny::shiny),
    ("slivers", slivers::slivers),
    ("triangle", plain::triangle),
    ("turned-door", rooms::turned_door),
    ("two-rooms", rooms::two_rooms),
];

/// Names of all scenes.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    MAKERS.iter().map(|maker| maker.0)
}

pub(super) fn make(name: &str) -> Option<SceneFiles> {
    MAKERS.iter().find(|maker| maker.0 == name).map(|maker| maker.1())
}

/// Writes all scenes of the gallery and its comparison into `dir`, which is made if it is missing; files of these names
/// are replaced. Returns the paths written, the comparison's first.
///
/// # Errors
/// [`Error::Io`] where a file cannot be written.
pub(crate) fn generate(dir: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
    let plan = dir.join(PLAN_NAME);
    super::replace_file(&plan, PLAN)?;
    let mut paths = vec![plan];
    for (name, maker) in MAKERS {
        paths.extend(super::write_scene(name, &maker(), dir)?);
    }
    Ok(paths)
}

/// From where a picture is taken.
struct View {
    eye: DVec3,
    target: DVec3,
    vfov: f64,
    /// Stops.
    exposure: f64,
}

/// The beginning of a scene file: what it is for, camera and film. All pictures are of 64 × 48 pixels.
fn head(about: &str, view: &View) -> String {
    let comment: String = about.lines().map(|line| format!("# {line}\n")).collect();
    let (eye, target) = (toml_vector(view.eye), toml_vector(view.target));
    let (vfov, exposure) = (number(view.vfov), number(view.exposure));
    format!(
        "{comment}[camera]\norigin = {eye}\ntarget = {target}\nvfov = {vfov}\n\n\
         [film]\nwidth = 64\nheight = 48\nexposure = {exposure}\n\n[integrator]\nmax_depth = 12\n"
    )
}

/// A `[[mesh]]` without a change of place.
fn mesh(name: &str) -> String {
    format!("\n[[mesh]]\npath = \"{name}.obj\"\n")
}

/// A material that glows and reflects nothing.
fn lamp(name: &'static str, emission: [f64; 3]) -> Material {
    Material { emission, ..Material::diffuse(name, [0.0; 3]) }
}

/// A scene with a mesh of its own.
fn with_mesh(name: &str, about: &str, view: &View, model: Model) -> SceneFiles {
    SceneFiles { toml: head(about, view) + &mesh(name), model }
}
