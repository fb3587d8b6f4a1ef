//! The state of a render between two iterations.

use super::adaptive::{Adaptive, Left};
use super::foresight;
use super::guide_file::LoadedGuide;
use super::noise::Noise;
use super::policy::{Budget, GuidePolicy, History, Iteration, Mode, Plan, Policy};
use super::schedule::{LONGEST_ITERATION, Tiling};
use super::{GuideIo, IterationReport, Settings, roulette};
use crate::film::accumulate::Film;
use crate::film::tile::Tile;
use crate::film::{Combine, RadianceLayer};
use crate::guiding::Guide;
use crate::guiding::settings::{GuidingSettings, Updates};
use crate::integrator::{Counters, Roulette, RouletteNormalisation, SamplerKind};
use crate::io::clock::WallClock;
use crate::scene::{Camera, Scene};
use serde::{Deserialize, Serialize};

/// Samples per pixel after which the error of the picture is estimated first: fewer say little of it.
pub(super) const FIRST_ESTIMATE: u32 = 16;

/// All that a render takes from one iteration to the next: with the scene, the settings and this it goes on, in another
/// process too, and ends with the same picture. In the middle of an iteration the [`Record`] belongs to it. It holds no clocks,
/// threads or buffers.
#[derive(Serialize, Deserialize)]
pub(super) struct RenderState {
    pub film: Film,
    /// With the snapshot that the next iteration draws from. `None` where none is ever used.
    #[serde(skip)]
    pub guide: Option<Guide>,
    pub policy: Policy,
    /// The next iteration, or the one under way.
    pub plan: Plan,
    /// The normalisation of guided roulette; `None` until picture and guide say enough.
    pub roulette: Option<RouletteNormalisation>,
    /// Σ x and Σ x² of the luminance of light that bounced, pixel by pixel, over pilot samples; empty after them.
    pub bounced: Vec<[f32; 2]>,
    /// Of all random numbers; with what the guide was given, as nothing drawn from it may know of it.
    pub seed: u64,
    /// Sample with which the sequence begins that is under way: samples that are drawn alike are spread evenly together, and
    /// independently of all others.
    pub sequence: u32,
    /// Light that is kept apart.
    pub layers: Vec<RadianceLayer>,
    /// Columns and pixels of the picture.
    pub width: u32,
    pub pixels: u64,
    /// Camera paths so far.
    pub paths: u64,
    /// Samples per pixel that the guide has learnt from in this render, and of the small picture before it.
    pub learnt_samples: u32,
    /// Camera paths of the last iteration from which it has learnt, in this render or the one before.
    pub learnt_paths: u64,
    /// What gives tiles different numbers of samples, where that is asked for.
    pub adaptive: Option<Adaptive>,
    /// Samples per pixel after which the error of the picture is estimated next, and the newest estimate.
    pub next_estimate: u32,
    pub relative_error: Option<f64>,
    /// Iterations of the small picture by which the guide was trained, and those of the render.
    pub training: Vec<IterationReport>,
    pub iterations: Vec<IterationReport>,
}

/// An iteration under way. With it, a state goes on from the middle of an iteration too.
#[derive(Serialize, Deserialize)]
pub(super) struct Record {
    pub report: IterationReport,
    /// What its passes did, one by one, where that is asked for.
    passes: Option<Vec<Counters>>,
    pub order: IterationOrder,
    /// Of the iteration.
    pub clock: WallClock,
    /// Passes that are done.
    pub passes_done: u32,
    /// The pass that was cut, where rendering ended in the middle of one.
    pub cut: Option<CutPass>,
    /// The picture is as good as was asked for.
    pub is_good: bool,
    /// No state of this iteration can go on to the same bits any more: a round was cut after which the guide would have changed.
    #[serde(skip)]
    pub is_broken: bool,
}

/// What was decided of an iteration when it began.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct IterationOrder {
    /// Samples per pixel.
    pub samples: u32,
    /// They are all that is left of the budget.
    pub last: bool,
    /// It is learnt from.
    pub learn: bool,
}

