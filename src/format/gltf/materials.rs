//! Materials: metallic and rough ones, and panes of glass.

use super::Warnings;
use super::buffers::{Buffers, Uri, parsed};
use crate::bsdf::{BsdfDescription, DielectricParameters, PrincipledMaps, PrincipledParameters};
use crate::image::picture::{Picture, Samples};
use crate::image::srgb;
use crate::math::Rgb;
use crate::scene::description::{MaterialDescription, SceneDescription};
use crate::texture::{
    ColorTexture, EmbeddedPicture, EmbeddedPictures, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture, picture_at,
};
use crate::{Error, Result};
use gltf::material::AlphaMode;
use gltf::texture::{Info, MagFilter, Texture, TextureTransform, WrappingMode};
use gltf::{Document, Material};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A material with what meshes have to bring for it.
struct Entry {
    name: String,
    description: MaterialDescription,
    uv_set: u32,
}

/// All materials of a file, the default one last.
pub(super) struct Materials {
    all: Vec<Entry>,
    pictures: EmbeddedPictures,
}

/// What is said of materials of meshes with colours.
const COLORED: &str = " in the colours of vertices";

impl Materials {
    pub(crate) fn read(document: &Document, buffers: &Buffers, warnings: &mut Warnings) -> Result<Materials> {
        let mut reader = Reader { buffers, warnings, pictures: EmbeddedPictures::new(), uv_set: None };
        let mut all: Vec<Entry> = Vec::new();
        for (k, material) in document.materials().enumerate() {
            let name = material.name().map_or(format!("material {k}"), str::to_string);
            let taken = |name: &String| all.iter().any(|entry| entry.name == *name);
            let name = if taken(&name) { format!("{name} ({k})") } else { name };
            reader.uv_set = None;
            let description = reader.material(&material, &name)?;
            all.push(Entry { name, description, uv_set: reader.uv_set.unwrap_or(0) });
        }
        let bsdf = PrincipledParameters {
            base_color: ColorTexture::grey(1.0),
            metallic: 1.0,
            roughness: 1.0,
            ..PrincipledParameters::default()
        };
        let description = MaterialDescription { bsdf: bsdf.into(), ..MaterialDescription::default() };
        all.push(Entry { name: "default".into(), description, uv_set: 0 });
        Ok(Materials { all, pictures: reader.pictures })
    }

    fn entry(&self, index: Option<usize>) -> &Entry {
        let default = self.all.len() - 1;
        &self.all[index.unwrap_or(default).min(default)]
    }

    /// The name under which a primitive with this material finds it, the set of texture coordinates that it takes, and whether it takes
    /// the colours of vertices, which are there or not.
    pub(crate) fn of(&self, index: Option<usize>, has_colors: bool, warnings: &mut Warnings) -> (String, u32, bool) {
        let Entry { name, description, uv_set } = self.entry(index);
        if !has_colors {
            return (name.clone(), *uv_set, false);
        }
        let mut colored = description.clone();
        colored.multiply_vertex_colors();
        if colored == *description {
            warnings.add(format!("material `{name}`: the colours of vertices mean nothing beside its picture"));
            return (name.clone(), *uv_set, false);
        }
        (format!("{name}{COLORED}"), *uv_set, true)
    }

    /// Those that meshes of the scene have, and all pictures.
    pub(crate) fn into_used(
        self,
        scene: &SceneDescription,
    ) -> (BTreeMap<String, MaterialDescription>, EmbeddedPictures) {
        let used = scene.meshes.iter().filter_map(|mesh| mesh.material.as_ref());
        let mut materials = BTreeMap::new();
        for name in used {
            let plain = self.all.iter().find(|entry| entry.name == *name);
            let found = plain.map(|entry| entry.description.clone()).or_else(|| {
                let plain = name.strip_suffix(COLORED)?;
                let mut colored = self.all.iter().find(|entry| entry.name == plain)?.description.clone();
                colored.multiply_vertex_colors();
                Some(colored)
            });
            materials.extend(found.map(|found| (name.clone(), found)));
        }
        (materials, self.pictures)
    }
}

/// Reads one material after the other.
struct Reader<'a, 'b> {
    buffers: &'a Buffers<'a>,
    warnings: &'a mut Warnings<'b>,
    pictures: EmbeddedPictures,
    /// Of the material's pictures so far.
    uv_set: Option<u32>,
}

