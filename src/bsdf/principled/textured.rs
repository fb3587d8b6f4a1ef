//! The principled model where metallic, roughness or specular are pictures.

use super::super::lanes::{LobeNumbers, SameMaterial};
use super::super::model::Prepared;
use super::super::multiple_scattering::Loss;
use super::super::{BsdfSample, Gloss, Scatter};
use super::{Principled, PrincipledLobes, PrincipledModel};
use crate::math::Rgb;
use crate::simd::{Lanes, Vec3Lanes};
use glam::Vec3;

/// [`PrincipledModel`] where numbers come from pictures: the second colour is metallic, roughness and specular.
#[derive(Clone, Debug)]
pub(crate) struct TexturedPrincipledModel(pub(super) PrincipledModel);

impl TexturedPrincipledModel {
    /// [`Prepared::at`], where it is known that light which facets send to each other is lost.
    #[inline(always)]
    fn without_loss(&self, [base_color, shares]: [Rgb; 2]) -> TexturedPrincipled<'_> {
        TexturedPrincipled { base_color, lobes: self.0.lobes.with(shares), loss: None }
    }
}

impl Prepared for TexturedPrincipledModel {
    type At<'s> = TexturedPrincipled<'s>;

    #[inline(always)]
    fn at(&self, [base_color, shares]: [Rgb; 2]) -> TexturedPrincipled<'_> {
        let lobes = self.0.lobes.with(shares);
        TexturedPrincipled { base_color, lobes, loss: self.0.loss(lobes.set.roughness) }
    }

    fn in_lanes(&self) -> bool {
        self.0.loss.is_none()
    }

    #[inline(never)]
    fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        surfaces.eval_pdf(wi, |colors| self.without_loss(colors), f, pdf);
    }

    #[inline(never)]
    fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
        let at = |colors| {
            let at = self.without_loss(colors);
            TexturedPrincipled { lobes: at.lobes.known_without_coat(), ..at }
        };
        let draw = |colors, wo, lobe, u, turn| at(colors).principled().draw(wo, lobe, u, || turn);
        surfaces.draw(numbers, draw, wi);
    }

    fn draws_in_lanes(&self) -> bool {
        self.0.loss.is_none() && self.0.lobes.set.clearcoat == 0.0
    }

    #[inline(never)]
    fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
        surfaces.albedo(|colors| self.without_loss(colors), albedo);
    }
}

/// [`Principled`] with numbers of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexturedPrincipled<'s> {
    base_color: Rgb,
    lobes: PrincipledLobes,
    loss: Option<Loss<'s>>,
}

impl TexturedPrincipled<'_> {
    #[inline(always)]
    fn principled(&self) -> Principled<'_> {
        Principled { base_color: self.base_color, lobes: &self.lobes, loss: self.loss }
    }
}

impl Scatter for TexturedPrincipled<'_> {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    #[inline(always)]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.principled().eval_pdf(wo, wi)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        self.principled().sample(wo, u_lobe, u)
    }

    #[inline(always)]
    fn albedo(&self, wo: Vec3) -> Rgb {
        self.principled().albedo(wo)
    }

    fn roughness(&self) -> f32 {
        self.principled().roughness()
    }

    fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
        self.principled().sharp_probability(wo, alpha)
    }

    fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        self.principled().eval_pdf_rough(wo, wi, alpha)
    }

    fn gloss(&self, wo: Vec3) -> Option<Gloss> {
        self.principled().gloss(wo)
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        self.principled().diffuse_albedo(wo)
    }
}
