//! Rough metal (Cook & Torrance 1982, in the form of Walter et al. 2007).

use super::conductor::Metal;
use super::lanes::{LobeNumbers, SameMaterial};
use super::microfacet::{Microfacet, sin_cos_turn};
use super::model::Prepared;
use super::multiple_scattering::{Loss, LossTable};
use super::{BLACK, BsdfSample, Gloss, Scatter, choice, fresnel};
use crate::math::Rgb;
use crate::math::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use crate::simd::{Lanes, Vec3Lanes};
use glam::Vec3;
use std::sync::Arc;

/// A rough metal; how much it reflects may vary from place to place.
#[derive(Clone, Debug)]
pub(crate) struct RoughConductorModel {
    metal: Metal,
    microfacet: Microfacet,
    /// What facets lose, and the mean over directions of what the metal reflects.
    multiple: Option<(Arc<LossTable>, Rgb)>,
}

impl RoughConductorModel {
    /// With `loss`, which is that of `microfacet`, light that facets send to each other comes back.
    pub(super) fn new(metal: Metal, microfacet: Microfacet, loss: Option<Arc<LossTable>>) -> RoughConductorModel {
        RoughConductorModel { metal, microfacet, multiple: loss.map(|loss| (loss, metal.mean_fresnel())) }
    }

    /// [`Prepared::at`], where it is known already that this is the metal, that its facets are GGX's and that what they send to each
    /// other is lost: a loop over lanes that is told so has no jump.
    #[inline(always)]
    fn plain_ggx(&self, metal: Metal, [reflectance, _]: [Rgb; 2]) -> RoughConductor<'_> {
        RoughConductor { metal, reflectance, microfacet: self.microfacet.known_as_ggx(), multiple: None }
    }
}

impl Prepared for RoughConductorModel {
    type At<'s> = RoughConductor<'s>;

    #[inline(always)]
    fn colors(&self, [reflectance, other]: [Rgb; 2]) -> [Rgb; 2] {
        let returned = |(loss, mean): &(Arc<LossTable>, Rgb)| loss.at(0.0).returned(*mean * reflectance);
        [reflectance, self.multiple.as_ref().map_or(other, returned)]
    }

    #[inline(always)]
    fn at(&self, [reflectance, returned]: [Rgb; 2]) -> RoughConductor<'_> {
        let multiple = self.multiple.as_ref().map(|(loss, _)| (loss.at(0.0), returned));
        RoughConductor { metal: self.metal, reflectance, microfacet: self.microfacet, multiple }
    }

    fn in_lanes(&self) -> bool {
        self.microfacet.is_ggx() && self.multiple.is_none()
    }

    #[inline(never)]
    fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        match self.metal {
            Metal::Perfect => surfaces.eval_pdf(wi, |colors| self.plain_ggx(Metal::Perfect, colors), f, pdf),
            Metal::Index { eta, k } => {
                surfaces.eval_pdf(wi, |colors| self.plain_ggx(Metal::Index { eta, k }, colors), f, pdf);
            }
        }
    }

    #[inline(never)]
    fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
        // which metal it is makes no difference to directions
        let at = |colors| self.plain_ggx(Metal::Perfect, colors);
        surfaces.draw(numbers, |colors, wo, lobe, u, turn| at(colors).draw(wo, lobe, u, || turn), wi);
    }

    fn draws_in_lanes(&self) -> bool {
        self.in_lanes()
    }

    #[inline(never)]
    fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        match self.metal {
            Metal::Perfect => surfaces.albedo(|colors| self.plain_ggx(Metal::Perfect, colors), albedo),
            Metal::Index { eta, k } => {
                surfaces.albedo(|colors| self.plain_ggx(Metal::Index { eta, k }, colors), albedo);
            }
        }
    }
}

/// f = F·D·G/(4 cosθo cosθi) times `reflectance`; and what facets send to each other, or else that is lost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughConductor<'s> {
    metal: Metal,
    reflectance: Rgb,
    microfacet: Microfacet,
    /// The lobe of multiple scattering and its colour.
    multiple: Option<(Loss<'s>, Rgb)>,
}

