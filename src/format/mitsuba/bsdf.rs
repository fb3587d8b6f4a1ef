//! Materials.

use super::metals;
use super::texture::{TURNED, Textures};
use crate::Result;
use crate::bsdf::{
    BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, DiffuseTransmitterParameters,
    MicrofacetDistribution, NullParameters, PlasticParameters, PrincipledMaps, PrincipledParameters,
};
use crate::format::xml::color;
use crate::format::xml::object::{Object, Objects};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use std::rc::Rc;

/// BSDFs may be within each other so deep.
const DEEPEST: usize = 16;

/// Reads materials.
pub(crate) struct Materials<'a> {
    pub(crate) objects: &'a Objects,
    pub(crate) textures: &'a Textures<'a>,
}

impl Materials<'_> {
    /// The material of a shape that says nothing of it: a lamp reflects nothing.
    pub(crate) fn default_material(shines: bool) -> MaterialDescription {
        one_sided(DiffuseParameters { reflectance: ColorTexture::grey(if shines { 0.0 } else { 0.5 }) })
    }

    pub(crate) fn material(&self, bsdf: &Rc<Object>) -> Result<MaterialDescription> {
        self.nested(bsdf, 0)
    }

    fn nested(&self, bsdf: &Rc<Object>, depth: usize) -> Result<MaterialDescription> {
        if depth > DEEPEST {
            return Err(bsdf.error("this bsdf is within itself"));
        }
        let inner = || {
            let found = self.objects.child(bsdf, "bsdf")?;
            let found = found.ok_or_else(|| bsdf.error(format!("the {} needs another bsdf", bsdf.label())))?;
            self.nested(&found, depth + 1)
        };
        let material = match bsdf.kind.as_str() {
            "twosided" => {
                if self.objects.children(bsdf, "bsdf")?.len() > 1 {
                    self.objects.warn(&bsdf.at, "both sides have the first bsdf of this `twosided`");
                }
                changed(inner()?, |single| single.two_sided = true)
            }
            "mask" => {
                let opacity = self.textures.scalar(bsdf, "opacity", 0.5)?;
                MaterialDescription { opacity: Some(opacity), ..inner()? }
            }
            "bumpmap" => {
                let relief = self.relief(bsdf, ReliefKind::Heights)?;
                changed(inner()?, |single| single.relief.clone_from(&relief))
            }
            "normalmap" => {
                let relief = self.relief(bsdf, ReliefKind::Normals)?;
                changed(inner()?, |single| single.relief.clone_from(&relief))
            }
            "blendbsdf" => self.blend(bsdf, depth)?,
            "mixturebsdf" => self.mixture(bsdf, depth)?,
            "coating" | "roughcoating" => {
                self.replaced(bsdf, "what it coats is taken without the coat");
                bsdf.ignore(&[
                    "int_ior",
                    "ext_ior",
                    "thickness",
                    "sigma_a",
                    "alpha",
                    "distribution",
                    "specular_reflectance",
                ]);
                inner()?
            }
            _ => self.single(bsdf)?,
        };
        self.objects.finish(bsdf);
        Ok(material)
    }

    fn replaced(&self, bsdf: &Object, what: &str) {
        self.objects.warn(&bsdf.at, format!("the {} has no counterpart: {what}", bsdf.label()));
    }

    /// The picture of heights or of normals.
    fn relief(&self, bsdf: &Object, kind: ReliefKind) -> Result<Option<ReliefTexture>> {
        let missing = || bsdf.error(format!("the {} needs a texture", bsdf.label()));
        let texture = self.objects.child(bsdf, "texture")?.ok_or_else(missing)?;
        let image = self.textures.picture(&texture)?;
        if kind == ReliefKind::Normals && image.path.to_string_lossy().ends_with(TURNED) {
            self.objects.warn(&texture.at, "the normals in a turned picture are as if it were not turned");
        }
        let tinted = f64::from(crate::math::luminance(image.tint));
        let strength = (bsdf.number("scale", 1.0)? * tinted) as f32;
        bsdf.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
        Ok(Some(ReliefTexture { image: ImageTexture { tint: Rgb::ONE, ..image }, kind, strength }))
    }

    /// Two materials side by side. Constant diffuse ones are one diffuse one; beside nothing the other is partly there.
    fn blend(&self, bsdf: &Rc<Object>, depth: usize) -> Result<MaterialDescription> {
        let children = self.objects.children(bsdf, "bsdf")?;
        let [(_, first), (_, second)] = &children[..] else {
            return Err(bsdf.error("`blendbsdf` needs two bsdfs"));
        };
        let weight = self.textures.scalar(bsdf, "weight", 0.5)?;
        let (first, second) = (self.nested(first, depth + 1)?, self.nested(second, depth + 1)?);
        if let ScalarTexture::Constant(share) = weight
            && let Some(mixed) = mixed(&first, &second, share)
        {
            return Ok(mixed);
        }
        match (&first.bsdf, &second.bsdf, &weight) {
            (BsdfDescription::Null(_), _, _) if second.opacity.is_none() => {
                return Ok(MaterialDescription { opacity: Some(weight), ..second });
            }
            (_, BsdfDescription::Null(_), &ScalarTexture::Constant(share)) if first.opacity.is_none() => {
                return Ok(MaterialDescription { opacity: Some(ScalarTexture::Constant(1.0 - share)), ..first });
            }
            _ => (),
        }
        Ok(MaterialDescription::blend(weight, [first, second]))
    }

    /// Several materials with the weights that a string says, blend by blend. Weights that are less than 1 together absorb the rest.
    fn mixture(&self, bsdf: &Rc<Object>, depth: usize) -> Result<MaterialDescription> {
        let children = self.objects.children(bsdf, "bsdf")?;
        let weights = color::numbers(bsdf.text("weights")?.unwrap_or_default()).unwrap_or_default();
        if children.is_empty() || weights.len() != children.len() || weights.iter().any(|weight| *weight < 0.0) {
            return Err(bsdf.error("`mixturebsdf` needs as many `weights`, of 0 or more, as it has bsdfs"));
        }
        let mut parts = Vec::new();
        for (_, child) in &children {
            parts.push(self.nested(child, depth + 1)?);
        }
        let mut weights = weights;
        let sum: f64 = weights.iter().sum();
        if sum > 1.0 {
            // as there
            self.objects.warn(&bsdf.at, "`weights` are more than 1 together and are divided by their sum");
        } else if sum < 1.0 - 1e-6 {
            parts.push(one_sided(DiffuseParameters { reflectance: ColorTexture::grey(0.0) }));
            weights.push(1.0 - sum);
        }
        Ok(blended(parts, &weights))
    }

    fn single(&self, bsdf: &Rc<Object>) -> Result<MaterialDescription> {
        bsdf.ignore(&["sample_visible", "specular_sampling_weight", "diffuse_sampling_weight"]);
        Ok(match bsdf.kind.as_str() {
            "diffuse" => one_sided(self.diffuse(bsdf)?),
            "roughdiffuse" | "oren_nayar" => {
                self.replaced(bsdf, "`diffuse` of its reflectance is taken");
                bsdf.ignore(&["alpha", "use_fast_approx"]);
                one_sided(self.diffuse(bsdf)?)
            }
            "difftrans" => {
                let transmittance = self.textures.color(bsdf, "transmittance", 0.5)?;
                one_sided(DiffuseTransmitterParameters { reflectance: ColorTexture::grey(0.0), transmittance })
            }
            "conductor" => one_sided(self.conductor(bsdf, false)?),
            "roughconductor" => one_sided(self.conductor(bsdf, true)?),
            "dielectric" => one_sided(self.dielectric(bsdf, false)?),
            "thindielectric" => one_sided(DielectricParameters { thin: true, ..self.dielectric(bsdf, false)? }),
            "roughdielectric" => one_sided(self.dielectric(bsdf, true)?),
            "plastic" => one_sided(self.plastic(bsdf, false)?),
            "roughplastic" => one_sided(self.plastic(bsdf, true)?),
            "phong" => {
                self.replaced(bsdf, "`roughplastic` with a highlight of about its width is taken");
                one_sided(self.phong(bsdf)?)
            }
            "principled" => self.principled(bsdf)?,
            "null" => one_sided(NullParameters),
            kind => return Err(bsdf.error(format!("the bsdf `{kind}` has no counterpart, and no other looks like it"))),
        })
    }

    fn diffuse(&self, bsdf: &Object) -> Result<DiffuseParameters> {
        let name = if bsdf.find("diffuse_reflectance").is_some() { "diffuse_reflectance" } else { "reflectance" };
        Ok(DiffuseParameters { reflectance: self.textures.color(bsdf, name, 0.5)? })
    }

    /// α of a rough surface, and its distribution.
    fn roughness(&self, bsdf: &Object) -> Result<(f32, MicrofacetDistribution)> {
        let distribution = match bsdf.text("distribution")? {
            None | Some("beckmann") => MicrofacetDistribution::Beckmann,
            Some("ggx") => MicrofacetDistribution::Ggx,
            Some(other) => {
                self.objects
                    .warn(&bsdf.at, format!("the distribution `{other}` has no counterpart: Beckmann's is taken"));
                MicrofacetDistribution::Beckmann
            }
        };
        let (u, v) = (bsdf.find("alpha_u").is_some(), bsdf.find("alpha_v").is_some());
        let alpha = if u || v {
            let [u, v] = [self.textures.number(bsdf, "alpha_u", 0.1)?, self.textures.number(bsdf, "alpha_v", 0.1)?];
            let mean = 0.5 * (u + v);
            if u != v {
                let message =
                    format!("α of {u} along u and of {v} along v has no counterpart: the mean, {mean}, is taken");
                self.objects.warn(&bsdf.at, message);
            }
            mean
        } else {
            self.textures.number(bsdf, "alpha", 0.1)?
        };
        // a smooth surface is another model there, and α below this is none here
        Ok((alpha.clamp(1e-4, 1.0), distribution))
    }

    fn conductor(&self, bsdf: &Object, rough: bool) -> Result<ConductorParameters> {
        let own = bsdf.find("eta").is_some() || bsdf.find("k").is_some();
        let name = bsdf.text("material")?;
        let eta_k = match name {
            Some(name) => metals::metal(bsdf, name)?,
            None if own => Some((bsdf.color("eta", Rgb::ZERO)?, bsdf.color("k", Rgb::ONE)?)),
            None if self.objects.is_old() => metals::metal(bsdf, "Cu")?,
            None => None,
        };
        let outside =
            metals::index(bsdf, if bsdf.find("ext_eta").is_some() { "ext_eta" } else { "ext_ior" }, "vacuum")?;
        // η of 0 is a singular case of Fresnel's formula
        let eta_k = eta_k.map(|(eta, k)| ((eta / outside).max(Rgb::splat(1e-4)), k / outside));
        let specular_reflectance = self.textures.color(bsdf, "specular_reflectance", 1.0)?;
        let (alpha, distribution) = if rough { self.roughness(bsdf)? } else { (0.0, MicrofacetDistribution::Ggx) };
        Ok(ConductorParameters { eta_k, specular_reflectance, alpha, distribution, energy_conserving: false })
    }

    fn dielectric(&self, bsdf: &Object, rough: bool) -> Result<DielectricParameters> {
        let (alpha, distribution) = if rough { self.roughness(bsdf)? } else { (0.0, MicrofacetDistribution::Ggx) };
        Ok(DielectricParameters {
            int_ior: metals::index(bsdf, "int_ior", "bk7")?,
            ext_ior: metals::index(bsdf, "ext_ior", "air")?,
            specular_reflectance: self.textures.constant(bsdf, "specular_reflectance", 1.0)?,
            specular_transmittance: self.textures.constant(bsdf, "specular_transmittance", 1.0)?,
            alpha,
            distribution,
            thin: false,
        })
    }

    fn plastic(&self, bsdf: &Object, rough: bool) -> Result<PlasticParameters> {
        let (alpha, distribution) = if rough { self.roughness(bsdf)? } else { (0.0, MicrofacetDistribution::Ggx) };
        Ok(PlasticParameters {
            reflectance: self.textures.color(bsdf, "diffuse_reflectance", 0.5)?,
            specular_reflectance: self.textures.constant(bsdf, "specular_reflectance", 1.0)?,
            int_ior: metals::index(bsdf, "int_ior", "polypropylene")?,
            ext_ior: metals::index(bsdf, "ext_ior", "air")?,
            alpha,
            distribution,
            nonlinear: bsdf.flag("nonlinear", false)?,
            energy_conserving: false,
            additive: false,
        })
    }

    /// α = √(2/(e + 2)) of an exponent e (Walter et al. 2007, §5.2).
    fn phong(&self, bsdf: &Object) -> Result<PlasticParameters> {
        let exponent = self.textures.number(bsdf, "exponent", 30.0)?;
        bsdf.ignore(&["specular_reflectance"]);
        let reflectance = self.textures.color(bsdf, "diffuse_reflectance", 0.5)?;
        let distribution = MicrofacetDistribution::Beckmann;
        Ok(PlasticParameters {
            reflectance,
            alpha: (2.0 / (exponent + 2.0)).sqrt(),
            distribution,
            ..Default::default()
        })
    }

    fn principled(&self, bsdf: &Object) -> Result<MaterialDescription> {
        let transmitted = self.textures.scalar(bsdf, "spec_trans", 0.0)?;
        let opaque = self.principled_opaque(bsdf)?;
        match transmitted {
            ScalarTexture::Constant(share) if share <= 0.0 => Ok(one_sided(opaque)),
            transmitted => self.principled_transmissive(bsdf, transmitted, opaque),
        }
    }

    /// The model is m·metal + (1 − m)·((1 − t)·opaque + t·glass): all but its diffuse base is the same with and without transmission t, and
    /// what reflects at the interface of glass is what reflects at that of an opaque dielectric.
    fn principled_transmissive(
        &self,
        bsdf: &Object,
        transmitted: ScalarTexture,
        opaque: PrincipledParameters,
    ) -> Result<MaterialDescription> {
        if [opaque.clearcoat, opaque.sheen, opaque.spec_tint].iter().any(|share| *share > 0.0) {
            let message = "`clearcoat`, `sheen` and `spec_tint` of `principled` are left out where `spec_trans` lets light through";
            self.objects.warn(&bsdf.at, message);
        }
        let of_metallic = |metallic: f32| {
            let maps = PrincipledMaps { metallic: None, ..opaque.maps.clone() };
            one_sided(PrincipledParameters { metallic, maps, ..opaque.clone() })
        };
        let glass = self.principled_glass(bsdf)?;
        let dielectric = match transmitted {
            ScalarTexture::Constant(share) if share >= 1.0 => glass,
            share => MaterialDescription::blend(share, [of_metallic(0.0), glass]),
        };
        match opaque.maps.metallic.clone().unwrap_or(ScalarTexture::Constant(opaque.metallic)) {
            ScalarTexture::Constant(share) if share <= 0.0 => Ok(dielectric),
            share => Ok(MaterialDescription::blend(share, [dielectric, of_metallic(1.0)])),
        }
    }

    fn principled_opaque(&self, bsdf: &Object) -> Result<PrincipledParameters> {
        let base_color = self.textures.color(bsdf, "base_color", 0.5)?;
        for name in ["anisotropic", "flatness"] {
            if self.textures.number(bsdf, name, 0.0)? != 0.0 {
                self.objects.warn(&bsdf.at, format!("`{name}` of `principled` has no counterpart: 0 is taken"));
            }
        }
        bsdf.ignore(&["diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"]);
        let share = |name: &str, default: f32| self.textures.number(bsdf, name, default).map(|x| x.clamp(0.0, 1.0));
        let mut maps = PrincipledMaps::NONE;
        let split = |name: &str, default: f32, map: &mut Option<ScalarTexture>| -> Result<f32> {
            Ok(match self.textures.scalar(bsdf, name, default)? {
                ScalarTexture::Constant(number) => number.clamp(0.0, 1.0),
                picture => {
                    *map = Some(picture);
                    default
                }
            })
        };
        let metallic = split("metallic", 0.0, &mut maps.metallic)?;
        let roughness = split("roughness", 0.5, &mut maps.roughness)?;
        let specular = match bsdf.maybe_number("eta")? {
            // the reflectance at normal incidence is 0.08·specular
            Some(eta) => ((((eta - 1.0) / (eta + 1.0)).powi(2) / 0.08) as f32).clamp(0.0, 1.0),
            None => split("specular", 0.5, &mut maps.specular)?,
        };
        Ok(PrincipledParameters {
            base_color,
            metallic,
            roughness,
            specular,
            spec_tint: share("spec_tint", 0.0)?,
            clearcoat: share("clearcoat", 0.0)?,
            clearcoat_gloss: share("clearcoat_gloss", 0.0)?,
            sheen: share("sheen", 0.0)?,
            sheen_tint: share("sheen_tint", 0.0)?,
            energy_conserving: false,
            maps,
        })
    }

    /// What it is where all light that is not reflected goes through: rough glass that takes the root of the colour at each crossing.
    fn principled_glass(&self, bsdf: &Object) -> Result<MaterialDescription> {
        let base_color = self.textures.constant(bsdf, "base_color", 0.5)?;
        let roughness = self.textures.number(bsdf, "roughness", 0.5)?;
        let specular = self.textures.number(bsdf, "specular", 0.5)?;
        let of_specular = f64::from(2.0 / (1.0 - (0.08 * specular.clamp(0.0, 1.0)).sqrt()) - 1.0);
        Ok(one_sided(DielectricParameters {
            int_ior: bsdf.number("eta", of_specular)? as f32,
            specular_transmittance: base_color.max(Rgb::ZERO).map(f32::sqrt),
            // as rough as it is there at least
            alpha: (roughness * roughness).clamp(1e-3, 1.0),
            ..DielectricParameters::default()
        }))
    }
}

