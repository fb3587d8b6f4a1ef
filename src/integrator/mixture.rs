//! The mixture of BSDF and guide: the one place where a path's directions are drawn and their density is known.
//!
//! Next-event estimation asks the same `pdf` that `sample` draws from, so its weights are exact.

use crate::bsdf::Bsdf;
use crate::geometry::SurfaceInteraction;
use crate::guiding::GuidingDistribution;
use crate::math::{Rgb, rng::Rng};
use glam::Vec3;

/// BSDFs with a sharper lobe than this are left to their own sampling: strata are too wide for them.
const MIN_GUIDED_ROUGHNESS: f32 = 0.3;

/// With the product of guide and BSDF, down to about the width of a tree's smallest cells.
const MIN_PRODUCT_ROUGHNESS: f32 = 0.05;

/// How directions are chosen at one vertex.
#[derive(Clone, Copy)]
pub struct Mixture<'a> {
    bsdf: &'a Bsdf<'a>,
    guide: Option<&'a GuidingDistribution<'a>>,
    /// Probability of sampling the BSDF; 1 without a guide.
    bsdf_fraction: f32,
}

/// A direction with which the path goes on.
pub struct DirectionSample {
    /// Unit, in world space.
    pub wi: Vec3,
    /// f·|cosθ|/p, p being the density of the whole mixture.
    pub weight: Rgb,
    /// `None` for a delta lobe.
    pub pdf: Option<Densities>,
}

/// Densities of a direction, per steradian.
#[derive(Clone, Copy, Debug)]
pub struct Densities {
    pub mixture: f32,
    pub bsdf: f32,
    /// Negative without a guide.
    pub guide: f32,
}

impl Densities {
    /// Where the BSDF keeps a share of the directions.
    #[inline(always)]
    pub fn mixed(bsdf_fraction: f32, bsdf: f32, guide: f32) -> Densities {
        Densities { mixture: bsdf_fraction * bsdf + (1.0 - bsdf_fraction) * guide, bsdf, guide }
    }

    /// Without a guide.
    #[inline(always)]
    pub fn plain(bsdf: f32) -> Densities {
        Densities { mixture: bsdf, bsdf, guide: -1.0 }
    }
}

impl<'a> Mixture<'a> {
    /// `guide` is what the state knows, `bsdf_fraction` the share that the BSDF keeps where there is a guide.
    #[inline]
    pub fn new(bsdf: &'a Bsdf<'a>, guide: Option<&'a GuidingDistribution<'a>>, bsdf_fraction: f32) -> Mixture<'a> {
        let bsdf_fraction = if guide.is_some() { bsdf_fraction } else { 1.0 };
        Mixture { bsdf, guide, bsdf_fraction }
    }

    /// Whether a guide can help this BSDF; with the product, a sharper one.
    #[inline]
    pub fn guides(bsdf: &Bsdf, product: bool) -> bool {
        bsdf.roughness() >= if product { MIN_PRODUCT_ROUGHNESS } else { MIN_GUIDED_ROUGHNESS }
    }

    /// Value f·|cosθ| of the BSDF's smooth lobes and density of the mixture at `wi` (world space).
    #[inline]
    pub fn eval_pdf(&self, si: &SurfaceInteraction, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if !si.consistent(wi) {
            return (Rgb::ZERO, 0.0);
        }
        let (f, pdf) = self.bsdf.eval_pdf(wo, si.frame.to_local(wi));
        (f, self.density(pdf, wi))
    }

    /// Density of the mixture at `wi` (world space), where the BSDF has the density `bsdf`.
    #[inline(always)]
    pub fn density(&self, bsdf: f32, wi: Vec3) -> f32 {
        self.densities(bsdf, wi).mixture
    }

    #[inline(always)]
    fn densities(&self, bsdf: f32, wi: Vec3) -> Densities {
        match self.guide {
            Some(guide) => Densities::mixed(self.bsdf_fraction, bsdf, guide.pdf(wi)),
            None => Densities::plain(bsdf),
        }
    }

    /// Draws a direction. `wo` is in the shading frame. `None` where the path ends.
    #[inline(always)]
    pub fn sample(&self, si: &SurfaceInteraction, wo: Vec3, rng: &mut Rng) -> Option<DirectionSample> {
        let Some(guide) = self.guide else { return self.sample_bsdf(si, wo, rng) };
        // the same numbers whoever draws, so that a packet draws them side by side
        let (chosen, cell) = (rng.f32(), rng.f64());
        if chosen < self.bsdf_fraction {
            return self.sample_bsdf(si, wo, rng);
        }
        let (wi, guide_pdf) = guide.sample(cell, rng.f32x2());
        if !si.consistent(wi) {
            return None;
        }
        let (f, bsdf_pdf) = self.bsdf.eval_pdf(wo, si.frame.to_local(wi));
        let pdf = Densities::mixed(self.bsdf_fraction, bsdf_pdf, guide_pdf);
        (f != Rgb::ZERO && pdf.mixture > 0.0).then(|| DirectionSample { wi, weight: f / pdf.mixture, pdf: Some(pdf) })
    }

    #[inline(always)]
    fn sample_bsdf(&self, si: &SurfaceInteraction, wo: Vec3, rng: &mut Rng) -> Option<DirectionSample> {
        // Lambert's law has one lobe
        let lobe = if self.bsdf.lambertian().is_some() { 0.0 } else { rng.f32() };
        let drawn = self.bsdf.sample(wo, lobe, rng.f32x2())?;
        let wi = si.frame.to_world(drawn.wi);
        if !si.consistent(wi) || drawn.weight == Rgb::ZERO {
            return None;
        }
        if drawn.delta {
            return Some(DirectionSample { wi, weight: drawn.weight / self.bsdf_fraction, pdf: None });
        }
        let pdf = self.densities(drawn.pdf, wi);
        Some(DirectionSample { wi, weight: drawn.weight * (drawn.pdf / pdf.mixture), pdf: Some(pdf) })
    }
}

#[cfg(test)]
#[path = "mixture_tests.rs"]
pub mod tests;
