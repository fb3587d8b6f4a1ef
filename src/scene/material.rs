//! Materials, ready for rendering: scattering with its textures, emission, and what is seen through.

use super::blend::Blend;
use crate::Result;
use crate::bsdf::{Bsdf, BsdfModel, BsdfTables, color_textures, share_textures};
use crate::embree::OpacityTest;
use crate::geometry::Mesh;
use crate::light::EmitterPattern;
use crate::math::{Rgb, rng::mix};
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, Relief, ScalarMap, ScalarTexture, Texture, TextureCache, TextureMap};
use std::sync::Arc;

/// A material of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    model: BsdfModel,
    /// Constant colours; those of textures stand in `maps`, and here black.
    colors: [Rgb; 2],
    textured: bool,
    /// Whether it is Lambertian and the same everywhere, as most of most scenes.
    plain: bool,
    maps: [Option<TextureMap>; 2],
    /// Whether the colour is to be multiplied by that of the mesh's vertices.
    of_vertices: [bool; 2],
    /// Components of the second colour that come from pictures.
    shares: [Option<ScalarMap>; 3],
    opacity: Share,
    /// What it is mixed of. How it scatters is theirs then.
    blend: Option<Blend>,
    relief: Option<Relief>,
    /// Times the picture, where there is one.
    emission: Rgb,
    emission_map: Option<TextureMap>,
    /// The largest component of a texel of that picture; else 1.
    emission_peak: f32,
    /// Whether that is anything.
    emits: bool,
    emission_two_sided: bool,
    /// Number of its light group.
    light_group: u32,
}

/// A number in [0, 1] that may come from a picture, which is loaded. What is no number is 1.
#[derive(Clone, Copy, Debug)]
pub(super) enum Share {
    Constant(f32),
    Map(ScalarMap),
}

impl Share {
    pub(super) fn new(texture: &ScalarTexture, cache: &mut TextureCache) -> Result<Share> {
        Ok(match texture {
            ScalarTexture::Constant(share) => Share::Constant(*share),
            picture => ScalarMap::new(picture, cache)?.map_or(Share::Constant(1.0), Share::Map),
        })
    }

    #[inline]
    pub(super) fn value(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        let share = match self {
            Share::Constant(share) => *share,
            Share::Map(map) => map.value(textures, uv),
        };
        if share < 1.0 { share.max(0.0) } else { 1.0 }
    }

    pub(super) fn is_constant(&self) -> bool {
        matches!(self, Share::Constant(_))
    }

    pub(super) fn map(&self) -> Option<TextureMap> {
        match self {
            Share::Constant(_) => None,
            Share::Map(scalar) => Some(scalar.map),
        }
    }

    fn is_one(&self, textures: &[Texture]) -> bool {
        match self {
            Share::Constant(share) => *share >= 1.0,
            Share::Map(map) => map.is_one(textures),
        }
    }
}

