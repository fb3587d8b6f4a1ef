//! What happens at the vertices of a wave, narrated: a packet at a time, step by step.

use super::guided::{edge, edges};
use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Wavefront};
use crate::film::LightPath;
use crate::film::tile::Aovs;
use crate::geometry::{NOTHING, Ray, RayRows, SurfaceInteraction};
use crate::integrator::batch::{PathPacket, PathState};
use crate::integrator::mixture::Mixture;
use crate::integrator::sampler::DirectionNumbers;
use crate::integrator::vertex_record::VertexRecord;
use crate::math::{Rgb, luminance};
use crate::scene::material::Material;
use crate::simd::{LANES, Lanes, Mask, Packing, Vec3Lanes, each, mask, pick};
use glam::Vec3;

impl<'a, P: Probe> Wavefront<'a, '_, P> {
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
            packet.begin(first, self.batch.wave.paths.packet(first).keys);
            self.shade(depth, &mut packet);
        }
    }

    fn shade(&mut self, depth: u32, packet: &mut Packet<'a>) {
        // Surfaces. A ray that left the scene sees the environment, and is done.
        self.compute_interactions(depth, packet);

        // Pictures are in no cache; by now it is known for all where they are to be read.
        let scene = self.integrator.scene;
        for k in each(if scene.has_textures() { packet.met() } else { Mask::NONE }) {
            scene.prefetch(packet.surfaces.material(k), packet.surfaces.uv(k));
        }

        // Emission, weighted against the chance that next-event estimation had of drawing this direction.
        for k in each(packet.met()) {
            self.shade_hit(packet, k, depth);
        }

        // What the guide knows of each place.
        if let Some(guide) = self.integrator.guide {
            self.probe.step(Stage::Guide);
            self.ask_the_guide(guide, packet, depth);
        }

        // Direct light.
        self.probe.step(Stage::NextEvent);
        self.ask_lights(packet, depth);

        // The next direction, or several.
        self.probe.step(Stage::Shade);
        self.scatter(packet, depth);
    }

    /// The surfaces that rays of a packet met.
    fn compute_interactions(&mut self, depth: u32, packet: &mut Packet<'a>) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let (first, rays) = (packet.ray(0), &self.batch.wave.rays);
        let (rows, left) = (rays.rows(first), (rays.len() - first) as u32);
        let present = mask(|k| (k as u32) < left);
        let mut met = present & mask(|k| rows.geometry[k] != NOTHING);
        // at a path's end only emission counts
        if depth >= settings.max_depth && !(depth == 1 && features) {
            for k in each(met) {
                met.set(k, rays.hit(first + k).is_some_and(|hit| scene.emits(hit)));
            }
        }
        packet.surfaces.begin(&rows, met);
        for k in each(met) {
            match rows.instance[k] {
                NOTHING => scene.meet(k, rows.geometry[k], rows.primitive[k], &mut packet.surfaces),
                _ => _ = rays.hit(first + k).map(|hit| scene.meet_instance(k, hit, &mut packet.surfaces)),
            }
        }
        for k in each(present & !met) {
            self.escape(first + k, depth);
        }
        packet.surfaces.resolve();
    }

    /// Path `i` meets nothing that counts. Where that is because it left the scene, an environment may be seen.
    fn escape(&mut self, i: usize, depth: u32) {
        let (rays, paths) = (&self.batch.wave.rays, &self.batch.wave.paths);
        let mut le = Rgb::ZERO;
        if rays.hit(i).is_none() {
            le = self.weigh_environment(i);
            let path = LightPath { segments: depth, group: self.integrator.scene.lights().group_of_surroundings() };
            self.batch.radiance.add(paths.slot(i) as usize, path, paths.throughput(i) * le);
        }
        self.keep_local(i, depth, le);
    }

    /// Takes the emission of surface `k`, and finds how it scatters, unless the path ends there.
    #[inline(always)]
    fn shade_hit(&mut self, packet: &mut Packet<'a>, k: usize, depth: u32) {
        let PathIntegrator { scene, settings, features, .. } = *self.integrator;
        let material = scene.material(packet.surfaces.material(k));
        if material.emits() {
            let path = LightPath { segments: depth, group: material.light_group() };
            self.take_emission(packet.ray(k), path, &packet.surfaces.get(k));
        }
        if depth == 1 && features {
            self.keep_features(packet, k);
        }
        if depth < settings.max_depth {
            // two calls, so that what is plain is never put down in memory between
            match material.plain() {
                Some(bsdf) => packet.bsdfs.set(k, &bsdf),
                None => self.set_bsdf(packet, k, material),
            }
        }
    }

    /// Takes how surface `k` scatters, where something has to be looked up for it.
    #[inline(always)]
    fn set_bsdf(&self, packet: &mut Packet<'a>, k: usize, material: &'a Material) {
        let scene = self.integrator.scene;
        let bsdf = scene.bsdf(material, packet.surfaces.uv(k), || packet.surfaces.color(k));
        match material.relief() {
            None => packet.bsdfs.set(k, &bsdf),
            Some(relief) => {
                let (hit, si) = (self.batch.wave.rays.hit(packet.ray(k)), packet.surfaces.get(k));
                packet.bsdfs.set(k, &scene.in_relief(bsdf, relief, hit, &si));
            }
        }
    }

    /// What `si` sends along ray `i`, which met it; it is added to the pixel.
    #[inline(never)]
    fn take_emission(&mut self, i: usize, path: LightPath, si: &SurfaceInteraction) {
        let (le, paths) = (self.weigh_emission(i, si), &self.batch.wave.paths);
        if le != Rgb::ZERO {
            self.batch.radiance.add(paths.slot(i) as usize, path, paths.throughput(i) * le);
            self.keep_local(i, path.segments, le);
        }
    }

    #[inline(never)]
    fn keep_features(&mut self, packet: &Packet, k: usize) {
        let (scene, i, surfaces) = (self.integrator.scene, packet.ray(k), &packet.surfaces);
        let (material, ray, si) = (scene.material(surfaces.material(k)), self.batch.wave.rays.ray(i), surfaces.get(k));
        let (mut bsdf, mut normal) =
            (scene.bsdf(material, surfaces.uv(k), || surfaces.color(k)), surfaces.facing_normal(k));
        if let Some(relief) = material.relief() {
            bsdf = scene.in_relief(bsdf, relief, self.batch.wave.rays.hit(i), &si);
            let turned = si.frame.to_world(bsdf.normal());
            normal = if si.frame.n.dot(normal) < 0.0 { -turned } else { turned };
        }
        let slot = self.batch.wave.paths.slot(i) as usize;
        self.batch.features[slot] = Aovs {
            albedo: bsdf.albedo(surfaces.wo_local(k)),
            normal,
            geometric_normal: si.ng * -si.ng.dot(ray.dir).signum(),
            position: si.p,
            depth: ray.tfar,
            met: 1.0,
        };
        if let Some((ids, hit)) = self.batch.ids.get_mut(slot).zip(self.batch.wave.rays.hit(i)) {
            *ids = [scene.object(&hit), surfaces.material(k)];
        }
    }

    /// Draws where paths go on, once or more often, and lays their next rays.
    fn scatter(&mut self, packet: &mut Packet<'a>, depth: u32) {
        let survival = self.survive(packet, depth);
        if packet.has_moments().any() {
            self.add_expected(packet, &survival);
        }
        let (wide, goes) = (packet.vectorised(), mask(|k| survival.count[k] > 0));
        if (goes & !wide).any() {
            let numbers = self.sampler.direction(&packet.keys, depth);
            for k in each(goes & !wide) {
                self.draw(packet, k, &survival, (&numbers, depth));
            }
        }
        let splits = wide & mask(|k| survival.count[k] > 1);
        if splits.any() {
            self.split(packet, splits, &survival, depth);
        }
        self.scatter_vectorised(packet, wide & goes, &survival, depth);
    }

    /// Adds what was expected of branches that roulette has ended, and takes it away for those that splitting has added: C(1 − N/r),
    /// where N branches go on, r were expected and each is expected to bring C. That is 0 on average, whatever C is, as it was known
    /// before N was drawn; and the nearer C is to what a branch brings, the less is left to chance (a control variate).
    #[inline(always)]
    fn add_expected(&mut self, packet: &Packet, survival: &Survival) {
        let mut expected = Vec3Lanes::ZERO;
        packet.expected(&survival.albedo, &mut expected);
        let before = self.batch.wave.paths.packet(packet.ray(0));
        for k in 0..LANES {
            // where no branch was expected, nothing was to be expected of it
            let missing = pick(survival.paths[k] > 0.0, 1.0 - survival.count[k] as f32 / survival.paths[k], 0.0);
            expected.set(k, before.throughput.get(k) * expected.get(k) * missing);
        }
        for k in each(packet.has_moments()) {
            self.batch.radiance.expect(before.slot[k] as usize, expected.get(k));
        }
    }

    /// The second and further branches of paths that split.
    #[inline(never)]
    fn split(&mut self, packet: &mut Packet<'a>, splits: Mask, survival: &Survival, depth: u32) {
        let (first, mut draws) = (packet.keys, splits);
        for branch in 1.. {
            draws = draws & mask(|k| survival.count[k] > branch);
            if !draws.any() {
                break;
            }
            packet.keys = first.branch(depth, branch);
            self.scatter_vectorised(packet, draws, survival, depth);
        }
        packet.keys = first;
    }

    /// One direction for each vertex that draws, side by side.
    #[inline(always)]
    fn scatter_vectorised(&mut self, packet: &Packet<'a>, draws: Mask, survival: &Survival, depth: u32) {
        let proposals = packet.propose(draws, self.sampler, depth);
        self.counters.directions += draws.count();
        self.counters.guided_directions += proposals.by_guide.count();
        let before = self.batch.wave.paths.packet(packet.ray(0));
        let (mut weight, mut throughput) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        for k in 0..LANES {
            weight.set(k, proposals.weight.get(k) / survival.paths[k]);
            throughput.set(k, before.throughput.get(k) * weight.get(k));
        }
        let (keys, pdf, normal, analog) = (packet.keys, proposals.mixture, packet.light_normals, survival.analog);
        let paths = PathPacket { slot: before.slot, throughput, keys, pdf, normal, analog };
        let keeps_normals = self.keeps_normals();
        let next = &mut self.batch.next;
        let packing = Packing::new(proposals.goes.bits(), next.rays.len());
        let (org, dir) = (proposals.org.rows(), proposals.dir.rows());
        next.rays.pack(&packing, &RayRows { org, dir, tfar: &[f32::INFINITY; LANES] });
        next.paths.pack(&packing, &paths, keeps_normals);
        if self.learn {
            next.paths.arrivals.pack(&packing, &edges(packet, &proposals, &weight, &survival.luminance));
        }
    }

    /// Whether paths go on, and each as how many.
    #[inline(always)]
    fn survive(&self, packet: &Packet<'a>, depth: u32) -> Survival {
        let (mut s, scatters) = (Survival::NONE, packet.bsdfs.are());
        packet.albedo(&mut s.albedo);
        let before = &self.batch.wave.paths.packet(packet.ray(0)).analog;
        for k in 0..LANES {
            s.analog[k] = before[k] * s.albedo.get(k).max_element();
            s.luminance[k] = luminance(s.albedo.get(k));
        }
        s.paths = self.expected_paths(packet, &s.albedo, &mut s.analog, depth);
        let (mut u, scatters) = ([0.0; LANES], scatters.lanes());
        if mask(|k| s.paths[k].fract() > 0.0).any() {
            u = self.sampler.roulette(&packet.keys, depth);
        }
        for k in 0..LANES {
            let count = s.paths[k] as u32 + (u[k] < s.paths[k].fract()) as u32;
            s.count[k] = pick(scatters.has(k), count, 0);
        }
        s
    }

    /// Draws the directions in which the path goes on from vertex `k` by itself.
    #[inline(never)]
    fn draw(&mut self, packet: &Packet<'a>, k: usize, survival: &Survival, numbers: Numbers) {
        packet.with_mixture(k, |mixture| self.draw_from(mixture, packet, k, survival, numbers));
    }

    #[inline(always)]
    fn draw_from(
        &mut self,
        mixture: &Mixture,
        packet: &Packet<'a>,
        k: usize,
        survival: &Survival,
        (numbers, depth): Numbers,
    ) {
        let (si, wo) = (packet.surfaces.get(k), packet.surfaces.wo_local(k));
        let (mut keys, mut numbers) = (packet.keys.get(k), numbers.get(k));
        let (paths, analog, i) = (survival.paths[k], survival.analog[k], packet.ray(k));
        self.counters.directions += if mixture.is_smooth() { survival.count[k] as u64 } else { 0 };
        for split in 0..survival.count[k] {
            if split > 0 {
                keys = packet.keys.get(k).branch(depth, split);
                numbers = self.sampler.direction(&keys, depth);
            }
            self.counters.guided_directions += mixture.chooses_guide(&numbers) as u64;
            let Some(next) = mixture.sample(&si, wo, &numbers) else { continue };
            let weight = next.weight / paths;
            if self.learn {
                let edge = edge(packet, k, &next, survival.luminance[k]);
                let back = self.unexpected(packet, k, &next) / paths;
                let arrival = VertexRecord { parent: i as u32, weight: back, edge };
                self.batch.next.paths.arrivals.push(&arrival);
            }
            let throughput = self.batch.wave.paths.throughput(i) * weight;
            let pdf = next.pdf.map_or(f32::INFINITY, |pdf| pdf.mixture);
            let normal = packet.light_normals.get(k);
            self.enqueue_ray(i, si.spawn(next.wi), next.wi, PathState { throughput, keys, pdf, normal, analog });
        }
    }

    /// Lays the next ray of path `i`, with what it carries.
    #[inline(always)]
    fn enqueue_ray(&mut self, i: usize, org: Vec3, dir: Vec3, state: PathState) {
        let b = &mut *self.batch;
        b.next.rays.push(&Ray { org, dir, tfar: f32::INFINITY });
        b.next.paths.push(b.wave.paths.slot(i), state);
    }
}

/// Where paths go on from vertices which stand so far along their paths, counted from 1.
type Numbers<'a> = (&'a DirectionNumbers<LANES>, u32);

/// How paths go on.
struct Survival {
    /// As so many.
    count: [u32; LANES],
    /// How many were expected.
    paths: Lanes,
    /// What roulette goes by from here on.
    analog: Lanes,
    /// The BSDF's albedo.
    albedo: Vec3Lanes,
    /// And its luminance.
    luminance: Lanes,
}

impl Survival {
    const NONE: Survival = Survival {
        count: [0; LANES],
        paths: [0.0; LANES],
        analog: [0.0; LANES],
        albedo: Vec3Lanes::ZERO,
        luminance: [0.0; LANES],
    };
}
