//! A diffuse base under a smooth dielectric coat.

use super::coat::Entering;
use super::interface::{checked_alpha, checked_eta, indices, rough};
use super::lanes::SameMaterial;
use super::model::{BsdfParameters, Prepared, checked_color};
use super::rough_plastic::RoughPlasticModel;
use super::{BLACK, BsdfSample, BsdfTables, DIFFUSE, MicrofacetDistribution, Model, Scatter, choice, fresnel};
use crate::Result;
use crate::document::{UNIT, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use crate::simd::{Lanes, Vec3Lanes};
use crate::texture::ColorTexture;
use glam::Vec3;

/// A diffuse base under a dielectric coat, smooth or rough, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticParameters {
    pub reflectance: ColorTexture,
    pub specular_reflectance: Rgb,
    pub int_ior: f32,
    pub ext_ior: f32,
    /// Roughness of the coat's microfacet distribution; 0 is smooth.
    pub alpha: f32,
    pub distribution: MicrofacetDistribution,
    /// Colour shifts by internal scattering are taken into account.
    pub nonlinear: bool,
    /// The base gets all that the coat does not reflect, so that no light is lost in a rough coat.
    pub energy_conserving: bool,
    /// The base is seen as if there were no coat, and what a rough coat reflects is added.
    pub additive: bool,
}

impl Default for PlasticParameters {
    fn default() -> PlasticParameters {
        PlasticParameters {
            reflectance: ColorTexture::grey(0.5),
            specular_reflectance: Rgb::ONE,
            int_ior: 1.5,
            ext_ior: 1.0,
            alpha: 0.0,
            distribution: MicrofacetDistribution::Ggx,
            nonlinear: false,
            energy_conserving: false,
            additive: false,
        }
    }
}

impl Fields for PlasticParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.texture(key("reflectance", "albedo of the base"), &mut self.reflectance)?;
        indices(visitor, "index of refraction of the coat", &mut self.int_ior, &mut self.ext_ior)?;
        let specular = key("specular_reflectance", "multiplies the coat's reflection");
        visitor.color(specular, UNIT, &mut self.specular_reflectance)?;
        rough(visitor, "roughness of the coat", &mut self.alpha, &mut self.distribution)?;
        let meaning = "`reflectance` is that of what the coat does not reflect: R becomes R(1 − E) + E with E the coat's albedo, and \
                       no light is lost in a rough coat (albedo scaling)";
        visitor.flag(key("energy_conserving", meaning), &mut self.energy_conserving)?;
        let meaning = "the base is as bright as without a coat, and what a rough coat reflects is added, as in nori and pbrt-v3: such a \
                       surface may reflect more light than it gets";
        let additive = key("additive", meaning).only(!self.energy_conserving, "`energy_conserving = false`");
        visitor.added_flag(additive, &mut self.additive)?;
        let rough = !self.additive || self.alpha > 0.0;
        visitor.check(rough, &["additive", "alpha"], "`additive` needs a rough coat: an `alpha` greater than 0")?;
        let meaning = "takes colour shifts by scattering inside the coat into account";
        let nonlinear =
            key("nonlinear", meaning).only(self.takes_shifts(), "`energy_conserving = false` and `additive = false`");
        visitor.flag(nonlinear, &mut self.nonlinear)
    }
}

impl PlasticParameters {
    /// Whether there is scattering inside the coat that could shift colours.
    fn takes_shifts(&self) -> bool {
        !self.energy_conserving && !self.additive
    }

    fn entering(&self) -> Entering {
        match (self.energy_conserving, self.additive) {
            (true, _) => Entering::Conserving,
            (false, true) => Entering::All,
            (false, false) => Entering::Refracted,
        }
    }
}

impl BsdfParameters for PlasticParameters {
    const NUMBER: u32 = 5;
    const OPAQUE: bool = true;

    fn model(&self, tables: &mut BsdfTables) -> Result<Model> {
        let eta = checked_eta(self.int_ior, self.ext_ior)?;
        let alpha = checked_alpha(self.alpha)?;
        let PlasticParameters { specular_reflectance: specular, distribution, .. } = *self;
        let nonlinear = self.nonlinear && self.takes_shifts();
        checked_color(specular, "specular_reflectance")?;
        Ok(if alpha == 0.0 {
            PlasticModel { coat: SmoothCoat::new(eta), specular, nonlinear }.into()
        } else {
            RoughPlasticModel { coat: tables.coat(eta, alpha, distribution, self.entering()), specular, nonlinear }
                .into()
        })
    }
}

