//! The principled model where metallic, roughness or specular are pictures.

use super::super::model::Prepared;
use super::super::{BsdfSample, Scatter};
use super::{Principled, PrincipledLobes};
use crate::math::Rgb;
use glam::Vec3;

/// [`PrincipledLobes`] where numbers come from pictures: the second colour is metallic, roughness and specular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexturedPrincipledModel {
    lobes: PrincipledLobes,
}

impl TexturedPrincipledModel {
    /// `lobes`: what is constant.
    pub(super) fn new(lobes: PrincipledLobes) -> TexturedPrincipledModel {
        TexturedPrincipledModel { lobes }
    }
}

impl Prepared for TexturedPrincipledModel {
    type At<'s> = TexturedPrincipled;

    #[inline(always)]
    fn at(&self, [base_color, shares]: [Rgb; 2]) -> TexturedPrincipled {
        TexturedPrincipled { base_color, lobes: self.lobes.with(shares) }
    }
}

/// [`Principled`] with numbers of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexturedPrincipled {
    base_color: Rgb,
    lobes: PrincipledLobes,
}

impl TexturedPrincipled {
    fn principled(&self) -> Principled<'_> {
        Principled { base_color: self.base_color, lobes: &self.lobes }
    }
}

impl Scatter for TexturedPrincipled {
    const SMOOTH: bool = true;
    const OPAQUE: bool = true;

    fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.principled().eval_pdf(wo, wi)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        self.principled().sample(wo, u_lobe, u)
    }

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

    fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        self.principled().diffuse_albedo(wo)
    }
}
