//! The path tracer: a batch of paths, advanced bounce by bounce.

use super::backup::{self, Arrival, Edge, Expectation, Vertex};
use super::batch::{Batch, BatchResult, Continuation, Counters, Task};
use super::mixture::{DirectionSample, Mixture};
use super::roulette::{Efficiency, MAX_SURVIVAL};
use crate::bsdf::Bsdf;
use crate::embree::{Coherence, Hit, Ray};
use crate::film::tile::{Features, Tile, TileSamples};
use crate::geometry::SurfaceInteraction;
use crate::guiding::{Field, PackedDirection, Recorder, StateKey, Summary};
use crate::math::{Rgb, luminance, rng::Rng};
use crate::scene::Scene;
use crate::scene::description::{GuideSampling, GuidingSettings, IntegratorSettings, Roulette};
use glam::Vec3;
use std::time::{Duration, Instant};

/// Splitting stops where a wave has this many times the paths of its batch.
const MAX_WAVE: usize = 4;

/// Cosines are divided by at least this, where a BSDF's value is wanted without its own.
const MIN_COSINE: f32 = 1e-3;

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
    pub field: Field<'a>,
    pub settings: &'a GuidingSettings,
    /// Whether transitions are recorded.
    pub learn: bool,
    /// What guided roulette goes by; `None` while too little is known of the picture.
    pub efficiency: Option<&'a Efficiency>,
}

/// What the guide knows of a vertex.
struct Guided<'a> {
    /// Where to record.
    key: StateKey,
    /// Shading normal on the side of the path.
    normal: Vec3,
    summary: Option<&'a Summary>,
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
            jitter: [0.5; 3],
        };
        walk.generate();
        walk.advance(1);
        let recorder = walk.record();
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
        let mut walk = Walk { integrator: self, task: &task, batch, counters, learn: false, jitter: [0.5; 3] };
        walk.advance(2);
        walk.batch.radiance.clone()
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
    jitter: [f32; 3],
}

