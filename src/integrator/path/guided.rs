//! What the guide has to say at a vertex, and what it will learn of it.

use super::draw::DirectionSamples;
use super::packet::Packet;
use super::{GuideUse, Probe, Wavefront};
use crate::bsdf::{Bsdf, DIFFUSE};
use crate::guiding::settings::{GuideSampling, LearningRule};
use crate::guiding::{PackedDirection, RegionId, RegionInfo, RegionLookup};
use crate::integrator::Roulette;
use crate::integrator::backward_pass::{BootstrapValue, Targets};
use crate::integrator::mixture::{DirectionSample, GuidedBy, GuidedLobes, glossy_product};
use crate::integrator::roulette::{MAX_SURVIVAL, Moments, RouletteNormalisation};
use crate::integrator::vertex_record::{PathSegment, VertexRecordLanes};
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
    key: RegionId,
    summary: Option<&'a RegionInfo>,
}

impl<'a, P: Probe> Wavefront<'a, '_, P> {
    /// Asks the guide about the vertices of a packet: first where all of them are in its memory, then what is there.
    pub(super) fn ask_the_guide(&mut self, guide: GuideUse<'a>, packet: &mut Packet<'a>, depth: u32) {
        packet.guided = [None; LANES];
        packet.find_guided_lobes();
        let mut normals = Vec3Lanes::ZERO;
        packet.surfaces.facing_normals(&mut normals);
        let keys = guide.field.locate_lanes(packet.smooth(), packet.surfaces.places(), &normals, self.jitter);
        let mut known = Mask::NONE;
        for k in each(packet.smooth()) {
            self.counters.guide_queries += 1;
            let (p, n) = (packet.surfaces.p(k), normals.get(k));
            let place = match &keys {
                Some(keys) => Some(RegionLookup { drawn: keys[k], recorded: keys[k] }),
                None => guide.field.locate(p, n, self.jitter),
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
        self.expect(guide, summary, &bsdf, packet, k, depth);
        packet.set_visibility(k, summary.open);
        if packet.rough().has(k) {
            packet.set_moments(k, Moments::of(summary));
        }
        let products = matches!(guide.settings.sampling, GuideSampling::Product | GuideSampling::GlossyProduct);
        if products && bsdf.lambertian().is_none() && self.take_product(guide, packet, k, n, &bsdf)
            || packet.lobes(k).share() == 0.0
        {
            return;
        }
        match guide.field.tree(summary, n) {
            Some(tree) => packet.set_tree_guide(k, tree, summary.bsdf_fraction),
            None => packet.set_guide(k, guide.field.distribution(summary, n), summary.bsdf_fraction),
        }
    }

    /// The same from a product with the BSDF; whether there is one.
    #[inline(never)]
    fn take_product(&self, guide: GuideUse<'a>, packet: &mut Packet<'a>, k: usize, n: Vec3, bsdf: &Bsdf) -> bool {
        let Some(summary) = packet.guided[k].and_then(|guided| guided.summary) else { return false };
        let (frame, wo) = (packet.surfaces.get(k).frame, packet.surfaces.wo_local(k));
        let product = match guide.settings.sampling {
            GuideSampling::Product => {
                let lobes = GuidedLobes::of(bsdf, wo, GuidedBy::FullProduct);
                let value = |w| {
                    let wi = frame.to_local(w);
                    let (f, _) = lobes.eval_pdf(bsdf, wo, wi, bsdf.eval_pdf(wo, wi));
                    luminance(f) / wi.z.abs().max(MIN_COSINE)
                };
                (lobes.share() > 0.0).then(|| (lobes, guide.field.distribution(summary, n).times(value)))
            }
            _ => glossy_product((guide.field, summary), bsdf, wo, (&frame, n)),
        };
        let Some((lobes, directions)) = product else { return false };
        packet.set_product(k, lobes, directions, summary.bsdf_fraction);
        true
    }

    /// Keeps what the table expects of going on from a vertex that is kept for learning.
    #[inline]
    fn expect(&mut self, guide: GuideUse, summary: &RegionInfo, bsdf: &Bsdf, packet: &Packet, k: usize, depth: u32) {
        if !self.learn {
            return;
        }
        let (rule, blend) = (guide.settings.rule_in_use(), guide.settings.blend_visits);
        let known = (summary.irradiance, summary.peak, summary.visits);
        let (reflectance, whole) = match bsdf.lambertian() {
            Some(reflectance) => (reflectance, true),
            None => (bsdf.diffuse_albedo(packet.surfaces.wo_local(k)), false),
        };
        let expected = Targets::expected(rule, |rule| {
            let value = BootstrapValue::new(rule, blend, known, reflectance);
            if whole { value } else { value.map(BootstrapValue::of_a_part) }
        });
        self.batch.vertices[depth as usize - 1].expected[packet.ray(k)] = expected;
    }

    /// What goes back to vertex `k`, which draws by itself, of what `next` finds, as a part of its weight: what the vertex
    /// expects already of its diffuse lobes is left out.
    #[inline]
    pub(super) fn unexpected(&self, packet: &Packet, k: usize, next: &DirectionSample) -> Targets<Rgb> {
        let all = Targets { rule: next.weight, moments: next.weight };
        let (Some(guide), Some(summary)) = (self.integrator.guide, packet.guided[k].and_then(|known| known.summary))
        else {
            return all;
        };
        let (Some(bsdf), Some(pdf), wo) = (packet.bsdfs.get(k), next.pdf, packet.surfaces.wo_local(k)) else {
            return all;
        };
        if bsdf.lambertian().is_some() || bsdf.diffuse_albedo(wo) == Rgb::ZERO {
            return all;
        }
        let wi = packet.surfaces.get(k).frame.to_local(next.wi);
        let (diffuse, _) = bsdf.eval_pdf_rough(wo, wi, DIFFUSE);
        let (rule, blend) = (guide.settings.rule_in_use(), guide.settings.blend_visits);
        let without = |rule| match BootstrapValue::share(rule, blend, summary.visits) {
            Some(share) => (next.weight - diffuse * (share / pdf.mixture)).max(Rgb::ZERO),
            None => next.weight,
        };
        Targets { rule: without(rule), moments: without(LearningRule::ExpectedSarsa) }
    }

    /// Expected numbers of paths that go on, where surfaces reflect `albedo` and `analog` of the light would be left. The
    /// throughput's roulette goes by that share, not by the throughput: a guide that finds the light lowers the throughput
    /// of just the paths that matter. In `analog` is left what is still to be accounted for after these numbers.
    #[inline(always)]
    pub(super) fn expected_paths(&self, packet: &Packet, albedo: &Vec3Lanes, analog: &mut Lanes, depth: u32) -> Lanes {
        let settings = self.integrator.settings;
        let mut paths = [1.0; LANES];
        if settings.roulette != Roulette::None && depth >= settings.rr_depth {
            for k in 0..LANES {
                paths[k] = analog[k].min(MAX_SURVIVAL);
            }
        }
        for k in 0..LANES {
            analog[k] /= paths[k];
        }
        let efficiency = self.integrator.guide.and_then(|guide| guide.efficiency);
        if let (Roulette::Guided, Some(efficiency)) = (settings.roulette, efficiency) {
            self.guided_paths(efficiency, packet, albedo, &mut paths, analog);
        }
        paths
    }

    /// The same where it goes by what the guide knows. `paths` holds what the numbers are without that.
    #[inline(always)]
    fn guided_paths(
        &self,
        efficiency: &RouletteNormalisation,
        packet: &Packet,
        albedo: &Vec3Lanes,
        paths: &mut Lanes,
        analog: &mut Lanes,
    ) {
        let full = self.batch.next.rays.len() >= MAX_WAVE * self.task.paths();
        let max_split = if full { 1.0 } else { self.integrator.settings.max_split };
        let before = self.batch.wave.paths.packet(packet.ray(0));
        let (mut inverse_luminance, mut sharp) = ([0.0; LANES], [0.0; LANES]);
        for k in each(packet.has_moments()) {
            inverse_luminance[k] = self.batch.inverse_luminance[before.slot[k] as usize];
            sharp[k] = packet.lobes(k).sharp();
        }
        let told = packet.has_moments().lanes();
        for k in 0..LANES {
            let reflected = luminance(before.throughput.get(k) * albedo.get(k)) * (1.0 - sharp[k]);
            let rough = efficiency.paths(packet.moments(k), reflected, inverse_luminance[k], max_split);
            let guided = with_sharp_lobes(rough, sharp[k], paths[k]).min(max_split.max(1.0));
            paths[k] = pick(told.has(k), guided, paths[k]);
            // what a state has told of accounts for all of the way to it
            analog[k] = pick(told.has(k), 1.0, analog[k]);
        }
    }

    /// Notes for each path of the batch what guided roulette weighs its pixel by.
    pub(super) fn weigh_pixels(&mut self) {
        let (tile, b) = (self.task.tile, &mut *self.batch);
        b.inverse_luminance.clear();
        let Some(efficiency) = self.integrator.guide.and_then(|guide| guide.efficiency) else { return };
        for _ in 0..self.task.samples {
            for y in tile.y..tile.y + tile.height {
                let first = (y * self.integrator.camera.width + tile.x) as usize;
                let row = &efficiency.inverse_luminance[first..first + tile.width as usize];
                b.inverse_luminance.extend_from_slice(row);
            }
        }
    }
}

/// What is to be learnt of a direction. The weight is that of the draw, before roulette and splitting.
#[inline]
pub(super) fn edge(packet: &Packet, k: usize, next: &DirectionSample, albedo: f32) -> Option<PathSegment> {
    let (guided, pdf) = (packet.guided[k]?, next.pdf?);
    let [wi, normal] = [next.wi, packet.surfaces.facing_normal(k)].map(PackedDirection::new);
    Some(PathSegment {
        key: guided.key,
        wi,
        normal,
        pdf: pdf.mixture,
        bsdf_pdf: pdf.bsdf,
        guide_pdf: pdf.guide,
        scattered: if packet.rough().has(k) {
            scattered_by(packet.lobes(k), packet, k, next, pdf.mixture, albedo)
        } else if packet.products().has(k) {
            // the sign says that only the share is to be learnt of it
            -scattered_by(packet.drawn_lobes(k), packet, k, next, pdf.mixture, albedo)
        } else {
            0.0
        },
    })
}

/// Luminance of f·|cosθ| of the guided lobes over that of their albedo.
#[inline]
fn scattered_by(lobes: GuidedLobes, packet: &Packet, k: usize, next: &DirectionSample, pdf: f32, albedo: f32) -> f32 {
    let bsdf = packet.bsdfs.get(k).filter(|bsdf| bsdf.lambertian().is_none());
    let Some(bsdf) = bsdf.filter(|_| lobes.sharp() > 0.0) else { return scattered(next.weight, pdf, albedo) };
    let wi = packet.surfaces.get(k).frame.to_local(next.wi);
    let (f, _) = lobes.eval_pdf(&bsdf, packet.surfaces.wo_local(k), wi, (next.weight * pdf, pdf));
    // lobes are drawn in proportion to their albedos
    luminance(f) / (albedo * lobes.share())
}

/// Expected number of paths where the rough lobes by themselves ask for `rough` of them and the others, which are drawn
/// with probability `sharp`, for `others`. Numbers are roots of second moments (see [`RouletteNormalisation::paths`]), and second
/// moments of lobes add up.
#[inline(always)]
fn with_sharp_lobes(rough: f32, sharp: f32, others: f32) -> f32 {
    pick(sharp > 0.0, (rough * rough + sharp * others * others).sqrt(), rough)
}

/// How paths come to their next vertices where a packet has drawn side by side, which a guide can help all of; with the
/// weights of these branches.
#[inline(always)]
pub(super) fn edges(
    packet: &Packet,
    proposals: &DirectionSamples,
    weight: &Vec3Lanes,
    albedo: &Lanes,
) -> VertexRecordLanes {
    let mut normals = Vec3Lanes::ZERO;
    packet.surfaces.facing_normals(&mut normals);
    let mut arrivals = VertexRecordLanes {
        parent: packet.rays(),
        teaches: [0; LANES],
        // surfaces that are drawn from side by side are diffuse alone: all that they reflect is expected, or none of it
        weight: Targets { rule: *weight, moments: *weight },
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