/// The first tasks of a pass are done, and the others are not.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct CutPass {
    /// Number of its first sample, and how many of each pixel it takes.
    pub first: u32,
    pub samples: u32,
    /// How many tasks are done.
    pub done: usize,
    /// Whether the round is learnt from in which it was cut.
    pub learns: bool,
}

impl Record {
    /// Of an iteration that begins now.
    fn new(order: IterationOrder, report: IterationReport, passes: Option<Vec<Counters>>) -> Record {
        let clock = WallClock::start();
        Record { report, passes, order, clock, passes_done: 0, cut: None, is_good: false, is_broken: false }
    }

    /// What another budget than the one that it was made for leaves of its order: `before` is the number of samples before
    /// it, `spp` of all that there may be.
    pub fn reorder(&mut self, before: u32, spp: u32) {
        self.is_good = false;
        let left = spp.saturating_sub(before);
        self.order.samples = self.order.samples.min(left).max(self.report.samples);
        self.order.last = self.order.samples >= left;
    }

    pub fn begin_pass(&mut self) {
        self.passes.iter_mut().for_each(|passes| passes.push(Counters::default()));
    }

    /// Adds what a task did.
    pub fn add(&mut self, counters: &Counters) {
        self.report.counters.add(counters);
        self.passes.iter_mut().filter_map(|passes| passes.last_mut()).for_each(|pass| pass.add(counters));
    }

    /// Samples per pixel so far; on average, rounded down, where a pass was cut.
    pub fn count_samples(&mut self, pixels: u64) {
        self.report.samples = (self.report.counters.paths / pixels) as u32;
    }
}

/// A guide that has learnt nothing, with cells that suit what the camera looks at.
pub(super) fn new_guide(scene: &Scene, settings: &GuidingSettings) -> Option<Guide> {
    let mut guide = Guide::new(settings, scene.bounds(), scene.facets())?;
    if guide.adapts_to_vertices() {
        guide.expect_vertices(&foresight::vertices(scene));
    }
    Some(guide)
}

