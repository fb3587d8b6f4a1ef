//! Where paths go on from the vertices of a packet, drawn side by side.

use super::packet::Packet;
use crate::integrator::mixture::{Densities, DirectionSample};
use crate::math::Rgb;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
use glam::Vec3;

/// Random numbers of the vertices that draw side by side, in the order in which a vertex by itself draws them.
#[derive(Default)]
pub(super) struct Numbers {
    drawn: [bool; LANES],
    /// Whether it is the guide that draws; else the BSDF.
    by_guide: [bool; LANES],
    /// Which cell the guide draws.
    cell: [f64; LANES],
    /// A direction of the BSDF, or within the guide's cell.
    u: [Lanes; 2],
}

/// What comes of them.
pub(super) struct Proposals {
    dir: Vec3Lanes,
    org: Vec3Lanes,
    /// f·|cosθ| of directions that the guide drew.
    value: Vec3Lanes,
    bsdf: Lanes,
    guide: Lanes,
}

impl Numbers {
    /// Whether vertex `k` is one of them.
    #[inline(always)]
    pub fn has(&self, k: usize) -> bool {
        self.drawn[k]
    }
}

impl Packet<'_> {
    /// Draws the numbers of vertex `k`, where [`Packet::is_wide`].
    #[inline(always)]
    pub fn draw_numbers(&mut self, k: usize, numbers: &mut Numbers) {
        let fraction = self.bsdf_fraction(k);
        let rng = &mut self.rng[k];
        let by_guide = fraction.is_some_and(|fraction| rng.f32() >= fraction);
        if by_guide {
            numbers.cell[k] = rng.f64();
        } else {
            // which lobe, where a BSDF has several
            rng.f32();
        }
        let u = rng.f32x2();
        (numbers.u[0][k], numbers.u[1][k]) = (u[0], u[1]);
        (numbers.drawn[k], numbers.by_guide[k]) = (true, by_guide);
    }

    /// Draws directions with these numbers.
    #[inline(always)]
    pub fn propose(&self, numbers: &Numbers) -> Proposals {
        let surfaces = &self.surfaces;
        let mut proposals = Proposals {
            dir: Vec3Lanes::ZERO,
            org: Vec3Lanes::ZERO,
            value: Vec3Lanes::ZERO,
            bsdf: [0.0; LANES],
            guide: [-1.0; LANES],
        };
        let mut local = Vec3Lanes::ZERO;
        self.diffuse.sample(surfaces.wo_locals(), &numbers.u, &mut local, &mut proposals.bsdf);
        surfaces.to_world(&local, &mut proposals.dir);
        if self.trees().any() {
            self.propose_by_guide(numbers, &mut proposals);
        }
        surfaces.spawn(&proposals.dir, &mut proposals.org);
        proposals
    }

    /// Puts the guide's directions among those of the BSDF, and finds what either makes of the other's.
    #[inline(always)]
    fn propose_by_guide(&self, Numbers { by_guide, cell, u, .. }: &Numbers, proposals: &mut Proposals) {
        let (mut dir, mut guide) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.trees().sample(by_guide, cell, u, &mut dir, &mut guide);
        for k in 0..LANES {
            proposals.dir.set(k, if by_guide[k] { dir.get(k) } else { proposals.dir.get(k) });
        }
        self.trees().pdf(&proposals.dir, &mut proposals.guide);
        let (mut local, mut bsdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        self.surfaces.to_local(&proposals.dir, &mut local);
        self.diffuse.eval_pdf(self.surfaces.wo_locals(), &local, &mut proposals.value, &mut bsdf);
        for k in 0..LANES {
            proposals.guide[k] = if by_guide[k] { guide[k] } else { proposals.guide[k] };
            proposals.bsdf[k] = if by_guide[k] { bsdf[k] } else { proposals.bsdf[k] };
        }
    }

    /// What vertex `k` has drawn, as [`Mixture::sample`] by itself, and where its ray begins; `None` where the path ends.
    ///
    /// [`Mixture::sample`]: crate::integrator::mixture::Mixture::sample
    #[inline(always)]
    pub fn proposal(&self, k: usize, numbers: &Numbers, proposals: &Proposals) -> Option<(Vec3, DirectionSample)> {
        let (wi, bsdf, reflectance) = (proposals.dir.get(k), proposals.bsdf[k], self.diffuse.reflectance(k));
        let pdf = match self.bsdf_fraction(k) {
            Some(fraction) => Densities::mixed(fraction, bsdf, proposals.guide[k]),
            None => Densities::plain(bsdf),
        };
        let (goes, weight) = if numbers.by_guide[k] {
            let f = proposals.value.get(k);
            (f != Rgb::ZERO && pdf.mixture > 0.0, f / pdf.mixture)
        } else {
            (bsdf > 0.0 && reflectance != Rgb::ZERO, reflectance * (bsdf / pdf.mixture))
        };
        (goes && self.surfaces.consistent(k, wi))
            .then(|| (proposals.org.get(k), DirectionSample { wi, weight, pdf: Some(pdf) }))
    }
}

#[cfg(test)]
#[path = "draw_tests.rs"]
mod tests;
