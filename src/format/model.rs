//! A model alone: its own materials, an automatic camera, and the defaults of a scene file, but for exposure and tone.

use super::SceneFile;
use crate::Result;
use crate::film::FilmSettings;
use crate::image::{Exposure, Tone};
use crate::scene::description::{MeshDescription, SceneDescription};
use crate::scene::model::MeshSource;
use glam::DAffine3;
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    // Nobody has said how bright its lights are, or looked at a window beside what it lights.
    let film = FilmSettings { exposure: Exposure::Auto, tone: Tone::Agx, ..Default::default() };
    let scene = SceneDescription { film, meshes: vec![whole_file(path)], sky_where_dark: true, ..Default::default() };
    Ok((SceneFile { scene, ..Default::default() }, Vec::new()))
}

/// A mesh as it is in its file.
pub(crate) fn whole_file(path: &Path) -> MeshDescription {
    let source = MeshSource::File(path.to_path_buf());
    MeshDescription {
        source,
        transform: DAffine3::IDENTITY,
        material: None,
        material_location: None,
        group: None,
        location: None,
    }
}
