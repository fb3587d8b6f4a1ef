//! The sections of a scene file, whatever kind of document they stand in. They are read *over* what there is, so that the
//! command line's overrides are read by the same code as the file.

pub(super) mod blend;
pub(super) mod camera;
mod fields;
pub(super) mod guiding;
pub(super) mod materials;
pub(super) mod scattering;
pub(super) mod textures;
pub(super) mod world;

use super::SceneFile;
use crate::document::{Fault, Reader, Source};
use camera::section;

/// The sections that overrides can reach.
pub(super) fn read(root: &mut Reader, source: &Source, file: &mut SceneFile) -> Result<(), Fault> {
    section(root, "camera", |t| camera::camera(t, &mut file.scene.camera))?;
    section(root, "film", |t| file.scene.film.read(t))?;
    section(root, "integrator", |t| file.integrator.read(t))?;
    section(root, "guiding", |t| guiding::guiding(t, &mut file.guiding))?;
    section(root, "render", |t| file.render.read(t))?;
    root.take("material").map_or(Ok(()), |n| materials::materials(n, source, &mut file.scene))
}
