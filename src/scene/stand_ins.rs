//! What stands in for pictures that cannot be read.

use super::assets::LoadedAssets;
use super::description::MaterialDescription;
use crate::fields::{each_share, each_texture};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ScalarTexture, TextureCache};
use crate::{Error, Result};
use rustc_hash::FxHashMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

impl LoadedAssets {
    /// Reads the pictures of materials that libraries describe. Libraries travel without their pictures and name any format: a material
    /// goes on in half of its own colour, opaque and without glowing, and says so. A picture that a scene file names must be there and usable, which is
    /// seen when the material is made.
    ///
    /// # Errors
    /// The first picture that cannot be read, where `strict`.
    pub(crate) fn stand_in_for_pictures(&mut self, cache: &mut TextureCache, strict: bool) -> Result<()> {
        let mut reading = Reading { cache, failures: FxHashMap::default(), found: Vec::new() };
        for ((material, name), _) in
            self.materials.iter_mut().zip(&self.names).zip(&self.of_library).filter(|(_, own)| **own)
        {
            reading.material(name, material);
        }
        match reading.found.first() {
            Some((path, message)) if strict => Err(Error::file(path, message)),
            _ => {
                let warnings = reading.found.into_iter().map(|(path, message)| Error::file(path, message).to_string());
                self.warnings.extend(warnings);
                Ok(())
            }
        }
    }
}

/// Pictures while they are read.
struct Reading<'a> {
    cache: &'a mut TextureCache,
    /// Of files that have been tried, what is wrong with them.
    failures: FxHashMap<PathBuf, String>,
    found: Vec<(PathBuf, String)>,
}

impl Reading<'_> {
    fn material(&mut self, name: &str, material: &mut MaterialDescription) {
        each_texture(&mut material.bsdf, |color| {
            if let ColorTexture::Image(image) = color
                && self.fails(&image.path, name)
            {
                *color = ColorTexture::Constant(image.tint * 0.5);
            }
        });
        each_share(&mut material.bsdf, |_, map| {
            if self.scalar_fails(map.as_ref(), name) {
                *map = None;
            }
        });
        if self.scalar_fails(material.opacity.as_ref(), name) {
            material.opacity = None;
        }
        if let Some(relief) = &material.relief
            && self.fails(&relief.image.path, name)
        {
            material.relief = None;
        }
        // nothing tells where it glows
        if let Some(image) = &material.emission_map
            && self.fails(&image.path, name)
        {
            (material.emission, material.emission_map) = (Rgb::ZERO, None);
        }
    }

    fn scalar_fails(&mut self, texture: Option<&ScalarTexture>, name: &str) -> bool {
        texture.and_then(ScalarTexture::image).is_some_and(|image| self.fails(&image.path, name))
    }

    /// Whether the picture of the material `name` cannot be used; that is noted.
    fn fails(&mut self, path: &Path, name: &str) -> bool {
        if !self.failures.contains_key(path) {
            let Err(error) = self.cache.get(path) else { return false };
            self.failures.insert(path.to_path_buf(), reason(&error));
        }
        let reason = &self.failures[path];
        self.found.push((path.to_path_buf(), format!("the picture of material `{name}` {reason}")));
        true
    }
}

/// What goes on from "the picture".
fn reason(error: &Error) -> String {
    match error {
        Error::Io { error, .. } if error.kind() == ErrorKind::NotFound => "is missing".into(),
        Error::Io { error, .. } => format!("cannot be read: {error}"),
        Error::File { message, .. } => format!("cannot be used: {message}"),
        other => format!("cannot be used: {other}"),
    }
}
