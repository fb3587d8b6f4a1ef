//! Pictures on surfaces.
//!
//! Conventions as of Mitsuba's `bitmap`: texel centres lie at (i + ½)/w, values are decoded to linear light before they
//! are interpolated, the picture repeats. v points up, so (0, 0) is the lower left corner of the file's picture.

mod description;
mod glow;
mod relief;
mod scalar;
#[cfg(test)]
mod tests;
mod texels;

use crate::image::picture;
use crate::math::Rgb;
use crate::{Error, Result};
use glow::GlowMap;
use rustc_hash::FxHashMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use texels::{Summary, Texels};

pub use description::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
pub(crate) use description::{EmbeddedPicture, EmbeddedPictures, picture_at};
pub(crate) use relief::{Relief, Tangents};
pub(crate) use scalar::ScalarMap;

/// A picture in memory as it was stored in its file: 1 to 4 channels of 8 or 16 bits, or of floats.
#[derive(Clone, Debug)]
pub struct Texture {
    texels: Texels,
    opaque: bool,
    /// The largest component of any texel's colour; 0 where none is positive.
    peak: f32,
    /// Made when first asked for.
    glow: OnceLock<GlowMap>,
}

impl Texture {
    /// Loads a picture; the content decides of which format it is, not the name.
    ///
    /// Whole numbers are taken as sRGB unless the file says otherwise, floats as linear.
    ///
    /// # Errors
    /// All name the file: unreadable, of another format, damaged, a side above 2¹⁶ texels, above 1 GiB when decoded,
    /// floats that are not finite.
    pub fn load(path: &Path) -> Result<Texture> {
        picture::load(path).map(|picture| Texture::new(picture.into()))
    }

    fn new(texels: Texels) -> Texture {
        let Summary { opaque, peak } = texels.summary();
        Texture { texels, opaque, peak, glow: OnceLock::new() }
    }

    /// Linear colour at `uv`; bilinear, or of the texel that `uv` lies in. A coordinate that is not finite counts as 0.
    pub(crate) fn color(&self, uv: [f32; 2], nearest: bool) -> Rgb {
        self.interpolate(uv, nearest, |x, y| self.texels.color(x, y))
    }

    /// Asks for the texels that a colour or a number at `uv` is made of: for one of each row, beside which the other mostly lies.
    #[inline(always)]
    fn prefetch(&self, uv: [f32; 2]) {
        let (width, height) = (self.texels.width, self.texels.height);
        let (column, _, _) = neighbours(fraction(uv[0]), width);
        let (below, above, _) = neighbours(fraction(uv[1]), height);
        for row in [below, above] {
            self.texels.prefetch(column, height - 1 - row);
        }
    }

    /// The alpha channel at `uv` where the picture has one, else the luminance of the values as they are stored, not
    /// decoded from sRGB. In [0, 1] for 8 and 16 bits. Interpolated as [`Texture::color`].
    pub(crate) fn scalar(&self, uv: [f32; 2], nearest: bool) -> f32 {
        self.interpolate(uv, nearest, |x, y| self.texels.scalar(x, y))
    }

    /// The luminance of the values as they are stored at `uv`, whatever the alpha channel says.
    pub(crate) fn stored_luminance(&self, uv: [f32; 2], nearest: bool) -> f32 {
        self.interpolate(uv, nearest, |x, y| self.texels.stored_luminance(x, y))
    }

    /// The values as they are stored at `uv`, not decoded; those of integers in [0, 1].
    fn stored_color(&self, uv: [f32; 2], nearest: bool) -> Rgb {
        self.interpolate(uv, nearest, |x, y| self.texels.stored_color(x, y))
    }

    /// By how much the luminance of the stored values grows from one texel to the next along u and along v, in the mean of both
    /// neighbours.
    fn steps(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [width, height] = self.size().map(|side| 1.0 / side as f32);
        let at = |u: f32, v: f32| self.stored_luminance([u, v], false);
        [0.5 * (at(u + width, v) - at(u - width, v)), 0.5 * (at(u, v + height) - at(u, v - height))]
    }

    /// Mean linear colour of all texels, which is also the mean of [`Texture::color`] over the unit square.
    #[cfg(test)]
    fn mean(&self) -> Rgb {
        self.texels.mean()
    }

    /// Whether [`Texture::scalar`] is 1 everywhere.
    pub(crate) fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// Memory that the texels take.
    pub(crate) fn bytes(&self) -> usize {
        self.texels.bytes()
    }

