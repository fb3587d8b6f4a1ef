//! What the guide has to say at a vertex, and what it will learn of it.

use super::{Probe, Stage, Walk};
use crate::bsdf::Bsdf;
use crate::geometry::SurfaceInteraction;
use crate::guiding::{PackedDirection, StateKey, Summary};
use crate::integrator::backup::{Edge, Expectation};
use crate::integrator::mixture::{DirectionSample, Mixture};
use crate::integrator::roulette::MAX_SURVIVAL;
use crate::math::luminance;
use crate::scene::description::{GuideSampling, Roulette};
use glam::Vec3;

/// Splitting stops where a wave has this many times the paths of its batch.
const MAX_WAVE: usize = 4;

/// Cosines are divided by at least this, where a BSDF's value is wanted without its own.
const MIN_COSINE: f32 = 1e-3;

/// What the guide knows of a vertex.
pub(super) struct Guided<'a> {
    /// Where to record.
    key: StateKey,
    /// Shading normal on the side of the path.
    normal: Vec3,
    pub(super) summary: Option<&'a Summary>,
}

impl<'a, P: Probe> Walk<'a, '_, P> {
    /// What the guide knows of the state in which the path now is, where a guide could help its BSDF.
    #[inline]
    pub(super) fn ask_the_guide(&mut self, si: &SurfaceInteraction, wo: Vec3, bsdf: &Bsdf) -> Option<Guided<'a>> {
        let guide = self.integrator.guide.filter(|_| bsdf.has_smooth())?;
        self.probe.step(Stage::Guide);
        self.counters.guide_queries += 1;
        let normal = si.facing(wo);
        let Some(place) = guide.field.place(si.p, normal, self.jitter) else {
            if self.learn {
                self.batch.points.push((si.p, normal));
            }
            return None;
        };
        let summary = guide.field.summary(place.drawn);
        self.counters.guide_hits += summary.is_some() as u64;
        Some(Guided { key: place.recorded, normal, summary })
    }

    #[inline]
    pub(super) fn mixture<'m>(
        &mut self,
        si: &SurfaceInteraction,
        wo: Vec3,
        bsdf: &'m Bsdf<'m>,
        guided: Option<&Guided<'m>>,
    ) -> Mixture<'m>
    where
        'a: 'm,
    {
        let known = self.integrator.guide.zip(guided).filter(|_| Mixture::guides(bsdf, self.product()));
        let Some((guide, summary, normal)) = known.and_then(|(u, g)| Some((u, g.summary?, g.normal))) else {
            return Mixture::new(bsdf, None, 1.0);
        };
        self.probe.step(Stage::Guide);
        let mut distribution = guide.field.distribution(summary, normal);
        if self.product() && bsdf.lambertian().is_none() {
            distribution = distribution.times(|w| {
                let wi = si.frame.to_local(w);
                luminance(bsdf.eval(wo, wi)) / wi.z.abs().max(MIN_COSINE)
            });
        }
        Mixture::new(bsdf, Some(distribution), summary.bsdf_fraction)
    }

    /// Whether directions are drawn from the product of guide and BSDF.
    #[inline]
    pub(super) fn product(&self) -> bool {
        self.integrator.guide.is_some_and(|guide| guide.settings.sampling == GuideSampling::Product)
    }

    /// What the table expects of going on.
    #[inline]
    pub(super) fn expectation(&self, summary: Option<&Summary>, bsdf: &Bsdf) -> Option<Expectation> {
        let guide = self.integrator.guide.filter(|_| self.learn)?.settings;
        let (summary, reflectance) = (summary?, bsdf.lambertian()?);
        let known = (summary.irradiance, summary.peak, summary.visits);
        Expectation::new(guide.rule_in_use(), guide.blend_visits, known, reflectance)
    }

    /// Expected number of paths that go on. The throughput's roulette goes by the share of light that scattering leaves
    /// on the way (`analog`), not by the throughput: a guide that finds the light lowers the throughput of just the
    /// paths that matter.
    #[inline]
    pub(super) fn paths(
        &self,
        summary: Option<&Summary>,
        guides: bool,
        reflected: f32,
        analog: f32,
        slot: u32,
        depth: u32,
    ) -> f32 {
        let settings = self.integrator.settings;
        if settings.roulette == Roulette::None {
            return 1.0;
        }
        let efficiency = self.integrator.guide.and_then(|guide| guide.efficiency);
        if let (Roulette::Guided, Some(efficiency)) = (settings.roulette, efficiency) {
            let full = self.batch.next.rays.len() >= MAX_WAVE * self.task.paths();
            let max_split = if full { 1.0 } else { settings.max_split };
            // of the return by a sharp lobe, a state's moments say nothing
            let Some(summary) = summary.filter(|_| guides) else {
                return if depth >= settings.rr_depth { MAX_SURVIVAL } else { 1.0 };
            };
            return efficiency.paths(summary, reflected, self.pixel(slot), max_split);
        }
        if depth >= settings.rr_depth { analog.min(MAX_SURVIVAL) } else { 1.0 }
    }

    /// The pixel of a path, row by row over the film.
    #[inline]
    pub(super) fn pixel(&self, slot: u32) -> usize {
        let tile = self.task.tile;
        let pixel = slot % tile.pixels() as u32;
        let (x, y) = (tile.x + pixel % tile.width, tile.y + pixel / tile.width);
        (y * self.integrator.scene.camera.width + x) as usize
    }
}

/// What is to be learnt of a direction.
#[inline]
pub(super) fn edge(guided: Option<&Guided>, next: &DirectionSample, albedo: f32) -> Option<Edge> {
    let (guided, pdf) = (guided?, next.pdf?);
    Some(Edge {
        key: guided.key,
        wi: PackedDirection::new(next.wi),
        normal: PackedDirection::new(guided.normal),
        pdf: pdf.mixture,
        bsdf_pdf: pdf.bsdf,
        guide_pdf: pdf.guide,
        scattered: luminance(next.weight) * pdf.mixture / albedo,
    })
}
