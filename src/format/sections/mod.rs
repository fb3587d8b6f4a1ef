//! The sections of a scene file, whatever kind of document they stand in. They are read *over* what there is, so that the
//! command line's overrides are read by the same code as the file.

mod fields;
pub(super) mod materials;
pub(super) mod scattering;
pub(super) mod settings;
pub(super) mod textures;
pub(super) mod world;

use super::SceneFile;
use crate::document::{Fault, Reader};
use settings::section;
use std::path::Path;

/// The sections that overrides can reach.
pub(super) fn read(root: &mut Reader, base: &Path, file: &mut SceneFile) -> Result<(), Fault> {
    section(root, "camera", |t| settings::camera(t, &mut file.scene.camera))?;
    section(root, "film", |t| settings::film(t, &mut file.scene.film))?;
    section(root, "integrator", |t| settings::integrator(t, &mut file.integrator))?;
    section(root, "guiding", |t| settings::guiding(t, &mut file.guiding))?;
    section(root, "render", |t| settings::render(t, &mut file.render))?;
    root.take("material").map_or(Ok(()), |n| materials::materials(n, base, &mut file.scene.materials))
}
