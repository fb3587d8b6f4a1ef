//! Scenes of nori, the renderer of courses, in XML. docs/nori.md says what is read.
//!
//! Courses and their students add to nori what they need, under names of their own: what several of them call alike is read, and what
//! looks like nothing here is a warning or an error.

mod guider;
mod light;
mod material;
mod mesh;
mod sensor;
#[cfg(test)]
mod tests;

use super::SceneFile;
use super::mitsuba::bsdf::Materials;
use super::mitsuba::texture::Textures;
use super::xml::object::Objects;
use crate::Result;

pub(super) fn read(objects: Objects) -> Result<(SceneFile, Vec<String>)> {
    let mut file = SceneFile::default();
    sensor::camera(&objects, &mut file)?;
    sensor::integrator(&objects, &mut file)?;
    guider::read(&objects, &mut file.guiding)?;
    let textures = Textures::new(&objects);
    let materials = Materials { objects: &objects, textures: &textures };
    for (_, mesh) in objects.children(&objects.root, "mesh")? {
        mesh::read(&mesh, &materials, &mut file)?;
    }
    for (_, emitter) in objects.children(&objects.root, "emitter")? {
        file.scene.lights.push(light::light(&objects, &emitter)?);
    }
    // a test says what a picture ought to be
    objects.children(&objects.root, "test")?;
    file.scene.pictures = textures.into_embedded();
    objects.finish(&objects.root);
    Ok((file, objects.into_warnings()))
}
