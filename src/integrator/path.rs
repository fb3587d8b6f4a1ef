//! The path tracer: a batch of paths, advanced bounce by bounce.

mod draw;
mod guided;
mod light;
mod outcome;
mod packet;
mod scatter;
mod shade;

use super::backward_pass::WaveRecord;
use super::batch::{Batch, BatchResult, Counters, PathPacket, PathState, Task, Wave};
use super::probe::{Cast, Probe, Stage};
use super::roulette::RouletteNormalisation;
use super::sampler::{CameraNumbers, PathKey, PathKeys, Sampler, SamplerKind};
use super::stop::Stop;
use crate::embree::Coherence;
use crate::film::RadianceLayer;
use crate::film::ids::NOTHING;
use crate::film::tile::{Aovs, Tile};
use crate::geometry::{Ray, RayRows};
use crate::guiding::Field;
use crate::guiding::settings::GuidingSettings;
use crate::integrator::IntegratorSettings;
use crate::io::clock::{CpuClock, WallClock};
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::scene::{Camera, Scene};
use crate::simd::{LANES, Packing, Vec3Lanes};
use glam::Vec3;
use std::time::Duration;

/// Everything a batch reads and nothing it writes.
#[derive(Clone, Copy)]
pub(crate) struct PathIntegrator<'a> {
    pub(crate) scene: &'a Scene,
    /// The scene's, or another.
    pub(crate) camera: &'a Camera,
    pub(crate) settings: &'a IntegratorSettings,
    pub(crate) guide: Option<GuideUse<'a>>,
    pub(crate) seed: u64,
    pub(crate) sampler: SamplerKind,
    /// Sample with which the sequence of samples begins that is spread evenly by itself, counted over the whole render.
    pub(crate) sequence: u32,
    /// Also average what the camera sees first.
    pub(crate) features: bool,
    /// With these, also count which objects and materials it sees.
    pub(crate) ids: bool,
    /// Also tell the light that bounced from what came directly.
    pub(crate) bounced: bool,
    /// Layers of light that are kept apart.
    pub(crate) layers: &'a [RadianceLayer],
}

/// How the guide takes part.
#[derive(Clone, Copy)]
pub(crate) struct GuideUse<'a> {
    pub(crate) field: Field<'a>,
    pub(crate) settings: &'a GuidingSettings,
    /// Whether transitions are recorded.
    pub(crate) learn: bool,
    /// What guided roulette goes by; `None` while too little is known of the picture.
    pub(crate) efficiency: Option<&'a RouletteNormalisation>,
}

impl<'a> PathIntegrator<'a> {
    /// A plain path tracer: no guide, and nothing but the picture, of independent samples.
    pub(crate) fn plain(scene: &'a Scene, settings: &'a IntegratorSettings, seed: u64) -> PathIntegrator<'a> {
        PathIntegrator {
            scene,
            camera: &scene.camera,
            settings,
            guide: None,
            seed,
            sampler: SamplerKind::Independent,
            sequence: 0,
            features: false,
            ids: false,
            bounced: false,
            layers: &[],
        }
    }

    /// Renders one task.
    pub(crate) fn render(&self, task: &Task, batch: &mut Batch) -> BatchResult {
        self.render_probed(task, batch, &mut (), &Stop::new()).expect("a task that nobody stops is finished")
    }

    /// As [`Self::render`], watched; `None` where `stop` gave it up before its end. What its paths had brought until
    /// then is lost: those that are over are the shorter ones, and they alone would bias the picture.
    pub(crate) fn render_probed<P: Probe>(
        &self,
        task: &Task,
        batch: &mut Batch,
        probe: &mut P,
        stop: &Stop,
    ) -> Option<BatchResult> {
        let (wall, cpu) = (WallClock::start(), CpuClock::thread());
        let mut walk = Wavefront {
            integrator: self,
            task,
            batch,
            probe,
            sampler: Sampler::new(self.sampler, task.first_sample + task.samples - self.sequence),
            counters: Counters { paths: task.paths() as u64, ..Counters::default() },
            learn: self.guide.is_some_and(|g| g.learn),
            jitter: [0.5; 3],
        };
        walk.generate();
        walk.weigh_pixels();
        if !walk.advance(1, stop) {
            return None;
        }
        let recorder = walk.record();
        let mut result = walk.gather();
        result.counters.transitions = recorder.as_ref().map_or(0, |r| r.len() as u64);
        result.recorder = recorder;
        (result.counters.wall, result.counters.cpu) = (wall.elapsed(), cpu.elapsed());
        Some(result)
    }
}

