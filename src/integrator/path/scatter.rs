//! Where paths go on from the vertices of a packet: whether they do, as how many, in which directions; and their next rays.

use super::draw::DirectionSamples;
use super::guided::{edge, edges};
use super::packet::Packet;
use super::{Probe, Wavefront};
use crate::geometry::{Ray, RayRows};
use crate::integrator::batch::{PathPacket, PathState};
use crate::integrator::mixture::Mixture;
use crate::integrator::sampler::DirectionNumbers;
use crate::integrator::vertex_record::VertexRecord;
use crate::math::luminance;
use crate::simd::{LANES, Lanes, Mask, Packing, Vec3Lanes, each, mask, pick};
use glam::Vec3;

impl<'a, P: Probe> Wavefront<'a, '_, P> {
    /// Draws where paths go on, once or more often, and lays their next rays.
    pub(super) fn scatter(&mut self, packet: &mut Packet<'a>, depth: u32) {
        let survival = self.survive(packet, depth);
        if packet.has_moments().any() {
            self.add_expected(packet, &survival);
        }
        let (wide, goes) = (packet.vectorised(), mask(|k| survival.count[k] > 0));
        if (goes & !wide).any() {
            let numbers = self.sampler.direction(&packet.keys, depth);
            self.scatter_others(packet, goes & !wide, &survival, (&numbers, depth));
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

    /// Directions for vertices that are not [`Packet::vectorised`].
    #[inline(always)]
    fn scatter_others(&mut self, packet: &Packet<'a>, draws: Mask, survival: &Survival, numbers: Numbers) {
        let splits = mask(|k| survival.count[k] > 1);
        if self.learn || (draws & (packet.led() | splits)).any() {
            for k in each(draws) {
                self.draw(packet, k, survival, numbers);
            }
        } else {
            self.counters.directions += (draws & packet.smooth()).count();
            let drawn = packet.draw_unguided(draws, numbers.0);
            self.lay(packet, drawn.goes, [&drawn.org, &drawn.dir], &drawn.weight, &drawn.pdf, survival);
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
        let DirectionSamples { goes, org, dir, weight, mixture, .. } = &proposals;
        let (packing, weight) = self.lay(packet, *goes, [org, dir], weight, mixture, survival);
        if self.learn {
            let arrivals = edges(packet, &proposals, &weight, &survival.luminance);
            self.batch.next.paths.arrivals.pack(&packing, &arrivals);
        }
    }

    /// Lays the next rays of the paths of a packet that go on, with what they carry; where they were put, and their weights after
    /// roulette and splitting.
    #[inline(always)]
    fn lay(
        &mut self,
        packet: &Packet<'a>,
        goes: Mask,
        [org, dir]: [&Vec3Lanes; 2],
        drawn: &Vec3Lanes,
        pdf: &Lanes,
        survival: &Survival,
    ) -> (Packing, Vec3Lanes) {
        let before = self.batch.wave.paths.packet(packet.ray(0));
        let (mut weight, mut throughput) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        for k in 0..LANES {
            weight.set(k, drawn.get(k) / survival.paths[k]);
            throughput.set(k, before.throughput.get(k) * weight.get(k));
        }
        let (keys, pdf, normal, analog) = (packet.keys, *pdf, packet.light_normals, survival.analog);
        let paths = PathPacket { slot: before.slot, throughput, keys, pdf, normal, analog };
        let keeps_normals = self.keeps_normals();
        let next = &mut self.batch.next;
        let packing = Packing::new(goes.bits(), next.rays.len());
        next.rays.pack(&packing, &RayRows { org: org.rows(), dir: dir.rows(), tfar: &[f32::INFINITY; LANES] });
        next.paths.pack(&packing, &paths, keeps_normals);
        (packing, weight)
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
                let back = self.unexpected(packet, k, &next).map(|weight| weight / paths);
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
