//! Textures as written.

use crate::Result;
use crate::image::picture::{self, Picture, Samples};
use crate::math::Rgb;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A colour: constant, from a picture or from the mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorTexture {
    Constant(Rgb),
    Image(ImageTexture),
    /// The colours of the mesh's vertices or faces, times this.
    Vertex(Rgb),
}

impl ColorTexture {
    /// The same grey everywhere.
    pub(crate) const fn grey(value: f32) -> ColorTexture {
        ColorTexture::Constant(Rgb::splat(value))
    }
}

/// A number, constant or from a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarTexture {
    Constant(f32),
    /// The alpha channel where the picture has one, else its luminance as stored (not decoded from sRGB).
    Image(ImageTexture),
    /// The luminance as stored, whatever the alpha channel says.
    Luminance(ImageTexture),
    /// Red (0), green (1) or blue (2) as stored.
    Channel(ImageTexture, usize),
}

impl ScalarTexture {
    /// The picture, where there is one.
    pub(crate) fn image(&self) -> Option<&ImageTexture> {
        match self {
            ScalarTexture::Constant(_) => None,
            ScalarTexture::Image(image) | ScalarTexture::Luminance(image) | ScalarTexture::Channel(image, _) => {
                Some(image)
            }
        }
    }
}

/// A picture on a surface. v points up: (0, 0) is the lower left corner. Outside of [0, 1) it repeats, unless it is clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    pub(crate) path: PathBuf,
    /// Multiplies (u, v) first.
    pub(crate) scale: [f32; 2],
    /// Then added.
    pub(crate) offset: [f32; 2],
    /// Nearest texel instead of bilinear.
    pub(crate) nearest: bool,
    /// Multiplies the picture.
    pub(crate) tint: Rgb,
    /// The picture does not repeat: its edge goes on.
    pub(crate) clamp: bool,
}

impl ImageTexture {
    /// The whole picture once over the unit square.
    pub(crate) fn new(path: PathBuf) -> ImageTexture {
        ImageTexture { path, scale: [1.0; 2], offset: [0.0; 2], nearest: false, tint: Rgb::ONE, clamp: false }
    }

    /// The mean of the picture times the tint: of its linear colours or, where `stored`, of its values as they are stored.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn mean(&self, embedded: &EmbeddedPictures, stored: bool) -> Result<Rgb> {
        let picture = picture_at(&self.path, embedded)?;
        let picture = if stored { picture.with_curve(|x| x) } else { picture };
        Ok(picture.mean() * self.tint)
    }

    /// Makes the numbers that are stored those that its colours are in linear light. (What cannot be read is an error where the scene is
    /// loaded.)
    pub(crate) fn decode(&mut self, embedded: &mut EmbeddedPictures) {
        let name = PathBuf::from(format!("{}#decoded", self.path.display()));
        if !embedded.contains_key(&name) {
            let Ok(picture) = picture_at(&self.path, embedded) else { return };
            if matches!(picture.samples, Samples::F32(_)) {
                return;
            }
            let numbers = picture.colors().iter().flat_map(|color| color.to_array()).collect();
            let picture = Picture { channels: 3, samples: Samples::F32(numbers), ..picture };
            embedded.insert(name.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        }
        self.path = name;
    }

    /// Lets every second copy be mirrored, across u, v or both: by a picture that has its own mirror image beside it.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn mirror(&mut self, axes: [bool; 2], embedded: &mut EmbeddedPictures) -> Result<()> {
        let [u, v] = axes.map(usize::from);
        let name = PathBuf::from(format!("{}#mirrored {u}{v}", self.path.display()));
        if !embedded.contains_key(&name) {
            let picture = picture_at(&self.path, embedded)?.mirrored(axes);
            embedded.insert(name.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        }
        self.path = name;
        for (axis, _) in axes.iter().enumerate().filter(|(_, mirrored)| **mirrored) {
            self.scale[axis] *= 0.5;
            self.offset[axis] *= 0.5;
        }
        Ok(())
    }
}

/// A picture that is in no file of its own.
#[derive(Clone, Debug)]
pub(crate) enum EmbeddedPicture {
    /// The bytes of a file, of any format that is read but OpenEXR.
    Encoded(Vec<u8>),
    Decoded(Picture),
}

/// Such pictures by the path that stands for each: no file has it.
pub(crate) type EmbeddedPictures = BTreeMap<PathBuf, Arc<EmbeddedPicture>>;

/// The picture that a path stands for, or that is in the file.
///
/// # Errors
/// A file that cannot be read, and bytes that are no picture.
pub(crate) fn picture_at(path: &Path, embedded: &EmbeddedPictures) -> Result<Picture> {
    match embedded.get(path).map(|picture| &**picture) {
        Some(EmbeddedPicture::Encoded(bytes)) => picture::load_bytes(path, bytes),
        Some(EmbeddedPicture::Decoded(picture)) => Ok(picture.clone()),
        None => picture::load(path),
    }
}

/// A picture that turns the normals of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ReliefTexture {
    pub(crate) image: ImageTexture,
    pub(crate) kind: ReliefKind,
    /// Multiplies the tilt of normals, or the heights.
    pub(crate) strength: f32,
}

/// What the values of such a picture are, as they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReliefKind {
    /// Normals in the frame of the texture coordinates: red along u, green along v, blue out of the surface; 0.5 is zero.
    Normals,
    /// The same, but for green, which is along −v.
    NormalsDown,
    /// Heights out of the surface in units of length.
    Heights,
    /// Heights in widths of a texel.
    TexelHeights,
    /// Normals if the picture looks like those, else heights in widths of a texel.
    NormalsOrTexelHeights,
}
