//! Metal: a mirror or a rough surface, by its roughness.

use super::interface::{checked_alpha, rough};
use super::microfacet::Microfacet;
use super::mirror::MirrorModel;
use super::model::{BsdfParameters, out_of_domain};
use super::rough_conductor::RoughConductorModel;
use super::{BsdfTables, MicrofacetDistribution, Model, fresnel};
use crate::Result;
use crate::document::{NOT_NEGATIVE, POSITIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::texture::ColorTexture;

/// Metal as written.
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorParameters {
    /// Complex index of refraction `eta` + i`k`; `None` reflects all.
    pub eta_k: Option<(Rgb, Rgb)>,
    pub specular_reflectance: ColorTexture,
    /// Roughness of the microfacet distribution; 0 is smooth.
    pub alpha: f32,
    pub distribution: MicrofacetDistribution,
    /// Light that facets send to each other comes back.
    pub energy_conserving: bool,
}

impl Default for ConductorParameters {
    fn default() -> ConductorParameters {
        let distribution = MicrofacetDistribution::Ggx;
        let specular_reflectance = ColorTexture::grey(1.0);
        ConductorParameters { eta_k: None, specular_reflectance, alpha: 0.0, distribution, energy_conserving: false }
    }
}

impl Fields for ConductorParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        let meaning = "real part of the index of refraction; without `eta` and `k` the Fresnel reflectance is 1";
        let eta = key("eta", meaning).optional();
        let k = key("k", "its imaginary part").optional();
        visitor.color_pair([(eta, POSITIVE), (k, NOT_NEGATIVE)], &mut self.eta_k)?;
        visitor.texture(key("specular_reflectance", "multiplies the reflection"), &mut self.specular_reflectance)?;
        rough(visitor, "roughness", &mut self.alpha, &mut self.distribution)?;
        let meaning = "light that facets send to each other comes back, so that a rough metal is as bright as a smooth one (multiple \
                       scattering)";
        visitor.added_flag(key("energy_conserving", meaning), &mut self.energy_conserving)
    }
}

impl BsdfParameters for ConductorParameters {
    const NUMBER: u32 = 3;
    const OPAQUE: bool = true;

    fn model(&self, tables: &mut BsdfTables) -> Result<Model> {
        let metal = checked_metal(self.eta_k)?;
        Ok(match checked_alpha(self.alpha)? {
            0.0 => MirrorModel(metal).into(),
            alpha => {
                let microfacet = Microfacet::new(self.distribution, alpha);
                let multiple = self.energy_conserving.then(|| tables.loss(&microfacet));
                RoughConductorModel::new(metal, microfacet, multiple).into()
            }
        })
    }
}

fn checked_metal(eta_k: Option<(Rgb, Rgb)>) -> Result<Metal> {
    let Some((eta, k)) = eta_k else { return Ok(Metal::Perfect) };
    // an index of 0 + 0i reflects 0/0
    let fine = eta.is_finite() && k.is_finite() && eta.min(k).min_element() >= 0.0;
    if fine && (eta + k).min_element() > 0.0 {
        Ok(Metal::Index { eta, k })
    } else {
        Err(out_of_domain("eta and k of a conductor", "finite, not negative and not both 0"))
    }
}

/// Complex index of refraction per channel, relative to vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Metal {
    /// Reflects all.
    Perfect,
    /// η + ik.
    Index { eta: Rgb, k: Rgb },
}

impl Metal {
    /// Fresnel reflectance at cosine `cos` ≥ 0.
    #[inline(always)]
    pub fn fresnel(&self, cos: f32) -> Rgb {
        match *self {
            Metal::Perfect => Rgb::ONE,
            Metal::Index { eta, k } => fresnel::conductor(cos, eta, k),
        }
    }

    /// Its mean over directions, 2∫F µ dµ.
    pub fn mean_fresnel(&self) -> Rgb {
        const STEPS: usize = 256;
        let midpoint = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        (0..STEPS).map(midpoint).map(|cos| self.fresnel(cos) * cos).sum::<Rgb>() * (2.0 / STEPS as f32)
    }
}
