//! Where paths go on from the vertices of a packet, drawn side by side.

use super::packet::Packet;
use crate::integrator::mixture::{Densities, DirectionSample, lobe_number};
use crate::integrator::sampler::{DirectionNumbers, Sampler};
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each, mask, pick};

/// Random numbers of the vertices that draw side by side.
struct RandomInputs {
    /// Whether it is the guide that draws; else the BSDF.
    by_guide: Mask,
    /// Which cell the guide draws.
    cell: [f64; LANES],
    /// A direction of the BSDF, or within the guide's cell.
    u: [Lanes; 2],
}

/// What comes of them: as of [`Mixture::sample`] by itself.
///
/// [`Mixture::sample`]: crate::integrator::mixture::Mixture::sample
pub(super) struct DirectionSamples {
    pub(crate) dir: Vec3Lanes,
    /// Where the ray begins.
    pub(crate) org: Vec3Lanes,
    pub(crate) weight: Vec3Lanes,
    pub(crate) mixture: Lanes,
    pub(crate) bsdf: Lanes,
    pub(crate) guide: Lanes,
    /// Whether the path goes on.
    pub(crate) goes: Mask,
    /// Whether it was the guide that drew.
    pub(crate) by_guide: Mask,
    /// f·|cosθ| of directions that the guide drew.
    value: Vec3Lanes,
}

/// Directions that BSDFs drew without a guide: as of [`Mixture::sample`] by itself.
///
/// [`Mixture::sample`]: crate::integrator::mixture::Mixture::sample
pub(super) struct UnguidedSamples {
    pub(crate) dir: Vec3Lanes,
    /// Where the ray begins.
    pub(crate) org: Vec3Lanes,
    pub(crate) weight: Vec3Lanes,
    /// Infinite for a delta lobe.
    pub(crate) pdf: Lanes,
    /// Whether the path goes on.
    pub(crate) goes: Mask,
}

