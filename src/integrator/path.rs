//! The path tracer: a batch of paths, advanced bounce by bounce.

mod guided;
mod light;
mod outcome;

use super::backup::{Arrival, Edge};
use super::batch::{Batch, BatchResult, Continuation, Counters, Task, Wave};
use super::mixture::Mixture;
use super::probe::{Cast, Probe, Stage};
use super::roulette::Efficiency;
use crate::embree::{Coherence, Ray};
use crate::film::tile::{Features, Tile};
use crate::guiding::Field;
use crate::math::{Rgb, luminance, rng::Rng};
use crate::scene::Scene;
use crate::scene::description::{GuidingSettings, IntegratorSettings};
use guided::edge;
use std::time::{Duration, Instant};

/// Everything a batch reads and nothing it writes.
#[derive(Clone, Copy)]
pub struct PathIntegrator<'a> {
    pub scene: &'a Scene,
    pub settings: &'a IntegratorSettings,
    pub guide: Option<GuideUse<'a>>,
    pub seed: u64,
    /// Also average what the camera sees first.
    pub features: bool,
    /// Also tell the light that bounced from what came directly.
    pub bounced: bool,
}

/// How the guide takes part.
#[derive(Clone, Copy)]
pub struct GuideUse<'a> {
    pub field: Field<'a>,
    pub settings: &'a GuidingSettings,
    /// Whether transitions are recorded.
    pub learn: bool,
    /// What guided roulette goes by; `None` while too little is known of the picture.
    pub efficiency: Option<&'a Efficiency>,
}

impl PathIntegrator<'_> {
    /// Renders one task.
    pub fn render(&self, task: &Task, batch: &mut Batch) -> BatchResult {
        self.render_probed(task, batch, &mut ())
    }

    /// As [`Self::render`], watched.
    pub fn render_probed<P: Probe>(&self, task: &Task, batch: &mut Batch, probe: &mut P) -> BatchResult {
        let start = Instant::now();
        let mut walk = Walk {
            integrator: self,
            task,
            batch,
            probe,
            counters: Counters { paths: task.paths() as u64, ..Counters::default() },
            learn: self.guide.is_some_and(|g| g.learn),
            jitter: [0.5; 3],
        };
        walk.generate();
        walk.advance(1);
        let recording = Instant::now();
        let recorder = walk.record();
        walk.counters.recording = recording.elapsed();
        let mut result = walk.gather();
        result.counters.transitions = recorder.as_ref().map_or(0, |r| r.len() as u64);
        result.recorder = recorder;
        result.counters.total = start.elapsed();
        result
    }
}

/// A ray that does not come from the camera.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    pub ray: Ray,
    /// Density of its direction per steradian, against which emission that it meets is weighed; `None`: weight 1.
    pub pdf: Option<f32>,
    pub rng: Rng,
}

impl PathIntegrator<'_> {
    /// One sample of the radiance that arrives along each ray, as the second segment of a path would bring it. The
    /// guide is not to learn from it.
    pub fn radiance(&self, starts: &[Start], batch: &mut Batch) -> Vec<Rgb> {
        let tile = Tile { x: 0, y: 0, width: starts.len() as u32, height: 1 };
        let task = Task { tile, first_sample: 0, samples: 1 };
        batch.wave.clear();
        batch.radiance.clear();
        batch.radiance.resize(starts.len(), Rgb::ZERO);
        for (slot, &Start { ray, pdf, rng }) in (0..).zip(starts) {
            batch.wave.rays.push(&ray);
            batch.wave.paths.push(Continuation { slot, throughput: Rgb::ONE, rng, pdf, analog: 1.0, arrival: None });
        }
        let counters = Counters::default();
        let (probe, jitter) = (&mut (), [0.5; 3]);
        let mut walk = Walk { integrator: self, task: &task, batch, probe, counters, learn: false, jitter };
        walk.advance(2);
        walk.batch.radiance.clone()
    }
}

/// One batch on its way.
struct Walk<'a, 'b, P> {
    integrator: &'a PathIntegrator<'a>,
    task: &'a Task,
    batch: &'b mut Batch,
    probe: &'b mut P,
    counters: Counters,
    learn: bool,
    /// Moves the wave's look-ups in the guide. One jitter serves a whole wave: neighbours then read the same tables,
    /// which stay in the cache, and what blends tables is the next wave's jitter. Drawn from numbers of its own, it
    /// knows nothing of the paths, and so cannot bias them.
    jitter: [f32; 3],
}

