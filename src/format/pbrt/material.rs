//! Materials, and which mesh is made of which.

use super::light::emitted;
use super::parameters::{Parameters, Values};
use super::shape::{Alpha, Shape};
use super::spectrum::Role;
use super::texture::{Found, Textures, scalar};
use super::world::{MaterialRef, World};
use crate::Result;
use crate::bsdf::{
    BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, DiffuseTransmitterParameters,
    MicrofacetDistribution, NullParameters, PlasticParameters,
};
use crate::format::mitsuba::bsdf::mixed;
use crate::format::mitsuba::metals;
use crate::image::picture;
use crate::math::{Rgb, luminance};
use crate::scene::description::{MaterialDescription, MeshDescription, SceneDescription};
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::rc::Rc;

/// Materials may be within each other so deep.
const DEEPEST: usize = 16;

/// α below this is a smooth surface, as there.
const SMOOTH: f32 = 1e-3;

/// What tells apart what shapes are made of: material, light and the area that it is spread over, and what they let through.
type Key = (*const Parameters, *const Parameters, u64, String);

/// Reads materials.
pub(super) struct Materials<'a> {
    pub(crate) world: &'a World,
    pub(crate) textures: &'a Textures<'a>,
    /// Names of materials that have been described.
    names: HashMap<Key, String>,
}

