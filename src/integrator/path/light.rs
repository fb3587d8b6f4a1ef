//! Light at a vertex: what is met by chance, and what is asked for by next-event estimation, each weighed against the
//! other.

use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Wave, Wavefront};
use crate::film::{LightPath, RadianceLayer};
use crate::geometry::{RayRows, SurfaceInteraction};
use crate::integrator::batch::NextEventLanes;
use crate::integrator::sampler::LightNumbers;
use crate::light::LightSampleContext;
use crate::math::Rgb;
use crate::simd::{LANES, Packing, Vec3Lanes, each, mask, pick};

impl<P: Probe> Wavefront<'_, '_, P> {
    /// Draws a light for each vertex of a packet that can be lit, and lays shadow rays towards those from which
    /// something would come.
    pub(super) fn ask_lights(&mut self, packet: &mut Packet, depth: u32) {
        if !self.integrator.settings.next_event {
            return;
        }
        self.draw_lights(packet, depth);
        let drawn = &packet.lights.pdf;
        if !mask(|k| drawn[k] > 0.0).any() {
            return;
        }
        let (mut f, mut pdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        packet.eval_pdf(&mut f, &mut pdf);
        let mut weight = [1.0; LANES];
        let lights = &packet.lights;
        if self.integrator.settings.mis {
            let delta = lights.delta.lanes();
            for k in 0..LANES {
                weight[k] = pick(delta.has(k), 1.0, power_heuristic(lights.pdf[k], pdf[k]));
            }
        }
        let [mut local, mut brought] = [Vec3Lanes::ZERO; 2];
        lights.contribution(&f, &weight, &mut local);
        let throughput = &self.batch.wave.paths.packet(packet.ray(0)).throughput;
        for k in 0..LANES {
            brought.set(k, throughput.get(k) * local.get(k));
        }
        let (mut org, mut dir, mut tfar) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO, [0.0; LANES]);
        lights.shadow_rays(&packet.surfaces, &mut org, &mut dir, &mut tfar);
        // a ray without a length may have no direction either
        let asks = mask(|k| (lights.pdf[k] > 0.0) & (local.get(k) != Rgb::ZERO) & (tfar[k] > 0.0));
        let b = &mut *self.batch;
        let packing = Packing::new(asks.bits(), b.shadow_rays.len());
        b.shadow_rays.pack(&packing, &RayRows { org: org.rows(), dir: dir.rows(), tfar: &tfar });
        let (slot, vertex) = (b.wave.paths.packet(packet.ray(0)).slot, packet.rays());
        let groups = self.integrator.layers.iter().any(|layer| matches!(layer, RadianceLayer::Group(_)));
        let group = if groups { lights.groups(self.integrator.scene.lights()) } else { [0; LANES] };
        let events = NextEventLanes { slot, contribution: brought, local, vertex, group };
        b.next_events.pack(&packing, &events, [self.learn, groups]);
    }

    fn draw_lights(&self, packet: &mut Packet, depth: u32) {
        let lights = (self.integrator.scene.lights(), self.integrator.settings.light_sampler);
        let lit = packet.smooth();
        let LightNumbers { choice, point: mut u } = self.sampler.light(&packet.keys, depth);
        if self.keeps_normals() {
            packet.find_light_normals();
        }
        let Packet { surfaces, lights: drawn, light_normals, .. } = packet;
        drawn.choose(lit, lights, [surfaces.places(), light_normals], &choice, &mut u);
        drawn.resolve(surfaces.places(), &u);
    }

    /// What the shadow rays found open is added to pixels and to what vertices will learn.
    pub(super) fn add_next_events(&mut self, depth: usize) {
        self.probe.stage(Stage::NextEvent);
        let b = &mut *self.batch;
        for first in (0..b.shadow_rays.len()).step_by(LANES) {
            let events = &b.next_events.packets[first / LANES];
            for k in each(b.shadow_rays.open(first)) {
                let path = LightPath { segments: depth as u32 + 1, group: events.group[k] };
                b.radiance.add(events.slot[k] as usize, path, events.contribution.get(k));
                if self.learn {
                    b.vertices[depth - 1].local[events.vertex[k] as usize] += events.local.get(k);
                }
            }
        }
    }

    /// Whether paths remember the normals of the surfaces that they come from, because lights are chosen by them.
    #[inline(always)]
    pub(super) fn keeps_normals(&self) -> bool {
        let PathIntegrator { scene, settings, .. } = self.integrator;
        settings.next_event && scene.lights().look_at_points(settings.light_sampler)
    }

    /// What surroundings send along ray `i`, which left the scene.
    #[inline]
    pub(super) fn weigh_environment(&self, i: usize) -> Rgb {
        let (lights, by) = (self.integrator.scene.lights(), self.integrator.settings.light_sampler);
        let Wave { rays, paths } = &self.batch.wave;
        let dir = rays.ray(i).dir;
        let le = lights.environment_radiance(dir);
        if le == Rgb::ZERO {
            return le;
        }
        le * self.emitter_weight(paths.pdf(i), || lights.pdf_environment(by, &self.origin(i), dir))
    }

    /// Where ray `i` comes from, as a light would be chosen there.
    #[inline]
    fn origin(&self, i: usize) -> LightSampleContext {
        let Wave { rays, paths } = &self.batch.wave;
        LightSampleContext { p: rays.ray(i).org, n: paths.normal(i) }
    }

    /// What the surface `si` sends along ray `i`, which met it.
    #[inline]
    pub(super) fn weigh_emission(&self, i: usize, si: &SurfaceInteraction) -> Rgb {
        let scene = self.integrator.scene;
        let le = scene.emission(si);
        if le == Rgb::ZERO {
            return le;
        }
        let Wave { rays, paths } = &self.batch.wave;
        let by = self.integrator.settings.light_sampler;
        let light_pdf = || rays.hit(i).map_or(0.0, |hit| scene.emitter_pdf(by, &self.origin(i), &hit, si));
        le * self.emitter_weight(paths.pdf(i), light_pdf)
    }

    /// MIS weight of an emitter that a ray met by itself. `pdf` is the density the ray was drawn with, infinite where no
    /// other way could have found it, `light_pdf` that of next-event estimation for the same direction.
    #[inline]
    pub(super) fn emitter_weight(&self, pdf: f32, light_pdf: impl FnOnce() -> f32) -> f32 {
        let settings = self.integrator.settings;
        if pdf == f32::INFINITY || !settings.next_event {
            1.0
        } else if settings.mis {
            power_heuristic(pdf, light_pdf())
        } else {
            0.0
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

#[cfg(test)]
#[path = "light_tests.rs"]
mod tests;
