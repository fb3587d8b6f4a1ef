//! What happens at the vertices of a wave, narrated: a packet at a time, step by step.

use super::packet::Packet;
use super::{PathIntegrator, Probe, Stage, Wavefront};
use crate::film::LightPath;
use crate::film::tile::Aovs;
use crate::geometry::{NOTHING, SurfaceInteraction};
use crate::math::Rgb;
use crate::scene::material::Material;
use crate::simd::{LANES, Mask, each, mask};
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
        packet.bsdfs.find_groups();

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
                None => self.set_bsdf(packet, k, depth),
            }
        }
    }

    /// Takes how surface `k` scatters, where something has to be looked up for it. Where two materials are mixed, here it is decided which
    /// of them the vertex is: for next-event estimation, the guide and the next direction alike.
    #[inline(always)]
    fn set_bsdf(&self, packet: &mut Packet<'a>, k: usize, depth: u32) {
        let scene = self.integrator.scene;
        let chance = || self.sampler.part(&packet.keys.get(k), depth)[0];
        let material = scene.choose_material(packet.surfaces.material(k), packet.surfaces.uv(k), chance);
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

    /// Albedo and normal of surface `k` as it is seen, if it is of this material.
    fn look(&self, packet: &Packet, k: usize, material: &Material) -> (Rgb, Vec3) {
        let (scene, i, surfaces) = (self.integrator.scene, packet.ray(k), &packet.surfaces);
        let (si, normal) = (surfaces.get(k), surfaces.facing_normal(k));
        let bsdf = scene.bsdf(material, surfaces.uv(k), || surfaces.color(k));
        let Some(relief) = material.relief() else { return (bsdf.albedo(surfaces.wo_local(k)), normal) };
        let bsdf = scene.in_relief(bsdf, relief, self.batch.wave.rays.hit(i), &si);
        let turned = si.frame.to_world(bsdf.normal());
        (bsdf.albedo(surfaces.wo_local(k)), if si.frame.n.dot(normal) < 0.0 { -turned } else { turned })
    }

    #[inline(never)]
    fn keep_features(&mut self, packet: &Packet, k: usize) {
        let (scene, i, surfaces) = (self.integrator.scene, packet.ray(k), &packet.surfaces);
        let (material, ray, si) = (scene.material(surfaces.material(k)), self.batch.wave.rays.ray(i), surfaces.get(k));
        let (mut albedo, mut normal) = (Rgb::ZERO, Vec3::ZERO);
        scene.each_choice(material, surfaces.uv(k), &mut |choice, share| {
            let (own_albedo, own_normal) = self.look(packet, k, choice);
            albedo += own_albedo * share;
            normal += own_normal * share;
        });
        let slot = self.batch.wave.paths.slot(i) as usize;
        self.batch.features[slot] = Aovs {
            albedo,
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
}
