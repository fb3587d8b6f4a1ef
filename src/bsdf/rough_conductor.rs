//! Rough metal (Cook & Torrance 1982, in the form of Walter et al. 2007).

use super::conductor::Metal;
use super::microfacet::Microfacet;
use super::model::Prepared;
use super::{BLACK, BsdfSample, Scatter, fresnel};
use crate::math::Rgb;
use glam::Vec3;

/// A rough metal; how much it reflects may vary from place to place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughConductorModel {
    pub(super) metal: Metal,
    pub(super) microfacet: Microfacet,
}

impl Prepared for RoughConductorModel {
    type At<'s> = RoughConductor;

    #[inline(always)]
    fn at(&self, [reflectance, _]: [Rgb; 2]) -> RoughConductor {
        RoughConductor { metal: self.metal, reflectance, microfacet: self.microfacet }
    }
}

/// f = F·D·G/(4 cosθo cosθi) times `reflectance`; light that facets send to each other is lost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughConductor {
    pub metal: Metal,
    pub reflectance: Rgb,
    pub microfacet: Microfacet,
}

impl Scatter for RoughConductor {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some((m, pdf)) = reflection_pdf(&self.microfacet, wo, wi) else { return BLACK };
        let f = self.metal.fresnel(wo.dot(m)) * self.reflectance;
        (f * (pdf * self.microfacet.g1(wi)), pdf)
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = sample_reflection(&self.microfacet, wo, u)?;
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.metal.fresnel(wo.z) * self.reflectance } else { Rgb::ZERO }
    }

    fn roughness(&self) -> f32 {
        self.microfacet.alpha()
    }
}

/// The facet that mirrors wo to wi, and the density of wi when visible normals are drawn and mirrored:
/// D(m)·G1(wo)/(4 cosθo). Both directions above the horizon, else `None`.
#[inline]
pub(super) fn reflection_pdf(microfacet: &Microfacet, wo: Vec3, wi: Vec3) -> Option<(Vec3, f32)> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    let m = (wo + wi).try_normalize().filter(|m| m.z > 0.0)?;
    Some((m, 0.25 * microfacet.d(m) * microfacet.g1_over_cos(wo)))
}

/// `wo` mirrored at a visible normal; `None` below the horizon.
#[inline]
pub(super) fn sample_reflection(microfacet: &Microfacet, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    if wo.z <= 0.0 {
        return None;
    }
    let wi = fresnel::reflect(wo, microfacet.sample_visible(wo, u)).normalize();
    (wi.z > 0.0).then_some(wi)
}