impl Reader<'_, '_> {
    fn material(&mut self, material: &Material, name: &str) -> Result<MaterialDescription> {
        let bsdf = self.bsdf(material, name)?;
        let opacity = self.opacity(material)?;
        let strength = material.emissive_strength().unwrap_or(1.0);
        let emission_map = match material.emissive_texture() {
            Some(info) => Some(self.info(&info, Rgb::ONE)?),
            None => None,
        };
        let relief = match material.normal_texture() {
            Some(normal) => {
                self.use_set(normal.tex_coord());
                let image = self.image(&normal.texture(), None, Rgb::ONE)?;
                Some(ReliefTexture { image, kind: ReliefKind::Normals, strength: normal.scale().max(0.0) })
            }
            None => None,
        };
        if material.extension_value("KHR_materials_unlit").is_some() {
            self.warnings.add(format!("material `{name}`: `KHR_materials_unlit` means nothing: it reflects light"));
        }
        let emission = (Rgb::from(material.emissive_factor()) * strength).max(Rgb::ZERO);
        Ok(MaterialDescription {
            bsdf,
            two_sided: true,
            opacity,
            emission_map: emission_map.filter(|_| emission != Rgb::ZERO),
            emission,
            emission_two_sided: material.double_sided(),
            light_group: None,
            relief,
            blend: None,
        })
    }

    fn bsdf(&mut self, material: &Material, name: &str) -> Result<BsdfDescription> {
        let pbr = material.pbr_metallic_roughness();
        let [r, g, b, _] = pbr.base_color_factor();
        let factor = Rgb::new(r, g, b).clamp(Rgb::ZERO, Rgb::ONE);
        let base_color = match pbr.base_color_texture() {
            Some(info) => ColorTexture::Image(self.info(&info, factor)?),
            None => ColorTexture::Constant(factor),
        };
        let ior = material.ior().unwrap_or(1.5).clamp(1.0, 10.0);
        if let Some(transmission) = material.transmission().filter(|t| t.transmission_factor() > 0.0) {
            if transmission.transmission_factor() >= 0.5 {
                return Ok(self.glass(material, name, ior, &base_color));
            }
            self.warnings.add(format!("material `{name}`: a transmission below a half is taken for none"));
        }
        let share = |x: f32| x.clamp(0.0, 1.0);
        let mut maps = PrincipledMaps::NONE;
        if let Some(info) = pbr.metallic_roughness_texture() {
            let image = |factor: f32, reader: &mut Self| reader.info(&info, Rgb::splat(share(factor)));
            maps.metallic = Some(ScalarTexture::Channel(image(pbr.metallic_factor(), self)?, 2));
            maps.roughness = Some(ScalarTexture::Channel(image(pbr.roughness_factor(), self)?, 1));
        }
        let specular = material.specular();
        let strength = specular.as_ref().map_or(1.0, |specular| specular.specular_factor());
        if specular.is_some_and(|s| s.specular_texture().is_some() || s.specular_color_factor() != [1.0; 3]) {
            self.warnings
                .add(format!("material `{name}`: a colour or picture of `KHR_materials_specular` means nothing"));
        }
        let coat = material.extension_value("KHR_materials_clearcoat");
        let coat = |key: &str| coat.and_then(|coat| coat.get(key)?.as_f64()).unwrap_or(0.0) as f32;
        let reflected = ((ior - 1.0) / (ior + 1.0)).powi(2);
        Ok(PrincipledParameters {
            base_color,
            metallic: share(pbr.metallic_factor()),
            roughness: share(pbr.roughness_factor()),
            // the reflectance at normal incidence is 0.08·specular
            specular: share(strength * reflected / 0.08),
            clearcoat: share(coat("clearcoatFactor")),
            clearcoat_gloss: share(1.0 - coat("clearcoatRoughnessFactor")),
            maps,
            ..PrincipledParameters::default()
        }
        .into())
    }

    /// A pane, or a body where there is `KHR_materials_volume`.
    fn glass(&mut self, material: &Material, name: &str, ior: f32, base_color: &ColorTexture) -> BsdfDescription {
        let transmittance = match base_color {
            ColorTexture::Constant(color) => *color,
            _ => {
                self.warnings.add(format!("material `{name}`: glass has no picture: it is clear"));
                Rgb::ONE
            }
        };
        let body = material.volume().is_some_and(|volume| volume.thickness_factor() > 0.0);
        if body {
            self.warnings.add(format!("material `{name}`: light is not absorbed within glass"));
        }
        let roughness = material.pbr_metallic_roughness().roughness_factor().clamp(0.0, 1.0);
        let alpha = roughness * roughness;
        if !body && alpha > 0.01 {
            self.warnings.add(format!("material `{name}`: a pane is smooth, whatever its roughness"));
        }
        let alpha = if body { alpha } else { 0.0 };
        DielectricParameters {
            int_ior: ior,
            specular_transmittance: transmittance,
            thin: !body,
            alpha,
            ..Default::default()
        }
        .into()
    }

