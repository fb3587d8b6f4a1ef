//! What the guide has to say at a vertex, and what it will learn of it.

use super::draw::Proposals;
use super::packet::Packet;
use super::{GuideUse, Probe, Walk};
use crate::bsdf::Bsdf;
use crate::guiding::settings::GuideSampling;
use crate::guiding::{PackedDirection, Place, StateKey, Summary};
use crate::integrator::Roulette;
use crate::integrator::arrivals::{ArrivalLanes, Edge};
use crate::integrator::backup::Expectation;
use crate::integrator::mixture::{DirectionSample, Mixture};
use crate::integrator::roulette::{Efficiency, MAX_SURVIVAL, Moments};
use crate::math::{Rgb, luminance};
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each, pick};
use glam::Vec3;

/// Splitting stops where a wave has this many times the paths of its batch.
const MAX_WAVE: usize = 4;

/// Cosines are divided by at least this, where a BSDF's value is wanted without its own.
const MIN_COSINE: f32 = 1e-3;

/// What the guide knows of a vertex.
#[derive(Clone, Copy)]
pub(super) struct Guided<'a> {
    /// Where to record.
    key: StateKey,
    summary: Option<&'a Summary>,
}

impl<'a, P: Probe> Walk<'a, '_, P> {
    /// Asks the guide about the vertices of a packet: first where all of them are in its memory, then what is there.
    pub(super) fn ask_the_guide(&mut self, guide: GuideUse<'a>, packet: &mut Packet<'a>, depth: u32) {
        packet.guided = [None; LANES];
        let mut normals = Vec3Lanes::ZERO;
        packet.surfaces.facing_normals(&mut normals);
        let keys = guide.field.places(packet.surfaces.places(), &normals, self.jitter);
        let mut known = Mask::NONE;
        for k in each(packet.smooth()) {
            self.counters.guide_queries += 1;
            let (p, n) = (packet.surfaces.p(k), normals.get(k));
            let place = match &keys {
                Some(keys) => Some(Place { drawn: keys[k], recorded: keys[k] }),
                None => guide.field.place(p, n, self.jitter),
            };
            let Some(place) = place else {
                if self.learn {
                    self.batch.points.push((p, n));
                }
                continue;
            };
            let summary = guide.field.summary(place.drawn);
            known.set(k, summary.is_some());
            self.counters.guide_hits += summary.is_some() as u64;
            packet.guided[k] = Some(Guided { key: place.recorded, summary });
        }
        for k in each(known) {
            self.take_directions(guide, packet, k, normals.get(k), depth);
        }
        packet.resolve_trees();
    }

    /// Takes the guide's directions at vertex `k`, where they can help.
    #[inline(always)]
    fn take_directions(&mut self, guide: GuideUse<'a>, packet: &mut Packet<'a>, k: usize, n: Vec3, depth: u32) {
        let (Some(bsdf), Some(Guided { summary: Some(summary), .. })) = (packet.bsdfs.get(k), packet.guided[k]) else {
            return;
        };
        self.expect(guide, summary, &bsdf, depth, packet.ray(k));
        if Mixture::guides(&bsdf, false) {
            packet.tell(k, Moments::of(summary));
        }
        if !Mixture::guides(&bsdf, self.product()) {
            return;
        }
        let product = self.product() && bsdf.lambertian().is_none();
        match guide.field.tree(summary, n).filter(|_| !product) {
            Some(tree) => packet.lead_by_tree(k, tree, summary.bsdf_fraction),
            None => self.take_others(guide, packet, k, n, product.then_some(&bsdf)),
        }
    }

    /// The same where they are no tree, or its product with the BSDF.
    #[inline(never)]
    fn take_others(&self, guide: GuideUse<'a>, packet: &mut Packet<'a>, k: usize, n: Vec3, product: Option<&Bsdf>) {
        let Some(summary) = packet.guided[k].and_then(|guided| guided.summary) else { return };
        let mut directions = guide.field.distribution(summary, n);
        if let Some(bsdf) = product {
            let (frame, wo) = (packet.surfaces.get(k).frame, packet.surfaces.wo_local(k));
            directions = directions.times(|w| {
                let wi = frame.to_local(w);
                luminance(bsdf.eval(wo, wi)) / wi.z.abs().max(MIN_COSINE)
            });
        }
        packet.lead(k, directions, summary.bsdf_fraction);
    }

    /// Keeps what the table expects of going on from a vertex that is kept for learning.
    #[inline]
    fn expect(&mut self, guide: GuideUse, summary: &Summary, bsdf: &Bsdf, depth: u32, i: usize) {
        let Some(reflectance) = bsdf.lambertian().filter(|_| self.learn) else { return };
        let (rule, blend) = (guide.settings.rule_in_use(), guide.settings.blend_visits);
        let known = (summary.irradiance, summary.peak, summary.visits);
        let expected = Expectation::new(rule, blend, known, reflectance);
        self.batch.vertices[depth as usize - 1].expected[i] = expected.unwrap_or(Expectation::NONE);
    }

    /// Whether directions are drawn from the product of guide and BSDF.
    #[inline]
    pub(super) fn product(&self) -> bool {
        self.integrator.guide.is_some_and(|guide| guide.settings.sampling == GuideSampling::Product)
    }

    /// Expected numbers of paths that go on, where surfaces reflect `albedo` and `analog` of the light would be left. The
    /// throughput's roulette goes by that share, not by the throughput: a guide that finds the light lowers the throughput
    /// of just the paths that matter.
    #[inline(always)]
    pub(super) fn expected_paths(&self, packet: &Packet, albedo: &Vec3Lanes, analog: &Lanes, depth: u32) -> Lanes {
        let settings = self.integrator.settings;
        let efficiency = self.integrator.guide.and_then(|guide| guide.efficiency);
        let mut paths = [1.0; LANES];
        if let (Roulette::Guided, Some(efficiency)) = (settings.roulette, efficiency) {
            self.guided_paths(efficiency, packet, albedo, depth, &mut paths);
        } else if settings.roulette != Roulette::None && depth >= settings.rr_depth {
            for k in 0..LANES {
                paths[k] = analog[k].min(MAX_SURVIVAL);
            }
        }
        paths
    }

    /// The same where it goes by what the guide knows.
    #[inline(always)]
    fn guided_paths(
        &self,
        efficiency: &Efficiency,
        packet: &Packet,
        albedo: &Vec3Lanes,
        depth: u32,
        paths: &mut Lanes,
    ) {
        let settings = self.integrator.settings;
        let full = self.batch.next.rays.len() >= MAX_WAVE * self.task.paths();
        let max_split = if full { 1.0 } else { settings.max_split };
        // of the return by a sharp lobe, a state's moments say nothing
        let untold = if depth >= settings.rr_depth { MAX_SURVIVAL } else { 1.0 };
        let before = self.batch.wave.paths.packet(packet.ray(0));
        let mut inverse_luminance = [0.0; LANES];
        for k in each(packet.told()) {
            inverse_luminance[k] = self.batch.inverse_luminance[before.slot[k] as usize];
        }
        let told = packet.told().lanes();
        for k in 0..LANES {
            let reflected = luminance(before.throughput.get(k) * albedo.get(k));
            let guided = efficiency.paths(packet.moments(k), reflected, inverse_luminance[k], max_split);
            paths[k] = pick(told.has(k), guided, untold);
        }
    }

    /// Notes for each path of the batch what guided roulette weighs its pixel by.
    pub(super) fn weigh_pixels(&mut self) {
        let (tile, b) = (self.task.tile, &mut *self.batch);
        b.inverse_luminance.clear();
        let Some(efficiency) = self.integrator.guide.and_then(|guide| guide.efficiency) else { return };
        for _ in 0..self.task.samples {
            for y in tile.y..tile.y + tile.height {
                let first = (y * self.integrator.scene.camera.width + tile.x) as usize;
                let row = &efficiency.inverse_luminance[first..first + tile.width as usize];
                b.inverse_luminance.extend_from_slice(row);
            }
        }
    }
}