impl<'a, P: Probe> Walk<'a, '_, P> {
    /// Camera rays, sample by sample, pixels in blocks of 4×4 so that a packet looks one way.
    fn generate(&mut self) {
        self.probe.stage(Stage::Generate);
        let (task, integrator, b) = (self.task, self.integrator, &mut *self.batch);
        let tile = task.tile;
        b.wave.clear();
        b.radiance.clear();
        b.radiance.resize(task.paths(), Rgb::ZERO);
        b.features.clear();
        b.features.resize(if integrator.features { task.paths() } else { 0 }, Features::default());
        b.direct.clear();
        let camera = &integrator.scene.camera;
        let arrival = self.learn.then_some(Arrival { parent: u32::MAX, weight: Rgb::ONE, edge: None });
        for sample in 0..task.samples {
            for (x, y) in blocks(tile.width, tile.height) {
                let slot = sample * tile.pixels() as u32 + y * tile.width + x;
                let (px, py) = (tile.x + x, tile.y + y);
                let mut rng = Rng::for_path(integrator.seed, py * camera.width + px, task.first_sample + sample);
                b.wave.rays.push(&camera.ray(px, py, rng.f32x2()));
                b.wave.paths.push(Continuation { slot, throughput: Rgb::ONE, rng, pdf: None, analog: 1.0, arrival });
            }
        }
    }

    /// All bounces of all paths: intersect, shade, shadow rays, and then the rays with which they go on.
    fn advance(&mut self, first_depth: usize) {
        let mut depth = first_depth;
        let mut jitter = self.jitter_numbers();
        while !self.batch.wave.rays.is_empty() {
            if self.integrator.guide.is_some_and(|g| g.settings.jitter) {
                self.jitter = [jitter.f32(), jitter.f32(), jitter.f32()];
            }
            if self.learn && self.batch.vertices.len() < depth {
                self.batch.vertices.push(Vec::new());
            }
            let coherence = if depth == 1 { Coherence::Coherent } else { Coherence::Incoherent };
            self.counters.rays += self.batch.wave.rays.len() as u64;
            self.trace(depth, coherence);
            self.shade_wave(depth);
            self.keep_direct(depth);
            self.counters.shadow_rays += self.batch.shadow_rays.len() as u64;
            self.trace_shadows(depth);
            self.add_next_events(depth);
            std::mem::swap(&mut self.batch.wave, &mut self.batch.next);
            depth += 1;
        }
    }

    /// Notes what each path has brought by the time when only light of a further bounce can follow: that which the first
    /// vertex emits, and that of lights which it saw. No choice of directions helps with what shadow rays find.
    fn keep_direct(&mut self, depth: usize) {
        let PathIntegrator { settings, bounced, .. } = self.integrator;
        if *bounced && depth == if settings.next_event { 2 } else { 1 } {
            self.batch.direct.extend_from_slice(&self.batch.radiance);
        }
    }

    fn trace(&mut self, depth: usize, coherence: Coherence) {
        self.probe.stage(Stage::Intersect);
        let Wave { rays, paths } = &mut self.batch.wave;
        let (cast, geometry) = (Cast { rays, slots: &paths.slot, depth }, self.integrator.scene.geometry());
        self.counters.embree += timed(|| self.probe.trace(cast, geometry, coherence));
    }

    fn trace_shadows(&mut self, depth: usize) {
        self.probe.stage(Stage::Intersect);
        let Batch { shadow_rays, next_events, .. } = &mut *self.batch;
        let cast = Cast { rays: shadow_rays, slots: &next_events.slot, depth };
        let geometry = self.integrator.scene.geometry();
        self.counters.embree += timed(|| self.probe.trace_shadows(cast, geometry, Coherence::Incoherent));
    }

    /// Random numbers of the batch, apart from those of its paths.
    fn jitter_numbers(&self) -> Rng {
        let Task { tile, first_sample, .. } = *self.task;
        let corner = tile.y * self.integrator.scene.camera.width + tile.x;
        Rng::for_path(!self.integrator.seed, corner, first_sample)
    }

    fn shade_wave(&mut self, depth: usize) {
        self.probe.stage(Stage::Shade);
        self.batch.shadow_rays.clear();
        self.batch.next_events.clear();
        self.batch.next.clear();
        for i in 0..self.batch.wave.rays.len() {
            self.shade(i, depth as u32);
        }
    }

    /// One vertex of path `i`: what arrives there counts, light is asked for, and where the path goes on, its next
    /// ray joins the next wave. The order of the steps is that of the light transport equation read from the left:
    /// emission, direct light, then the rest.
    #[inline]
    fn shade(&mut self, i: usize, depth: u32) {
        let PathIntegrator { scene, settings, .. } = *self.integrator;
        let ray = self.batch.wave.rays.ray(i);
        let (slot, throughput, pdf) = {
            let p = &self.batch.wave.paths;
            (p.slot[i], p.throughput[i], p.pdf[i])
        };

        // The ray left the scene: only an environment is there to be seen.
        let Some(hit) = self.batch.wave.rays.hit(i) else {
            let le = self.weigh_environment(ray.dir, pdf);
            self.batch.radiance[slot as usize] += throughput * le;
            self.log(i, depth, le, None);
            return;
        };
        let wo_world = -ray.dir;
        let si = scene.interaction(&hit, wo_world);

        // Emission, weighted against the chance that next-event estimation had of drawing this direction.
        let le = self.weigh_emission(&hit, &si, &ray, pdf);
        self.batch.radiance[slot as usize] += throughput * le;

        let bsdf = scene.bsdf(&si);
        let wo = si.frame.to_local(wo_world);
        if depth == 1 && self.integrator.features {
            let normal = si.facing(wo_world);
            self.batch.features[slot as usize] = Features { albedo: bsdf.albedo(wo), normal, depth: hit.t };
        }
        if depth >= settings.max_depth {
            self.log(i, depth, le, None);
            return;
        }

        // What the guide knows of this state.
        let mut rng = self.batch.wave.paths.rng[i];
        let guided = self.ask_the_guide(&si, wo_world, &bsdf);
        let summary = guided.as_ref().and_then(|g| g.summary);
        self.log(i, depth, le, self.expectation(summary, &bsdf));
        let mixture = self.mixture(&si, wo, &bsdf, guided.as_ref());

        self.probe.step(Stage::NextEvent);
        if settings.next_event && bsdf.has_smooth() {
            self.ask_a_light(&si, wo, &mixture, slot, throughput, depth, &mut rng);
        }

        // The next direction, or several.
        self.probe.step(Stage::Shade);
        let albedo = bsdf.albedo(wo);
        let analog = self.batch.wave.paths.analog[i] * albedo.max_element();
        let guides = Mixture::guides(&bsdf, false);
        let paths = self.paths(summary, guides, luminance(throughput * albedo), analog, slot, depth);
        let count = paths as u32 + (rng.f32() < paths.fract()) as u32;
        for k in 0..count {
            let mut rng = if k == 0 { rng } else { Rng::new(((rng.next_u32() as u64) << 32) | k as u64) };
            let Some(next) = mixture.sample(&si, wo, &mut rng) else { continue };
            let weight = next.weight / paths;
            let arrival = self.learn.then(|| Arrival {
                parent: self.batch.vertices[depth as usize - 1].len() as u32 - 1,
                weight,
                edge: edge(guided.as_ref(), &next, luminance(albedo))
                    .map(|e| Edge { scattered: if guides { e.scattered } else { 0.0 }, ..e }),
            });
            let b = &mut self.batch.next;
            b.rays.push(&Ray { org: si.spawn(next.wi), dir: next.wi, tfar: f32::INFINITY });
            b.paths.push(Continuation {
                slot,
                throughput: throughput * weight,
                rng,
                pdf: next.pdf.map(|pdf| pdf.mixture),
                analog: analog / paths,
                arrival,
            });
        }
    }
}

/// The pixels of a rectangle in blocks of 4×4.
fn blocks(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..height.div_ceil(4)).flat_map(move |by| {
        (0..width.div_ceil(4)).flat_map(move |bx| {
            (0..16).map(move |k| (4 * bx + k % 4, 4 * by + k / 4)).filter(move |&(x, y)| x < width && y < height)
        })
    })
}

fn timed(f: impl FnOnce()) -> Duration {
    let start = Instant::now();
    f();
    start.elapsed()
}