impl<'a> Materials<'a> {
    pub(crate) fn new(world: &'a World, textures: &'a Textures<'a>) -> Materials<'a> {
        Materials { world, textures, names: HashMap::new() }
    }

    /// Puts all shapes into the scene, with what they are made of.
    pub(crate) fn place(mut self, scene: &mut SceneDescription) -> Result<()> {
        for shape in &self.world.shapes {
            let material = Some(self.name(shape, scene)?);
            scene.meshes.push(MeshDescription {
                source: shape.source.clone(),
                transform: shape.transform,
                material,
                material_location: Some(shape.at.clone()),
                group: shape.object.clone(),
                location: Some(shape.at.clone()),
            });
        }
        Ok(())
    }

    /// The name of what the shape is made of, which is described under it.
    fn name(&mut self, shape: &Shape, scene: &mut SceneDescription) -> Result<String> {
        let (name, parameters) = self.referred(&shape.material)?;
        let light = shape.area_light.as_ref().map_or(std::ptr::null(), Rc::as_ptr);
        let area = shape.area.filter(|_| !light.is_null()).unwrap_or(0.0).to_bits();
        let key = (Rc::as_ptr(&parameters), light, area, format!("{:?}", shape.alpha));
        if let Some(name) = self.names.get(&key) {
            return Ok(name.clone());
        }
        let mut material = self.nested(&parameters, 0)?;
        self.let_through(shape, &mut material)?;
        let mut name = name.unwrap_or_else(|| format!("material in line {}", parameters.at.line));
        if self.emission(shape, &mut material)? {
            name += " light";
        }
        let known = &scene.materials;
        let usable = |name: &String| known.get(name).is_none_or(|known| *known == material);
        let name = (1..).map(|k| if k == 1 { name.clone() } else { format!("{name} ({k})") }).find(usable);
        let name = name.unwrap_or_default();
        scene.materials.insert(name.clone(), material);
        self.names.insert(key, name.clone());
        Ok(name)
    }

    fn referred(&self, material: &MaterialRef) -> Result<(Option<String>, Rc<Parameters>)> {
        match material {
            MaterialRef::Own(parameters) => Ok((None, parameters.clone())),
            MaterialRef::Named(name, at) => match self.world.materials.get(name) {
                Some(parameters) => Ok((Some(name.clone()), parameters.clone())),
                None => Err(at.error(format!("there is no material \"{name}\""))),
            },
        }
    }

    fn let_through(&self, shape: &Shape, material: &mut MaterialDescription) -> Result<()> {
        let opacity = match &shape.alpha {
            Alpha::Opaque => return Ok(()),
            Alpha::Constant(alpha) if *alpha >= 1.0 => return Ok(()),
            Alpha::Constant(alpha) => ScalarTexture::Constant(alpha.max(0.0) as f32),
            Alpha::Texture(name, at) => scalar(self.textures.named(name, true, at, 0)?),
        };
        if matches!(material.bsdf, BsdfDescription::Null(_)) {
            return Ok(());
        }
        if material.opacity.replace(opacity).is_some() {
            self.world.warnings.add(&shape.at, "`alpha` counts, and the opacity of the material does not");
        }
        Ok(())
    }

    /// Whether the shape shines.
    fn emission(&self, shape: &Shape, material: &mut MaterialDescription) -> Result<bool> {
        let Some(p) = &shape.area_light else { return Ok(false) };
        let dark = |why: &str| {
            self.world.warnings.add(&shape.at, format!("{why}, as in pbrt: this shape does not shine"));
            Ok(false)
        };
        if shape.object.is_some() {
            return dark("objects have no lights");
        }
        if matches!(material.bsdf, BsdfDescription::Null(_)) {
            return dark("what is no surface has no light");
        }
        if !matches!(p.plugin.as_str(), "diffuse" | "area") {
            return Err(p.error(format!("the area light \"{}\" has no counterpart", p.plugin)));
        }
        let two_sided = p.flag("twosided", false)?;
        let mut emission = emitted(self.world, p, "L")?;
        let image = p.text("filename")?.map(|name| ImageTexture::new(self.world.file(name)));
        if let Some(power) = p.maybe_number("power")?.filter(|&power| power > 0.0) {
            let area = shape.area.ok_or_else(|| {
                shape.at.error(
                    "the `power` of its light is that of each triangle, which differ or stand in a file: say `L`",
                )
            })?;
            let mean = image.as_ref().map_or(Ok(1.0), mean_luminance)?;
            let sides = if two_sided { 2.0 } else { 1.0 };
            emission *= (power / (sides * area * PI * mean)) as f32;
        }
        p.finish(&self.world.warnings);
        if !emission.is_finite() || emission == Rgb::ZERO {
            return Ok(false);
        }
        (material.emission, material.emission_map, material.emission_two_sided) = (emission, image, two_sided);
        Ok(true)
    }

    /// One material, which others may be within.
    fn nested(&self, p: &Rc<Parameters>, depth: usize) -> Result<MaterialDescription> {
        if depth > DEEPEST {
            return Err(p.error("this material is within itself"));
        }
        if p.plugin == "mix" {
            let mixed = self.mix(p, depth)?;
            p.finish(&self.world.warnings);
            return Ok(mixed);
        }
        let mut material = self.single(p)?;
        material.relief = self.relief(p)?;
        p.ignore(&["type"]);
        p.finish(&self.world.warnings);
        Ok(material)
    }

    pub(crate) fn replaced(&self, p: &Parameters, what: &str) {
        self.world.warnings.add(&p.at, format!("the material \"{}\" has no counterpart: {what}", p.plugin));
    }

    fn mix(&self, p: &Rc<Parameters>, depth: usize) -> Result<MaterialDescription> {
        let found = match p.find("materials").map(|found| &found.values) {
            Some(Values::Texts(names)) => names.clone(),
            _ => {
                let names = [p.text("namedmaterial1")?, p.text("namedmaterial2")?];
                names.into_iter().flatten().map(str::to_string).collect()
            }
        };
        let [first, second] = &found[..] else { return Err(p.error("a \"mix\" needs the names of two materials")) };
        let part = |name: &String| {
            let (_, parameters) = self.referred(&MaterialRef::Named(name.clone(), p.at.clone()))?;
            self.nested(&parameters, depth + 1)
        };
        let (first, second) = (part(first)?, part(second)?);
        let amount = match self.textures.found(p, "amount", !self.world.old)? {
            None => ScalarTexture::Constant(0.5),
            Some(Found::Constant(color)) => ScalarTexture::Constant(luminance(color).clamp(0.0, 1.0)),
            // as numbers, also where version 3 has colours
            Some(Found::Image(_)) => {
                self.textures.found(p, "amount", true)?.map_or(ScalarTexture::Constant(0.5), scalar)
            }
        };
        // version 3 counts the first one's share
        let [one, other] = if self.world.old { [second, first] } else { [first, second] };
        if let ScalarTexture::Constant(share) = amount
            && let Some(mixed) = mixed(&one, &other, share)
        {
            return Ok(mixed);
        }
        Ok(MaterialDescription::blend(amount, [one, other]))
    }

    fn relief(&self, p: &Parameters) -> Result<Option<ReliefTexture>> {
        if let Some(name) = p.text("normalmap")? {
            let image = ImageTexture::new(self.world.file(name));
            return Ok(Some(ReliefTexture { image, kind: ReliefKind::Normals, strength: 1.0 }));
        }
        let Some((_, name)) = p.first_of(&["displacement", "bumpmap"]) else { return Ok(None) };
        match self.textures.found(p, name, true)? {
            Some(Found::Image(image)) => {
                let strength = luminance(image.tint);
                let image = ImageTexture { tint: Rgb::ONE, ..image };
                Ok(Some(ReliefTexture { image, kind: ReliefKind::Heights, strength }))
            }
            _ => Ok(None),
        }
    }

    fn single(&self, p: &Rc<Parameters>) -> Result<MaterialDescription> {
        let textures = self.textures;
        let bsdf: BsdfDescription = match p.plugin.as_str() {
            "diffuse" => DiffuseParameters { reflectance: textures.color(p, "reflectance", 0.5)? }.into(),
            "coateddiffuse" => self.coated(p)?.into(),
            "conductor" => self.conductor(p, "")?.into(),
            "coatedconductor" => {
                self.replaced(p, "the conductor is taken without its coat");
                p.ignore(&["interface.roughness", "interface.uroughness", "interface.vroughness", "interface.eta"]);
                p.ignore(&["thickness", "g", "albedo", "maxdepth", "nsamples"]);
                self.conductor(p, "conductor.")?.into()
            }
            "dielectric" => {
                let alpha = self.alpha(p, "", 0.0)?;
                DielectricParameters { int_ior: self.index(p, &["eta"])?, alpha, ..Default::default() }.into()
            }
            "thindielectric" => {
                DielectricParameters { int_ior: self.index(p, &["eta"])?, thin: true, ..Default::default() }.into()
            }
            "diffusetransmission" => self.transmission(p)?.into(),
            "subsurface" => {
                self.replaced(p, "its surface is taken for \"coateddiffuse\"");
                p.ignore(&["name", "sigma_a", "sigma_s", "mfp", "g", "scale"]);
                let reflectance = textures.color(p, "reflectance", 0.7)?;
                PlasticParameters { reflectance, ..self.coated(p)? }.into()
            }
            "interface" | "none" | "" => NullParameters.into(),
            _ => return self.legacy(p),
        };
        Ok(MaterialDescription { bsdf, ..MaterialDescription::default() })
    }

    /// A diffuse base under a coat, all colour shifts by scattering between them included.
    fn coated(&self, p: &Parameters) -> Result<PlasticParameters> {
        if self.textures.constant(p, "albedo", Rgb::ZERO)? != Rgb::ZERO {
            self.world.warnings.add(&p.at, "nothing scatters light within a coat here");
        }
        p.ignore(&["thickness", "g", "maxdepth", "nsamples"]);
        Ok(PlasticParameters {
            reflectance: self.textures.color(p, "reflectance", 0.5)?,
            int_ior: self.index(p, &["eta"])?,
            alpha: self.alpha(p, "", 0.0)?,
            nonlinear: true,
            ..PlasticParameters::default()
        })
    }

    /// A metal by its indices or by what it reflects at right angles.
    pub(crate) fn conductor(&self, p: &Parameters, prefix: &str) -> Result<ConductorParameters> {
        let (alpha, distribution) = (self.alpha(p, prefix, 0.0)?, MicrofacetDistribution::Ggx);
        let plain = ConductorParameters { alpha, distribution, ..ConductorParameters::default() };
        let (eta, k) = (format!("{prefix}eta"), format!("{prefix}k"));
        match self.textures.maybe_color(p, "reflectance")? {
            // η = 1 and this k reflect it
            Some(ColorTexture::Constant(color)) => {
                let color = color.clamp(Rgb::ZERO, Rgb::splat(0.9999));
                let k = (color / (Rgb::ONE - color)).map(f32::sqrt) * 2.0;
                Ok(ConductorParameters { eta_k: Some((Rgb::ONE, k)), ..plain })
            }
            Some(picture) => Ok(ConductorParameters { specular_reflectance: picture, ..plain }),
            None => {
                let (copper_eta, copper_k) = metals::known("Cu").unwrap_or_default();
                let eta = self.textures.constant(p, &eta, copper_eta)?;
                let k = self.textures.constant(p, &k, copper_k)?;
                // η of 0 is a singular case of Fresnel's formula
                Ok(ConductorParameters { eta_k: Some((eta.max(Rgb::splat(1e-4)), k)), ..plain })
            }
        }
    }

    fn transmission(&self, p: &Parameters) -> Result<DiffuseTransmitterParameters> {
        let scale = p.number("scale", 1.0)? as f32;
        let scaled = |texture: ColorTexture| match texture {
            ColorTexture::Constant(color) => ColorTexture::Constant((color * scale).clamp(Rgb::ZERO, Rgb::ONE)),
            ColorTexture::Image(image) => ColorTexture::Image(ImageTexture { tint: image.tint * scale, ..image }),
            other => other,
        };
        Ok(DiffuseTransmitterParameters {
            reflectance: scaled(self.textures.color(p, "reflectance", 0.25)?),
            transmittance: scaled(self.textures.color(p, "transmittance", 0.25)?),
        })
    }

    /// An index of refraction under one of these names: a number, or a spectrum, of which the mean counts.
    pub(crate) fn index(&self, p: &Parameters, names: &[&str]) -> Result<f32> {
        let Some((_, name)) = p.first_of(names) else { return Ok(1.5) };
        let index = match self.world.color(p, name, Role::Reflectance)? {
            Some(color) => color.element_sum() / 3.0,
            None => self.textures.number(p, name, 1.5)?,
        };
        if index > 0.0 { Ok(index) } else { Err(p.error(format!("`{name}` must be greater than 0"))) }
    }

    /// α of a rough surface; 0 where it is smooth.
    pub(crate) fn alpha(&self, p: &Parameters, prefix: &str, default: f32) -> Result<f32> {
        let name = |name: &str| format!("{prefix}{name}");
        let both = self.textures.number(p, &name("roughness"), default)?;
        let [u, v] = ["uroughness", "vroughness"].map(|direction| self.textures.number(p, &name(direction), both));
        let remaps = p.flag("remaproughness", true)?;
        let alpha = |roughness: f32| match remaps {
            false => roughness,
            true if self.world.old => remapped(roughness),
            true => roughness.sqrt(),
        };
        let (u, v) = (alpha(u?.max(0.0)), alpha(v?.max(0.0)));
        let alpha = 0.5 * (u + v);
        if u != v {
            let message =
                format!("α of {u} along u and of {v} along v has no counterpart: the mean, {alpha}, is taken");
            self.world.warnings.add(&p.at, message);
        }
        Ok(if alpha < SMOOTH { 0.0 } else { alpha.min(1.0) })
    }
}

/// α of a roughness between 0 and 1, as version 3 has it.
fn remapped(roughness: f32) -> f32 {
    let x = roughness.max(1e-3).ln();
    1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
}

fn mean_luminance(image: &ImageTexture) -> Result<f64> {
    let colors = picture::load(&image.path)?.colors();
    let sum: f64 = colors.iter().map(|color| f64::from(luminance(*color))).sum();
    Ok((sum / colors.len() as f64).max(f64::MIN_POSITIVE))
}
