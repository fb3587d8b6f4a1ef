//! The memory of a batch of paths, and what comes out of it.

use super::backward_pass::{Return, WaveRecord};
use super::radiance::Radiance;
use super::sampler::{PathKey, PathKeys};
use super::vertex_record::VertexRecords;
use crate::embree::{HitBatch, ShadowBatch};
use crate::film::ids::Ids;
use crate::film::tile::{Aovs, Tile, TileSamples};
use crate::guiding::Recorder;
use crate::io::clock::CpuTime;
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Packing, Vec3Lanes};
use glam::Vec3;
use std::time::Duration;

/// A tile and the samples to take of each of its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    pub(crate) tile: Tile,
    /// Index of the first sample, counted over the whole render.
    pub(crate) first_sample: u32,
    pub(crate) samples: u32,
}

impl Task {
    pub(crate) fn paths(&self) -> usize {
        self.tile.pixels() * self.samples as usize
    }
}

/// Paths under way, in the order of their rays, and as these in packets.
#[derive(Default)]
pub(super) struct Paths {
    packets: Vec<PathPacket>,
    len: usize,
    /// How each path came here; kept where something is learnt.
    pub(crate) arrivals: VertexRecords,
}

/// What a path carries from vertex to vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub(crate) throughput: Rgb,
    pub(crate) keys: PathKey,
    /// Density of the ray's direction per steradian; infinite behind a camera or a delta lobe.
    pub(crate) pdf: f32,
    /// Normal of the surface that it comes from, as of [`LightSampleContext`](crate::light::LightSampleContext); any where
    /// lights are not chosen by it.
    pub(crate) normal: Vec3,
    /// What roulette goes by: the share of light that scattering would have left on the way here.
    pub(crate) analog: f32,
}

/// The same for a packet of paths, side by side.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct PathPacket {
    /// Place in the batch: which pixel and sample.
    pub(crate) slot: [u32; LANES],
    pub(crate) throughput: Vec3Lanes,
    /// Their random numbers.
    pub(crate) keys: PathKeys<LANES>,
    pub(crate) pdf: Lanes,
    pub(crate) normal: Vec3Lanes,
    pub(crate) analog: Lanes,
}

impl Paths {
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        self.arrivals.clear();
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, slot: u32, state: PathState) {
        let (packet, lane) = (self.len / LANES, self.len % LANES);
        if packet == self.packets.len() {
            self.packets.push(PathPacket::EMPTY);
        }
        self.packets[packet].set(lane, slot, state);
        self.len += 1;
    }

    /// Adds the paths of a packet that `packing`, made for this length, has chosen; their normals only where lights are chosen
    /// by them.
    #[inline(always)]
    pub(crate) fn pack(&mut self, packing: &Packing, paths: &PathPacket, normals: bool) {
        let [first, second] = packing.packets(&mut self.packets, || PathPacket::EMPTY);
        paths.pack(packing, [&mut *first, &mut *second]);
        if normals {
            paths.normal.pack(packing, [&mut first.normal, &mut second.normal]);
        }
        self.len += packing.count();
    }

    /// The packet of path `first`, a multiple of [`LANES`].
    #[inline(always)]
    pub(crate) fn packet(&self, first: usize) -> &PathPacket {
        debug_assert!(first < self.len && first.is_multiple_of(LANES));
        &self.packets[first / LANES]
    }

    /// Place of path `i` in the batch.
    #[inline(always)]
    pub(crate) fn slot(&self, i: usize) -> u32 {
        self.packets[i / LANES].slot[i % LANES]
    }

    #[inline(always)]
    pub(crate) fn throughput(&self, i: usize) -> Rgb {
        self.packets[i / LANES].throughput.get(i % LANES)
    }

    /// Density of the ray's direction, as of [`PathState`].
    #[inline(always)]
    pub(crate) fn pdf(&self, i: usize) -> f32 {
        self.packets[i / LANES].pdf[i % LANES]
    }

    /// As of [`PathState`].
    #[inline(always)]
    pub(crate) fn normal(&self, i: usize) -> Vec3 {
        self.packets[i / LANES].normal.get(i % LANES)
    }
}

