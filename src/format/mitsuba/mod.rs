//! Scenes of Mitsuba, in XML: versions 0.4 to 0.6 and 2 to 3. docs/mitsuba.md says what is read.
//!
//! [`super::xml`] makes objects with properties of the text; the files here ask them for what they know. What nobody has asked for is a
//! warning, a plug-in that nothing here looks like is an error.

pub(crate) mod bsdf;
pub(crate) mod emitter;
pub(crate) mod export;
pub(crate) mod metals;
pub(crate) mod sensor;
pub(crate) mod shape;
mod sun;
#[cfg(test)]
mod tests;
pub(crate) mod texture;

use super::SceneFile;
use super::xml::object::Objects;
use crate::Result;
use bsdf::Materials;
use shape::Shapes;
use std::rc::Rc;
use texture::Textures;

pub(super) fn read(objects: Objects) -> Result<(SceneFile, Vec<String>)> {
    let mut file = SceneFile::default();
    sensor::integrator(&objects, &mut file)?;
    sensor::sensors(&objects, &mut file)?;
    let textures = Textures::new(&objects);
    let materials = Materials { objects: &objects, textures: &textures };
    let shining = Shapes::new(&objects, &materials, &mut file).read()?;
    for (_, emitter) in objects.children(&objects.root, "emitter")? {
        if shining.contains(&Rc::as_ptr(&emitter)) {
            continue;
        }
        file.scene.lights.push(emitter::light(&objects, &emitter)?);
    }
    // these are used where something refers to them
    for tag in ["bsdf", "texture", "medium", "film", "sampler", "rfilter"] {
        objects.children(&objects.root, tag)?;
    }
    file.scene.pictures = textures.into_embedded();
    objects.finish(&objects.root);
    Ok((file, objects.into_warnings()))
}