    fn opacity(&mut self, material: &Material) -> Result<Option<ScalarTexture>> {
        let mode = material.alpha_mode();
        if mode == AlphaMode::Opaque {
            return Ok(None);
        }
        let pbr = material.pbr_metallic_roughness();
        let factor = pbr.base_color_factor()[3].clamp(0.0, 1.0);
        let cutoff = (mode == AlphaMode::Mask).then(|| material.alpha_cutoff().unwrap_or(0.5));
        let decided = |alpha: f32| cutoff.map_or(alpha, |cutoff| if alpha >= cutoff { 1.0 } else { 0.0 });
        let constant = || Ok(Some(ScalarTexture::Constant(decided(factor))));
        let Some(info) = pbr.base_color_texture() else { return constant() };
        let image = self.info(&info, Rgb::ONE)?;
        let picture = picture_at(&image.path, &self.pictures)?;
        let Some(alpha) = alpha(&picture) else { return constant() };
        let values = alpha.into_iter().map(|alpha| (decided(alpha * factor) * 255.0).round() as u8).collect();
        let samples = Samples::U8(values, srgb::DECODE_8.clone());
        let picture = Picture { channels: 1, samples, notes: Vec::new(), ..picture };
        let label = format!("{}#alpha of material {}", self.buffers.path.display(), material.index().unwrap_or(0));
        let path = PathBuf::from(label);
        self.pictures.insert(path.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        Ok(Some(ScalarTexture::Luminance(ImageTexture { path, ..image })))
    }

    fn use_set(&mut self, set: u32) {
        if *self.uv_set.get_or_insert(set) != set {
            self.warnings.add("pictures of one material take one set of texture coordinates: that of the first");
        }
    }

    fn info(&mut self, info: &Info, tint: Rgb) -> Result<ImageTexture> {
        let transform = info.texture_transform();
        self.use_set(transform.as_ref().and_then(TextureTransform::tex_coord).unwrap_or(info.tex_coord()));
        self.image(&info.texture(), transform, tint)
    }

    /// v counts from above there, and from below here: 1 − v.
    fn image(&mut self, texture: &Texture, transform: Option<TextureTransform>, tint: Rgb) -> Result<ImageTexture> {
        let (mut scale, mut offset) = ([1.0; 2], [0.0; 2]);
        if let Some(transform) = transform {
            (scale, offset) = (transform.scale(), transform.offset());
            if transform.rotation() != 0.0 {
                self.warnings.add("a turned texture is not known here: it is only scaled and moved");
            }
        }
        let sampler = texture.sampler();
        let wraps = [sampler.wrap_s(), sampler.wrap_t()];
        let clamped = wraps.map(|wrap| wrap == WrappingMode::ClampToEdge);
        if clamped[0] != clamped[1] {
            self.warnings.add("a picture repeats in both directions or in none");
        }
        let mut image = ImageTexture {
            scale,
            offset: [offset[0], 1.0 - scale[1] - offset[1]],
            nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
            clamp: clamped == [true; 2],
            tint,
            ..ImageTexture::new(self.picture(texture)?)
        };
        let mirrored = wraps.map(|wrap| wrap == WrappingMode::MirroredRepeat);
        if mirrored != [false; 2] {
            image.mirror(mirrored, &mut self.pictures)?;
        }
        Ok(image)
    }

    /// The file of a picture, or the path that stands for one that is in the file itself.
    fn picture(&mut self, texture: &Texture) -> Result<PathBuf> {
        let path = self.buffers.path;
        let image = texture.source();
        let label = || PathBuf::from(format!("{}#image {}", path.display(), image.index()));
        let bytes = match image.source() {
            gltf::image::Source::View { view, .. } => self.buffers.view(&view)?.to_vec(),
            gltf::image::Source::Uri { uri, .. } => match parsed(uri, path)? {
                Uri::File(file) => return Ok(file),
                Uri::Data(bytes) => bytes,
            },
        };
        if bytes.is_empty() {
            return Err(Error::file(path, format!("image {} is empty", image.index())));
        }
        self.pictures.entry(label()).or_insert_with(|| Arc::new(EmbeddedPicture::Encoded(bytes)));
        Ok(label())
    }
}

/// The alpha channel, from 0 to 1.
fn alpha(picture: &Picture) -> Option<Vec<f32>> {
    let step = picture.channels;
    if !step.is_multiple_of(2) {
        return None;
    }
    let at = |k: usize| k * step + step - 1;
    let pixels = 0..picture.width * picture.height;
    Some(match &picture.samples {
        Samples::U8(values, _) => pixels.map(|k| f32::from(values[at(k)]) / 255.0).collect(),
        Samples::U16(values, _) => pixels.map(|k| f32::from(values[at(k)]) / 65535.0).collect(),
        Samples::F32(values) => pixels.map(|k| values[at(k)].clamp(0.0, 1.0)).collect(),
    })
}
