//! Scene files in TOML, as docs/scene-file.md describes them.

use super::SceneFile;
use super::sections::camera::camera;
use super::sections::{self, world};
use crate::Result;
use crate::document::{At, Entry, Fault, Node, Reader, Source, from_toml, read_text};
use crate::scene::description::{
    CameraDescription, InstanceDescription, MeshDescription, NamedCamera, SceneDescription,
};
use std::collections::BTreeSet;
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    parse(&read_text(path)?, path)
}

/// Parses a scene file's text. `path` names it in errors, and paths in it are relative to its folder.
pub(super) fn parse(text: &str, path: &Path) -> Result<(SceneFile, Vec<String>)> {
    let source = Source { path, text, overrides: &[] };
    let mut file = SceneFile::default();
    from_toml(text, &At::Text).and_then(|root| whole(root, &source, &mut file)).map_err(|fault| source.error(fault))?;
    let nothing = "the scene has no [[mesh]]: only its background will be seen";
    let empty = file.scene.meshes.is_empty().then(|| nothing.to_string());
    let warnings = empty.into_iter().chain(groups_without_instance(&file.scene)).collect();
    Ok((file, warnings))
}

fn groups_without_instance(scene: &SceneDescription) -> Vec<String> {
    let seen: BTreeSet<&str> = scene.instances.iter().map(|instance| instance.group.as_str()).collect();
    let groups: BTreeSet<&str> = scene.meshes.iter().filter_map(|mesh| mesh.group.as_deref()).collect();
    let warning = |group| format!("the group `{group}` has no [[instance]] and will not be seen");
    groups.difference(&seen).map(warning).collect::<Vec<_>>()
}

/// `[cameras.NAME]`, in the order of the file.
fn cameras(node: Node) -> Result<Vec<NamedCamera>, Fault> {
    let mut entries: Vec<(String, Entry)> = Reader::new("[cameras]", node)?.into_entries().into_iter().collect();
    entries.sort_by_key(|(_, entry)| entry.key);
    let read = |(name, entry): (String, Entry)| {
        let mut t = Reader::new(format!("[cameras.{name}]"), entry.node)?;
        let mut said = None;
        camera(&mut t, &mut said)?;
        t.finish()?;
        Ok(NamedCamera { name, camera: said.unwrap_or_else(CameraDescription::open), size: [None; 2] })
    };
    entries.into_iter().map(read).collect()
}

/// A whole file's tree.
fn whole(root: Node, source: &Source, file: &mut SceneFile) -> Result<(), Fault> {
    let base = source.folder();
    let mut root = Reader::new("the scene file", root)?;
    sections::read(&mut root, source, file)?;
    let scene = &mut file.scene;
    if let Some(node) = root.take("cameras") {
        scene.cameras = cameras(node)?;
    }
    for node in root.take("mesh").map_or(Ok(vec![]), |n| n.tables("mesh"))? {
        let mut t = Reader::new("[[mesh]]", node)?;
        let mesh = world::mesh(&mut t, base)?;
        let [location, material_location] =
            [world::transform_at(&t), world::material_at(&t)].map(|at| source.location(at));
        scene.meshes.push(MeshDescription { location, material_location, ..mesh });
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
        world::light(&mut t, base, scene)?;
        t.finish()?;
    }
    root.finish()
}