/// A smooth coat; the base may vary from place to place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlasticModel {
    coat: SmoothCoat,
    specular: Rgb,
    nonlinear: bool,
}

impl Prepared for PlasticModel {
    type At<'s> = Plastic;

    #[inline(always)]
    fn colors(&self, [reflectance, other]: [Rgb; 2]) -> [Rgb; 2] {
        [base_under_coat(reflectance, self.coat.internal_reflectance, self.coat.eta, self.nonlinear), other]
    }

    #[inline(always)]
    fn at(&self, [base, _]: [Rgb; 2]) -> Plastic {
        Plastic { base, specular: self.specular, coat: self.coat }
    }

    fn in_lanes(&self) -> bool {
        true
    }

    #[inline(never)]
    fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        surfaces.eval_pdf(wi, |colors| self.at(colors), f, pdf);
    }

    #[inline(never)]
    fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        surfaces.albedo(|colors| self.at(colors), albedo);
    }
}

/// The coat, computed once per material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SmoothCoat {
    /// Index of the coat over that of the air.
    pub eta: f32,
    /// 2∫(1 − F)µ dµ: share of diffuse light that enters.
    pub mean_transmittance: f32,
    /// 2∫F µ dµ from inside: share of what the base reflects that the coat sends back to it.
    pub internal_reflectance: f32,
}

impl SmoothCoat {
    pub fn new(eta: f32) -> SmoothCoat {
        SmoothCoat {
            eta,
            mean_transmittance: 1.0 - fresnel::diffuse_reflectance(eta),
            internal_reflectance: fresnel::diffuse_reflectance(1.0 / eta),
        }
    }
}

/// What a Lambertian base of reflectance R under a coat makes of light that has entered, times the 1/η² of its
/// way out: R/((1 − R·ρ)η²) with ρ the `internal` reflectance of the coat. With `nonlinear` false the colours of
/// textures are kept: R/((1 − ρ)η²).
#[inline]
pub(super) fn base_under_coat(reflectance: Rgb, internal: f32, eta: f32, nonlinear: bool) -> Rgb {
    let returned = if nonlinear { reflectance * internal } else { Rgb::splat(internal) };
    reflectance / ((Rgb::ONE - returned) * (eta * eta))
}

/// A delta reflection F and a base T(cosθo)·T(cosθi)·base/π with T = 1 − F.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plastic {
    /// As [`base_under_coat`] gives it.
    pub base: Rgb,
    /// Times the coat's reflection.
    pub specular: Rgb,
    pub coat: SmoothCoat,
}

impl Plastic {
    /// Albedos from wo: of the coat, and of the base.
    #[inline(always)]
    fn albedos(&self, wo: Vec3) -> (Rgb, Rgb) {
        let (f, _) = fresnel::dielectric(wo.z, self.coat.eta);
        (f * self.specular, ((1.0 - f) * self.coat.mean_transmittance) * self.base)
    }
}

impl Scatter for Plastic {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return BLACK;
        }
        let (coat, base) = self.albedos(wo);
        let Some(p) = choice(coat, base) else { return BLACK };
        let t_o = 1.0 - fresnel::dielectric(wo.z, self.coat.eta).0;
        let t_i = 1.0 - fresnel::dielectric(wi.z, self.coat.eta).0;
        let cosine = square_to_cosine_hemisphere_pdf(wi);
        (self.base * (t_o * t_i * cosine), (1.0 - p) * cosine)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (coat, base) = self.albedos(wo);
        let p = choice(coat, base)?;
        if u_lobe < p {
            return BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), coat, p, 1.0);
        }
        let wi = square_to_cosine_hemisphere(u);
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 {
            return Rgb::ZERO;
        }
        let (coat, base) = self.albedos(wo);
        coat + base
    }

    fn roughness(&self) -> f32 {
        DIFFUSE
    }

    /// That of the coat, which is a delta lobe.
    fn sharp_probability(&self, wo: Vec3, _alpha: f32) -> f32 {
        if wo.z <= 0.0 {
            return 1.0;
        }
        let (coat, base) = self.albedos(wo);
        choice(coat, base).unwrap_or(1.0)
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 { Rgb::ZERO } else { self.albedos(wo).1 }
    }
}
