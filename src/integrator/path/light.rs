//! Light at a vertex: what is met by chance, and what is asked for by next-event estimation, each weighed against the
//! other.

use super::{Probe, Stage, Walk};
use crate::embree::{Hit, Ray};
use crate::geometry::SurfaceInteraction;
use crate::integrator::mixture::Mixture;
use crate::math::{Rgb, rng::Rng};
use glam::Vec3;

impl<P: Probe> Walk<'_, '_, P> {
    /// Draws a light and lays a shadow ray towards it.
    #[allow(clippy::too_many_arguments, reason = "a step of the narrated loop above")]
    #[inline]
    pub(super) fn ask_a_light(
        &mut self,
        si: &SurfaceInteraction,
        wo: Vec3,
        mixture: &Mixture,
        slot: u32,
        throughput: Rgb,
        depth: u32,
        rng: &mut Rng,
    ) {
        let (u_choice, u) = (rng.f64(), rng.f32x2());
        let Some(light) = self.integrator.scene.lights().sample(si.p, u_choice, u) else { return };
        let (f, mixture_pdf) = mixture.eval_pdf(si, wo, light.wi);
        if f == Rgb::ZERO {
            return;
        }
        let weight = match self.integrator.settings.mis && !light.delta {
            true => power_heuristic(light.pdf, mixture_pdf),
            false => 1.0,
        };
        let local = f * light.radiance * (weight / light.pdf);
        if local == Rgb::ZERO {
            return;
        }
        self.batch.shadow_rays.push(&light.shadow_ray(si.spawn(light.wi)));
        let vertex = if self.learn { self.batch.vertices[depth as usize - 1].len() as u32 - 1 } else { 0 };
        let n = &mut self.batch.next_events;
        n.slot.push(slot);
        n.contribution.push(throughput * local);
        n.local.push(local);
        n.vertex.push(vertex);
    }

    /// What the shadow rays found open is added to pixels and to what vertices will learn.
    pub(super) fn add_next_events(&mut self, depth: usize) {
        self.probe.stage(Stage::NextEvent);
        let b = &mut *self.batch;
        for k in 0..b.shadow_rays.len() {
            if b.shadow_rays.occluded(k) {
                continue;
            }
            b.radiance[b.next_events.slot[k] as usize] += b.next_events.contribution[k];
            if self.learn {
                b.vertices[depth - 1][b.next_events.vertex[k] as usize].local += b.next_events.local[k];
            }
        }
    }

    #[inline]
    pub(super) fn weigh_environment(&self, dir: Vec3, pdf: Option<f32>) -> Rgb {
        let lights = self.integrator.scene.lights();
        let le = lights.environment_radiance(dir);
        if le == Rgb::ZERO { le } else { le * self.emitter_weight(pdf, || lights.pdf_environment(dir)) }
    }

    #[inline]
    pub(super) fn weigh_emission(&self, hit: &Hit, si: &SurfaceInteraction, ray: &Ray, pdf: Option<f32>) -> Rgb {
        let scene = self.integrator.scene;
        let le = scene.emission(si);
        if le == Rgb::ZERO { le } else { le * self.emitter_weight(pdf, || scene.emitter_pdf(hit, si, ray)) }
    }

    /// MIS weight of an emitter that a ray met by itself. `pdf` is the density the ray was drawn with, `light_pdf`
    /// that of next-event estimation for the same direction.
    #[inline]
    pub(super) fn emitter_weight(&self, pdf: Option<f32>, light_pdf: impl FnOnce() -> f32) -> f32 {
        let settings = self.integrator.settings;
        match pdf {
            Some(pdf) if settings.next_event && settings.mis => power_heuristic(pdf, light_pdf()),
            Some(_) if settings.next_event => 0.0,
            _ => 1.0,
        }
    }
}

/// Veach's power heuristic (1997, eq. 9.13, β = 2) for one sample of each technique.
#[inline]
fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // the ratio first: squares of densities overflow sooner than densities
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
