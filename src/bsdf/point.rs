//! A BSDF at one point of a surface, whatever it is.

use super::diffuse::Diffuse;
use super::{BsdfKind, BsdfModel, BsdfSample, Gloss, Scatter, mirrored};
use crate::math::Rgb;
use glam::Vec3;

/// The BSDF at one point: what its material says for everywhere, borrowed, and the colours there. One-sided opaque kinds
/// are black from behind (wo.z < 0); two-sided ones scatter there like their mirror image about the surface.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'s> {
    pub(super) model: &'s BsdfModel,
    pub(super) colors: [Rgb; 2],
    /// About which it scatters, unit, in the shading frame; `None`: about that frame's own normal.
    pub(super) normal: Option<Vec3>,
}

impl<'s> Bsdf<'s> {
    /// The kind, with its parameters.
    #[inline(always)]
    pub(super) fn kind(&self) -> BsdfKind<'s> {
        self.model.kind(self.colors)
    }

    /// f(wo, wi)·|cosθi| per steradian, summed over the smooth lobes.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.eval_pdf(wo, wi).0
    }

    /// Density of [`Self::sample`] per steradian of `wi` over all smooth lobes, the probability of choosing them
    /// included: its integral is that of drawing a smooth sample at all.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_pdf(wo, wi).1
    }

    /// [`Self::eval`] and [`Self::pdf`] at once.
    #[inline]
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if let Some(normal) = self.normal {
            return self.eval_pdf_turned(normal, wo, wi);
        }
        let (wo, wi) = if self.turned(wo) { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        match self.diffuse() {
            Some(b) => b.eval_pdf(wo, wi),
            None => self.eval_pdf_other(wo, wi),
        }
    }

    /// Draws `wi`: `u_lobe` chooses the lobe, `u` the direction in it, all uniform in [0, 1). `None` where light
    /// is absorbed or the draw left the domain (probability 1 − ∫pdf − that of the delta lobes).
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if let Some(normal) = self.normal {
            return self.sample_turned(normal, wo, u_lobe, u);
        }
        let turned = self.turned(wo);
        let wo = if turned { mirrored(wo) } else { wo };
        let mut sample = match self.diffuse() {
            Some(b) => b.sample(wo, u_lobe, u),
            None => self.sample_other(wo, u_lobe, u),
        }?;
        if turned {
            sample.wi = mirrored(sample.wi);
        }
        Some(sample)
    }

    /// Whether any lobe is smooth: else neither next-event estimation nor a guide can help.
    #[inline]
    pub fn has_smooth(&self) -> bool {
        self.model.smooth()
    }

    /// Whether light never crosses the surface: smooth lobes are black but for the side of `wo` in the shading frame.
    #[inline]
    pub fn is_opaque(&self) -> bool {
        self.model.opaque()
    }

    /// Estimate of the directional-hemispherical albedo from `wo`: the share of energy that all lobes together,
    /// delta lobes included, scatter; the scaling of radiance by refraction left out; in [0, 1].
    ///
    /// Exact for diffuse kinds, mirrors, smooth glass and plastic; within 0.003 for rough plastic. Rough metal and
    /// glass count as if no facet shadowed another: too high by up to 0.09 near the normal and 0.17 towards grazing
    /// at alpha 0.25, by up to 0.7 at alpha 1. Principled likewise, over a Lambertian base.
    #[inline]
    pub fn albedo(&self, wo: Vec3) -> Rgb {
        if let Some(normal) = self.normal {
            let (flat, own) = self.own_view(normal, wo);
            return flat.albedo(own);
        }
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        let albedo = match self.diffuse() {
            Some(b) => b.albedo(wo),
            None => self.albedo_other(wo),
        };
        albedo.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The reflectance R of a Lambertian surface, f = R/π on the side of `wo` (for a one-sided surface: on its
    /// front); `None` for any other, and about another normal than the shading frame's.
    #[inline]
    pub fn lambertian(&self) -> Option<Rgb> {
        self.diffuse().map(|diffuse| diffuse.reflectance)
    }

    /// Probability with which [`Self::sample`] draws from a lobe of less roughness than `alpha` > 0, delta lobes included:
    /// it does where `u_lobe` is below this number. 1 where `wo` is on the side that scatters nothing.
    #[inline]
    pub fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        match self.normal {
            _ if self.model.is_diffuse() => 0.0,
            None => self.sharp_probability_other(wo, alpha),
            Some(normal) => {
                let (flat, own) = self.own_view(normal, wo);
                flat.sharp_probability_other(own, alpha)
            }
        }
    }

    /// As much of [`Self::eval_pdf`] as is of lobes with at least the roughness `alpha`; with [`DIFFUSE`], of diffuse ones.
    /// The density integrates to at most 1 − [`Self::sharp_probability`].
    #[inline]
    pub fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        if let Some(normal) = self.normal {
            return self.eval_pdf_rough_turned(normal, wo, wi, alpha);
        }
        let (wo, wi) = if self.turned(wo) { (mirrored(wo), mirrored(wi)) } else { (wo, wi) };
        match self.diffuse() {
            Some(b) => b.eval_pdf(wo, wi),
            None => self.eval_pdf_rough_other(wo, wi, alpha),
        }
    }

    /// As much of [`Self::albedo`] as is of lobes that follow Lambert's law on the side of `wo`, but for the Fresnel
    /// transmittance of a coat or the grazing angles of the principled model's base. Black for translucent kinds, and about
    /// another normal than the shading frame's.
    #[inline]
    pub fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        if self.normal.is_some() {
            return Rgb::ZERO;
        }
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        let albedo = match self.diffuse() {
            Some(b) => b.albedo(wo),
            None => self.diffuse_albedo_other(wo),
        };
        albedo.clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The reflection by microfacets that a surface of metal, coated plastic or the principled model has over its diffuse base; `None`
    /// for other kinds, about another normal than the shading frame's, and on the side that scatters nothing.
    #[inline]
    pub(crate) fn gloss(&self, wo: Vec3) -> Option<Gloss> {
        if self.normal.is_some() || self.model.is_diffuse() {
            return None;
        }
        self.gloss_other(if self.turned(wo) { mirrored(wo) } else { wo })
    }

    /// Lowest roughness alpha of the smooth lobes, at most 1; 1 for diffuse kinds, 0 without smooth lobes.
    #[inline]
    pub fn roughness(&self) -> f32 {
        self.model.roughness()
    }

    #[inline]
    fn turned(&self, wo: Vec3) -> bool {
        self.turns() && wo.z < 0.0
    }

    /// Whether it scatters to both sides alike.
    #[inline(always)]
    pub(super) fn turns(&self) -> bool {
        self.model.turns()
    }

    /// Most of most scenes: it is worth a short way of its own.
    #[inline]
    pub(super) fn diffuse(&self) -> Option<Diffuse> {
        (self.model.is_diffuse() && self.normal.is_none()).then_some(Diffuse { reflectance: self.colors[0] })
    }

    #[inline(never)]
    fn eval_pdf_other(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.kind().eval_pdf(wo, wi)
    }

    #[inline(never)]
    fn sample_other(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        self.kind().sample(wo, u_lobe, u)
    }

    #[inline(never)]
    fn albedo_other(&self, wo: Vec3) -> Rgb {
        self.kind().albedo(wo)
    }

    #[inline(never)]
    fn sharp_probability_other(&self, wo: Vec3, alpha: f32) -> f32 {
        let wo = if self.turned(wo) { mirrored(wo) } else { wo };
        self.kind().sharp_probability(wo, alpha)
    }

    #[inline(never)]
    fn eval_pdf_rough_other(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        self.kind().eval_pdf_rough(wo, wi, alpha)
    }

    #[inline(never)]
    fn gloss_other(&self, wo: Vec3) -> Option<Gloss> {
        self.kind().gloss(wo).filter(|_| wo.z > 0.0)
    }

    #[inline(never)]
    fn diffuse_albedo_other(&self, wo: Vec3) -> Rgb {
        self.kind().diffuse_albedo(wo)
    }
}