impl PathPacket {
    pub(crate) const EMPTY: PathPacket = PathPacket {
        slot: [0; LANES],
        throughput: Vec3Lanes::ZERO,
        keys: PathKeys::NONE,
        pdf: [0.0; LANES],
        normal: Vec3Lanes::ZERO,
        analog: [0.0; LANES],
    };

    /// Paths that begin at a camera.
    pub(crate) fn at_camera(slot: [u32; LANES], keys: PathKeys<LANES>) -> PathPacket {
        let mut throughput = Vec3Lanes::ZERO;
        throughput.set_rows([&[1.0; LANES]; 3]);
        PathPacket {
            slot,
            throughput,
            keys,
            pdf: [f32::INFINITY; LANES],
            normal: Vec3Lanes::ZERO,
            analog: [1.0; LANES],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, slot: u32, state: PathState) {
        let PathState { throughput, keys, pdf, normal, analog } = state;
        self.slot[lane] = slot;
        self.throughput.set(lane, throughput);
        self.keys.set(lane, keys);
        self.normal.set(lane, normal);
        (self.pdf[lane], self.analog[lane]) = (pdf, analog);
    }

    #[inline(always)]
    fn pack(&self, packing: &Packing, [first, second]: [&mut PathPacket; 2]) {
        packing.put(&self.slot, [&mut first.slot, &mut second.slot]);
        self.throughput.pack(packing, [&mut first.throughput, &mut second.throughput]);
        self.keys.pack(packing, [&mut first.keys, &mut second.keys]);
        packing.put(&self.pdf, [&mut first.pdf, &mut second.pdf]);
        packing.put(&self.analog, [&mut first.analog, &mut second.analog]);
    }
}

/// The rays of a wave and the paths that cast them.
pub(super) struct Wave {
    pub(crate) rays: HitBatch,
    pub(crate) paths: Paths,
}

impl Wave {
    fn new() -> Wave {
        Wave { rays: HitBatch::with_capacity(0), paths: Paths::default() }
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
    }
}

/// What the shadow rays of one wave would bring, in their order and as these in packets.
#[derive(Default)]
pub(super) struct NextEvents {
    pub(crate) packets: Vec<NextEventLanes>,
    len: usize,
}

/// The same for a packet, side by side.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct NextEventLanes {
    /// Place of the path in the batch.
    pub(crate) slot: [u32; LANES],
    /// To the pixel.
    pub(crate) contribution: Vec3Lanes,
    /// To the vertex, and which one it is in its wave.
    pub(crate) local: Vec3Lanes,
    /// How many shadow rays this one stands for.
    pub(crate) rays: Lanes,
    pub(crate) vertex: [u32; LANES],
    /// Number of the light's group.
    pub(crate) group: [u32; LANES],
}

impl NextEvents {
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds those of a packet that `packing`, made for this length, has chosen; what vertices learn only where they `learn`, and
    /// groups where lights are told apart.
    #[inline(always)]
    pub(crate) fn pack(&mut self, packing: &Packing, events: &NextEventLanes, [learn, groups]: [bool; 2]) {
        let [first, second] = packing.packets(&mut self.packets, || NextEventLanes::EMPTY);
        packing.put(&events.slot, [&mut first.slot, &mut second.slot]);
        events.contribution.pack(packing, [&mut first.contribution, &mut second.contribution]);
        if learn {
            events.local.pack(packing, [&mut first.local, &mut second.local]);
            packing.put(&events.rays, [&mut first.rays, &mut second.rays]);
            packing.put(&events.vertex, [&mut first.vertex, &mut second.vertex]);
        }
        if groups {
            packing.put(&events.group, [&mut first.group, &mut second.group]);
        }
        self.len += packing.count();
    }

    /// Place of the path of shadow ray `i` in the batch.
    #[inline(always)]
    pub(crate) fn slot(&self, i: usize) -> u32 {
        self.packets[i / LANES].slot[i % LANES]
    }
}

