//! The mixture of BSDF and guide: the one place where a path's directions are drawn and their density is known.
//!
//! A guide stands in for the rough lobes of a BSDF only. Sharp lobes are drawn as often as without a guide; of the
//! directions that the rough ones would draw, the guide draws a share.
//!
//! Next-event estimation asks the same `pdf` that `sample` draws from, so its weights are exact.

use crate::bsdf::{Bsdf, Gloss};
use crate::geometry::SurfaceInteraction;
use crate::guiding::{Field, GlossyLobe, GuidingDistribution, RegionInfo};
use crate::integrator::sampler::DirectionNumbers;
use crate::math::{Frame, Rgb};
use glam::Vec3;

/// Lobes of less roughness than this are left to the BSDF's own sampling: strata are too wide for them.
const MIN_GUIDED_ROUGHNESS: f32 = 0.3;

/// With the product of guide and BSDF, down to about the width of a tree's smallest cells.
const MIN_PRODUCT_ROUGHNESS: f32 = 0.05;

/// With the product along the drawn path, down to about the width of the cells at which it ends.
const MIN_GLOSSY_ROUGHNESS: f32 = 0.08;

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// The number by which a BSDF chooses its lobe where no guide draws, from the one that would choose the guide's cell.
#[inline(always)]
pub(crate) fn lobe_number(cell: f64) -> f32 {
    (cell as f32).min(BELOW_ONE)
}

/// What a guide's directions are drawn in proportion to, where it stands in for lobes of a BSDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GuidedBy {
    /// Radiance and cosine, or radiance alone.
    Radiance,
    /// The product with a glossy reflection, along the path that is drawn.
    GlossyProduct,
    /// The product with the BSDF itself, in every cell.
    FullProduct,
}

/// The lobes of a BSDF for which a guide may stand in: those of at least a certain roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuidedLobes {
    /// The least roughness.
    alpha: f32,
    /// Probability that the BSDF by itself draws from another lobe.
    sharp: f32,
}

impl GuidedLobes {
    /// All lobes, of Lambert's law for example.
    pub(crate) const ALL: GuidedLobes = GuidedLobes { alpha: 0.0, sharp: 0.0 };

    /// Of a BSDF seen from `wo` (shading frame). Products help sharper lobes too.
    #[inline]
    pub(crate) fn of(bsdf: &Bsdf, wo: Vec3, by: GuidedBy) -> GuidedLobes {
        let alpha = match by {
            GuidedBy::Radiance => MIN_GUIDED_ROUGHNESS,
            GuidedBy::GlossyProduct => MIN_GLOSSY_ROUGHNESS,
            GuidedBy::FullProduct => MIN_PRODUCT_ROUGHNESS,
        };
        GuidedLobes { alpha, sharp: bsdf.sharp_probability(wo, alpha) }
    }

    /// Probability that the BSDF by itself draws from one of these lobes; 0 where a guide cannot help.
    #[inline(always)]
    pub(crate) fn share(&self) -> f32 {
        1.0 - self.sharp
    }

    /// Probability that the BSDF by itself draws from another lobe.
    #[inline(always)]
    pub(crate) fn sharp(&self) -> f32 {
        self.sharp
    }

    /// Value f·|cosθ| of these lobes and their part in the BSDF's density; both directions in the shading frame. `whole` is
    /// what the BSDF itself gives.
    #[inline(always)]
    pub(crate) fn eval_pdf(&self, bsdf: &Bsdf, wo: Vec3, wi: Vec3, whole: (Rgb, f32)) -> (Rgb, f32) {
        if self.sharp == 0.0 { whole } else { bsdf.eval_pdf_rough(wo, wi, self.alpha) }
    }
}