impl Material {
    /// # Errors
    /// Textures that cannot be loaded, and parameters out of their domain.
    pub(crate) fn new(
        description: &MaterialDescription,
        cache: &mut TextureCache,
        tables: &mut BsdfTables,
    ) -> Result<Material> {
        let (mut colors, mut maps, mut of_vertices) = ([Rgb::ZERO; 2], [None; 2], [false; 2]);
        for (k, texture) in color_textures(&description.bsdf).into_iter().enumerate() {
            match texture {
                None => {}
                Some(ColorTexture::Constant(color)) => colors[k] = color,
                Some(ColorTexture::Vertex(tint)) => (colors[k], of_vertices[k]) = (tint, true),
                Some(ColorTexture::Image(image)) => maps[k] = Some(cache.resolve(&image)?),
            }
        }
        let opacity = description.opacity.as_ref();
        let opacity = opacity.map_or(Ok(Share::Constant(1.0)), |texture| Share::new(texture, cache))?;
        let blend = description.blend.as_ref().map(|blend| Blend::new(blend, cache, tables)).transpose()?;
        let relief = description.relief.as_ref().map(|texture| Relief::new(texture, cache)).transpose()?;
        let emission_map = description.emission_map.as_ref().map(|image| cache.resolve(image)).transpose()?;
        let emission_peak = emission_map.map_or(1.0, |map| map.peak(cache.textures()));
        let model = BsdfModel::new(&description.bsdf, description.two_sided, tables)?;
        let mut shares = [None; 3];
        for (k, (number, map)) in share_textures(&description.bsdf).into_iter().flatten().enumerate() {
            colors[1][k] = number;
            shares[k] = map.map(|map| ScalarMap::new(&map, cache)).transpose()?.flatten();
        }
        let has_pictures = maps.iter().any(Option::is_some) || shares.iter().any(Option::is_some);
        let textured = has_pictures || of_vertices.contains(&true);
        Ok(Material {
            plain: model.is_diffuse() && !textured && relief.is_none() && blend.is_none(),
            model,
            colors,
            textured,
            maps,
            of_vertices,
            shares,
            opacity,
            blend,
            relief,
            emission: description.emission,
            emission_map,
            emission_peak,
            emits: description.emission * emission_peak != Rgb::ZERO,
            emission_two_sided: description.emission_two_sided,
            light_group: 0,
        })
    }

    /// As a part of a blend: what is no surface is a hole in the other part.
    pub(super) fn in_blend(self, description: &MaterialDescription) -> Material {
        let hole = description.blend.is_none() && !description.bsdf.bsdf_type().is_surface();
        if hole { Material { opacity: Share::Constant(0.0), ..self } } else { self }
    }

    /// The same, its light being in that group.
    pub(crate) fn in_light_group(self, light_group: u32) -> Material {
        Material { light_group, ..self }
    }

    pub(crate) fn light_group(&self) -> u32 {
        self.light_group
    }