impl NextEventLanes {
    pub(crate) const EMPTY: NextEventLanes = NextEventLanes {
        slot: [0; LANES],
        contribution: Vec3Lanes::ZERO,
        local: Vec3Lanes::ZERO,
        rays: [0.0; LANES],
        vertex: [0; LANES],
        group: [0; LANES],
    };
}

/// Scratch memory for one batch at a time; a worker keeps it from task to task.
pub struct Batch {
    /// The wave under way, and the next one as it grows.
    pub(super) wave: Wave,
    pub(super) next: Wave,
    pub(super) shadow_rays: ShadowBatch,
    pub(super) next_events: NextEvents,
    /// Vertices by wave, where something is learnt.
    pub(super) vertices: Vec<WaveRecord>,
    pub(super) followed: [Vec<Return>; 2],
    /// Vertices with their normals, while the guide has no sites.
    pub(super) points: Vec<(Vec3, Vec3)>,
    pub(super) radiance: Radiance,
    pub(super) features: Vec<Aovs>,
    /// What camera rays met; empty where not asked for.
    pub(super) ids: Vec<Ids>,
    /// By path, 1 over the luminance expected of its pixel, where guided roulette goes by it.
    pub(super) inverse_luminance: Vec<f32>,
    /// Empty: for the next task's transitions, perhaps with room from earlier ones.
    pub(crate) recorder: Recorder,
}

impl Batch {
    pub(crate) fn new() -> Batch {
        Batch {
            wave: Wave::new(),
            next: Wave::new(),
            shadow_rays: ShadowBatch::with_capacity(0),
            next_events: NextEvents::default(),
            vertices: Vec::new(),
            followed: Default::default(),
            points: Vec::new(),
            radiance: Radiance::default(),
            features: Vec::new(),
            ids: Vec::new(),
            inverse_luminance: Vec::new(),
            recorder: Recorder::new(),
        }
    }
}

impl Default for Batch {
    fn default() -> Batch {
        Batch::new()
    }
}

/// What a task brings back.
#[derive(Default)]
pub struct BatchResult {
    pub(crate) samples: TileSamples,
    /// Per pixel of the tile, Σ x and Σ x² of the luminance x that bounced; empty where there was none, or not asked for.
    pub(crate) bounced: Vec<[f32; 2]>,
    pub(crate) recorder: Option<Recorder>,
    pub(crate) counters: Counters,
}

/// Path statistics; they add up.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    pub paths: u64,
    /// Segments of all paths.
    pub rays: u64,
    pub shadow_rays: u64,
    /// Paths that brought no light.
    pub(crate) zero_contribution: u64,
    /// Vertices where the guide was asked, and where it knew an answer.
    pub guide_queries: u64,
    pub guide_hits: u64,
    /// Directions drawn at surfaces with smooth lobes, and those of them that the guide drew.
    pub directions: u64,
    pub guided_directions: u64,
    /// Transitions recorded.
    pub transitions: u64,
    /// NaN or infinite samples; they count as black.
    pub non_finite: u64,
    /// The first of them: pixel and sample.
    pub(crate) first_non_finite: Option<(u32, u32, u32)>,
    /// Wall time of threads in Embree's queries, packets prepared, and in whole batches: short pieces, for which a
    /// processor clock would be too slow.
    pub(crate) embree_wall: Duration,
    pub(crate) wall: Duration,
    /// Processor time of whole batches, and as much of it as it took to make transitions of the paths.
    pub(crate) cpu: CpuTime,
    pub(crate) recording_cpu: CpuTime,
}

impl Counters {
    pub(crate) fn add(&mut self, other: &Counters) {
        self.paths += other.paths;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.zero_contribution += other.zero_contribution;
        self.guide_queries += other.guide_queries;
        self.guide_hits += other.guide_hits;
        self.directions += other.directions;
        self.guided_directions += other.guided_directions;
        self.transitions += other.transitions;
        self.non_finite += other.non_finite;
        self.first_non_finite = self.first_non_finite.or(other.first_non_finite);
        self.embree_wall += other.embree_wall;
        self.wall += other.wall;
        self.cpu += other.cpu;
        self.recording_cpu += other.recording_cpu;
    }
}
