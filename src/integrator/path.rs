//! The path tracer: a batch of paths, advanced bounce by bounce.

use super::backup::{self, Vertex};
use super::batch::{Batch, BatchResult, Counters, Task};
use super::mixture::Mixture;
use crate::bsdf::Bsdf;
use crate::embree::{Coherence, Hit, Ray};
use crate::film::tile::{Features, TileSamples};
use crate::geometry::SurfaceInteraction;
use crate::guiding::{Field, Recorder, StateKey};
use crate::math::{Rgb, rng::Rng};
use crate::scene::Scene;
use crate::scene::description::{IntegratorSettings, Roulette};
use glam::Vec3;
use std::time::{Duration, Instant};

/// Survival of roulette at most, so that no path between mirrors runs for ever.
const MAX_SURVIVAL: f32 = 0.95;

/// Everything a batch reads and nothing it writes.
#[derive(Clone, Copy)]
pub struct PathIntegrator<'a> {
    pub scene: &'a Scene,
    pub settings: &'a IntegratorSettings,
    pub guide: Option<GuideUse<'a>>,
    pub seed: u64,
    /// Also average what the camera sees first.
    pub features: bool,
}

/// How the guide takes part.
#[derive(Clone, Copy)]
pub struct GuideUse<'a> {
    pub field: &'a Field,
    pub bsdf_fraction: f32,
    pub lambda: f32,
    /// Whether transitions are recorded.
    pub learn: bool,
}

impl PathIntegrator<'_> {
    /// Renders one task.
    pub fn render(&self, task: &Task, batch: &mut Batch) -> BatchResult {
        let start = Instant::now();
        let mut walk = Walk {
            integrator: self,
            task,
            batch,
            counters: Counters { paths: task.paths() as u64, ..Counters::default() },
            learn: self.guide.is_some_and(|g| g.learn),
            jitter: [0.5; 2],
        };
        walk.generate();
        walk.advance();
        let recorder = walk.record();
        let mut result = walk.gather();
        result.counters.transitions = recorder.as_ref().map_or(0, |r| r.len() as u64);
        result.recorder = recorder;
        result.counters.total = start.elapsed();
        result
    }
}

/// One batch on its way.
struct Walk<'a, 'b> {
    integrator: &'a PathIntegrator<'a>,
    task: &'a Task,
    batch: &'b mut Batch,
    counters: Counters,
    learn: bool,
    /// Moves the wave's look-ups in the guide. One jitter serves a whole wave: neighbours then read the same tables,
    /// which stay in the cache, and what blends tables is the next wave's jitter. Drawn from numbers of its own, it
    /// knows nothing of the paths, and so cannot bias them.
    jitter: [f32; 2],
}

impl Walk<'_, '_> {
    /// Camera rays, sample by sample, pixels in blocks of 4×4 so that a packet looks one way.
    fn generate(&mut self) {
        let (task, integrator, b) = (self.task, self.integrator, &mut *self.batch);
        let tile = task.tile;
        b.rays.clear();
        b.paths.clear();
        b.radiance.clear();
        b.radiance.resize(task.paths(), Rgb::ZERO);
        b.features.clear();
        b.features.resize(if integrator.features { task.paths() } else { 0 }, Features::default());
        let camera = &integrator.scene.camera;
        for sample in 0..task.samples {
            for (x, y) in blocks(tile.width, tile.height) {
                let slot = sample * tile.pixels() as u32 + y * tile.width + x;
                let (px, py) = (tile.x + x, tile.y + y);
                let mut rng = Rng::for_path(integrator.seed, py * camera.width + px, task.first_sample + sample);
                b.rays.push(&camera.ray(px, py, rng.f32x2()));
                b.paths.push_camera(slot, rng);
            }
        }
    }

    /// All bounces of all paths: intersect, shade, shadow rays, and the survivors' next rays in place of the old.
    fn advance(&mut self) {
        let mut depth = 1;
        let mut jitter = self.jitter_numbers();
        while !self.batch.rays.is_empty() {
            self.jitter = jitter.f32x2();
            if self.learn && self.batch.waves.len() < depth {
                self.batch.waves.push(Vec::new());
            }
            let coherence = if depth == 1 { Coherence::Coherent } else { Coherence::Incoherent };
            self.counters.rays += self.batch.rays.len() as u64;
            let scene = self.integrator.scene;
            self.counters.embree += timed(|| self.batch.rays.trace(scene.geometry(), coherence));
            self.shade_wave(depth);
            self.counters.shadow_rays += self.batch.shadow_rays.len() as u64;
            self.counters.embree += timed(|| self.batch.shadow_rays.trace(scene.geometry(), Coherence::Incoherent));
            self.add_next_events(depth);
            depth += 1;
        }
    }