impl<'a> Walk<'a, '_> {
    /// Camera rays, sample by sample, pixels in blocks of 4×4 so that a packet looks one way.
    fn generate(&mut self) {
        let (task, integrator, b) = (self.task, self.integrator, &mut *self.batch);
        let tile = task.tile;
        b.wave.clear();
        b.radiance.clear();
        b.radiance.resize(task.paths(), Rgb::ZERO);
        b.features.clear();
        b.features.resize(if integrator.features { task.paths() } else { 0 }, Features::default());
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
            let scene = self.integrator.scene;
            self.counters.embree += timed(|| self.batch.wave.rays.trace(scene.geometry(), coherence));
            self.shade_wave(depth);
            self.counters.shadow_rays += self.batch.shadow_rays.len() as u64;
            self.counters.embree += timed(|| self.batch.shadow_rays.trace(scene.geometry(), Coherence::Incoherent));
            self.add_next_events(depth);
            std::mem::swap(&mut self.batch.wave, &mut self.batch.next);
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

        if settings.next_event && bsdf.has_smooth() {
            self.ask_a_light(&si, wo, &mixture, slot, throughput, depth, &mut rng);
        }

        // The next direction, or several.
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

    /// What the guide knows of the state in which the path now is, where a guide could help its BSDF.
    #[inline]
    fn ask_the_guide(&mut self, si: &SurfaceInteraction, wo: Vec3, bsdf: &Bsdf) -> Option<Guided<'a>> {
        let guide = self.integrator.guide.filter(|_| bsdf.has_smooth())?;
        self.counters.guide_queries += 1;
        let normal = si.facing(wo);
        let Some(place) = guide.field.place(si.p, normal, self.jitter) else {
            if self.learn {
                self.batch.points.push((si.p, normal));
            }
            return None;
        };
        let summary = guide.field.summary(place.drawn);
        self.counters.guide_hits += summary.is_some() as u64;
        Some(Guided { key: place.recorded, normal, summary })
    }

    #[inline]
    fn mixture<'m>(
        &self,
        si: &SurfaceInteraction,
        wo: Vec3,
        bsdf: &'m Bsdf<'m>,
        guided: Option<&Guided<'m>>,
    ) -> Mixture<'m>
    where
        'a: 'm,
    {
        let known = self.integrator.guide.zip(guided).filter(|_| Mixture::guides(bsdf, self.product()));
        let Some((guide, summary, normal)) = known.and_then(|(u, g)| Some((u, g.summary?, g.normal))) else {
            return Mixture::new(bsdf, None, 1.0);
        };
        let mut distribution = guide.field.distribution(summary, normal);
        if self.product() && bsdf.lambertian().is_none() {
            distribution = distribution.times(|w| {
                let wi = si.frame.to_local(w);
                luminance(bsdf.eval(wo, wi)) / wi.z.abs().max(MIN_COSINE)
            });
        }
        Mixture::new(bsdf, Some(distribution), summary.bsdf_fraction)
    }

    /// Whether directions are drawn from the product of guide and BSDF.
    #[inline]
    fn product(&self) -> bool {
        self.integrator.guide.is_some_and(|guide| guide.settings.sampling == GuideSampling::Product)
    }

    /// What the table expects of going on.
    #[inline]
    fn expectation(&self, summary: Option<&Summary>, bsdf: &Bsdf) -> Option<Expectation> {
        let guide = self.integrator.guide.filter(|_| self.learn)?.settings;
        let (summary, reflectance) = (summary?, bsdf.lambertian()?);
        let known = (summary.irradiance, summary.peak, summary.visits);
        Expectation::new(guide.rule_in_use(), guide.blend_visits, known, reflectance)
    }

    /// Expected number of paths that go on. The throughput's roulette goes by the share of light that scattering leaves
    /// on the way (`analog`), not by the throughput: a guide that finds the light lowers the throughput of just the
    /// paths that matter.
    #[inline]
    fn paths(
        &self,
        summary: Option<&Summary>,
        guides: bool,
        reflected: f32,
        analog: f32,
        slot: u32,
        depth: u32,
    ) -> f32 {
        let settings = self.integrator.settings;
        if settings.roulette == Roulette::None {
            return 1.0;
        }
        let efficiency = self.integrator.guide.and_then(|guide| guide.efficiency);
        if let (Roulette::Guided, Some(efficiency)) = (settings.roulette, efficiency) {
            let full = self.batch.next.rays.len() >= MAX_WAVE * self.task.paths();
            let max_split = if full { 1.0 } else { settings.max_split };
            // of the return by a sharp lobe, a state's moments say nothing
            let Some(summary) = summary.filter(|_| guides) else {
                return if depth >= settings.rr_depth { MAX_SURVIVAL } else { 1.0 };
            };
            return efficiency.paths(summary, reflected, self.pixel(slot), max_split);
        }
        if depth >= settings.rr_depth { analog.min(MAX_SURVIVAL) } else { 1.0 }
    }

    /// The pixel of a path, row by row over the film.
    #[inline]
    fn pixel(&self, slot: u32) -> usize {
        let tile = self.task.tile;
        let pixel = slot % tile.pixels() as u32;
        let (x, y) = (tile.x + pixel % tile.width, tile.y + pixel / tile.width);
        (y * self.integrator.scene.camera.width + x) as usize
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
        let vertex = if self.learn { self.batch.vertices[depth as usize - 1].len() as u32 - 1 } else { 0 };
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
                b.vertices[depth - 1][b.next_events.vertex[k] as usize].local += b.next_events.local[k];
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

    /// Keeps a vertex for learning, once it is known what it adds and expects.
    #[inline]
    fn log(&mut self, i: usize, depth: u32, local: Rgb, expected: Option<Expectation>) {
        if self.learn {
            let arrival = self.batch.wave.paths.arrival[i];
            self.batch.vertices[depth as usize - 1].push(Vertex { arrival, local, expected });
        }
    }

    fn record(&mut self) -> Option<Recorder> {
        if !self.learn {
            return None;
        }
        let mut recorder = Recorder::new();
        let b = &mut *self.batch;
        backup::record(&b.vertices, &mut b.followed, &mut recorder);
        b.points.drain(..).for_each(|(p, n)| recorder.push_point(p, n));
        b.vertices.iter_mut().for_each(Vec::clear);
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

/// What is to be learnt of a direction.
#[inline]
fn edge(guided: Option<&Guided>, next: &DirectionSample, albedo: f32) -> Option<Edge> {
    let (guided, pdf) = (guided?, next.pdf?);
    Some(Edge {
        key: guided.key,
        wi: PackedDirection::new(next.wi),
        normal: PackedDirection::new(guided.normal),
        pdf: pdf.mixture,
        bsdf_pdf: pdf.bsdf,
        guide_pdf: pdf.guide,
        scattered: luminance(next.weight) * pdf.mixture / albedo,
    })
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
