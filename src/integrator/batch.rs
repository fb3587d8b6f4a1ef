//! The memory of a batch of paths, and what comes out of it.

use super::backup::{Arrival, Followed, Vertex};
use crate::embree::{HitBatch, ShadowBatch};
use crate::film::tile::{Features, Tile, TileSamples};
use crate::guiding::Recorder;
use crate::math::Rgb;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
use crate::math::rng::{Rng, RngLanes};
use glam::Vec3;
use std::time::Duration;

/// A tile and the samples to take of each of its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    pub tile: Tile,
    /// Index of the first sample, counted over the whole render.
    pub first_sample: u32,
    pub samples: u32,
}

impl Task {
    pub fn paths(&self) -> usize {
        self.tile.pixels() * self.samples as usize
    }
}

/// Paths under way, in the order of their rays, and as these in packets.
#[derive(Default)]
pub(super) struct Paths {
    /// Place in the batch: which pixel and sample.
    pub slot: Vec<u32>,
    packets: Vec<PathPacket>,
    /// How each path came here; kept where something is learnt.
    pub arrival: Vec<Arrival>,
}

/// What a path carries from vertex to vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState {
    pub throughput: Rgb,
    pub rng: Rng,
    /// Density of the ray's direction per steradian; infinite behind a camera or a delta lobe.
    pub pdf: f32,
    /// What roulette goes by: the share of light that scattering would have left on the way here.
    pub analog: f32,
}

/// The same for a packet of paths, side by side.
#[derive(Clone, Copy)]
pub(super) struct PathPacket {
    pub throughput: Vec3Lanes,
    pub rng: RngLanes,
    pub pdf: Lanes,
    pub analog: Lanes,
}

impl Paths {
    pub fn clear(&mut self) {
        self.slot.clear();
        self.arrival.clear();
    }

    #[inline(always)]
    pub fn push(&mut self, slot: u32, state: PathState) {
        let (packet, lane) = (self.slot.len() / LANES, self.slot.len() % LANES);
        if packet == self.packets.len() {
            self.packets.push(PathPacket::EMPTY);
        }
        self.packets[packet].set(lane, state);
        self.slot.push(slot);
    }

    /// The packet of path `first`, a multiple of [`LANES`].
    #[inline(always)]
    pub fn packet(&self, first: usize) -> &PathPacket {
        debug_assert!(first < self.slot.len() && first.is_multiple_of(LANES));
        &self.packets[first / LANES]
    }

    #[inline(always)]
    pub fn throughput(&self, i: usize) -> Rgb {
        self.packets[i / LANES].throughput.get(i % LANES)
    }

    /// Density of the ray's direction, as of [`PathState`].
    #[inline(always)]
    pub fn pdf(&self, i: usize) -> f32 {
        self.packets[i / LANES].pdf[i % LANES]
    }
}

impl PathPacket {
    const EMPTY: PathPacket =
        PathPacket { throughput: Vec3Lanes::ZERO, rng: RngLanes::ZERO, pdf: [0.0; LANES], analog: [0.0; LANES] };

    #[inline(always)]
    fn set(&mut self, lane: usize, PathState { throughput, rng, pdf, analog }: PathState) {
        self.throughput.set(lane, throughput);
        self.rng.set(lane, rng);
        (self.pdf[lane], self.analog[lane]) = (pdf, analog);
    }
}

/// The rays of a wave and the paths that cast them.
pub(super) struct Wave {
    pub rays: HitBatch,
    pub paths: Paths,
}

impl Wave {
    fn new() -> Wave {
        Wave { rays: HitBatch::with_capacity(0), paths: Paths::default() }
    }

    pub fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
    }
}

/// Shadow rays of one wave and what they would bring.
#[derive(Default)]
pub(super) struct NextEvents {
    pub slot: Vec<u32>,
    /// To the pixel.
    pub contribution: Vec<Rgb>,
    /// To the vertex, and which one it is in its wave; kept where something is learnt.
    pub local: Vec<(Rgb, u32)>,
}

impl NextEvents {
    pub fn clear(&mut self) {
        self.slot.clear();
        self.contribution.clear();
        self.local.clear();
    }
}

/// Scratch memory for one batch at a time; a worker keeps it from task to task.
pub struct Batch {
    /// The wave under way, and the next one as it grows.
    pub(super) wave: Wave,
    pub(super) next: Wave,
    pub(super) shadow_rays: ShadowBatch,
    pub(super) next_events: NextEvents,
    /// Vertices by wave, where something is learnt.
    pub(super) vertices: Vec<Vec<Vertex>>,
    pub(super) followed: [Vec<Followed>; 2],
    /// Vertices with their normals, while the guide has no sites.
    pub(super) points: Vec<(Vec3, Vec3)>,
    pub(super) radiance: Vec<Rgb>,
    /// As much of it as no bounce brought; empty where not asked for, or no path came so far.
    pub(super) direct: Vec<Rgb>,
    pub(super) features: Vec<Features>,
    /// Empty: for the next task's transitions, perhaps with room from earlier ones.
    pub recorder: Recorder,
}

impl Batch {
    pub fn new() -> Batch {
        Batch {
            wave: Wave::new(),
            next: Wave::new(),
            shadow_rays: ShadowBatch::with_capacity(0),
            next_events: NextEvents::default(),
            vertices: Vec::new(),
            followed: Default::default(),
            points: Vec::new(),
            radiance: Vec::new(),
            direct: Vec::new(),
            features: Vec::new(),
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
    pub samples: TileSamples,
    /// Per pixel of the tile, Σ x and Σ x² of the luminance x that bounced; empty where there was none, or not asked for.
    pub bounced: Vec<[f32; 2]>,
    pub recorder: Option<Recorder>,
    pub counters: Counters,
}

/// Path statistics; they add up.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    pub paths: u64,
    /// Segments of all paths.
    pub rays: u64,
    pub shadow_rays: u64,
    /// Paths that brought no light.
    pub zero_contribution: u64,
    /// Vertices where the guide was asked, and where it knew an answer.
    pub guide_queries: u64,
    pub guide_hits: u64,
    /// Transitions recorded.
    pub transitions: u64,
    /// NaN or infinite samples; they count as black.
    pub non_finite: u64,
    /// The first of them: pixel and sample.
    pub first_non_finite: Option<(u32, u32, u32)>,
    /// Processor time in Embree's queries, packets prepared, and in all of the batch.
    pub embree: Duration,
    pub total: Duration,
    /// As much of `total` as it took to make transitions of the paths.
    pub recording: Duration,
}

impl Counters {
    pub fn add(&mut self, other: &Counters) {
        self.paths += other.paths;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.zero_contribution += other.zero_contribution;
        self.guide_queries += other.guide_queries;
        self.guide_hits += other.guide_hits;
        self.transitions += other.transitions;
        self.non_finite += other.non_finite;
        self.first_non_finite = self.first_non_finite.or(other.first_non_finite);
        self.embree += other.embree;
        self.total += other.total;
        self.recording += other.recording;
    }
}
