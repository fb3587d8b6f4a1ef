//! Recorded rays through Embree alone: by kind, in one order or another, 1, 8 or 16 at a time.

use super::record::{Kind, RecordedWave, Recording};
use crate::embree::{
    Coherence, HitBatch, HitPacket, Packet8, Packet16, Scene, Shadow8, Shadow16, ShadowBatch, ShadowPacket,
};
use crate::geometry::Ray;
use crate::io::clock::WallClock;
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Duration;

/// Which rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RaySet {
    Camera,
    Bounce1,
    Bounce2,
    /// The third bounce and all after it.
    Later,
    Shadow,
}

impl RaySet {
    pub(crate) const ALL: [RaySet; 5] =
        [RaySet::Camera, RaySet::Bounce1, RaySet::Bounce2, RaySet::Later, RaySet::Shadow];

    pub(crate) fn name(self) -> &'static str {
        match self {
            RaySet::Camera => "camera",
            RaySet::Bounce1 => "bounce 1",
            RaySet::Bounce2 => "bounce 2",
            RaySet::Later => "bounce 3 and on",
            RaySet::Shadow => "shadow",
        }
    }

    fn has(self, wave: &RecordedWave) -> bool {
        let own = match (wave.kind, wave.depth) {
            (Kind::Shadow, _) => RaySet::Shadow,
            (Kind::Closest, 0 | 1) => RaySet::Camera,
            (Kind::Closest, 2) => RaySet::Bounce1,
            (Kind::Closest, 3) => RaySet::Bounce2,
            (Kind::Closest, _) => RaySet::Later,
        };
        own == self
    }
}

/// In which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum RayOrder {
    /// As they come: path after path, sample after sample, a tile's pixels row by row.
    Paths,
    /// As the renderer has them: wave after wave.
    Waves,
    /// Each wave sorted by the signs of the directions: the cheapest order that could help.
    Octants,
}

impl RayOrder {
    pub(crate) const ALL: [RayOrder; 3] = [RayOrder::Paths, RayOrder::Waves, RayOrder::Octants];

    pub(crate) fn name(self) -> &'static str {
        match self {
            RayOrder::Paths => "paths",
            RayOrder::Waves => "waves",
            RayOrder::Octants => "octants",
        }
    }
}

/// Rays to be traced together.
pub(crate) struct Chunk {
    kind: Kind,
    coherence: Coherence,
    rays: Vec<Ray>,
}

/// What one batch has to trace, one after the other. Threads share out strands.
pub(crate) type Strand = Vec<Chunk>;

/// All rays, just as the renderer hands them to Embree.
pub(crate) fn as_rendered(recording: &Recording) -> Vec<Strand> {
    recording.batches.iter().map(|waves| waves.iter().map(chunk).collect()).collect()
}

/// The rays of one set.
pub(crate) fn arranged(recording: &Recording, set: RaySet, order: RayOrder) -> Vec<Strand> {
    let of_batch = |waves: &Vec<RecordedWave>| {
        let own: Vec<&RecordedWave> = waves.iter().filter(|wave| set.has(wave)).collect();
        match order {
            RayOrder::Paths => path_by_path(&own).into_iter().collect(),
            RayOrder::Waves => own.into_iter().map(chunk).collect(),
            RayOrder::Octants => own.into_iter().map(|wave| sorted(chunk(wave))).collect(),
        }
    };
    recording.batches.iter().map(of_batch).collect()
}

pub(crate) fn count(strands: &[Strand]) -> usize {
    strands.iter().flatten().map(|chunk| chunk.rays.len()).sum()
}

fn chunk(wave: &RecordedWave) -> Chunk {
    Chunk { kind: wave.kind, coherence: wave.coherence, rays: wave.rays.clone() }
}

fn path_by_path(waves: &[&RecordedWave]) -> Option<Chunk> {
    let first = waves.first()?;
    let mut all: Vec<(u32, Ray)> =
        waves.iter().flat_map(|wave| wave.slots.iter().copied().zip(wave.rays.iter().copied())).collect();
    // waves come by depth, and the sort is stable
    all.sort_by_key(|(slot, _)| *slot);
    Some(Chunk { kind: first.kind, coherence: first.coherence, rays: all.into_iter().map(|(_, ray)| ray).collect() })
}

