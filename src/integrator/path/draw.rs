//! Where paths go on from the vertices of a packet, drawn side by side.

use super::packet::Packet;
use crate::integrator::mixture::{Densities, DirectionSample};
use crate::math::Rgb;
use crate::math::lanes::{LANES, Lanes, Mask, Vec3Lanes, mask};

/// Random numbers of the vertices that draw side by side, in the order in which a vertex by itself draws them.
struct Numbers {
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
pub(super) struct Proposals {
    pub dir: Vec3Lanes,
    /// Where the ray begins.
    pub org: Vec3Lanes,
    pub weight: Vec3Lanes,
    pub mixture: Lanes,
    bsdf: Lanes,
    guide: Lanes,
    /// Whether the path goes on.
    pub goes: Mask,
    /// f·|cosθ| of directions that the guide drew.
    value: Vec3Lanes,
}

impl Proposals {
    #[inline(always)]
    pub fn get(&self, k: usize) -> DirectionSample {
        let pdf = Densities { mixture: self.mixture[k], bsdf: self.bsdf[k], guide: self.guide[k] };
        DirectionSample { wi: self.dir.get(k), weight: self.weight.get(k), pdf: Some(pdf) }
    }
}

impl Packet<'_> {
    /// Draws directions at these vertices, each of which is [`Packet::wide`].
    #[inline(always)]
    pub fn propose(&mut self, draws: &Mask) -> Proposals {
        let numbers = self.draw_numbers(draws);
        let surfaces = &self.surfaces;
        let mut proposals = Proposals {
            dir: Vec3Lanes::ZERO,
            org: Vec3Lanes::ZERO,
            weight: Vec3Lanes::ZERO,
            mixture: [0.0; LANES],
            bsdf: [0.0; LANES],
            guide: [-1.0; LANES],
            goes: *draws,
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
    fn draw_numbers(&mut self, draws: &Mask) -> Numbers {
        let mut cell = [0.0; LANES];
        let (mut by_guide, mut by_bsdf) = ([false; LANES], *draws);
        if self.trees().any() {
            let guided = mask(|k| draws[k] & self.trees().are()[k]);
            let chosen = self.rng.f32(&guided);
            by_guide = mask(|k| guided[k] & (chosen[k] >= self.bsdf_fraction()[k]));
            by_bsdf = mask(|k| draws[k] & !by_guide[k]);
            cell = self.rng.f64(&by_guide);
        }
        // which lobe, where a BSDF has several
        self.rng.f32(&by_bsdf);
        Numbers { by_guide, cell, u: [self.rng.f32(draws), self.rng.f32(draws)] }
    }

    /// Puts the guide's directions among those of the BSDF, and finds what either makes of the other's.
    #[inline(always)]
    fn propose_by_guide(&self, Numbers { by_guide, cell, u, .. }: &Numbers, proposals: &mut Proposals) {
        let (mut dir, mut guide) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.trees().sample(by_guide, cell, u, &mut dir, &mut guide);
        for k in 0..LANES {
            proposals.dir.set(k, if by_guide[k] { dir.get(k) } else { proposals.dir.get(k) });
        }
        self.trees().pdf(&mask(|k| !by_guide[k]), &proposals.dir, &mut proposals.guide);
        let (mut local, mut bsdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.surfaces.to_local(&proposals.dir, &mut local);
        self.bsdfs.diffuse().eval_pdf(self.surfaces.wo_locals(), &local, &mut proposals.value, &mut bsdf);
        for k in 0..LANES {
            let guided = if by_guide[k] { guide[k] } else { proposals.guide[k] };
            proposals.guide[k] = if self.trees().are()[k] { guided } else { -1.0 };
            proposals.bsdf[k] = if by_guide[k] { bsdf[k] } else { proposals.bsdf[k] };
        }
    }

    /// Densities of the mixture and weights of what was drawn, and whether the path goes on.
    #[inline(always)]
    fn weigh(&self, Numbers { by_guide, .. }: &Numbers, proposals: &mut Proposals) {
        for k in 0..LANES {
            let (bsdf, reflectance) = (proposals.bsdf[k], self.bsdfs.diffuse().reflectance(k));
            let mixed = Densities::mixed(self.bsdf_fraction()[k], bsdf, proposals.guide[k]).mixture;
            let mixture = if proposals.guide[k] < 0.0 { bsdf } else { mixed };
            let (f, share) = (proposals.value.get(k), bsdf / mixture);
            proposals.mixture[k] = mixture;
            proposals.weight.set(k, if by_guide[k] { f / mixture } else { reflectance * share });
            let drawn = if by_guide[k] {
                (f != Rgb::ZERO) & (mixture > 0.0)
            } else {
                (bsdf > 0.0) & (reflectance != Rgb::ZERO)
            };
            proposals.goes[k] &= drawn & self.surfaces.consistent(k, proposals.dir.get(k));
        }
    }
}

#[cfg(test)]
#[path = "draw_tests.rs"]
mod tests;