/// A ray that does not come from the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub(crate) ray: Ray,
    /// Density of its direction per steradian, against which emission that it meets is weighed; `None`: weight 1.
    pub(crate) pdf: Option<f32>,
    /// By which a light would be chosen where the ray begins, as of [`LightSampleContext`](crate::light::LightSampleContext).
    pub(crate) normal: Vec3,
    /// Its random numbers.
    pub(crate) keys: PathKey,
}

impl PathIntegrator<'_> {
    /// One sample of the radiance that arrives along each ray, as the second segment of a path would bring it. The
    /// guide is not to learn from it.
    pub(crate) fn radiance(&self, starts: &[Start], batch: &mut Batch) -> Vec<Rgb> {
        let tile = Tile { x: 0, y: 0, width: starts.len() as u32, height: 1 };
        let task = Task { tile, first_sample: 0, samples: 1 };
        batch.wave.clear();
        batch.radiance.begin(std::iter::empty(), starts.len());
        for (slot, &Start { ray, pdf, normal, keys }) in (0..).zip(starts) {
            batch.wave.rays.push(&ray);
            let pdf = pdf.unwrap_or(f32::INFINITY);
            batch.wave.paths.push(slot, PathState { throughput: Rgb::ONE, keys, pdf, normal, analog: 1.0 });
        }
        let counters = Counters::default();
        let (probe, jitter, sampler) = (&mut (), [0.5; 3], Sampler::new(self.sampler, u32::MAX));
        let mut walk =
            Wavefront { integrator: self, task: &task, batch, probe, sampler, counters, learn: false, jitter };
        walk.weigh_pixels();
        walk.advance(2, &Stop::new());
        walk.batch.radiance.all().collect()
    }

    /// Light that no choice of directions helps with: what the first vertex emits, and what shadow rays from it find.
    pub(super) fn unbounced(&self) -> Option<RadianceLayer> {
        self.bounced.then_some(RadianceLayer::Shortest(if self.settings.next_event { 2 } else { 1 }))
    }
}

/// One batch on its way.
struct Wavefront<'a, 'b, P> {
    integrator: &'a PathIntegrator<'a>,
    task: &'a Task,
    batch: &'b mut Batch,
    probe: &'b mut P,
    sampler: Sampler,
    counters: Counters,
    learn: bool,
    /// Moves the wave's look-ups in the guide. One jitter serves a whole wave: neighbours then read the same tables,
    /// which stay in the cache, and what blends tables is the next wave's jitter. Drawn from numbers of its own, it
    /// knows nothing of the paths, and so cannot bias them.
    jitter: [f32; 3],
}