/// Black from behind.
pub(crate) fn one_sided(bsdf: impl Into<BsdfDescription>) -> MaterialDescription {
    MaterialDescription { bsdf: bsdf.into(), two_sided: false, ..MaterialDescription::default() }
}

/// The same with a change to all that it is mixed of.
fn changed(mut material: MaterialDescription, mut change: impl FnMut(&mut MaterialDescription)) -> MaterialDescription {
    material.change_singles(&mut change);
    material
}

/// Several materials in one, by their weights.
fn blended(parts: Vec<MaterialDescription>, weights: &[f64]) -> MaterialDescription {
    let (mut all, mut sum) = (MaterialDescription::default(), 0.0);
    for (part, weight) in parts.into_iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
        let share = (weight / (sum + weight)) as f32;
        all = match sum == 0.0 {
            true => part,
            false => mixed(&all, &part, share)
                .unwrap_or_else(|| MaterialDescription::blend(ScalarTexture::Constant(share), [all, part])),
        };
        sum += weight;
    }
    all
}

/// What two constant diffuse materials are together; `share` of it is the second.
pub(crate) fn mixed(
    first: &MaterialDescription,
    second: &MaterialDescription,
    share: f32,
) -> Option<MaterialDescription> {
    let reflectance = |material: &MaterialDescription| match &material.bsdf {
        BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Constant(color) }) => Some(*color),
        _ => None,
    };
    let (a, b) = (reflectance(first)?, reflectance(second)?);
    let same = MaterialDescription { bsdf: first.bsdf.clone(), ..second.clone() };
    let reflectance = ColorTexture::Constant(a * (1.0 - share) + b * share);
    (same == *first).then(|| MaterialDescription { bsdf: DiffuseParameters { reflectance }.into(), ..first.clone() })
}