impl RenderState {
    /// Before the first iteration.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings, GuideIo { from, keep }: GuideIo) -> RenderState {
        let (width, height) = (camera.width, camera.height);
        let pixels = width as u64 * height as u64;
        let was_given = from.is_some();
        let roulette = from.as_ref().and_then(|from| seen(scene, camera, settings, from));
        let wanted = was_given || keep;
        let (guide, learnt_paths, salt) = from.map_or((None, 0, 0), |from| (Some(from.guide), from.paths, from.salt));
        let learnt_samples = guide.as_ref().map_or(0, |guide| (guide.learnt_paths() / pixels) as u32);
        let guide = guide.or_else(|| new_guide(scene, &settings.guiding));
        // With a guide from before, iterations go on where those ended: after one of its length, the old is half forgotten.
        let first = (learnt_paths / pixels).saturating_mul(2).clamp(1, LONGEST_ITERATION as u64) as u32;
        let policy = Policy::asked_for(settings, wanted, was_given.then_some(first), pixels);
        let layers = settings.render.radiance_layers(scene.light_groups().names().len());
        RenderState {
            film: Film::new(width, height, combine(settings, &policy), &layers)
                .of_even_samples(settings.render.sampler != SamplerKind::Independent)
                .that_tells_its_error(settings.render.noise.is_some()),
            layers,
            guide,
            plan: policy.next_iteration(&History { samples: 0, planned: None }),
            policy,
            roulette,
            bounced: Vec::new(),
            seed: settings.render.seed ^ salt,
            sequence: 0,
            width,
            pixels,
            paths: 0,
            learnt_samples,
            learnt_paths,
            adaptive: settings.render.adaptive.then(|| Adaptive::new(&Tiling::new(width, height))),
            next_estimate: FIRST_ESTIMATE,
            relative_error: None,
            training: Vec::new(),
            iterations: Vec::new(),
        }
    }

    /// Samples per pixel so far; on average, rounded down, where a pass was cut.
    pub fn samples(&self) -> u32 {
        (self.paths / self.pixels) as u32
    }

    /// Whether it can be one of a render of this scene.
    pub fn fits(&self, scene: &Scene, settings: &Settings) -> bool {
        let (width, height) = (scene.camera.width, scene.camera.height);
        let pixels = width as usize * height as usize;
        let layers = settings.render.radiance_layers(scene.light_groups().names().len());
        let whole = |n: usize| n == pixels;
        self.film.fits(width, height, &layers)
            && self.adaptive.is_some() == settings.render.adaptive
            && self.adaptive.as_ref().is_none_or(|adaptive| adaptive.fits(Tiling::new(width, height).tiles().len()))
            && (self.width, self.pixels, &self.layers) == (width, pixels as u64, &layers)
            && self.roulette.as_ref().is_none_or(|roulette| whole(roulette.inverse_luminance.len()))
            && (self.bounced.is_empty() || whole(self.bounced.len()))
    }

    /// Whether the iteration draws from the guide, and learns.
    pub fn is_guided(&self) -> bool {
        self.guide.is_some() && self.plan.mode == Mode::Guided
    }

    /// Whether the guide's snapshot follows what it learns, round by round.
    pub fn is_online(&self, settings: &Settings) -> bool {
        self.guide.is_some() && settings.guiding.updates == Updates::Online
    }

    /// Estimates the error of the picture; returns whether it is `noise` at most. It is time to again after an eighth more
    /// samples: by their number, so that no clock decides how many there are.
    pub fn is_as_good(&mut self, noise: f64) -> bool {
        self.next_estimate = self.samples().saturating_add((self.samples() / 8).max(1));
        self.relative_error = self.film.relative_error();
        self.relative_error.is_some_and(|error| error <= noise)
    }

    /// Whether the error is estimated after the newest pass, by which the render may end. Tiles that get different numbers of
    /// samples end by their own.
    pub fn can_end_by_error(&self) -> bool {
        self.samples() >= self.next_estimate && !self.is_allotted()
    }

    /// The record of the iteration that begins now. If `remembers`, the state can be kept at any time.
    pub fn begin_iteration(&mut self, order: IterationOrder, remembers: bool, online: bool) -> Record {
        let pilot = self.plan.mode == Mode::Pilot;
        if !pilot {
            self.bounced = Vec::new();
        } else if self.bounced.is_empty() {
            self.bounced = vec![[0.0; 2]; self.pixels as usize];
        }
        let usable_states = self.guide.as_ref().map_or(0, |g| g.field().len());
        if let Some(guide) = &mut self.guide {
            guide.begin_iteration(self.pixels * u64::from(self.plan.samples));
            if remembers && order.learn {
                guide.remember(online);
            }
        }
        let report = IterationReport { usable_states, ..IterationReport::default() };
        Record::new(order, report, pilot.then(Vec::new))
    }

    /// Adds what light that bounced has brought to a tile.
    pub fn add_bounced(&mut self, tile: &Tile, sums: &[[f32; 2]]) {
        let width = self.width as usize;
        for (k, [sum, squares]) in sums.iter().enumerate() {
            let (x, y) = (tile.x as usize + k % tile.width as usize, tile.y as usize + k / tile.width as usize);
            let to = &mut self.bounced[y * width + x];
            (to[0], to[1]) = (to[0] + sum, to[1] + squares);
        }
    }

    /// The guide takes the end of an iteration that it has learnt from; a `whole` one may change what its states are.
    pub fn end_learning(&mut self, whole: bool, report: &mut IterationReport) {
        let (Some(guide), paths) = (&mut self.guide, report.counters.paths) else { return };
        report.add_learning(|| if whole { guide.end_iteration(paths) } else { guide.refresh() });
        self.learnt_paths = self.learnt_paths.max(report.counters.paths);
    }

    /// What the noise of a finished iteration says of roulette and of the guide.
    pub fn weigh(&mut self, Record { report, passes, .. }: &Record, settings: &Settings) {
        self.learnt_samples += if self.is_guided() { report.samples } else { 0 };
        let noise = if self.plan.mode == Mode::Pilot { Noise::of_samples } else { Noise::of }(&self.film);
        if settings.integrator.roulette == Roulette::Guided
            && let Some(noise) = &noise
        {
            let new = roulette::normalisation(noise, self.learnt_samples, &report.counters);
            self.roulette = new.or(self.roulette.take());
        }
        let (threads, render) = (rayon::current_num_threads() as f64, &settings.render);
        self.policy.observe(&Iteration {
            mode: self.plan.mode,
            samples: report.samples,
            all_samples: (self.paths / self.pixels) as u32,
            counters: &report.counters,
            passes: passes.as_deref().unwrap_or_default(),
            learning: report.learn_cpu,
            training: &self.training,
            film: &self.film,
            noise: noise.as_ref(),
            bounced: &self.bounced,
            budget: Budget { samples: render.spp, cpu_seconds: render.time.map(|wall| wall * threads) },
        });
    }

    /// Plans the next iteration, and ends the one before in the film, unless the next continues it.
    pub fn plan_next(&mut self) {
        let tiling = Tiling::new(self.width, (self.pixels / u64::from(self.width)) as u32);
        if let Some(adaptive) = &mut self.adaptive {
            adaptive.survey(&self.film, &tiling);
            adaptive.end_iteration(&self.film, &tiling);
        }
        let history = History { samples: self.samples(), planned: Some(self.plan.samples) };
        let before = std::mem::replace(&mut self.plan, self.policy.next_iteration(&history));
        let same_sequence = self.plan.continues || self.plan.is_drawn_as(&before);
        if !same_sequence {
            self.sequence = self.samples();
        }
        if !self.plan.continues || self.film.is_allotted() {
            self.film.end_iteration();
        }
        self.adaptive.iter_mut().for_each(|adaptive| adaptive.continue_sequence(same_sequence));
    }

    /// What comes of the order of the next iteration, where tiles get different numbers of samples in it.
    pub fn allot(&mut self, order: IterationOrder, left: Left, tiling: &Tiling) -> IterationOrder {
        let samples = self.samples();
        let begins = |adaptive: &mut Adaptive| adaptive.begins(samples, &left);
        if self.plan.mode == Mode::Pilot || !self.adaptive.as_mut().is_some_and(begins) {
            return order;
        }
        let Some(adaptive) = &mut self.adaptive else { return order };
        let order = adaptive.plan(&mut self.film, tiling, (order, left, samples));
        self.sequence = adaptive.sequence();
        order
    }

    /// Whether tiles get different numbers of samples.
    pub fn is_allotted(&self) -> bool {
        self.film.is_allotted()
    }

    /// The newest estimate of the picture's relative error.
    pub fn error_so_far(&self) -> Option<f64> {
        let height = (self.pixels / u64::from(self.width)) as u32;
        let of_tiles = self.adaptive.as_ref().filter(|_| self.is_allotted());
        match of_tiles {
            Some(adaptive) => adaptive.relative_error(&Tiling::new(self.width, height)),
            None => self.film.relative_error(),
        }
    }
}

/// How bright the picture is, and how noisy, where a guide has been learnt with this camera by machines together.
fn seen(scene: &Scene, camera: &Camera, settings: &Settings, from: &LoadedGuide) -> Option<RouletteNormalisation> {
    let view = from.view.as_ref().filter(|_| settings.integrator.roulette == Roulette::Guided)?;
    let tiles = Tiling::of_single_samples(camera.width, camera.height).tiles();
    view.of(&scene.hash_text(), &tiles, camera.width)
}

/// Unguided samples are identically distributed, so they are weighted equally, whatever their estimated variances.
fn combine(settings: &Settings, policy: &Policy) -> Combine {
    let combine = settings.render.combine;
    if combine == Combine::InverseVariance && policy.never_guides() { Combine::All } else { combine }
}

#[cfg(test)]
#[path = "state_tests.rs"]
mod tests;
