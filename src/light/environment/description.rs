//! Surroundings as they are described: a file, and how it is turned.

use super::Environment;
use crate::document::{NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::image::picture::{self, Picture, Samples};
use crate::io::{canon, memory};
use crate::light::octahedral;
use crate::light::source::{Findings, LightParameters};
use crate::math::Rgb;
use crate::{Error, Result};
use glam::Affine3A;
use std::path::PathBuf;

/// A picture of everything infinitely far away, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// In the mapping of [`Environment`].
    pub path: PathBuf,
    /// Multiplies the picture.
    pub scale: Rgb,
    /// From the picture's frame; a rotation, with or without a mirroring.
    pub to_world: Affine3A,
    /// The picture is a square in the mapping of [`octahedral`].
    pub octahedral: bool,
}

impl Default for EnvironmentLight {
    fn default() -> EnvironmentLight {
        EnvironmentLight {
            path: PathBuf::new(),
            scale: Rgb::ONE,
            to_world: Affine3A::from_rotation_y(0.0),
            octahedral: false,
        }
    }
}

impl Fields for EnvironmentLight {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.picture(key("path", PATH).required(), &mut self.path)?;
        visitor.color(key("scale", "multiplies the picture"), NOT_NEGATIVE, &mut self.scale)?;
        let angle = key("rotate_y", "turns it about +y, counter-clockwise seen from above").unit("degrees");
        let meaning = "from the picture's frame to the world, in the place of `rotate_y`; a translation means nothing";
        visitor.orientation(angle, key("to_world", meaning).optional(), &mut self.to_world)?;
        let meaning =
            "the picture is a square in the equal-area octahedral mapping of pbrt-v4, +z of its frame in the middle";
        visitor.added_flag(key("octahedral", meaning), &mut self.octahedral)
    }
}

const PATH: &str = "a picture in latitude and longitude, in W/(sr·m²): OpenEXR (`file.exr:LAYER` for one of several layers) or Radiance \
    HDR; of other formats sRGB is decoded, so that white is 1";

impl LightParameters for EnvironmentLight {
    const NUMBER: u32 = 1;
    type Loaded = Box<Environment>;

    fn load(&self, findings: &mut Findings) -> Result<Box<Environment>> {
        let path = &self.path;
        let picture = picture::load(path)?;
        // the picture unfolded has twice its pixels, and each takes sums while it is made
        let unfolded = if self.octahedral { 4 } else { 1 };
        let pixels = (picture.width * picture.height * unfolded) as u64;
        memory::check(pixels * (Environment::TABLE_BYTES_PER_PIXEL + size_of::<Rgb>() as u64))
            .map_err(|shortage| Error::file(path, format!("tables of its pixels {shortage}")))?;
        let data = picture.colors();
        findings.pictures.push(canon::texels([picture.width, picture.height], |canon| canon.array(&data)));
        findings.warnings.extend(notes(&picture).map(|note| format!("{}: {note}", path.display())));
        let (width, height, data) = match self.octahedral {
            false => (picture.width, picture.height, data),
            true if picture.width == picture.height => octahedral::unfolded(picture.width, &data),
            true => return Err(Error::file(path, "a picture in the octahedral mapping is as wide as it is high")),
        };
        let environment = Environment::new(width as u32, height as u32, data, self.scale, self.to_world)
            .map_err(|error| Error::file(path, error.to_string()))?;
        if environment.negative_pixels > 0 {
            let n = environment.negative_pixels;
            let warning = format!("{}: {n} pixels have negative radiance, which counts as 0", path.display());
            findings.warnings.push(warning);
        }
        Ok(Box::new(environment))
    }
}

/// What a user should know of a picture of surroundings.
fn notes(picture: &Picture) -> impl Iterator<Item = String> {
    let shown = "this picture is no radiance but colours for a screen: they are decoded (sRGB unless the file says otherwise), and white \
                 counts as a radiance of 1";
    let dim = !matches!(picture.samples, Samples::F32(_));
    picture.notes.clone().into_iter().chain(dim.then(|| shown.to_string()))
}