    /// Random numbers of the batch, apart from those of its paths.
    fn jitter_numbers(&self) -> Rng {
        let Task { tile, first_sample, .. } = *self.task;
        let corner = tile.y * self.integrator.scene.camera.width + tile.x;
        Rng::for_path(!self.integrator.seed, corner, first_sample)
    }

    fn shade_wave(&mut self, depth: usize) {
        self.batch.shadow_rays.clear();
        self.batch.next_events.clear();
        let mut alive = 0;
        for i in 0..self.batch.rays.len() {
            if self.shade(i, alive, depth as u32) {
                alive += 1;
            }
        }
        self.batch.rays.truncate(alive);
    }

    /// One vertex of path `i`: what arrives there counts, light is asked for, and where the path goes on, its next
    /// ray takes place `to` (never behind `i`). The order of the steps is that of the light transport equation read
    /// from the left: emission, direct light, then the rest.
    #[inline]
    fn shade(&mut self, i: usize, to: usize, depth: u32) -> bool {
        let PathIntegrator { scene, settings, .. } = *self.integrator;
        let ray = self.batch.rays.ray(i);
        let (slot, throughput, pdf) = {
            let p = &self.batch.paths;
            (p.slot[i], p.throughput[i], p.pdf[i])
        };

        // The ray left the scene: only an environment is there to be seen.
        let Some(hit) = self.batch.rays.hit(i) else {
            let le = self.weigh_environment(ray.dir, pdf);
            self.batch.radiance[slot as usize] += throughput * le;
            self.log(depth, Vertex { slot, action: None, weight: Rgb::ZERO, local: le, expected: None });
            return false;
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
        let mut vertex = Vertex { slot, action: None, weight: Rgb::ZERO, local: le, expected: None };
        if depth >= settings.max_depth {
            self.log(depth, vertex);
            return false;
        }

        // What the guide knows of this state.
        let mut rng = self.batch.paths.rng[i];
        let state = self.state(&si, wo_world, &bsdf);
        let guided = self.integrator.guide.zip(state);
        let distribution = guided.and_then(|(guide, key)| guide.field.distribution(key));
        self.counters.guide_hits += distribution.is_some() as u64;
        if let (Some(d), Some(reflectance)) = (&distribution, bsdf.lambertian()) {
            vertex.expected = Some(reflectance * (std::f32::consts::FRAC_1_PI * d.irradiance));
        }
        let fraction = guided.map_or(1.0, |(guide, _)| guide.bsdf_fraction);
        let mixture = Mixture::new(&bsdf, distribution, fraction);

        if settings.next_event && bsdf.has_smooth() {
            self.ask_a_light(&si, wo, &mixture, slot, throughput, depth, &mut rng);
        }

        // The next direction.
        let drawn = mixture.sample(&si, wo, &mut rng);
        let analog = self.batch.paths.analog[i] * bsdf.albedo(wo).max_element();
        let survival = self.survival(analog, depth);
        let Some(next) = drawn.filter(|_| survival >= 1.0 || rng.f32() < survival) else {
            self.log(depth, vertex);
            return false;
        };
        let weight = next.weight / survival;
        if let (Some((guide, key)), Some(_)) = (guided, next.pdf) {
            vertex.action = guide.field.action(key, next.wi).map(|a| (key, a as u16));
        }
        vertex.weight = weight;
        self.log(depth, vertex);

        let p = &mut self.batch.paths;
        p.slot[to] = slot;
        p.throughput[to] = throughput * weight;
        p.rng[to] = rng;
        p.pdf[to] = next.pdf;
        p.analog[to] = analog / survival;
        self.batch.rays.set(to, &Ray { org: si.spawn(next.wi), dir: next.wi, tfar: f32::INFINITY });
        true
    }

    /// The state in which the path now is, where a guide could help its BSDF.
    #[inline]
    fn state(&mut self, si: &SurfaceInteraction, wo: Vec3, bsdf: &Bsdf) -> Option<StateKey> {
        let guide = self.integrator.guide.filter(|_| bsdf.has_smooth())?;
        self.counters.guide_queries += 1;
        Some(guide.field.grid().key(si.p, si.facing(wo), self.jitter))
    }

    /// Draws a light and lays a shadow ray towards it.
    #[allow(clippy::too_many_arguments, reason = "a step of the narrated loop above")]
    #[inline]
    fn ask_a_light(
        &mut self,
        si: &SurfaceInteraction,
        wo: Vec3,
        mixture: &Mixture,
        slot: u32,
        throughput: Rgb,
        depth: u32,
        rng: &mut Rng,
    ) {
        let (u_choice, u) = (rng.f64(), rng.f32x2());
        let Some(light) = self.integrator.scene.lights().sample(si.p, u_choice, u) else { return };
        let (f, mixture_pdf) = mixture.eval_pdf(si, wo, light.wi);
        if f == Rgb::ZERO {
            return;
        }
        let weight = match self.integrator.settings.mis && !light.delta {
            true => power_heuristic(light.pdf, mixture_pdf),
            false => 1.0,
        };
        let local = f * light.radiance * (weight / light.pdf);
        if local == Rgb::ZERO {
            return;
        }
        self.batch.shadow_rays.push(&light.shadow_ray(si.spawn(light.wi)));
        let vertex = if self.learn { self.batch.waves[depth as usize - 1].len() as u32 } else { 0 };
        let n = &mut self.batch.next_events;
        n.slot.push(slot);
        n.contribution.push(throughput * local);
        n.local.push(local);
        n.vertex.push(vertex);
    }

    /// What the shadow rays found open is added to pixels and to what vertices will learn.
    fn add_next_events(&mut self, depth: usize) {
        let b = &mut *self.batch;
        for k in 0..b.shadow_rays.len() {
            if b.shadow_rays.occluded(k) {
                continue;
            }
            b.radiance[b.next_events.slot[k] as usize] += b.next_events.contribution[k];
            if self.learn {
                b.waves[depth - 1][b.next_events.vertex[k] as usize].local += b.next_events.local[k];
            }
        }
    }

    #[inline]
    fn weigh_environment(&self, dir: Vec3, pdf: Option<f32>) -> Rgb {
        let lights = self.integrator.scene.lights();
        let le = lights.environment_radiance(dir);
        if le == Rgb::ZERO { le } else { le * self.emitter_weight(pdf, || lights.pdf_environment(dir)) }
    }

    #[inline]
    fn weigh_emission(&self, hit: &Hit, si: &SurfaceInteraction, ray: &Ray, pdf: Option<f32>) -> Rgb {
        let scene = self.integrator.scene;
        let le = scene.emission(si);
        if le == Rgb::ZERO { le } else { le * self.emitter_weight(pdf, || scene.emitter_pdf(hit, si, ray)) }
    }

    /// MIS weight of an emitter that a ray met by itself. `pdf` is the density the ray was drawn with, `light_pdf`
    /// that of next-event estimation for the same direction.
    #[inline]
    fn emitter_weight(&self, pdf: Option<f32>, light_pdf: impl FnOnce() -> f32) -> f32 {
        let settings = self.integrator.settings;
        match pdf {
            Some(pdf) if settings.next_event && settings.mis => power_heuristic(pdf, light_pdf()),
            Some(_) if settings.next_event => 0.0,
            _ => 1.0,
        }
    }

    /// Probability of going on. It goes by the share of light that scattering leaves on the way (`analog`), not by
    /// the throughput: a guide that finds the light lowers the throughput of just the paths that matter.
    #[inline]
    fn survival(&self, analog: f32, depth: u32) -> f32 {
        match self.integrator.settings.roulette {
            Roulette::Throughput if depth >= self.integrator.settings.rr_depth => analog.min(MAX_SURVIVAL),
            _ => 1.0,
        }
    }

    #[inline]
    fn log(&mut self, depth: u32, vertex: Vertex) {
        if self.learn {
            self.batch.waves[depth as usize - 1].push(vertex);
        }
    }

    fn record(&mut self) -> Option<Recorder> {
        let guide = self.integrator.guide.filter(|_| self.learn)?;
        let mut recorder = Recorder::new();
        let b = &mut *self.batch;
        backup::record(&b.waves, self.task.paths(), guide.lambda, &mut b.returns, &mut recorder);
        b.waves.iter_mut().for_each(Vec::clear);
        Some(recorder)
    }

    /// Sums over the samples of each pixel. A sample that is not finite is counted and left out as black.
    fn gather(mut self) -> BatchResult {
        let (tile, pixels) = (self.task.tile, self.task.tile.pixels());
        let mut samples = TileSamples {
            sum: vec![Rgb::ZERO; pixels],
            sum_squares: vec![Rgb::ZERO; pixels],
            features: vec![Features::default(); if self.integrator.features { pixels } else { 0 }],
        };
        for (slot, &radiance) in self.batch.radiance.iter().enumerate() {
            let pixel = slot % pixels;
            if !radiance.is_finite() {
                self.counters.non_finite += 1;
                let (x, y) = (tile.x + pixel as u32 % tile.width, tile.y + pixel as u32 / tile.width);
                let sample = self.task.first_sample + (slot / pixels) as u32;
                self.counters.first_non_finite.get_or_insert((x, y, sample));
                continue;
            }
            self.counters.zero_contribution += (radiance == Rgb::ZERO) as u64;
            samples.sum[pixel] += radiance;
            samples.sum_squares[pixel] += radiance * radiance;
        }
        for (slot, &features) in self.batch.features.iter().enumerate() {
            samples.features[slot % pixels] += features;
        }
        BatchResult { samples, recorder: None, counters: self.counters }
    }
}

/// Veach's power heuristic (1997, eq. 9.13, β = 2) for one sample of each technique.
#[inline]
fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // the ratio first: squares of densities overflow sooner than densities
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
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
