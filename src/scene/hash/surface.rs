//! The canonical bytes of materials.

use super::Canon;
use crate::Result;
use crate::bsdf::{BsdfDescription, MicrofacetDistribution};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};
use std::path::Path;

/// Writes materials.
pub(super) struct Surface<'a> {
    pub canon: &'a mut Canon,
    pub picture: &'a mut dyn FnMut(&Path) -> Result<u64>,
}

impl Surface<'_> {
    pub fn material(&mut self, material: &MaterialDescription) -> Result<()> {
        let MaterialDescription { bsdf, two_sided, opacity, emission, emission_two_sided } = material;
        self.bsdf(bsdf)?;
        self.canon.flag(*two_sided);
        match opacity {
            None => self.canon.u32(0),
            Some(ScalarTexture::Constant(share)) => {
                self.canon.u32(1);
                self.canon.floats([*share]);
            }
            Some(ScalarTexture::Image(image)) => self.image(2, image)?,
            Some(ScalarTexture::Luminance(image)) => self.image(3, image)?,
        }
        self.canon.vector(*emission);
        self.canon.flag(*emission_two_sided);
        Ok(())
    }

    fn bsdf(&mut self, bsdf: &BsdfDescription) -> Result<()> {
        match bsdf {
            BsdfDescription::Null => self.canon.u32(0),
            BsdfDescription::Diffuse { reflectance } => {
                self.canon.u32(1);
                self.color(reflectance)?;
            }
            BsdfDescription::DiffuseTransmitter { reflectance, transmittance } => {
                self.canon.u32(2);
                self.color(reflectance)?;
                self.color(transmittance)?;
            }
            BsdfDescription::Conductor { eta_k, specular_reflectance, alpha, distribution } => {
                self.canon.u32(3);
                self.canon.flag(eta_k.is_some());
                eta_k.iter().for_each(|(eta, k)| [eta, k].into_iter().for_each(|v| self.canon.vector(*v)));
                self.color(specular_reflectance)?;
                self.rough(*alpha, *distribution);
            }
            BsdfDescription::Dielectric {
                int_ior,
                ext_ior,
                specular_reflectance,
                specular_transmittance,
                alpha,
                distribution,
                thin,
            } => {
                self.canon.u32(4);
                self.coat([*int_ior, *ext_ior], *specular_reflectance);
                self.canon.vector(*specular_transmittance);
                self.rough(*alpha, *distribution);
                self.canon.flag(*thin);
            }
            BsdfDescription::Plastic {
                reflectance,
                specular_reflectance,
                int_ior,
                ext_ior,
                alpha,
                distribution,
                nonlinear,
            } => {
                self.canon.u32(5);
                self.color(reflectance)?;
                self.coat([*int_ior, *ext_ior], *specular_reflectance);
                self.rough(*alpha, *distribution);
                self.canon.flag(*nonlinear);
            }
            BsdfDescription::Principled {
                base_color,
                metallic,
                roughness,
                specular,
                spec_tint,
                clearcoat,
                clearcoat_gloss,
                sheen,
                sheen_tint,
            } => {
                self.canon.u32(6);
                self.color(base_color)?;
                self.canon.floats([*metallic, *roughness, *specular, *spec_tint]);
                self.canon.floats([*clearcoat, *clearcoat_gloss, *sheen, *sheen_tint]);
            }
        }
        Ok(())
    }

    fn coat(&mut self, iors: [f32; 2], specular_reflectance: Rgb) {
        self.canon.floats(iors);
        self.canon.vector(specular_reflectance);
    }

    fn rough(&mut self, alpha: f32, distribution: MicrofacetDistribution) {
        self.canon.floats([alpha]);
        self.canon.u32(match distribution {
            MicrofacetDistribution::Ggx => 0,
            MicrofacetDistribution::Beckmann => 1,
        });
    }

    fn color(&mut self, color: &ColorTexture) -> Result<()> {
        match color {
            ColorTexture::Constant(color) => {
                self.canon.u32(1);
                self.canon.vector(*color);
                Ok(())
            }
            ColorTexture::Image(image) => self.image(2, image),
        }
    }

    fn image(&mut self, kind: u32, image: &ImageTexture) -> Result<()> {
        let ImageTexture { path, scale, offset, nearest, tint } = image;
        self.canon.u32(kind);
        self.canon.u64((self.picture)(path)?);
        self.canon.floats(*scale);
        self.canon.floats(*offset);
        self.canon.flag(*nearest);
        self.canon.vector(*tint);
        Ok(())
    }
}
