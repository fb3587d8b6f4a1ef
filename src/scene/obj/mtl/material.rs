//! What a record means to a path tracer.
//!
//! MTL describes shading models of its time, and exporters agree on little more than `Kd`. The reading here: `Pm` and
//! `illum` 3, 5 and 8 are metal, a highlight on a diffuse colour is plastic, `d` is partial coverage, and what both
//! transmits and refracts is glass. Maya writes `illum 4`, `Ni 1` and `Tf 1 1 1` for every opaque material: an index
//! of refraction of 1 never makes glass.

use super::record::Record;
use crate::bsdf::{BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, PlasticParameters};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};

/// Where a file gives none that could refract.
const DEFAULT_IOR: f32 = 1.5;

/// Of a material without `Kd`, as of [`MaterialDescription::default`].
const DEFAULT_DIFFUSE: Rgb = Rgb::splat(0.5);

/// Where a file says nothing about it: Blender's default.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// The largest exponent, which means a mirror.
const LARGEST_EXPONENT: f32 = 1000.0;

/// The coat of plastic is not smoother: the largest exponent is the format's end rather than a perfect surface.
const LEAST_PLASTIC_ALPHA: f32 = 1e-3;

impl Record {
    /// The material. Opaque ones scatter on both sides; emission leaves the side of the winding.
    pub fn describe(&self) -> MaterialDescription {
        let glass = self.is_glass();
        MaterialDescription {
            bsdf: if glass { self.dielectric() } else { self.opaque() },
            two_sided: !glass,
            opacity: if glass { None } else { self.opacity() },
            emission: self.emission.unwrap_or(Rgb::ZERO),
            emission_two_sided: false,
        }
    }

    fn opaque(&self) -> BsdfDescription {
        let specular = self.specular.unwrap_or(Rgb::ZERO);
        if self.metallic.is_some_and(|metallic| metallic >= 0.5) {
            // The base colour of the PBR extension is `Kd`; older exporters have a metal's colour in `Ks` alone.
            let old = self.diffuse == Some(Rgb::ZERO) && self.diffuse_map.is_none();
            let colour = if old { ColorTexture::Constant(specular) } else { self.diffuse_colour() };
            conductor(colour, self.roughness())
        } else if self.illumination_in(&[3.0, 5.0, 8.0]) {
            let black = specular == Rgb::ZERO;
            let colour = if black { self.diffuse_colour() } else { ColorTexture::Constant(specular) };
            conductor(colour, self.roughness.unwrap_or(0.0))
        } else if specular != Rgb::ZERO && self.illumination_in(&[2.0]) && self.exponent > Some(0.0) {
            self.plastic()
        } else {
            DiffuseParameters { reflectance: self.diffuse_colour() }.into()
        }
    }

    fn is_glass(&self) -> bool {
        let refracts = self.ior.is_none_or(|ior| (ior - 1.0).abs() > 1e-3);
        let filters = self.share_stopped() < 1.0 && self.filter.is_some();
        let transmits = self.illumination_in(&[4.0, 6.0, 7.0, 9.0]) || filters;
        refracts && transmits && self.dissolve_map.is_none()
    }

    fn dielectric(&self) -> BsdfDescription {
        let glass = DielectricParameters {
            int_ior: self.ior.unwrap_or(DEFAULT_IOR),
            specular_transmittance: self.filter.unwrap_or(Rgb::ONE),
            alpha: self.roughness.map_or(0.0, |roughness| roughness * roughness),
            ..DielectricParameters::default()
        };
        glass.into()
    }

    fn plastic(&self) -> BsdfDescription {
        let roughness = self.roughness();
        let plastic = PlasticParameters {
            reflectance: self.diffuse_colour(),
            int_ior: self.ior.filter(|&ior| ior > 1.0).unwrap_or(DEFAULT_IOR),
            alpha: (roughness * roughness).max(LEAST_PLASTIC_ALPHA),
            nonlinear: true,
            ..PlasticParameters::default()
        };
        plastic.into()
    }

    /// `map_Kd` times `Kd`. Exporters that leave `Kd` black beside a map mean the map, which is what Blender shows.
    fn diffuse_colour(&self) -> ColorTexture {
        match &self.diffuse_map {
            None => ColorTexture::Constant(self.diffuse.unwrap_or(DEFAULT_DIFFUSE)),
            Some(map) => {
                let colour = self.diffuse.filter(|&colour| colour != Rgb::ZERO).unwrap_or(Rgb::ONE);
                ColorTexture::Image(ImageTexture { tint: map.tint * colour, ..map.clone() })
            }
        }
    }

    /// `map_d` times `d`; a map beside `d 0` counts alone, as with `map_Kd`.
    fn opacity(&self) -> Option<ScalarTexture> {
        let stopped = self.share_stopped();
        match &self.dissolve_map {
            None => (stopped < 1.0).then_some(ScalarTexture::Constant(stopped)),
            Some(map) => {
                let factor = if stopped > 0.0 { stopped } else { 1.0 };
                Some(ScalarTexture::Image(ImageTexture { tint: map.tint * factor, ..map.clone() }))
            }
        }
    }

    fn share_stopped(&self) -> f32 {
        self.dissolve.or(self.transparency.map(|tr| 1.0 - tr)).unwrap_or(1.0)
    }

    /// `Pr`, or what Blender writes as `Ns` = 1000 (1 − roughness)².
    fn roughness(&self) -> f32 {
        let from_exponent = |ns: f32| 1.0 - (ns.min(LARGEST_EXPONENT) / LARGEST_EXPONENT).sqrt();
        self.roughness.or(self.exponent.map(from_exponent)).unwrap_or(DEFAULT_ROUGHNESS)
    }

    fn illumination_in(&self, models: &[f32]) -> bool {
        self.illumination.is_some_and(|illum| models.contains(&illum))
    }
}

/// A metal that reflects `colour` at every angle.
fn conductor(colour: ColorTexture, roughness: f32) -> BsdfDescription {
    let alpha = roughness * roughness;
    ConductorParameters { specular_reflectance: colour, alpha, ..ConductorParameters::default() }.into()
}
