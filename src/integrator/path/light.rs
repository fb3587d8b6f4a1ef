//! Light at a vertex: what is met by chance, and what is asked for by next-event estimation, each weighed against the
//! other.

use super::packet::Packet;
use super::{Probe, Stage, Walk, Wave};
use crate::embree::Ray;
use crate::geometry::SurfaceInteraction;
use crate::math::Rgb;
use crate::math::lanes::{LANES, Vec3Lanes};
use glam::Vec3;

impl<P: Probe> Walk<'_, '_, P> {
    /// Draws a light for each vertex of a packet that can be lit, and lays shadow rays towards those from which
    /// something would come.
    pub(super) fn ask_lights(&mut self, packet: &mut Packet) {
        if !self.integrator.settings.next_event {
            return;
        }
        self.draw_lights(packet);
        let (mut f, mut pdf) = (Vec3Lanes::ZERO, [0.0; LANES]);
        packet.eval_pdf(&mut f, &mut pdf);
        let mut weight = [1.0; LANES];
        let lights = &packet.lights;
        if self.integrator.settings.mis {
            for k in 0..LANES {
                weight[k] = if lights.delta[k] { 1.0 } else { power_heuristic(lights.pdf[k], pdf[k]) };
            }
        }
        let mut local = Vec3Lanes::ZERO;
        lights.contribution(&f, &weight, &mut local);
        let (mut org, mut dir, mut tfar) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO, [0.0; LANES]);
        lights.shadow_rays(&packet.surfaces, &mut org, &mut dir, &mut tfar);
        for k in 0..packet.surfaces.len() {
            if lights.pdf[k] > 0.0 && local.get(k) != Rgb::ZERO {
                let ray = Ray { org: org.get(k), dir: dir.get(k), tfar: tfar[k] };
                self.ask_light(&ray, local.get(k), packet, k);
            }
        }
    }

    fn draw_lights(&mut self, packet: &mut Packet) {
        let lights = self.integrator.scene.lights();
        let Packet { surfaces, bsdf, lights: drawn, rng, .. } = packet;
        for k in 0..surfaces.len() {
            match bsdf[k] {
                Some(bsdf) if bsdf.has_smooth() => {
                    let (u_choice, u) = (rng[k].f64(), rng[k].f32x2());
                    drawn.choose(k, lights, surfaces.p(k), u_choice, u);
                }
                _ => drawn.skip(k),
            }
        }
        drawn.resolve();
    }

    /// Lays a shadow ray from vertex `k` towards a light that would bring it `local`.
    #[inline]
    fn ask_light(&mut self, ray: &Ray, local: Rgb, packet: &Packet, k: usize) {
        self.batch.shadow_rays.push(ray);
        let (n, paths) = (&mut self.batch.next_events, &self.batch.wave.paths);
        n.slot.push(paths.slot[packet.ray[k]]);
        n.contribution.push(paths.state[packet.ray[k]].throughput * local);
        if self.learn {
            n.local.push((local, packet.kept[k]));
        }
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
                let (local, vertex) = b.next_events.local[k];
                b.vertices[depth - 1][vertex as usize].local += local;
            }
        }
    }

    #[inline]
    pub(super) fn weigh_environment(&self, dir: Vec3, pdf: Option<f32>) -> Rgb {
        let lights = self.integrator.scene.lights();
        let le = lights.environment_radiance(dir);
        if le == Rgb::ZERO { le } else { le * self.emitter_weight(pdf, || lights.pdf_environment(dir)) }
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
        let light_pdf = || rays.hit(i).map_or(0.0, |hit| scene.emitter_pdf(&hit, si, &rays.ray(i)));
        le * self.emitter_weight(paths.state[i].pdf, light_pdf)
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