impl<'a, P: Probe> Wavefront<'a, '_, P> {
    /// Camera rays, sample by sample, pixels in blocks of 4×4 so that a packet looks one way.
    fn generate(&mut self) {
        self.probe.stage(Stage::Generate);
        let (task, integrator, b) = (self.task, self.integrator, &mut *self.batch);
        let tile = task.tile;
        b.wave.clear();
        b.radiance.begin(integrator.layers.iter().copied().chain(integrator.unbounced()), task.paths());
        b.features.clear();
        b.features.resize(if integrator.features { task.paths() } else { 0 }, Aovs::default());
        b.ids.clear();
        b.ids.resize(if integrator.features && integrator.ids { task.paths() } else { 0 }, NOTHING);
        if self.learn {
            b.wave.paths.arrivals.begin(task.paths());
        }
        for sample in 0..task.samples {
            for_blocks(tile.width, tile.height, |pixels| self.generate_block(sample, pixels));
        }
    }

    /// The camera rays of a sample in a block of pixels of the tile.
    #[inline(always)]
    fn generate_block(&mut self, sample: u32, pixels: &[(u32, u32)]) {
        let (PathIntegrator { seed, sequence, .. }, tile) = (*self.integrator, self.task.tile);
        let (camera, number) = (self.integrator.camera, self.task.first_sample + sample - sequence);
        let mut keys = PathKeys::<LANES>::NONE;
        for (k, &(x, y)) in pixels.iter().enumerate() {
            keys.set(k, PathKey::new(seed, camera.pixel(tile.x + x, tile.y + y), sequence, number));
        }
        let [mut slot, mut across, mut down] = [[0; LANES]; 3];
        for (k, &(x, y)) in pixels.iter().enumerate() {
            slot[k] = sample * tile.pixels() as u32 + y * tile.width + x;
            (across[k], down[k]) = (tile.x + x, tile.y + y);
        }
        let (mut org, mut dir) = (Vec3Lanes::ZERO, Vec3Lanes::ZERO);
        if camera.has_lens() {
            let CameraNumbers { film, lens } = self.sampler.camera(&keys);
            camera.rays([&across, &down], &film, [&mut org, &mut dir]);
            camera.bend(&lens, [&mut org, &mut dir]);
        } else {
            camera.rays([&across, &down], &self.sampler.film(&keys), [&mut org, &mut dir]);
        }
        let (keeps_normals, Wave { rays, paths }) = (self.keeps_normals(), &mut self.batch.wave);
        let chosen = u16::MAX >> (LANES - pixels.len());
        let packing = Packing::new(chosen, rays.len());
        rays.pack(&packing, &RayRows { org: org.rows(), dir: dir.rows(), tfar: &[f32::INFINITY; LANES] });
        paths.pack(&packing, &PathPacket::at_camera(slot, keys), keeps_normals);
    }

    /// All bounces of all paths: intersect, shade, shadow rays, and then the rays with which they go on. `false` where
    /// `stop` came before the last.
    fn advance(&mut self, first_depth: usize, stop: &Stop) -> bool {
        let mut depth = first_depth;
        let mut jitter = self.jitter_numbers();
        while !self.batch.wave.rays.is_empty() {
            if stop.gives_up_tasks() {
                return false;
            }
            if self.integrator.guide.is_some_and(|g| g.settings.jitter) {
                self.jitter = [jitter.f32(), jitter.f32(), jitter.f32()];
            }
            if self.learn && self.batch.vertices.len() < depth {
                self.batch.vertices.push(WaveRecord::default());
            }
            if self.learn {
                self.batch.vertices[depth - 1].begin(&mut self.batch.wave.paths.arrivals);
            }
            let coherence = if depth == 1 { Coherence::Coherent } else { Coherence::Incoherent };
            self.counters.rays += self.batch.wave.rays.len() as u64;
            self.trace(depth, coherence);
            self.shade_wave(depth as u32);
            self.counters.shadow_rays += self.batch.shadow_rays.len() as u64;
            self.trace_shadows(depth);
            self.add_next_events(depth);
            std::mem::swap(&mut self.batch.wave, &mut self.batch.next);
            depth += 1;
        }
        true
    }

    fn trace(&mut self, depth: usize, coherence: Coherence) {
        self.probe.stage(Stage::Intersect);
        let Wave { rays, paths } = &mut self.batch.wave;
        let (cast, geometry) = (Cast { rays, slots: &|i| paths.slot(i), depth }, self.integrator.scene.geometry());
        self.counters.embree_wall += timed(|| self.probe.trace(cast, geometry, coherence));
    }

    fn trace_shadows(&mut self, depth: usize) {
        self.probe.stage(Stage::Intersect);
        let Batch { shadow_rays, next_events, .. } = &mut *self.batch;
        let cast = Cast { rays: shadow_rays, slots: &|i| next_events.slot(i), depth };
        let geometry = self.integrator.scene.geometry();
        self.counters.embree_wall += timed(|| self.probe.trace_shadows(cast, geometry, Coherence::Incoherent));
    }

    /// Random numbers of the batch, apart from those of its paths.
    fn jitter_numbers(&self) -> Rng {
        let Task { tile, first_sample, .. } = *self.task;
        let corner = self.integrator.camera.pixel(tile.x, tile.y);
        Rng::for_place(!self.integrator.seed, corner, first_sample)
    }
}

/// The pixels of a rectangle in blocks of 4×4, which are smaller at its edges.
#[inline(always)]
fn for_blocks(width: u32, height: u32, mut block: impl FnMut(&[(u32, u32)])) {
    for (by, bx) in (0..height).step_by(4).flat_map(|by| (0..width).step_by(4).map(move |bx| (by, bx))) {
        let (mut pixels, mut count) = ([(0, 0); LANES], 0);
        for y in by..height.min(by + 4) {
            for x in bx..width.min(bx + 4) {
                (pixels[count], count) = ((x, y), count + 1);
            }
        }
        block(&pixels[..count]);
    }
}

fn timed(f: impl FnOnce()) -> Duration {
    let clock = WallClock::start();
    f();
    clock.elapsed()
}
