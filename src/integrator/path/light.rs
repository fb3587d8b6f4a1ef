//! Light at a vertex: what is met by chance, and what is asked for by next-event estimation, each weighed against the
//! other.

use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Wave, Wavefront};
use crate::film::{LightPath, RadianceLayer};
use crate::geometry::{RayRows, SurfaceInteraction};
use crate::guiding::ShadowOutcome;
use crate::integrator::batch::NextEventLanes;
use crate::integrator::sampler::LightNumbers;
use crate::light::LightSampleContext;
use crate::math::{Rgb, luminance};
use crate::simd::{LANES, Lanes, Mask, Packing, Vec3Lanes, each, mask, pick};

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
        let groups = self.integrator.layers.iter().any(|layer| matches!(layer, RadianceLayer::Group(_)));
        let group = if groups { lights.groups(self.integrator.scene.lights()) } else { [0; LANES] };
        let (cast, rays) = self.cast_shadow_rays(packet, asks, &NextEvent { local, brought, group, depth });
        for k in 0..LANES {
            brought.set(k, brought.get(k) * rays[k]);
        }
        let b = &mut *self.batch;
        let packing = Packing::new(cast.bits(), b.shadow_rays.len());
        b.shadow_rays.pack(&packing, &RayRows { org: org.rows(), dir: dir.rows(), tfar: &tfar });
        let (slot, vertex) = (b.wave.paths.packet(packet.ray(0)).slot, packet.rays());
        let events = NextEventLanes { slot, contribution: brought, local, rays, vertex, group };
        b.next_events.pack(&packing, &events, [self.learn, groups]);
    }

    /// Which of the shadow rays that lanes ask for are cast, and how many each of them stands for. A ray is cast with a probability that
    /// goes by how much it may change the picture. What it would bring on average is known before, and is added here: C for a ray that is
    /// left out, and C(1 − 1/q) for one that is cast with the probability q. That is 0 on average less what rays that are left out would
    /// have found, whatever C is (a control variate).
    #[inline(always)]
    fn cast_shadow_rays(&mut self, packet: &Packet, asks: Mask, event: &NextEvent) -> (Mask, Lanes) {
        let (told, mut rays) = (asks & packet.has_visibility(), [1.0; LANES]);
        let efficiency = self.integrator.guide.and_then(|guide| guide.efficiency);
        let Some(efficiency) = efficiency.filter(|_| told.any()) else { return (asks, rays) };
        let slots = &self.batch.wave.paths.packet(packet.ray(0)).slot;
        let (mut inverse_luminance, mut probability) = ([0.0; LANES], [1.0; LANES]);
        for k in each(told) {
            inverse_luminance[k] = self.batch.inverse_luminance[slots[k] as usize];
        }
        let (open, known) = (packet.open(), told.lanes());
        for k in 0..LANES {
            let cast = efficiency.cast(luminance(event.brought.get(k)), inverse_luminance[k], open[k]);
            probability[k] = pick(known.has(k), cast, 1.0);
        }
        let doubtful = told & mask(|k| probability[k] < 1.0);
        if !doubtful.any() {
            return (asks, rays);
        }
        let u = self.sampler.shadow(&packet.keys, event.depth);
        for k in 0..LANES {
            rays[k] = 1.0 / probability[k];
        }
        let cast = asks & mask(|k| u[k] < probability[k]);
        self.expect_light(packet, [doubtful & cast, doubtful & !cast], &rays, event);
        (cast, rays)
    }

    /// Adds to pixels what shadow rays were expected to find, some that are `cast` and stand for so many `rays`, and some that are `left`
    /// out. Vertices learn what those are expected to bring that are left out, and of the others what they find.
    #[inline(always)]
    fn expect_light(&mut self, packet: &Packet, [cast, left]: [Mask; 2], rays: &Lanes, event: &NextEvent) {
        let (mut expected, open) = (Vec3Lanes::ZERO, packet.open());
        let is_left = left.lanes();
        for k in 0..LANES {
            let share = pick(is_left.has(k), 1.0, 1.0 - rays[k]);
            expected.set(k, event.brought.get(k) * (open[k] * share));
        }
        let b = &mut *self.batch;
        let slots = &b.wave.paths.packet(packet.ray(0)).slot;
        for k in each(cast | left) {
            let path = LightPath { segments: event.depth + 1, group: event.group[k] };
            let likely = is_left.has(k) & (open[k] > 0.5);
            b.radiance.expect_by(slots[k] as usize, path, expected.get(k), likely);
        }
        if self.learn {
            let local = &mut b.vertices[event.depth as usize - 1].local[packet.ray(0)..];
            for k in each(left) {
                local[k] += event.local.get(k) * open[k];
            }
        }
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
            if self.learn {
                let open = b.shadow_rays.open(first);
                for k in 0..LANES.min(b.shadow_rays.len() - first) {
                    let outcome = ShadowOutcome::new(events.rays[k], open.has(k));
                    b.vertices[depth - 1].shadows[events.vertex[k] as usize] = outcome;
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

/// What the lights that a packet has drawn would bring, if nothing were between, to vertices that are the `depth`th of their paths.
struct NextEvent {
    /// Towards the vertices before.
    local: Vec3Lanes,
    /// To the pixels.
    brought: Vec3Lanes,
    /// Numbers of the lights' groups.
    group: [u32; LANES],
    depth: u32,
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