fn sorted(mut chunk: Chunk) -> Chunk {
    let octant = |d: Vec3| (d.x < 0.0) as u8 | ((d.y < 0.0) as u8) << 1 | ((d.z < 0.0) as u8) << 2;
    chunk.rays.sort_by_key(|ray| octant(ray.dir));
    chunk
}

/// Seconds that Embree's calls take for all strands, summed over the threads of the current pool, and how many rays
/// met something. Packets are filled before the clock runs, as the renderer fills them while it shades; single rays
/// have no packet, and are handed over within it.
pub(crate) fn replay(scene: &Scene, strands: &[Strand], width: usize) -> (f64, usize) {
    let of_strand = |buffers: &mut Buffers, strand: &Strand| {
        strand.iter().map(|chunk| buffers.time(scene, chunk, width)).fold((Duration::ZERO, 0), add)
    };
    let (time, found) = strands.par_iter().map_init(Buffers::new, of_strand).reduce(|| (Duration::ZERO, 0), add);
    (time.as_secs_f64(), found)
}

fn add(a: (Duration, usize), b: (Duration, usize)) -> (Duration, usize) {
    (a.0 + b.0, a.1 + b.1)
}

struct Buffers {
    hits8: HitBatch<Packet8>,
    hits16: HitBatch<Packet16>,
    shadows8: ShadowBatch<Shadow8>,
    shadows16: ShadowBatch<Shadow16>,
}

impl Buffers {
    fn new() -> Buffers {
        Buffers {
            hits8: HitBatch::with_capacity(0),
            hits16: HitBatch::with_capacity(0),
            shadows8: ShadowBatch::with_capacity(0),
            shadows16: ShadowBatch::with_capacity(0),
        }
    }

    fn time(&mut self, scene: &Scene, chunk: &Chunk, width: usize) -> (Duration, usize) {
        match (chunk.kind, width) {
            (Kind::Closest, 8) => hits(&mut self.hits8, scene, chunk),
            (Kind::Closest, 16) => hits(&mut self.hits16, scene, chunk),
            (Kind::Shadow, 8) => shadows(&mut self.shadows8, scene, chunk),
            (Kind::Shadow, 16) => shadows(&mut self.shadows16, scene, chunk),
            (kind, _) => single(scene, &chunk.rays, kind),
        }
    }
}

fn hits<P: HitPacket>(batch: &mut HitBatch<P>, scene: &Scene, chunk: &Chunk) -> (Duration, usize) {
    batch.clear();
    chunk.rays.iter().for_each(|ray| batch.push(ray));
    let start = WallClock::start();
    batch.trace(scene, chunk.coherence);
    let time = start.elapsed();
    (time, (0..batch.len()).filter(|&i| batch.hit(i).is_some()).count())
}

fn shadows<P: ShadowPacket>(batch: &mut ShadowBatch<P>, scene: &Scene, chunk: &Chunk) -> (Duration, usize) {
    batch.clear();
    chunk.rays.iter().for_each(|ray| batch.push(ray));
    let start = WallClock::start();
    batch.trace(scene, chunk.coherence);
    let time = start.elapsed();
    (time, (0..batch.len()).filter(|&i| batch.occluded(i)).count())
}

fn single(scene: &Scene, rays: &[Ray], kind: Kind) -> (Duration, usize) {
    let start = WallClock::start();
    let found = match kind {
        Kind::Closest => rays.iter().filter(|ray| scene.intersect(ray).is_some()).count(),
        Kind::Shadow => rays.iter().filter(|ray| scene.occluded(ray)).count(),
    };
    (start.elapsed(), found)
}

/// Rays to the last bit, in their order.
#[cfg(test)]
pub(crate) fn bits(strands: &[Strand]) -> Vec<[u32; 7]> {
    let of = |ray: &Ray| {
        let [ox, oy, oz] = ray.org.to_array();
        let [dx, dy, dz] = ray.dir.to_array();
        [ox, oy, oz, dx, dy, dz, ray.tfar].map(f32::to_bits)
    };
    strands.iter().flatten().flat_map(|chunk| chunk.rays.iter().map(of)).collect()
}
