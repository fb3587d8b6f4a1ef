//! Materials of version 3.

use super::material::Materials;
use super::parameters::Parameters;
use super::texture::scalar;
use crate::Result;
use crate::bsdf::{
    BsdfDescription, DielectricParameters, DiffuseParameters, DiffuseTransmitterParameters, MirrorParameters,
    PlasticParameters, PrincipledMaps, PrincipledParameters,
};
use crate::math::{Rgb, luminance};
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};
use std::rc::Rc;

/// α of a highlight that is no mirror is at least this.
const LEAST_ALPHA: f32 = 1e-3;

impl Materials<'_> {
    pub(super) fn legacy(&self, p: &Rc<Parameters>) -> Result<MaterialDescription> {
        let textures = self.textures;
        let bsdf: BsdfDescription = match p.plugin.as_str() {
            "matte" => {
                if textures.number(p, "sigma", 0.0)? != 0.0 {
                    self.world.warnings.add(&p.at, "`sigma` has no counterpart: a Lambertian surface is taken");
                }
                DiffuseParameters { reflectance: textures.color(p, "Kd", 0.5)? }.into()
            }
            "plastic" => self.highlight(p, 1.5)?,
            "uber" => return self.uber(p),
            "substrate" => self.substrate(p)?.into(),
            "metal" => {
                let mut metal = self.conductor(p, "")?;
                metal.alpha = self.alpha(p, "", 0.01)?.max(LEAST_ALPHA);
                metal.into()
            }
            "mirror" => MirrorParameters { specular_reflectance: textures.color(p, "Kr", 0.9)? }.into(),
            "glass" => self.glass(p)?.into(),
            "translucent" => {
                self.replaced(p, "its diffuse part is taken");
                p.ignore(&["Ks", "roughness", "remaproughness"]);
                let part = |name: &str| -> Result<ColorTexture> {
                    Ok(times(textures.color(p, "Kd", 0.25)?, textures.constant(p, name, Rgb::splat(0.5))?))
                };
                DiffuseTransmitterParameters { reflectance: part("reflect")?, transmittance: part("transmit")? }.into()
            }
            "kdsubsurface" => {
                self.replaced(p, "its surface is taken for \"matte\"");
                p.ignore(&[
                    "mfp",
                    "Kr",
                    "Kt",
                    "eta",
                    "g",
                    "scale",
                    "roughness",
                    "uroughness",
                    "vroughness",
                    "remaproughness",
                ]);
                DiffuseParameters { reflectance: textures.color(p, "Kd", 0.5)? }.into()
            }
            "disney" => self.disney(p)?.into(),
            kind => {
                return Err(p.error(format!("the material \"{kind}\" has no counterpart, and no other looks like it")));
            }
        };
        Ok(MaterialDescription { bsdf, ..MaterialDescription::default() })
    }

    /// Kd/π, and the highlight of a dielectric times Ks.
    fn highlight(&self, p: &Parameters, index: f32) -> Result<BsdfDescription> {
        let reflectance = self.textures.color(p, "Kd", 0.25)?;
        let specular_reflectance = self.textures.constant(p, "Ks", Rgb::splat(0.25))?.clamp(Rgb::ZERO, Rgb::ONE);
        let alpha = self.alpha(p, "", 0.1)?.max(LEAST_ALPHA);
        if specular_reflectance == Rgb::ZERO {
            return Ok(DiffuseParameters { reflectance }.into());
        }
        let int_ior = index;
        let rest = PlasticParameters { additive: true, ..PlasticParameters::default() };
        Ok(PlasticParameters { reflectance, specular_reflectance, alpha, int_ior, ..rest }.into())
    }

    fn uber(&self, p: &Parameters) -> Result<MaterialDescription> {
        let index = self.index(p, &["eta", "index"])?;
        let [reflected, transmitted] = ["Kr", "Kt"].map(|name| self.textures.constant(p, name, Rgb::ZERO));
        let (reflected, transmitted) = (reflected?, transmitted?);
        let bsdf = if luminance(transmitted) > 0.5 {
            self.replaced(p, "with `Kt` above a half, glass is taken");
            p.ignore(&["Kd", "Ks", "roughness", "uroughness", "vroughness", "remaproughness"]);
            let specular_transmittance = transmitted.min(Rgb::ONE);
            DielectricParameters { int_ior: index, specular_transmittance, ..Default::default() }.into()
        } else {
            if reflected != Rgb::ZERO || transmitted != Rgb::ZERO {
                self.world.warnings.add(&p.at, "`Kr` and `Kt` of \"uber\" have no counterpart: 0 is taken");
            }
            self.highlight(p, index)?
        };
        let opacity = match self.textures.found(p, "opacity", false)?.map(scalar) {
            Some(ScalarTexture::Constant(opacity)) if opacity >= 1.0 => None,
            other => other,
        };
        Ok(MaterialDescription { bsdf, opacity, ..MaterialDescription::default() })
    }

    /// A base under a layer that reflects Ks at right angles.
    fn substrate(&self, p: &Parameters) -> Result<PlasticParameters> {
        self.replaced(p, "a base under a coat that reflects as much is taken");
        let specular = self.textures.constant(p, "Ks", Rgb::splat(0.5))?.clamp(Rgb::ZERO, Rgb::ONE);
        let level = specular.max_element().clamp(1e-4, 0.9);
        let root = level.sqrt();
        Ok(PlasticParameters {
            reflectance: self.textures.color(p, "Kd", 0.5)?,
            specular_reflectance: (specular / level).min(Rgb::ONE),
            int_ior: (1.0 + root) / (1.0 - root),
            alpha: self.alpha(p, "", 0.1)?.max(LEAST_ALPHA),
            energy_conserving: true,
            ..PlasticParameters::default()
        })
    }

    fn glass(&self, p: &Parameters) -> Result<DielectricParameters> {
        let share =
            |name: &str| -> Result<Rgb> { Ok(self.textures.constant(p, name, Rgb::ONE)?.clamp(Rgb::ZERO, Rgb::ONE)) };
        let smooth = p.first_of(&["uroughness", "vroughness", "roughness"]).is_none();
        p.ignore(&["remaproughness"]);
        // 0 is smooth, whatever it would become
        let rough = !smooth
            && ["uroughness", "vroughness", "roughness"]
                .iter()
                .any(|name| !matches!(self.textures.number(p, name, 0.0), Ok(0.0)));
        Ok(DielectricParameters {
            int_ior: self.index(p, &["eta", "index"])?,
            specular_reflectance: share("Kr")?,
            specular_transmittance: share("Kt")?,
            alpha: if rough { self.alpha(p, "", 0.0)? } else { 0.0 },
            ..DielectricParameters::default()
        })
    }

    fn disney(&self, p: &Parameters) -> Result<PrincipledParameters> {
        for name in ["anisotropic", "spectrans", "difftrans", "flatness"] {
            if self.textures.number(p, name, 0.0)? != 0.0 && name != "difftrans" {
                self.world.warnings.add(&p.at, format!("`{name}` of \"disney\" has no counterpart: 0 is taken"));
            }
        }
        p.ignore(&["thin", "scatterdistance", "difftrans"]);
        let share = |name: &str, default: f32| self.textures.number(p, name, default).map(|x| x.clamp(0.0, 1.0));
        let index = self.index(p, &["eta"])?;
        Ok(PrincipledParameters {
            base_color: self.textures.color(p, "color", 0.5)?,
            metallic: share("metallic", 0.0)?,
            roughness: share("roughness", 0.5)?,
            // the reflectance at normal incidence is 0.08·specular
            specular: (((index - 1.0) / (index + 1.0)).powi(2) / 0.08).clamp(0.0, 1.0),
            spec_tint: share("speculartint", 0.0)?,
            clearcoat: share("clearcoat", 0.0)?,
            clearcoat_gloss: share("clearcoatgloss", 1.0)?,
            sheen: share("sheen", 0.0)?,
            sheen_tint: share("sheentint", 0.5)?,
            energy_conserving: false,
            maps: PrincipledMaps::NONE,
        })
    }
}

fn times(texture: ColorTexture, by: Rgb) -> ColorTexture {
    match texture {
        ColorTexture::Constant(color) => ColorTexture::Constant((color * by).clamp(Rgb::ZERO, Rgb::ONE)),
        ColorTexture::Image(image) => ColorTexture::Image(ImageTexture { tint: image.tint * by, ..image }),
        ColorTexture::Vertex(tint) => ColorTexture::Vertex(tint * by),
    }
}