/// What is to be learnt of a direction. The weight is that of the draw, before roulette and splitting.
#[inline]
pub(super) fn edge(packet: &Packet, k: usize, next: &DirectionSample, albedo: f32) -> Option<Edge> {
    let (guided, pdf) = (packet.guided[k]?, next.pdf?);
    let [wi, normal] = [next.wi, packet.surfaces.facing_normal(k)].map(PackedDirection::new);
    Some(Edge {
        key: guided.key,
        wi,
        normal,
        pdf: pdf.mixture,
        bsdf_pdf: pdf.bsdf,
        guide_pdf: pdf.guide,
        scattered: if packet.guides(k) { scattered(next.weight, pdf.mixture, albedo) } else { 0.0 },
    })
}

/// How paths come to their next vertices where a packet has drawn side by side, which a guide can help all of; with the
/// weights of these branches.
#[inline(always)]
pub(super) fn edges(packet: &Packet, proposals: &Proposals, weight: &Vec3Lanes, albedo: &Lanes) -> ArrivalLanes {
    let mut normals = Vec3Lanes::ZERO;
    packet.surfaces.facing_normals(&mut normals);
    let mut arrivals = ArrivalLanes {
        parent: packet.rays(),
        teaches: [0; LANES],
        weight: *weight,
        key: [0; LANES],
        wi: PackedDirection::of_lanes(&proposals.dir),
        normal: PackedDirection::of_lanes(&normals),
        pdf: proposals.mixture,
        bsdf_pdf: proposals.bsdf,
        guide_pdf: proposals.guide,
        scattered: [0.0; LANES],
    };
    for k in 0..LANES {
        (arrivals.teaches[k], arrivals.key[k]) = packet.guided[k].map_or((0, 0), |guided| (1, guided.key.0));
        arrivals.scattered[k] = scattered(proposals.weight.get(k), proposals.mixture[k], albedo[k]);
    }
    arrivals
}

/// Luminance of f·|cosθ| over that of the albedo, by the weight of a draw.
#[inline(always)]
fn scattered(weight: Rgb, pdf: f32, albedo: f32) -> f32 {
    luminance(weight) * pdf / albedo
}