impl Packet<'_> {
    /// Draws directions at these vertices, none of which a guide leads.
    #[inline(always)]
    pub(crate) fn draw_unguided(&self, draws: Mask, numbers: &DirectionNumbers<LANES>) -> UnguidedSamples {
        let (surfaces, mut lobe) = (&self.surfaces, [0.0; LANES]);
        for k in 0..LANES {
            lobe[k] = lobe_number(numbers.cell[k]);
        }
        let [mut local, mut dir, mut org, mut weight] = [Vec3Lanes::ZERO; 4];
        let (mut pdf, numbers_of_lobes) = ([0.0; LANES], (&lobe, &numbers.point));
        let together =
            self.bsdfs.sample(draws, surfaces.wo_locals(), numbers_of_lobes, [&mut local, &mut weight], &mut pdf);
        surfaces.to_world(&local, &mut dir);
        let scatters = mask(|k| (pdf[k] > 0.0) & (weight.get(k) != Rgb::ZERO));
        let mut goes = together & scatters & mask(|k| surfaces.consistent(k, dir.get(k)));
        for k in each(draws & !together) {
            let (si, wo) = (surfaces.get(k), surfaces.wo_local(k));
            let next = self.with_mixture(k, |mixture| mixture.sample(&si, wo, &numbers.get(k))).flatten();
            goes.set(k, next.is_some());
            if let Some(DirectionSample { wi, weight: drawn, pdf: densities }) = next {
                dir.set(k, wi);
                weight.set(k, drawn);
                pdf[k] = densities.map_or(f32::INFINITY, |densities| densities.mixture);
            }
        }
        surfaces.spawn(&dir, &mut org);
        UnguidedSamples { dir, org, weight, pdf, goes }
    }

    /// Draws directions at these vertices, each of which is [`Packet::vectorised`], and the `vertex`th of its path from 1 on.
    #[inline(always)]
    pub(crate) fn propose(&self, draws: Mask, sampler: Sampler, vertex: u32) -> DirectionSamples {
        let numbers = self.draw_numbers(draws, sampler, vertex);
        let surfaces = &self.surfaces;
        let mut proposals = DirectionSamples {
            dir: Vec3Lanes::ZERO,
            org: Vec3Lanes::ZERO,
            weight: Vec3Lanes::ZERO,
            mixture: [0.0; LANES],
            bsdf: [0.0; LANES],
            guide: [-1.0; LANES],
            goes: draws,
            by_guide: numbers.by_guide,
            value: Vec3Lanes::ZERO,
        };
        let mut local = Vec3Lanes::ZERO;
        self.bsdfs.diffuse().sample(surfaces.wo_locals(), &numbers.u, &mut local, &mut proposals.bsdf);
        surfaces.to_world(&local, &mut proposals.dir);
        if self.trees().any() {
            self.propose_by_guide(&numbers, &mut proposals);
        }
        surfaces.spawn(&proposals.dir, &mut proposals.org);
        self.weigh(&numbers, &mut proposals);
        proposals
    }

    #[inline(always)]
    fn draw_numbers(&self, draws: Mask, sampler: Sampler, vertex: u32) -> RandomInputs {
        if !self.trees().any() {
            let u = sampler.direction_point(&self.keys, vertex);
            return RandomInputs { by_guide: Mask::NONE, cell: [0.0; LANES], u };
        }
        let numbers = sampler.direction(&self.keys, vertex);
        let chosen = mask(|k| numbers.chooser[k] >= self.bsdf_fraction()[k]);
        RandomInputs { by_guide: draws & self.trees().are() & chosen, cell: numbers.cell, u: numbers.point }
    }

    /// Puts the guide's directions among those of the BSDF, and finds what either makes of the other's.
    #[inline(always)]
    fn propose_by_guide(
        &self,
        RandomInputs { by_guide, cell, u, .. }: &RandomInputs,
        proposals: &mut DirectionSamples,
    ) {
        let (mut dir, mut guide) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.trees().sample(*by_guide, cell, u, &mut dir, &mut guide);
        // what neither draws has no use for a density
        let by_bsdf = proposals.goes & !*by_guide;
        let (by_guide, trees) = (by_guide.lanes(), self.trees().are().lanes());
        for k in 0..LANES {
            proposals.dir.set(k, pick(by_guide.has(k), dir.get(k), proposals.dir.get(k)));
        }
        self.trees().pdf(by_bsdf, &proposals.dir, &mut proposals.guide);
        let (mut local, mut bsdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.surfaces.to_local(&proposals.dir, &mut local);
        self.bsdfs.diffuse().eval_pdf(self.surfaces.wo_locals(), &local, &mut proposals.value, &mut bsdf);
        for k in 0..LANES {
            let guided = pick(by_guide.has(k), guide[k], proposals.guide[k]);
            proposals.guide[k] = pick(trees.has(k), guided, -1.0);
            proposals.bsdf[k] = pick(by_guide.has(k), bsdf[k], proposals.bsdf[k]);
        }
    }

    /// Densities of the mixture and weights of what was drawn, and whether the path goes on.
    #[inline(always)]
    fn weigh(&self, RandomInputs { by_guide, .. }: &RandomInputs, proposals: &mut DirectionSamples) {
        let guided = by_guide.lanes();
        for k in 0..LANES {
            let (bsdf, reflectance) = (proposals.bsdf[k], self.bsdfs.diffuse().reflectance(k));
            let mixed = Densities::mixed(self.bsdf_fraction()[k], bsdf, proposals.guide[k]).mixture;
            let mixture = pick(proposals.guide[k] < 0.0, bsdf, mixed);
            proposals.mixture[k] = mixture;
            let (by_guide, by_bsdf) = (proposals.value.get(k) / mixture, reflectance * (bsdf / mixture));
            proposals.weight.set(k, pick(guided.has(k), by_guide, by_bsdf));
        }
        let drawn_by_guide = mask(|k| (proposals.value.get(k) != Rgb::ZERO) & (proposals.mixture[k] > 0.0));
        let reflects = |k| self.bsdfs.diffuse().reflectance(k) != Rgb::ZERO;
        let drawn_by_bsdf = mask(|k| (proposals.bsdf[k] > 0.0) & reflects(k));
        let drawn = (*by_guide & drawn_by_guide) | (!*by_guide & drawn_by_bsdf);
        proposals.goes = proposals.goes & drawn & mask(|k| self.surfaces.consistent(k, proposals.dir.get(k)));
    }
}

#[cfg(test)]
#[path = "draw_tests.rs"]
mod tests;