    /// The same for pictures with the same texels, stored in the same way.
    pub(crate) fn content_hash(&self) -> u64 {
        self.texels.content_hash()
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.texels.width, self.texels.height]
    }

    #[inline(never)]
    fn within(&self, uv: [f32; 2]) -> [f32; 2] {
        let half = self.size().map(|side| 0.5 / side as f32);
        [0, 1].map(|i| uv[i].clamp(half[i], 1.0 - half[i]))
    }

    fn interpolate<T>(&self, uv: [f32; 2], nearest: bool, texel: impl Fn(usize, usize) -> T) -> T
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let (width, height) = (self.texels.width, self.texels.height);
        let (u, v) = (fraction(uv[0]), fraction(uv[1]));
        if nearest {
            let column = (u * width as f32) as usize;
            let row = (v * height as f32) as usize;
            return texel(column.min(width - 1), height - 1 - row.min(height - 1));
        }
        let (left, right, s) = neighbours(u, width);
        let (below, above, t) = neighbours(v, height);
        let lerp = |a: T, b: T, t: f32| a + (b - a) * t;
        let row = |y: usize| lerp(texel(left, height - 1 - y), texel(right, height - 1 - y), s);
        lerp(row(below), row(above), t)
    }
}

/// The part of `x` after the point, in [0, 1], so that the picture repeats.
fn fraction(x: f32) -> f32 {
    let fraction = x - x.floor();
    if fraction.is_finite() { fraction } else { 0.0 }
}

/// The two texels of `count` whose centres enclose `x` in [0, 1], and the weight of the second.
fn neighbours(x: f32, count: usize) -> (usize, usize, f32) {
    // One texel further, so that the number to truncate is positive.
    let x = x * count as f32 + 0.5;
    let second = x as usize;
    // x is at most count + ½; no division: it would take longer than all the rest
    let wrapped = if second >= count { second - count } else { second };
    let first = if wrapped == 0 { count - 1 } else { wrapped - 1 };
    (first, wrapped, x - second as f32)
}

/// How a material uses a texture: a resolved [`ImageTexture`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureMap {
    /// Of the texture in its [`TextureCache`].
    pub(crate) index: usize,
    scale: [f32; 2],
    offset: [f32; 2],
    nearest: bool,
    tint: Rgb,
    clamp: bool,
}

impl TextureMap {
    /// Linear colour at the surface's `uv`, times the tint. `textures` as of [`TextureCache::into_textures`].
    pub(crate) fn color(&self, textures: &[Texture], uv: [f32; 2]) -> Rgb {
        textures[self.index].color(self.clamped_uv(textures, uv), self.nearest) * self.tint
    }

    /// Asks for the texels at the surface's `uv`, which will be read soon.
    #[inline(always)]
    pub(crate) fn prefetch(&self, textures: &[Texture], uv: [f32; 2]) {
        textures[self.index].prefetch(self.clamped_uv(textures, uv));
    }

    /// [`Texture::scalar`] at the surface's `uv`, times the luminance of the tint.
    pub(crate) fn scalar(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        textures[self.index].scalar(self.clamped_uv(textures, uv), self.nearest) * texels::grey(self.tint)
    }

    /// [`Texture::stored_luminance`] at the surface's `uv`, times the luminance of the tint.
    pub(crate) fn stored_luminance(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        textures[self.index].stored_luminance(self.clamped_uv(textures, uv), self.nearest) * texels::grey(self.tint)
    }

    /// The values as they are stored at the surface's `uv`.
    fn stored_color(&self, textures: &[Texture], uv: [f32; 2]) -> Rgb {
        textures[self.index].stored_color(self.clamped_uv(textures, uv), self.nearest)
    }

    /// As of [`Texture::steps`] at the surface's `uv`, along the picture's own coordinates, times the luminance of the tint.
    fn steps(&self, textures: &[Texture], uv: [f32; 2]) -> [f32; 2] {
        textures[self.index].steps(self.clamped_uv(textures, uv)).map(|step| step * texels::grey(self.tint))
    }

    /// Mean linear colour of the picture, times the tint.
    #[cfg(test)]
    fn mean(&self, textures: &[Texture]) -> Rgb {
        textures[self.index].mean() * self.tint
    }

    /// The largest component of the picture's colours, times the tint; 0 where none is positive.
    pub(crate) fn peak(&self, textures: &[Texture]) -> f32 {
        textures[self.index].peak * self.tint.max_element()
    }

