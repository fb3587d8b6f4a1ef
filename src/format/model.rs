//! A model alone: its own materials, an automatic camera, and the defaults of a scene file.

use super::SceneFile;
use crate::Result;
use crate::scene::description::{MeshDescription, SceneDescription};
use crate::scene::model::MeshSource;
use glam::Affine3A;
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    let scene = SceneDescription { meshes: vec![whole_file(path)], ..Default::default() };
    Ok((SceneFile { scene, ..Default::default() }, Vec::new()))
}

/// A mesh as it is in its file.
pub(crate) fn whole_file(path: &Path) -> MeshDescription {
    let source = MeshSource::File(path.to_path_buf());
    MeshDescription { source, transform: Affine3A::IDENTITY, material: None, group: None, location: None }
}
