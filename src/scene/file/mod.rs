//! Scene files: TOML (described in docs/scene-file.md), `scene.json` ([`super::interchange`]), or an OBJ alone.
//!
//! Text becomes a tree of values with their places (`tree`); a `Reader` takes keys from its tables
//! and refuses what is wrong at its place. Sections are read *over* a description, so that the command line's
//! overrides are read by the same code as the file, whatever kind of file it is.

pub(super) mod json_tree;
pub(super) mod materials;
mod overrides;
pub(crate) mod reader;
pub(super) mod scattering;
pub(super) mod settings;
pub(crate) mod suggest;
mod textures;
pub(crate) mod tree;
pub(super) mod world;

#[cfg(test)]
mod faults;
#[cfg(test)]
mod reference_page;
#[cfg(test)]
mod tests;

use super::description::{
    DirectionTable, GuidingMethod, InstanceDescription, MeshDescription, Order, Roulette, SceneDescription,
    SourceLocation, Updates,
};
use super::interchange;
use crate::{Error, Result};
use glam::Affine3A;
use reader::Reader;
use settings::section;
use std::collections::BTreeSet;
use std::path::Path;
use tree::{At, Fault, Node};

/// Reads a scene: `.toml`, `.json` (interchange) or `.obj` (that mesh and defaults). `overrides` are `key=value`
/// as of `--set`, over what the file says. Also returns warnings.
///
/// # Errors
/// [`Error::Parse`] with line and column for faults in the file, [`Error::Override`] for faults in
/// those, [`Error::Io`] and [`Error::File`] for a file that cannot be read or is of another kind.
pub fn load(path: &Path, overrides: &[String]) -> Result<(SceneDescription, Vec<String>)> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("toml") => parse(&read_text(path)?, path, overrides),
        Some("json") => {
            let (mut scene, warnings) = interchange::parse(&read_text(path)?, path)?;
            apply_overrides(&mut scene, path, overrides)?;
            Ok((scene, warnings))
        }
        Some("obj") => {
            let mut scene = SceneDescription { meshes: vec![whole_file(path)], ..Default::default() };
            apply_overrides(&mut scene, path, overrides)?;
            Ok((scene, Vec::new()))
        }
        _ => Err(Error::file(path, "not a scene: its name must end in .toml, .json or .obj")),
    }
}

/// Parses a TOML scene file's text. `path` names it in errors, and paths in it are relative to its folder.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, path: &Path, overrides: &[String]) -> Result<(SceneDescription, Vec<String>)> {
    let source = Source { path, text, overrides: &[] };
    let mut scene = SceneDescription::default();
    tree::from_toml(text, &At::Text)
        .and_then(|root| whole(root, &source, &mut scene))
        .map_err(|fault| source.error(fault))?;
    apply_overrides(&mut scene, path, overrides)?;
    let nothing = "the scene has no [[mesh]]: only its background will be seen";
    let empty = scene.meshes.is_empty().then(|| nothing.to_string());
    let warnings = empty.into_iter().chain(groups_without_instance(&scene)).collect();
    Ok((scene, warnings))
}

fn groups_without_instance(scene: &SceneDescription) -> Vec<String> {
    let seen: BTreeSet<&str> = scene.instances.iter().map(|instance| instance.group.as_str()).collect();
    let groups: BTreeSet<&str> = scene.meshes.iter().filter_map(|mesh| mesh.group.as_deref()).collect();
    let warning = |group| format!("the group `{group}` has no [[instance]] and will not be seen");
    groups.difference(&seen).map(warning).collect::<Vec<_>>()
}

/// A mesh as it is in its file.
pub(crate) fn whole_file(path: &Path) -> MeshDescription {
    let path = path.to_path_buf();
    MeshDescription { path, transform: Affine3A::IDENTITY, material: None, group: None, location: None }
}

