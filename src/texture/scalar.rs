//! Numbers from pictures.

use super::description::ScalarTexture;
use super::{Texture, TextureCache, TextureMap};
use crate::Result;

/// A resolved [`ScalarTexture`] that is no constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarMap {
    pub(crate) map: TextureMap,
    source: Source,
}

/// Which number of a texel counts.
#[derive(Clone, Copy, Debug)]
enum Source {
    Alpha,
    Luminance,
    Channel(usize),
}

impl ScalarMap {
    /// `None` for a constant.
    ///
    /// # Errors
    /// As of [`TextureCache::get`].
    pub(crate) fn new(texture: &ScalarTexture, cache: &mut TextureCache) -> Result<Option<ScalarMap>> {
        let (image, source) = match texture {
            ScalarTexture::Constant(_) => return Ok(None),
            ScalarTexture::Image(image) => (image, Source::Alpha),
            ScalarTexture::Luminance(image) => (image, Source::Luminance),
            ScalarTexture::Channel(image, channel) => (image, Source::Channel(*channel)),
        };
        Ok(Some(ScalarMap { map: cache.resolve(image)?, source }))
    }

    /// At the surface's `uv`, as stored, times the luminance of the tint.
    pub(crate) fn value(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        match self.source {
            Source::Alpha => self.map.scalar(textures, uv),
            Source::Luminance => self.map.stored_luminance(textures, uv),
            Source::Channel(channel) => self.map.stored_channel(textures, uv, channel),
        }
    }

    /// Whether it is known to be 1 everywhere.
    pub(crate) fn is_one(&self, textures: &[Texture]) -> bool {
        matches!(self.source, Source::Alpha) && textures[self.map.index].is_opaque()
    }
}
