//! Clear glass and water, as a body and as a pane.

use super::interface::{checked_alpha, checked_eta, indices, rough};
use super::microfacet::Microfacet;
use super::model::{BsdfParameters, Prepared, checked_color};
use super::rough_dielectric::RoughDielectric;
use super::{BLACK, BsdfSample, BsdfTables, MicrofacetDistribution, Model, Scatter, choice, fresnel};
use crate::document::{UNIT, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::{Error, Result};
use glam::Vec3;

/// Glass and water as written.
#[derive(Clone, Debug, PartialEq)]
pub struct DielectricParameters {
    pub int_ior: f32,
    pub ext_ior: f32,
    pub specular_reflectance: Rgb,
    pub specular_transmittance: Rgb,
    /// Roughness of the microfacet distribution; 0 is smooth.
    pub alpha: f32,
    pub distribution: MicrofacetDistribution,
    /// A pane whose two sides are one surface, so rays pass without bending.
    pub thin: bool,
}

impl Default for DielectricParameters {
    fn default() -> DielectricParameters {
        DielectricParameters {
            int_ior: 1.5,
            ext_ior: 1.0,
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
            alpha: 0.0,
            distribution: MicrofacetDistribution::Ggx,
            thin: false,
        }
    }
}

impl Fields for DielectricParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        indices(visitor, "index of refraction inside", &mut self.int_ior, &mut self.ext_ior)?;
        let reflectance = key("specular_reflectance", "multiplies the reflection");
        visitor.color(reflectance, UNIT, &mut self.specular_reflectance)?;
        let transmittance = key("specular_transmittance", "multiplies the refraction");
        visitor.color(transmittance, UNIT, &mut self.specular_transmittance)?;
        rough(visitor, "roughness", &mut self.alpha, &mut self.distribution)?;
        let meaning = "a pane whose two sides are one surface: rays pass without bending";
        visitor.flag(key("thin", meaning), &mut self.thin)
    }
}

impl BsdfParameters for DielectricParameters {
    const NUMBER: u32 = 4;
    const OPAQUE: bool = false;

    fn model(&self, _tables: &mut BsdfTables) -> Result<Model> {
        let eta = checked_eta(self.int_ior, self.ext_ior)?;
        let alpha = checked_alpha(self.alpha)?;
        let (reflectance, transmittance) = (self.specular_reflectance, self.specular_transmittance);
        checked_color(reflectance, "specular_reflectance")?;
        checked_color(transmittance, "specular_transmittance")?;
        if self.thin && alpha > 0.0 {
            return Err(Error::Scene("a thin dielectric must be smooth (alpha = 0)".into()));
        }
        Ok(if self.thin {
            ThinDielectric { eta, reflectance, transmittance }.into()
        } else if alpha > 0.0 && eta != 1.0 {
            let microfacet = Microfacet::new(self.distribution, alpha);
            RoughDielectric { eta, reflectance, transmittance, microfacet }.into()
        } else {
            // equal indices bend nothing, however rough the interface
            Dielectric { eta, reflectance, transmittance }.into()
        })
    }
}

impl Prepared for Dielectric {
    type At<'s> = Dielectric;

    #[inline(always)]
    fn at(&self, _: [Rgb; 2]) -> Dielectric {
        *self
    }
}

impl Prepared for ThinDielectric {
    type At<'s> = ThinDielectric;

    #[inline(always)]
    fn at(&self, _: [Rgb; 2]) -> ThinDielectric {
        *self
    }
}

/// A smooth interface; `eta` is the index below the surface over that above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dielectric {
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

/// Index of the side that light from `wo` is refracted into over that of `wo`'s side.
#[inline]
pub(super) fn relative_index(eta: f32, wo: Vec3) -> f32 {
    if wo.z > 0.0 { eta } else { 1.0 / eta }
}

impl Scatter for Dielectric {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let eta = relative_index(self.eta, wo);
        let (f, cos_t) = fresnel::dielectric(wo.z.abs(), eta);
        let (reflected, transmitted) = (f * self.reflectance, (1.0 - f) * self.transmittance);
        let p = choice(reflected, transmitted)?;
        if u_lobe < p {
            return BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), reflected, p, 1.0);
        }
        let wi = Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t.copysign(wo.z));
        BsdfSample::delta(wi, transmitted / (eta * eta), 1.0 - p, eta)
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        let (f, _) = fresnel::dielectric(wo.z.abs(), relative_index(self.eta, wo));
        f * self.reflectance + (1.0 - f) * self.transmittance
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}

/// A pane whose two faces are one surface: light passes without bending. Reflections between the faces are
/// summed: R = F + (1 − F)²F/(1 − F²) = 2F/(1 + F).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThinDielectric {
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl ThinDielectric {
    /// What is reflected and what passes.
    fn split(&self, wo: Vec3) -> (Rgb, Rgb) {
        let (f, _) = fresnel::dielectric(wo.z.abs(), self.eta);
        let r = 2.0 * f / (1.0 + f);
        (r * self.reflectance, (1.0 - r) * self.transmittance)
    }
}

impl Scatter for ThinDielectric {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (reflected, transmitted) = self.split(wo);
        let p = choice(reflected, transmitted)?;
        if u_lobe < p {
            BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), reflected, p, 1.0)
        } else {
            BsdfSample::delta(-wo, transmitted, 1.0 - p, 1.0)
        }
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        let (reflected, transmitted) = self.split(wo);
        reflected + transmitted
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
