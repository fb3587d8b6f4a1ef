//! What happens at the vertices of a wave, narrated: a packet at a time, step by step.

use super::draw::Numbers;
use super::guided::edge;
use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Walk};
use crate::embree::Ray;
use crate::film::tile::Features;
use crate::integrator::backup::{Arrival, Edge};
use crate::integrator::batch::{PathState, Paths};
use crate::integrator::mixture::{DirectionSample, Mixture};
use crate::math::lanes::LANES;
use crate::math::{Rgb, luminance, rng::Rng};
use glam::Vec3;
use std::ops::Range;

impl<'a, P: Probe> Walk<'a, '_, P> {
    /// The vertices at which the wave's rays arrive.
    ///
    /// A packet is taken through each step before the next begins: what is plain arithmetic runs in vectors, and what
    /// one vertex has to wait for is filled with another's work. The order of the steps is that of the light transport
    /// equation read from the left: emission, direct light, then the rest.
    pub(super) fn shade_wave(&mut self, depth: u32) {
        self.probe.stage(Stage::Shade);
        self.batch.shadow_rays.clear();
        self.batch.next_events.clear();
        self.batch.next.clear();
        let mut packet = Packet::new();
        let rays = self.batch.wave.rays.len();
        for first in (0..rays).step_by(LANES) {
            self.shade(first..rays.min(first + LANES), depth, &mut packet);
        }
    }

    fn shade(&mut self, rays: Range<usize>, depth: u32, packet: &mut Packet<'a>) {
        // Surfaces. A ray that left the scene sees the environment, and is done.
        self.meet(rays, depth, packet);

        // Emission, weighted against the chance that next-event estimation had of drawing this direction.
        for k in 0..packet.surfaces.len() {
            self.arrive(packet, k, depth);
        }

        // What the guide knows of each place.
        if let Some(guide) = self.integrator.guide {
            self.probe.step(Stage::Guide);
            self.ask_the_guide(guide, packet, depth);
        }

        // Direct light.
        self.probe.step(Stage::NextEvent);
        self.ask_lights(packet);

        // The next direction, or several.
        self.probe.step(Stage::Shade);
        self.go_on(packet, depth);
    }

    /// The surfaces that rays of a packet met.
    fn meet(&mut self, rays: Range<usize>, depth: u32, packet: &mut Packet<'a>) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let Packet { surfaces, ray, .. } = packet;
        surfaces.clear();
        // at a path's end only emission counts
        let ends = depth >= settings.max_depth && !(depth == 1 && features);
        for i in rays {
            let wo = -self.batch.wave.rays.ray(i).dir;
            match self.batch.wave.rays.hit(i) {
                None => self.leave(i, -wo, depth),
                Some(hit) if ends && !scene.emits(hit) => _ = self.log(i, depth, Rgb::ZERO),
                Some(hit) => {
                    ray[surfaces.len()] = i;
                    scene.meet(hit, wo, surfaces);
                }
            }
        }
        surfaces.resolve();
    }

    /// A path leaves the scene along `dir`: only an environment is there to be seen.
    fn leave(&mut self, i: usize, dir: Vec3, depth: u32) {
        let Paths { slot, state, .. } = &self.batch.wave.paths;
        let (slot, PathState { throughput, pdf, .. }) = (slot[i] as usize, state[i]);
        let le = self.weigh_environment(dir, pdf);
        self.batch.radiance[slot] += throughput * le;
        self.log(i, depth, le);
    }

    /// Takes the emission of surface `k`, and finds how it scatters, unless the path ends there.
    #[inline]
    fn arrive(&mut self, packet: &mut Packet<'a>, k: usize, depth: u32) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let (i, si) = (packet.ray[k], packet.surfaces.get(k));
        let Paths { slot, state, .. } = &self.batch.wave.paths;
        let (slot, throughput) = (slot[i] as usize, state[i].throughput);
        packet.rng[k] = state[i].rng;
        let le = self.weigh_emission(i, &si);
        if le != Rgb::ZERO {
            self.batch.radiance[slot] += throughput * le;
        }
        packet.kept[k] = self.log(i, depth, le);

        let bsdf = scene.bsdf(&si);
        if depth == 1 && features {
            let depth = self.batch.wave.rays.ray(i).tfar;
            let (albedo, normal) = (bsdf.albedo(packet.surfaces.wo_local(k)), packet.surfaces.facing_normal(k));
            self.batch.features[slot] = Features { albedo, normal, depth };
        }
        packet.bsdf[k] = (depth < settings.max_depth).then_some(bsdf);
        packet.diffuse.set(k, packet.bsdf[k].as_ref());
    }

    /// Draws where paths go on, and lays their next rays.
    fn go_on(&mut self, packet: &mut Packet<'a>, depth: u32) {
        let mut survival = [Survival::default(); LANES];
        let mut numbers = Numbers::default();
        for k in 0..packet.surfaces.len() {
            survival[k] = self.survival(packet, k, depth);
            if packet.is_wide(k) && survival[k].count == 1 {
                packet.draw_numbers(k, &mut numbers);
            }
        }
        let proposals = packet.propose(&numbers);
        for (k, survival) in survival.iter().enumerate() {
            if numbers.has(k) {
                if let Some(next) = packet.proposal(k, &numbers, &proposals) {
                    self.lay(packet, k, survival, next, packet.rng[k]);
                }
            } else if survival.count > 0 {
                self.draw(packet, k, survival);
            }
        }
    }

    /// Whether the path goes on from vertex `k`, and as how many.
    #[inline]
    fn survival(&mut self, packet: &mut Packet<'a>, k: usize, depth: u32) -> Survival {
        let Some(bsdf) = &packet.bsdf[k] else { return Survival::default() };
        let Paths { slot, state, .. } = &self.batch.wave.paths;
        let (slot, throughput, analog) =
            (slot[packet.ray[k]], state[packet.ray[k]].throughput, state[packet.ray[k]].analog);
        let albedo = bsdf.albedo(packet.surfaces.wo_local(k));
        let analog = analog * albedo.max_element();
        let guides = Mixture::guides(bsdf, false);
        let paths = self.paths(packet.guided[k].as_ref(), guides, luminance(throughput * albedo), analog, slot, depth);
        let count = paths as u32 + (packet.rng[k].f32() < paths.fract()) as u32;
        Survival { count, paths, analog: analog / paths, albedo: luminance(albedo), guides }
    }

    /// Draws the directions in which the path goes on from vertex `k` by itself.
    fn draw(&mut self, packet: &Packet<'a>, k: usize, survival: &Survival) {
        let Some(mixture) = packet.mixture(k) else { return };
        let (si, wo, mut rng) = (packet.surfaces.get(k), packet.surfaces.wo_local(k), packet.rng[k]);
        for split in 0..survival.count {
            let mut rng = if split == 0 { rng } else { Rng::new(((rng.next_u32() as u64) << 32) | split as u64) };
            if let Some(next) = mixture.sample(&si, wo, &mut rng) {
                self.lay(packet, k, survival, (si.spawn(next.wi), next), rng);
            }
        }
    }

    /// Lays the next ray of a path from vertex `k`, with what it carries.
    #[inline(always)]
    fn lay(
        &mut self,
        packet: &Packet<'a>,
        k: usize,
        survival: &Survival,
        (org, next): (Vec3, DirectionSample),
        rng: Rng,
    ) {
        let weight = next.weight / survival.paths;
        let b = &mut *self.batch;
        if self.learn {
            let normal = packet.surfaces.facing_normal(k);
            let edge = edge(packet.guided[k].as_ref(), normal, &next, survival.albedo);
            let edge = edge.map(|e| Edge { scattered: if survival.guides { e.scattered } else { 0.0 }, ..e });
            b.next.paths.arrival.push(Arrival { parent: packet.kept[k], weight, edge });
        }
        let (paths, i) = (&b.wave.paths, packet.ray[k]);
        let throughput = paths.state[i].throughput * weight;
        let pdf = next.pdf.map(|pdf| pdf.mixture);
        b.next.rays.push(&Ray { org, dir: next.wi, tfar: f32::INFINITY });
        b.next.paths.push(paths.slot[i], PathState { throughput, rng, pdf, analog: survival.analog });
    }
}

/// How a path goes on.
#[derive(Clone, Copy, Default)]
struct Survival {
    /// As so many.
    count: u32,
    /// How many were expected.
    paths: f32,
    /// What roulette goes by from here on.
    analog: f32,
    /// Luminance of the BSDF's albedo.
    albedo: f32,
    /// Whether a guide can help here.
    guides: bool,
}