/// A whole file's tree.
fn whole(root: Node, source: &Source, scene: &mut SceneDescription) -> Result<(), Fault> {
    let base = source.folder();
    let mut root = Reader::new("the scene file", root)?;
    sections(&mut root, base, scene)?;
    for node in root.take("mesh").map_or(Ok(vec![]), |n| n.tables("mesh"))? {
        let mut t = Reader::new("[[mesh]]", node)?;
        let mesh = world::mesh(&mut t, base)?;
        scene.meshes.push(MeshDescription { location: source.location(world::transform_at(&t)), ..mesh });
        t.finish()?;
    }
    for node in root.take("instance").map_or(Ok(vec![]), |n| n.tables("instance"))? {
        let mut t = Reader::new("[[instance]]", node)?;
        let instance = world::instance(&mut t, &scene.meshes)?;
        let location = source.location(world::transform_at(&t));
        scene.instances.push(InstanceDescription { location, ..instance });
        t.finish()?;
    }
    for node in root.take("light").map_or(Ok(vec![]), |n| n.tables("light"))? {
        let mut t = Reader::new("[[light]]", node)?;
        scene.lights.push(world::light(&mut t, base)?);
        t.finish()?;
    }
    root.finish()
}

/// The sections that overrides can reach.
fn sections(root: &mut Reader, base: &Path, scene: &mut SceneDescription) -> Result<(), Fault> {
    section(root, "camera", |t| settings::camera(t, &mut scene.camera))?;
    section(root, "film", |t| settings::film(t, &mut scene.film))?;
    section(root, "integrator", |t| settings::integrator(t, &mut scene.integrator))?;
    section(root, "guiding", |t| settings::guiding(t, &mut scene.guiding))?;
    section(root, "render", |t| settings::render(t, &mut scene.render))?;
    root.take("material").map_or(Ok(()), |n| materials::materials(n, base, &mut scene.materials))
}

fn apply_overrides(scene: &mut SceneDescription, path: &Path, overrides: &[String]) -> Result<()> {
    let source = Source { path, text: "", overrides };
    let apply = |root: Node| {
        let mut root = Reader::new("--set", root)?;
        sections(&mut root, source.folder(), scene)?;
        root.finish()
    };
    overrides::tree(overrides).and_then(apply).map_err(|fault| source.error(fault))?;
    check_order(scene, path)
}

/// That settings of several sections go together, once all of them have been read.
fn check_order(scene: &SceneDescription, path: &Path) -> Result<()> {
    if scene.render.order != Order::Blocks {
        return Ok(());
    }
    let (guiding, guided) = (&scene.guiding, scene.guiding.method != GuidingMethod::None);
    let refined = guiding.method != GuidingMethod::Grid || guiding.table == DirectionTable::Tree;
    let wants = [
        (
            scene.render.time.is_some(),
            "a number of samples and no time: a block has all of its samples before the next",
        ),
        (guided && guiding.updates == Updates::Frozen, "guiding.updates = \"online\": it is one iteration"),
        (
            guided && refined,
            "guiding.method = \"grid\" with a table of strata: other states and trees are made between iterations",
        ),
        (
            guided && scene.integrator.roulette == Roulette::Guided,
            "another integrator.roulette than \"guided\", which goes by the picture of an earlier iteration",
        ),
    ];
    match wants.into_iter().find(|(wanted, _)| *wanted) {
        Some((_, what)) => Err(Error::file(path, format!("render.order = \"blocks\" needs {what}"))),
        None => Ok(()),
    }
}

/// A file's text, without the mark that some editors put before UTF-8.
fn read_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let (line, column) = line_and_column(e.as_bytes(), e.utf8_error().valid_up_to());
        Error::parse(path, line, column, "this byte is not UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// What faults' places refer to.
pub(crate) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub overrides: &'a [String],
}

impl Source<'_> {
    /// What paths in the file are relative to.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// The place in the file; `None` for what `--set` says.
    pub fn location(&self, at: At) -> Option<SourceLocation> {
        let At::Text(offset) = at else { return None };
        let (line, column) = line_and_column(self.text.as_bytes(), offset);
        Some(SourceLocation { path: self.path.to_path_buf(), line, column })
    }

    pub fn error(&self, fault: Fault) -> Error {
        match fault.at {
            At::Text(offset) => {
                let (line, column) = line_and_column(self.text.as_bytes(), offset);
                Error::parse(self.path, line, column, fault.message)
            }
            At::Set(index) => {
                let text = self.overrides.get(index).map_or("", String::as_str);
                Error::Override { index, text: text.to_string(), message: fault.message }
            }
        }
    }
}

/// Both from 1; columns count characters.
pub(crate) fn line_and_column(text: &[u8], offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let line = before.iter().filter(|b| **b == b'\n').count() + 1;
    // Bytes that continue a UTF-8 character are no columns of their own.
    let column = before[line_start..].iter().filter(|b| **b & 0xC0 != 0x80).count() + 1;
    (line, column)
}
