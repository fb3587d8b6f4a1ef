//! Scenes of pbrt, versions 3 and 4. docs/pbrt.md says what is read.
//!
//! [`world`] goes through the directives and gathers what stands where; once all of the text has been read, which defines textures and
//! materials in any order, the other files make of it what the project has.

mod camera;
mod legacy;
mod light;
mod material;
mod parameters;
mod shape;
mod spectrum;
#[cfg(test)]
mod tests;
mod texture;
mod tokens;
mod world;

use super::SceneFile;
use crate::Result;
use material::Materials;
use std::path::Path;
use texture::Textures;
use world::World;

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    let world = World::read(path)?;
    let mut file = SceneFile::default();
    let exposure = camera::read(&world, &mut file)?;
    let textures = Textures::new(&world);
    Materials::new(&world, &textures).place(&mut file.scene)?;
    for light in &world.lights {
        file.scene.lights.push(light::light(&world, light)?);
    }
    file.scene.instances = world.instances.clone();
    file.scene.pictures = textures.into_embedded();
    light::expose(&mut file.scene, exposure);
    Ok((file, world.warnings.into_list()))
}