impl RoughConductor<'_> {
    /// Albedos from wo, above the horizon: of single and of multiple scattering. Without the latter, as if no facet hid another.
    #[inline(always)]
    fn albedos(&self, wo: Vec3) -> (Rgb, Rgb) {
        let single = self.metal.fresnel(wo.z) * self.reflectance;
        self.multiple.map_or((single, Rgb::ZERO), |(loss, color)| {
            let lost = loss.at(wo.z);
            (single * (1.0 - lost), color * lost)
        })
    }

    /// Probability of drawing by the facets; `None` where nothing is reflected.
    #[inline(always)]
    fn single_share(&self, wo: Vec3) -> Option<f32> {
        if self.multiple.is_none() {
            return Some(1.0);
        }
        let (single, multiple) = self.albedos(wo);
        choice(single, multiple)
    }

    /// The direction of [`Scatter::sample`]; `turn` as of [`Microfacet::sample_visible_with`].
    #[inline(always)]
    fn draw(&self, wo: Vec3, u_lobe: f32, u: [f32; 2], turn: impl Fn() -> (f32, f32)) -> Option<Vec3> {
        if wo.z <= 0.0 {
            return None;
        }
        if u_lobe < self.single_share(wo)? {
            sample_reflection(&self.microfacet, wo, u, turn)
        } else {
            Some(square_to_cosine_hemisphere(u))
        }
    }

    /// The lobe of multiple scattering, and its density times the probability of drawing by it.
    #[inline(always)]
    fn eval_pdf_multiple(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        match (self.multiple, self.single_share(wo)) {
            (Some((loss, color)), Some(share)) if wo.z > 0.0 && wi.z > 0.0 => {
                (color * loss.lobe(wo.z, wi.z), (1.0 - share) * square_to_cosine_hemisphere_pdf(wi))
            }
            _ => BLACK,
        }
    }
}

impl Scatter for RoughConductor<'_> {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some((m, pdf)) = reflection_pdf(&self.microfacet, wo, wi) else { return BLACK };
        let Some(share) = self.single_share(wo) else { return BLACK };
        let single = self.metal.fresnel(wo.dot(m)) * self.reflectance * (pdf * self.microfacet.g1(wi));
        let (multiple, multiple_pdf) = self.eval_pdf_multiple(wo, wi);
        (single + multiple, share * pdf + multiple_pdf)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let wi = self.draw(wo, u_lobe, u, || sin_cos_turn(u[0]))?;
        BsdfSample::smooth(wi, self.eval_pdf(wo, wi), 1.0)
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z <= 0.0 {
            return Rgb::ZERO;
        }
        let (single, multiple) = self.albedos(wo);
        single + multiple
    }

    fn roughness(&self) -> f32 {
        self.microfacet.alpha()
    }

    fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        if wo.z <= 0.0 {
            return 1.0;
        }
        self.single_share(wo).map_or(1.0, |share| if self.roughness() < alpha { share } else { 0.0 })
    }

    fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        if self.roughness() < alpha { self.eval_pdf_multiple(wo, wi) } else { self.eval_pdf(wo, wi) }
    }

    fn gloss(&self, wo: Vec3) -> Option<Gloss> {
        let (single, multiple) = self.albedos(wo);
        Gloss::new(self.roughness(), single, multiple)
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.albedos(wo).1 } else { Rgb::ZERO }
    }
}

/// The facet that mirrors wo to wi, and the density of wi when visible normals are drawn and mirrored:
/// D(m)·G1(wo)/(4 cosθo). Both directions above the horizon, else `None`.
#[inline(always)]
pub(super) fn reflection_pdf(microfacet: &Microfacet, wo: Vec3, wi: Vec3) -> Option<(Vec3, f32)> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    let m = (wo + wi).try_normalize().filter(|m| m.z > 0.0)?;
    Some((m, 0.25 * microfacet.d(m) * microfacet.g1_over_cos(wo)))
}

/// `wo` mirrored at a visible normal; `None` below the horizon. `turn` as of [`Microfacet::sample_visible_with`].
#[inline(always)]
pub(super) fn sample_reflection(
    microfacet: &Microfacet,
    wo: Vec3,
    u: [f32; 2],
    turn: impl Fn() -> (f32, f32),
) -> Option<Vec3> {
    if wo.z <= 0.0 {
        return None;
    }
    let wi = fresnel::reflect(wo, microfacet.sample_visible_with(wo, u, turn)).normalize();
    (wi.z > 0.0).then_some(wi)
}
