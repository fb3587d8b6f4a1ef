//! A packet of vertices on its way through the steps of a wave.

use super::guided::Guided;
use crate::bsdf::{Bsdf, DiffuseLanes};
use crate::geometry::Surfaces;
use crate::guiding::{GuideLanes, GuidingDistribution};
use crate::integrator::mixture::{Densities, Mixture};
use crate::light::LightSamples;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
use crate::math::{Rgb, rng::Rng};

/// A packet of vertices. What one step hands on to the next lies side by side, so that each writes and reads no more
/// than it needs.
pub(super) struct Packet<'a> {
    pub surfaces: Surfaces<'a>,
    /// The ray, by its place in the wave, that met each surface.
    pub ray: [usize; LANES],
    /// How each scatters; `None` where the path ends.
    pub bsdf: [Option<Bsdf<'a>>; LANES],
    /// Those that are Lambertian.
    pub diffuse: DiffuseLanes,
    pub guided: [Option<Guided<'a>>; LANES],
    /// Where each vertex is kept for learning, by its place in its wave.
    pub kept: [u32; LANES],
    /// The guide's directions and the share that the BSDF keeps, where the guide can help.
    directions: [Option<(GuidingDistribution<'a>, f32)>; LANES],
    /// Those of them that are trees.
    trees: GuideLanes<'a>,
    pub lights: LightSamples,
    pub rng: [Rng; LANES],
}

impl<'a> Packet<'a> {
    pub fn new() -> Self {
        Packet {
            surfaces: Surfaces::new(),
            ray: [0; LANES],
            bsdf: [None; LANES],
            diffuse: DiffuseLanes::new(),
            guided: [None; LANES],
            kept: [0; LANES],
            directions: [const { None }; LANES],
            trees: GuideLanes::new(),
            lights: LightSamples::new(),
            rng: [Rng::new(0); LANES],
        }
    }

    /// Takes the guide's directions at vertex `k`, where there are any, with the share that the BSDF keeps.
    #[inline(always)]
    pub fn lead(&mut self, k: usize, directions: Option<(GuidingDistribution<'a>, f32)>) {
        self.trees.set(k, directions.as_ref().map(|(distribution, _)| distribution));
        self.directions[k] = directions;
    }

    /// The share of the directions at vertex `k` that the BSDF keeps, where a guide draws the others.
    #[inline(always)]
    pub fn bsdf_fraction(&self, k: usize) -> Option<f32> {
        self.directions[k].as_ref().map(|&(_, fraction)| fraction)
    }

    pub fn trees(&self) -> &GuideLanes<'a> {
        &self.trees
    }

    /// How directions are drawn at vertex `k`; `None` where the path ends.
    #[inline(always)]
    pub fn mixture(&self, k: usize) -> Option<Mixture<'_>> {
        let bsdf = self.bsdf[k].as_ref()?;
        Some(match &self.directions[k] {
            Some((guide, bsdf_fraction)) => Mixture::new(bsdf, Some(guide), *bsdf_fraction),
            None => Mixture::new(bsdf, None, 1.0),
        })
    }

    /// Whether at vertex `k` directions are drawn by Lambert's law alone.
    #[inline(always)]
    fn is_plain(&self, k: usize) -> bool {
        self.diffuse.is(k) && self.directions[k].is_none()
    }

    /// Whether at vertex `k` directions are drawn by Lambert's law, alone or with a tree: both are known side by side.
    #[inline(always)]
    pub fn is_wide(&self, k: usize) -> bool {
        self.diffuse.is(k) && (self.directions[k].is_none() || self.trees.is(k))
    }

    /// [`Mixture::eval_pdf`] towards the lights that were drawn. Any where there are none.
    pub fn eval_pdf(&self, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        let (surfaces, wi) = (&self.surfaces, &self.lights.wi);
        let mut local = Vec3Lanes::ZERO;
        surfaces.to_local(wi, &mut local);
        self.diffuse.eval_pdf(surfaces.wo_locals(), &local, f, pdf);
        for k in 0..LANES {
            let lit = surfaces.consistent(k, wi.get(k));
            f.set(k, if lit { f.get(k) } else { Rgb::ZERO });
            pdf[k] = if lit { pdf[k] } else { 0.0 };
        }
        let mut guide = [0.0; LANES];
        if self.trees.any() {
            self.trees.pdf(wi, &mut guide);
        }
        for k in 0..surfaces.len() {
            if self.is_plain(k) || self.lights.pdf[k] <= 0.0 {
                continue;
            }
            if let Some(fraction) = self.bsdf_fraction(k).filter(|_| self.is_wide(k)) {
                let mixed = Densities::mixed(fraction, pdf[k], guide[k]).mixture;
                pdf[k] = if f.get(k) != Rgb::ZERO { mixed } else { pdf[k] };
                continue;
            }
            let Some(mixture) = self.mixture(k) else { continue };
            if !self.diffuse.is(k) {
                let (value, density) = mixture.eval_pdf(&surfaces.get(k), surfaces.wo_local(k), wi.get(k));
                f.set(k, value);
                pdf[k] = density;
            } else if f.get(k) != Rgb::ZERO {
                pdf[k] = mixture.density(pdf[k], wi.get(k));
            }
        }
    }
}