/// The product of what is known of a region with the glossy reflection of a surface with this shading frame, seen from `wo` in it,
/// and the lobes that it stands in for; `n` is the surface's normal on the side of `wo`. `None` where the guide does as well
/// without: where facets are so rough that it stands in for them by itself, or so sharp that the BSDF does, and where the base
/// reflects more than they do; and where the guide knows no such product.
#[inline]
pub(crate) fn glossy_product<'f>(
    (field, region): (Field<'f>, &RegionInfo),
    bsdf: &Bsdf,
    wo: Vec3,
    (frame, n): (&Frame, Vec3),
) -> Option<(GuidedLobes, GuidingDistribution<'f>)> {
    let Gloss { alpha, specular, diffuse } = bsdf.gloss(wo)?;
    if !(MIN_GLOSSY_ROUGHNESS..MIN_GUIDED_ROUGHNESS).contains(&alpha) || specular <= diffuse {
        return None;
    }
    let lobe = GlossyLobe { wo: frame.to_world(wo), n, alpha, specular, diffuse };
    Some((GuidedLobes::of(bsdf, wo, GuidedBy::GlossyProduct), field.product(region, n, &lobe)?))
}

/// How directions are chosen at one vertex.
#[derive(Clone, Copy)]
pub(crate) struct Mixture<'a> {
    bsdf: &'a Bsdf<'a>,
    guide: Option<&'a GuidingDistribution<'a>>,
    lobes: GuidedLobes,
    /// Of the directions of the guided lobes, the share that the BSDF keeps; 1 without a guide.
    bsdf_fraction: f32,
}

/// A direction with which the path goes on.
pub(crate) struct DirectionSample {
    /// Unit, in world space.
    pub(crate) wi: Vec3,
    /// f·|cosθ|/p, p being the density of the whole mixture.
    pub(crate) weight: Rgb,
    /// `None` for a delta lobe.
    pub(crate) pdf: Option<Densities>,
}

/// Densities of a direction, per steradian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Densities {
    pub(crate) mixture: f32,
    /// Of the BSDF's guided lobes by themselves; of all of them where none is guided.
    pub(crate) bsdf: f32,
    /// Negative without a guide.
    pub(crate) guide: f32,
}

impl Densities {
    /// Where the BSDF keeps a share of the directions, and all of its lobes are guided.
    #[inline(always)]
    pub(crate) fn mixed(bsdf_fraction: f32, bsdf: f32, guide: f32) -> Densities {
        Densities { mixture: bsdf_fraction * bsdf + (1.0 - bsdf_fraction) * guide, bsdf, guide }
    }
}