    /// The BSDF, where nothing has to be looked up or computed for it.
    #[inline(always)]
    pub(crate) fn plain(&self) -> Option<Bsdf<'_>> {
        self.plain.then(|| self.model.at(self.colors))
    }

    /// The BSDF at the texture coordinates `uv`; `vertex_color` finds the colour of the mesh's vertices there.
    #[inline]
    pub(crate) fn bsdf(&self, textures: &[Texture], uv: [f32; 2], vertex_color: impl Fn() -> Rgb) -> Bsdf<'_> {
        self.model.at(if self.textured { self.textured_colors(textures, uv, vertex_color) } else { self.colors })
    }

    /// Asks for the texels that [`Self::bsdf`] will read at the texture coordinates `uv`.
    #[inline]
    pub(crate) fn prefetch(&self, textures: &[Texture], uv: [f32; 2]) {
        if let Some(blend) = &self.blend {
            blend.prefetch(textures, uv);
        }
        if self.textured {
            let shares = self.shares.iter().flatten().map(|share| &share.map);
            self.maps.iter().flatten().chain(shares).for_each(|map| map.prefetch(textures, uv));
        }
    }

    /// What turns the normals, if anything does.
    #[inline(always)]
    pub(crate) fn relief(&self) -> Option<&Relief> {
        self.relief.as_ref()
    }

    #[inline(never)]
    fn textured_colors(&self, textures: &[Texture], uv: [f32; 2], vertex_color: impl Fn() -> Rgb) -> [Rgb; 2] {
        let color = |k: usize| match self.maps[k] {
            Some(map) => map.color(textures, uv),
            None if self.of_vertices[k] => self.colors[k] * vertex_color(),
            None => self.colors[k],
        };
        let mut colors = [color(0), color(1)];
        for (k, share) in self.shares.iter().enumerate() {
            colors[1][k] = share.map_or(colors[1][k], |share| share.value(textures, uv));
        }
        colors
    }

    /// Radiance emitted to the front, or to the back, at the texture coordinates `uv`.
    #[inline]
    pub(crate) fn emission(&self, front: bool, textures: &[Texture], uv: [f32; 2]) -> Rgb {
        let emission = if front || self.emission_two_sided { self.emission } else { Rgb::ZERO };
        if self.emission_map.is_none() { emission } else { emission * self.emission_factor(textures, uv) }
    }

    /// What the picture of the emission multiplies; 1 without one.
    #[inline(never)]
    fn emission_factor(&self, textures: &[Texture], uv: [f32; 2]) -> Rgb {
        self.emission_map.map_or(Rgb::ONE, |map| map.color(textures, uv).max(Rgb::ZERO))
    }

    /// The largest radiance of any place, of the sides that emit.
    pub(crate) fn brightest_emission(&self) -> Rgb {
        self.emission * self.emission_peak
    }

    pub(crate) fn has_emission_map(&self) -> bool {
        self.emission_map.is_some()
    }

    /// Whether nothing is emitted between these texture coordinates.
    pub(super) fn is_dark(&self, textures: &[Texture], uvs: impl Fn() -> [[f32; 2]; 3]) -> bool {
        self.emission_map.is_some_and(|map| map.is_black_between(textures, uvs()))
    }

    /// Texels of all pictures that say how much is seen of the emission, under a triangle with these texture coordinates.
    fn emission_texels(&self, textures: &[Texture], uvs: [[f32; 2]; 3]) -> f64 {
        let maps = self.opacity_maps().into_iter().chain(self.emission_map);
        maps.map(|map| map.texels_between(textures, uvs)).fold(1.0, f64::max)
    }

    /// The same material with another emission on the sides that emit.
    pub(crate) fn with_emission(&self, change: impl Fn(Rgb) -> Rgb) -> Material {
        Material { emission: change(self.emission), ..self.clone() }
    }

    #[inline]
    pub(crate) fn emits(&self) -> bool {
        self.emits
    }

    pub(crate) fn emission_two_sided(&self) -> bool {
        self.emission_two_sided
    }

    /// What it is at a vertex: itself, or one of those that it is mixed of, by the chance `u` in [0, 1).
    #[inline(always)]
    pub(super) fn choose(&self, textures: &[Texture], uv: [f32; 2], u: impl FnOnce() -> f32) -> &Material {
        match &self.blend {
            None => self,
            Some(blend) => blend.choose(textures, uv, u()),
        }
    }

    /// Calls `each` with what it may be, and `probability` times how probable that is.
    pub(super) fn each_choice<'a>(
        &'a self,
        textures: &[Texture],
        uv: [f32; 2],
        probability: f32,
        each: &mut dyn FnMut(&'a Material, f32),
    ) {
        match &self.blend {
            None => each(self, probability),
            Some(blend) => blend.each_choice(textures, uv, probability, each),
        }
    }

    /// Probability that a ray is stopped, in [0, 1]. What is no number stops all.
    pub(super) fn opacity(&self, textures: &[Texture], uv: [f32; 2]) -> f32 {
        let own = self.opacity.value(textures, uv);
        self.blend.as_ref().map_or(own, |blend| own * blend.opacity(textures, uv))
    }

    /// The pictures that this goes by.
    pub(super) fn opacity_maps(&self) -> Vec<TextureMap> {
        let parts = self.blend.iter().flat_map(Blend::opacity_maps);
        parts.chain(self.opacity.map()).collect()
    }

    /// The same where it is the same everywhere.
    pub(crate) fn constant_opacity(&self, textures: &[Texture]) -> Option<f32> {
        let own = match self.opacity {
            Share::Constant(_) => self.opacity.value(textures, [0.0; 2]),
            Share::Map(_) => self.opacity.is_one(textures).then_some(1.0)?,
        };
        self.blend.as_ref().map_or(Some(own), |blend| Some(own * blend.constant_opacity(textures)?))
    }

    pub(super) fn is_opaque(&self, textures: &[Texture]) -> bool {
        self.opacity.is_one(textures) && self.blend.as_ref().is_none_or(|blend| blend.is_opaque(textures))
    }
}

