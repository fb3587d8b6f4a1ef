//! Surfaces of two materials, mixed. At each vertex of a path such a surface is one of the two, by chance: what the vertex adds is right
//! on average for f = (1 − w) f₁ + w f₂, delta parts included, and whatever asks a surface how it scatters meets a single material.

use super::description::{BlendDescription, BlendPart};
use super::material::{Material, Share};
use crate::Result;
use crate::bsdf::BsdfTables;
use crate::texture::{Texture, TextureCache, TextureMap};

/// Two materials and how they are mixed.
#[derive(Clone, Debug)]
pub(super) struct Blend {
    /// Of the second.
    weight: Share,
    parts: Box<[Material; 2]>,
}

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl Blend {
    pub(super) fn new(
        description: &BlendDescription,
        cache: &mut TextureCache,
        tables: &mut BsdfTables,
    ) -> Result<Blend> {
        let [first, second] = &*description.parts;
        let mut part = |part: &BlendPart| Ok(Material::new(&part.material, cache, tables)?.in_blend(&part.material));
        let parts = [part(first)?, part(second)?];
        Ok(Blend { weight: Share::new(&description.weight, cache)?, parts: Box::new(parts) })
    }

    /// Shares of light that either stops, of what falls on the mixture.
    fn shares(&self, textures: &[Texture], uv: [f32; 2]) -> [f32; 2] {
        let (weight, [first, second]) = (self.weight.value(textures, uv), &*self.parts);
        [(1.0 - weight) * first.opacity(textures, uv), weight * second.opacity(textures, uv)]
    }

    pub(super) fn opacity(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        self.shares(textures, uv).iter().sum()
    }

    pub(super) fn is_opaque(&self, textures: &[Texture]) -> bool {
        self.parts.iter().all(|part| part.is_opaque(textures))
    }

    /// The opacity where it is the same everywhere.
    pub(super) fn constant_opacity(&self, textures: &[Texture]) -> Option<f32> {
        if self.is_opaque(textures) {
            return Some(1.0);
        }
        let [first, second] = [&self.parts[0], &self.parts[1]].map(|part| part.constant_opacity(textures));
        first.zip(second).filter(|_| self.weight.is_constant()).map(|_| self.opacity(textures, [0.0; 2]))
    }

    /// The pictures that its opacity goes by.
    pub(super) fn opacity_maps(&self) -> Vec<TextureMap> {
        let parts = self.parts.iter().flat_map(Material::opacity_maps);
        parts.chain(self.weight.map()).collect()
    }

    /// Probability of the second part where light is stopped.
    fn second(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        let [first, second] = self.shares(textures, uv);
        if first + second > 0.0 { second / (first + second) } else { self.weight.value(textures, uv) }
    }

    /// One of the parts by the chance `u`; what is left of that is uniform in [0, 1) again, for blends within blends.
    pub(super) fn choose(&self, textures: &[Texture], uv: [f32; 2], u: f32) -> &Material {
        let second = self.second(textures, uv);
        let (part, left) =
            if u < second { (&self.parts[1], u / second) } else { (&self.parts[0], (u - second) / (1.0 - second)) };
        part.choose(textures, uv, || left.min(BELOW_ONE))
    }

    /// As of [`Material::each_choice`].
    pub(super) fn each_choice<'a>(
        &'a self,
        textures: &[Texture],
        uv: [f32; 2],
        probability: f32,
        each: &mut dyn FnMut(&'a Material, f32),
    ) {
        let second = self.second(textures, uv);
        for (part, share) in self.parts.iter().zip([1.0 - second, second]) {
            part.each_choice(textures, uv, probability * share, each);
        }
    }

    /// As of [`Material::prefetch`].
    pub(super) fn prefetch(&self, textures: &[Texture], uv: [f32; 2]) {
        self.weight.map().iter().for_each(|map| map.prefetch(textures, uv));
        self.parts.iter().for_each(|part| part.prefetch(textures, uv));
    }
}

#[cfg(test)]
#[path = "blend_tests.rs"]
mod tests;