impl<'a> Mixture<'a> {
    /// `guide` is what the state knows, `bsdf_fraction` the share of the guided lobes' directions that the BSDF keeps where
    /// there is a guide.
    #[inline]
    pub(crate) fn new(
        bsdf: &'a Bsdf<'a>,
        guide: Option<&'a GuidingDistribution<'a>>,
        bsdf_fraction: f32,
        lobes: GuidedLobes,
    ) -> Mixture<'a> {
        let bsdf_fraction = if guide.is_some() { bsdf_fraction } else { 1.0 };
        Mixture { bsdf, guide, lobes, bsdf_fraction }
    }

    /// Whether the BSDF has smooth lobes: else a guide could not help.
    #[inline(always)]
    pub(crate) fn is_smooth(&self) -> bool {
        self.bsdf.has_smooth()
    }

    /// Probability that the BSDF draws: all that is of other lobes, and its share of the guided ones.
    #[inline(always)]
    fn bsdf_probability(&self) -> f32 {
        self.lobes.sharp + self.bsdf_fraction * self.lobes.share()
    }

    /// Value f·|cosθ| of the BSDF's smooth lobes and density of the mixture at `wi` (world space).
    #[inline]
    pub(crate) fn eval_pdf(&self, si: &SurfaceInteraction, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if !si.consistent(wi) {
            return (Rgb::ZERO, 0.0);
        }
        let local = si.frame.to_local(wi);
        let (f, pdf) = self.bsdf.eval_pdf(wo, local);
        let mixture = self.guide.map_or(pdf, |guide| self.densities(wo, local, (f, pdf), guide.pdf(wi)).mixture);
        (f, mixture)
    }

    /// Densities of the direction `wi` (shading frame), where the BSDF is `whole` and the guide has the density `guide`,
    /// negative where there is none.
    #[inline(always)]
    fn densities(&self, wo: Vec3, wi: Vec3, whole: (Rgb, f32), guide: f32) -> Densities {
        let (pdf, share) = (whole.1, self.lobes.share());
        if share == 0.0 {
            return Densities { mixture: pdf, bsdf: pdf, guide };
        }
        let rough = self.lobes.eval_pdf(self.bsdf, wo, wi, whole).1.min(pdf);
        let bsdf = rough / share;
        if guide < 0.0 {
            return Densities { mixture: pdf, bsdf, guide };
        }
        let mixed = Densities::mixed(self.bsdf_fraction, rough, share * guide);
        Densities { mixture: mixed.mixture + (pdf - rough), bsdf, guide }
    }

    /// Whether it is the guide that draws the direction of these numbers.
    #[inline(always)]
    pub(crate) fn chooses_guide(&self, numbers: &DirectionNumbers<1>) -> bool {
        self.guide.is_some() && numbers.chooser[0] >= self.bsdf_probability()
    }

    /// Draws a direction. `wo` is in the shading frame. `None` where the path ends.
    #[inline(always)]
    pub(crate) fn sample(
        &self,
        si: &SurfaceInteraction,
        wo: Vec3,
        numbers: &DirectionNumbers<1>,
    ) -> Option<DirectionSample> {
        let guide = self.guide.filter(|_| self.chooses_guide(numbers));
        let Some(guide) = guide else { return self.sample_bsdf(si, wo, numbers) };
        let (wi, guide_pdf) = guide.sample(numbers.cell[0], numbers.point.map(|[u]| u));
        if !si.consistent(wi) {
            return None;
        }
        let local = si.frame.to_local(wi);
        let (f, bsdf_pdf) = self.bsdf.eval_pdf(wo, local);
        let pdf = self.densities(wo, local, (f, bsdf_pdf), guide_pdf);
        (f != Rgb::ZERO && pdf.mixture > 0.0).then(|| DirectionSample { wi, weight: f / pdf.mixture, pdf: Some(pdf) })
    }

    #[inline(always)]
    fn sample_bsdf(&self, si: &SurfaceInteraction, wo: Vec3, numbers: &DirectionNumbers<1>) -> Option<DirectionSample> {
        let lobe = self.lobe(lobe_number(numbers.cell[0]));
        let drawn = self.bsdf.sample(wo, lobe, numbers.point.map(|[u]| u))?;
        let wi = si.frame.to_world(drawn.wi);
        if !si.consistent(wi) || drawn.weight == Rgb::ZERO {
            return None;
        }
        if drawn.delta {
            // delta lobes are sharp, and drawn as often as without a guide
            return Some(DirectionSample { wi, weight: drawn.weight, pdf: None });
        }
        let guide_pdf = self.guide.map_or(-1.0, |guide| guide.pdf(wi));
        let pdf = self.densities(wo, drawn.wi, (drawn.weight * drawn.pdf, drawn.pdf), guide_pdf);
        Some(DirectionSample { wi, weight: drawn.weight * (drawn.pdf / pdf.mixture), pdf: Some(pdf) })
    }

    /// The number by which the BSDF chooses its lobe, from a uniform one: given that the guide does not draw, sharp lobes
    /// are the more probable the more of the others' directions the guide draws.
    #[inline(always)]
    fn lobe(&self, u: f32) -> f32 {
        let (sharp, chosen) = (self.lobes.sharp, u * self.bsdf_probability());
        if self.guide.is_none() || sharp == 0.0 {
            u
        } else if chosen < sharp {
            chosen
        } else {
            (sharp + (chosen - sharp) / self.bsdf_fraction).min(BELOW_ONE)
        }
    }
}

#[cfg(test)]
#[path = "mixture_tests.rs"]
pub(crate) mod tests;