/// The test that Embree asks about a mesh, where any of its materials is seen through.
pub(super) fn opacity_test(
    mesh: &Arc<Mesh>,
    materials: &Arc<Vec<Material>>,
    textures: &Arc<Vec<Texture>>,
) -> Option<Box<dyn OpacityTest>> {
    let cut_out = CutOut::new(mesh, materials, textures);
    cut_out.see_through.contains(&true).then(|| Box::new(cut_out) as Box<dyn OpacityTest>)
}

/// How the emission varies over a mesh's emissive triangles, where they stand `mirrored` or not.
pub(super) fn emitter_pattern(
    mesh: &Arc<Mesh>,
    materials: &Arc<Vec<Material>>,
    textures: &Arc<Vec<Texture>>,
    mirrored: bool,
) -> Arc<dyn EmitterPattern> {
    Arc::new(PlacedPattern { cut_out: CutOut::new(mesh, materials, textures), mirrored })
}

/// Lets rays pass where the opacity says so. A partial opacity is decided by chance, and the chance is a hash of the
/// place that was hit: rays that differ get independent answers, and the same ray always the same.
struct CutOut {
    mesh: Arc<Mesh>,
    materials: Arc<Vec<Material>>,
    textures: Arc<Vec<Texture>>,
    /// By material.
    see_through: Vec<bool>,
}

impl CutOut {
    fn new(mesh: &Arc<Mesh>, materials: &Arc<Vec<Material>>, textures: &Arc<Vec<Texture>>) -> CutOut {
        let mut used = vec![false; materials.len()];
        mesh.materials.iter().for_each(|&m| used[m as usize] = true);
        let see_through = materials.iter().zip(used).map(|(material, used)| used && !material.is_opaque(textures));
        let see_through = see_through.collect();
        CutOut { mesh: mesh.clone(), materials: materials.clone(), textures: textures.clone(), see_through }
    }

    /// The opacity at barycentric weights; `None` where the whole triangle is opaque.
    fn opacity(&self, primitive: u32, u: f32, v: f32) -> Option<f32> {
        let material = self.mesh.materials[primitive as usize] as usize;
        let uv = || self.mesh.uv(primitive as usize, u, v);
        self.see_through[material].then(|| self.materials[material].opacity(&self.textures, uv()))
    }
}

/// Corners of a mirrored triangle that emits come in another order than in the mesh: the second and the third change
/// places, so that they run counter-clockwise seen from the side that emits.
struct PlacedPattern {
    cut_out: CutOut,
    mirrored: bool,
}

impl PlacedPattern {
    fn material(&self, triangle: u32) -> &Material {
        &self.cut_out.materials[self.cut_out.mesh.materials[triangle as usize] as usize]
    }
}

impl EmitterPattern for PlacedPattern {
    fn factor(&self, triangle: u32, weights: [f32; 2]) -> Rgb {
        let [u, v] = if self.mirrored { [weights[1], weights[0]] } else { weights };
        let (material, CutOut { mesh, textures, .. }) = (self.material(triangle), &self.cut_out);
        let opacity = self.cut_out.opacity(triangle, u, v).unwrap_or(1.0);
        material.emission_factor(textures, mesh.uv(triangle as usize, u, v)) / material.emission_peak * opacity
    }

    fn texels(&self, triangle: u32) -> f64 {
        let CutOut { mesh, textures, .. } = &self.cut_out;
        self.material(triangle).emission_texels(textures, mesh.uvs_of(triangle as usize))
    }
}

impl OpacityTest for CutOut {
    fn passes(&self, primitive: u32, u: f32, v: f32) -> bool {
        let Some(opacity) = self.opacity(primitive, u, v) else { return false };
        let bits = mix((u.to_bits() as u64) << 32 | v.to_bits() as u64) ^ primitive as u64;
        // 24 bits, as many as the fraction of an f32 holds
        let chance = (mix(bits) >> 40) as f32 * (1.0 / (1 << 24) as f32);
        chance >= opacity
    }
}

#[cfg(test)]
#[path = "vertex_color_tests.rs"]
mod vertex_color_tests;