    /// Whether the picture is black between these texture coordinates of the surface; `false` where that is not known.
    pub(crate) fn is_black_between(&self, textures: &[Texture], uvs: [[f32; 2]; 3]) -> bool {
        // the texels that a clamped picture shows are not those of the coordinates
        if self.clamp {
            return false;
        }
        let texture = &textures[self.index];
        let glow = texture.glow.get_or_init(|| GlowMap::new(&texture.texels));
        glow.is_black_between(&uvs.map(|uv| self.picture_uv(uv)))
    }

    /// How many texels lie between these texture coordinates of the surface, those of repeated pictures counted anew.
    pub(crate) fn texels_between(&self, textures: &[Texture], uvs: [[f32; 2]; 3]) -> f64 {
        let [a, b, c] = uvs.map(|uv| self.picture_uv(uv)).map(|[u, v]| glam::DVec2::new(u.into(), v.into()));
        let [width, height] = textures[self.index].size();
        let texels = 0.5 * (b - a).perp_dot(c - a).abs() * (width * height) as f64;
        if texels.is_finite() { texels } else { 1.0 }
    }

    /// Red (0), green (1) or blue (2) as stored at the surface's `uv`, times the luminance of the tint.
    pub(crate) fn stored_channel(&self, textures: &[Texture], uv: [f32; 2], channel: usize) -> f32 {
        self.stored_color(textures, uv)[channel] * texels::grey(self.tint)
    }

    /// Coordinates of the picture; of one that does not repeat, those of the nearest place between the centres of its outer texels.
    #[inline]
    fn clamped_uv(&self, textures: &[Texture], uv: [f32; 2]) -> [f32; 2] {
        let moved = self.picture_uv(uv);
        if self.clamp { textures[self.index].within(moved) } else { moved }
    }

    fn picture_uv(&self, uv: [f32; 2]) -> [f32; 2] {
        [uv[0] * self.scale[0] + self.offset[0], uv[1] * self.scale[1] + self.offset[1]]
    }
}

/// Loads every file once.
#[derive(Debug, Default)]
pub(crate) struct TextureCache {
    textures: Vec<Texture>,
    /// By path without links and dots, and layer.
    indices: FxHashMap<(PathBuf, Option<String>), usize>,
    /// What a user should know of how files were read.
    notes: Vec<String>,
    /// Pictures that are looked for here before they are looked for in files.
    embedded: EmbeddedPictures,
}

impl TextureCache {
    /// One that knows these pictures beside those in files.
    pub(crate) fn with(embedded: EmbeddedPictures) -> TextureCache {
        TextureCache { embedded, ..TextureCache::default() }
    }

    /// Index of the texture of this file, which is loaded when first asked for.
    ///
    /// # Errors
    /// As of [`Texture::load`]; the next call tries again.
    pub(crate) fn get(&mut self, path: &Path) -> Result<usize> {
        let embedded = self.embedded.get(path).cloned();
        let real = match &embedded {
            Some(_) => (path.to_path_buf(), None),
            None => {
                let (file, layer) = picture::split_layer(path);
                (file.canonicalize().map_err(Error::io(&file))?, layer)
            }
        };
        if let Some(&index) = self.indices.get(&real) {
            return Ok(index);
        }
        let mut picture = match embedded.as_deref() {
            None => picture::load(path)?,
            Some(EmbeddedPicture::Encoded(bytes)) => picture::load_bytes(path, bytes)?,
            Some(EmbeddedPicture::Decoded(picture)) => picture.clone(),
        };
        self.notes.extend(picture.notes.drain(..).map(|note| format!("{}: {note}", path.display())));
        self.textures.push(Texture::new(picture.into()));
        self.indices.insert(real, self.textures.len() - 1);
        Ok(self.textures.len() - 1)
    }

    /// Loads the picture that `image` names and resolves the rest of it.
    ///
    /// # Errors
    /// As of [`TextureCache::get`].
    pub(crate) fn resolve(&mut self, image: &ImageTexture) -> Result<TextureMap> {
        let &ImageTexture { ref path, scale, offset, nearest, tint, clamp } = image;
        Ok(TextureMap { index: self.get(path)?, scale, offset, nearest, tint, clamp })
    }

    /// The textures loaded so far, by index.
    pub(crate) fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// What there is to say of the files read since the last call.
    pub(crate) fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Ends loading.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.textures
    }
}
