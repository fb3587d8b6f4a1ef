//! What happens at the vertices of a wave, narrated: a packet at a time, step by step.

use super::guided::edge;
use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Walk};
use crate::embree::{NOTHING, Ray};
use crate::film::tile::Features;
use crate::geometry::SurfaceInteraction;
use crate::guiding::PackedDirection;
use crate::integrator::backup::Arrival;
use crate::integrator::batch::PathState;
use crate::integrator::mixture::{DirectionSample, Mixture};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, each, mask};
use crate::math::{Rgb, luminance, rng::Rng};
use glam::Vec3;

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
        for first in (0..self.batch.wave.rays.len()).step_by(LANES) {
            packet.begin(first, self.batch.wave.paths.packet(first).rng);
            self.shade(depth, &mut packet);
        }
    }

    fn shade(&mut self, depth: u32, packet: &mut Packet<'a>) {
        // Surfaces. A ray that left the scene sees the environment, and is done.
        self.meet(depth, packet);

        // Emission, weighted against the chance that next-event estimation had of drawing this direction.
        for k in each(packet.met()) {
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
    fn meet(&mut self, depth: u32, packet: &mut Packet<'a>) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let (first, rays) = (packet.ray(0), &self.batch.wave.rays);
        let (rows, left) = (rays.rows(first), (rays.len() - first) as u32);
        let present = mask(|k| (k as u32) < left);
        let mut met = mask(|k| present[k] & (rows.geometry[k] != NOTHING));
        // at a path's end only emission counts
        if depth >= settings.max_depth && !(depth == 1 && features) {
            for k in each(&met) {
                met[k] = rays.hit(first + k).is_some_and(|hit| scene.emits(hit));
            }
        }
        packet.surfaces.begin(&rows, met);
        for k in each(&met) {
            match rows.instance[k] {
                NOTHING => scene.meet(k, rows.geometry[k], rows.primitive[k], &mut packet.surfaces),
                _ => _ = rays.hit(first + k).map(|hit| scene.meet_instance(k, hit, &mut packet.surfaces)),
            }
        }
        for k in each(&mask(|k| present[k] & !met[k])) {
            self.leave(first + k, depth);
        }
        packet.surfaces.resolve();
    }

    /// Path `i` meets nothing that counts. Where that is because it left the scene, an environment may be seen.
    fn leave(&mut self, i: usize, depth: u32) {
        let (rays, paths) = (&self.batch.wave.rays, &self.batch.wave.paths);
        let mut le = Rgb::ZERO;
        if rays.hit(i).is_none() {
            le = self.weigh_environment(rays.ray(i).dir, paths.pdf(i));
            self.batch.radiance[paths.slot[i] as usize] += paths.throughput(i) * le;
        }
        self.log(i, depth, le);
    }

    /// Takes the emission of surface `k`, and finds how it scatters, unless the path ends there.
    #[inline(always)]
    fn arrive(&mut self, packet: &mut Packet<'a>, k: usize, depth: u32) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let (i, material) = (packet.ray(k), scene.material(packet.surfaces.material(k)));
        let le = if material.emits() { self.take_emission(i, &packet.surfaces.get(k)) } else { Rgb::ZERO };
        packet.kept[k] = self.log(i, depth, le);
        if depth == 1 && features {
            self.keep_features(packet, k);
        }
        if depth < settings.max_depth {
            // two calls, so that what is plain is never put down in memory between
            match material.plain() {
                Some(bsdf) => packet.bsdfs.set(k, &bsdf),
                None => packet.bsdfs.set(k, &scene.bsdf(material, packet.surfaces.uv(k))),
            }
        }
    }

    /// What `si` sends along ray `i`, which met it; it is added to the pixel.
    #[inline(never)]
    fn take_emission(&mut self, i: usize, si: &SurfaceInteraction) -> Rgb {
        let (le, paths) = (self.weigh_emission(i, si), &self.batch.wave.paths);
        if le != Rgb::ZERO {
            self.batch.radiance[paths.slot[i] as usize] += paths.throughput(i) * le;
        }
        le
    }

    #[inline(never)]
    fn keep_features(&mut self, packet: &Packet, k: usize) {
        let (scene, i, surfaces) = (self.integrator.scene, packet.ray(k), &packet.surfaces);
        let bsdf = scene.bsdf(scene.material(surfaces.material(k)), surfaces.uv(k));
        let (albedo, normal) = (bsdf.albedo(surfaces.wo_local(k)), surfaces.facing_normal(k));
        let depth = self.batch.wave.rays.ray(i).tfar;
        self.batch.features[self.batch.wave.paths.slot[i] as usize] = Features { albedo, normal, depth };
    }

    /// Draws where paths go on, and lays their next rays.
    fn go_on(&mut self, packet: &mut Packet<'a>, depth: u32) {
        let survival = self.survive(packet, depth);
        let wide = packet.wide();
        let wide = mask(|k| wide[k] & (survival.count[k] == 1));
        let proposals = packet.propose(&wide);
        let (mut weight, mut throughput) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        let before = &self.batch.wave.paths.packet(packet.ray(0)).throughput;
        for k in 0..LANES {
            weight.set(k, proposals.weight.get(k) / survival.paths[k]);
            throughput.set(k, before.get(k) * weight.get(k));
        }
        let [wi, normals] = self.packed(packet, &proposals.dir);
        for k in each(&mask(|k| proposals.goes[k] | ((survival.count[k] > 0) & !wide[k]))) {
            if !wide[k] {
                self.draw(packet, k, &survival);
                continue;
            }
            if self.learn {
                let packed = [wi[k], normals[k]];
                self.keep_arrival(packet, k, weight.get(k), &proposals.get(k), packed, survival.albedo[k]);
            }
            let (rng, analog) = (packet.rng.get(k), survival.analog[k]);
            let state = PathState { throughput: throughput.get(k), rng, pdf: proposals.mixture[k], analog };
            self.lay(packet.ray(k), proposals.org.get(k), proposals.dir.get(k), state);
        }
    }

    /// Whether paths go on, and each as how many.
    #[inline(always)]
    fn survive(&self, packet: &mut Packet<'a>, depth: u32) -> Survival {
        let (mut albedo, scatters) = (Vec3Lanes::ZERO, *packet.bsdfs.are());
        packet.albedo(&mut albedo);
        let before = &self.batch.wave.paths.packet(packet.ray(0)).analog;
        let mut s = Survival::default();
        for k in 0..LANES {
            s.analog[k] = before[k] * albedo.get(k).max_element();
            s.albedo[k] = luminance(albedo.get(k));
        }
        s.paths = self.expected_paths(packet, &albedo, &s.analog, depth);
        let u = packet.rng.f32(&scatters);
        for k in 0..LANES {
            let count = s.paths[k] as u32 + (u[k] < s.paths[k].fract()) as u32;
            s.count[k] = if scatters[k] { count } else { 0 };
            s.analog[k] /= s.paths[k];
        }
        s
    }

    /// Draws the directions in which the path goes on from vertex `k` by itself.
    #[inline(never)]
    fn draw(&mut self, packet: &Packet<'a>, k: usize, survival: &Survival) {
        packet.with_mixture(k, |mixture| self.draw_from(mixture, packet, k, survival));
    }

    #[inline(always)]
    fn draw_from(&mut self, mixture: &Mixture, packet: &Packet<'a>, k: usize, survival: &Survival) {
        let (si, wo, mut rng) = (packet.surfaces.get(k), packet.surfaces.wo_local(k), packet.rng.get(k));
        let (paths, analog, i) = (survival.paths[k], survival.analog[k], packet.ray(k));
        for split in 0..survival.count[k] {
            let mut rng = if split == 0 { rng } else { Rng::new(((rng.next_u32() as u64) << 32) | split as u64) };
            let Some(next) = mixture.sample(&si, wo, &mut rng) else { continue };
            let weight = next.weight / paths;
            if self.learn {
                let packed = [next.wi, packet.surfaces.facing_normal(k)].map(PackedDirection::new);
                self.keep_arrival(packet, k, weight, &next, packed, survival.albedo[k]);
            }
            let throughput = self.batch.wave.paths.throughput(i) * weight;
            let pdf = next.pdf.map_or(f32::INFINITY, |pdf| pdf.mixture);
            self.lay(i, si.spawn(next.wi), next.wi, PathState { throughput, rng, pdf, analog });
        }
    }

    /// Directions and the normals on the side of the path, packed, where something is learnt of them.
    #[inline(always)]
    fn packed(&self, packet: &Packet, dir: &Vec3Lanes) -> [[PackedDirection; LANES]; 2] {
        if !self.learn {
            return Default::default();
        }
        let mut normals = Vec3Lanes::ZERO;
        packet.surfaces.facing_normals(&mut normals);
        [PackedDirection::of_lanes(dir), PackedDirection::of_lanes(&normals)]
    }

    /// Keeps how the path comes to its next vertex, with the weight of this branch of it.
    #[inline(always)]
    fn keep_arrival(
        &mut self,
        packet: &Packet,
        k: usize,
        weight: Rgb,
        next: &DirectionSample,
        packed: [PackedDirection; 2],
        albedo: f32,
    ) {
        let edge = edge(packet, k, next, packed, albedo);
        self.batch.next.paths.arrival.push(Arrival { parent: packet.kept[k], weight, edge });
    }

    /// Lays the next ray of path `i`, with what it carries.
    #[inline(always)]
    fn lay(&mut self, i: usize, org: Vec3, dir: Vec3, state: PathState) {
        let b = &mut *self.batch;
        b.next.rays.push(&Ray { org, dir, tfar: f32::INFINITY });
        b.next.paths.push(b.wave.paths.slot[i], state);
    }
}

/// How paths go on.
#[derive(Default)]
struct Survival {
    /// As so many.
    count: [u32; LANES],
    /// How many were expected.
    paths: Lanes,
    /// What roulette goes by from here on.
    analog: Lanes,
    /// Luminance of the BSDF's albedo.
    albedo: Lanes,
}
