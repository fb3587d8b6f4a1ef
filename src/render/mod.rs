//! The driver: iterations × passes × tasks, the clock, and what the guide learns between rounds.

mod blocks;
mod efficiency;
mod noise;
mod schedule;
mod worth;

pub use worth::{Trial, Verdict};

use crate::film::accumulate::{Estimate, FEATURE_SAMPLES, Film};
use crate::guiding::Guide;
use crate::guiding::file::Trained;
use crate::integrator::path::GuideUse;
use crate::integrator::probe::Watch;
use crate::integrator::{Batch, BatchResult, Counters, Efficiency, PathIntegrator, Task};
use crate::math::luminance;
use crate::scene::Scene;
use crate::scene::description::{
    Combine, GuidingMethod, GuidingSettings, IntegratorSettings, Order, RenderSettings, Roulette, Updates,
};
use noise::Noise;
use rayon::prelude::*;
use schedule::{Tiling, iteration_samples, round_paths, rounds};
use std::time::{Duration, Instant};
use worth::Worth;

/// What to render with.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub integrator: IntegratorSettings,
    pub guiding: GuidingSettings,
    pub render: RenderSettings,
}

/// What one iteration did.
#[derive(Clone, Debug)]
pub struct IterationReport {
    /// Samples per pixel.
    pub samples: u32,
    pub seconds: f64,
    /// Seconds of it between rounds, in which the guide learnt and froze.
    pub learn_seconds: f64,
    /// Seconds of it between rounds, in which the picture took the samples of tiles.
    pub film_seconds: f64,
    pub counters: Counters,
    /// States that could be drawn from during the iteration.
    pub usable_states: usize,
}

/// How far a render is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples per pixel; on average, where blocks are rendered one after the other.
    pub samples: u32,
    /// Share of the budget that is used, in [0, 1].
    pub share: f64,
    pub seconds: f64,
    pub paths: u64,
}

/// Watches a render; returns whether it should go on.
pub type Observer<'a> = &'a mut dyn FnMut(&Progress) -> bool;

/// A finished render.
pub struct Rendering {
    pub estimate: Estimate,
    pub iterations: Vec<IterationReport>,
    /// All samples per pixel that were traced, those of discarded iterations too.
    pub samples: u32,
    /// From the guide's making to the last sample, learning included.
    pub seconds: f64,
    /// Seconds that it took to make one picture of the samples.
    pub film_seconds: f64,
    pub guide: Option<Guide>,
    /// Whether the guide paid; `None` where that was not asked, or too little was rendered to tell.
    pub verdict: Option<Verdict>,
    /// Camera paths of the last iteration from which the guide learnt.
    pub learnt_paths: u64,
}

/// The guide before and after a render.
#[derive(Default)]
pub struct Keeping {
    /// What to begin with; `None` begins with nothing.
    pub from: Option<Trained>,
    /// The guide will be used again: the last iteration too is learnt from.
    pub keep: bool,
}

/// Renders until the budget of samples or of time is used, or the observer has seen enough.
pub fn render(scene: &Scene, settings: &Settings, observer: Observer) -> Rendering {
    render_keeping(scene, settings, Keeping::default(), observer)
}

/// As [`render`], with a guide that was learnt before, or will be used after.
pub fn render_keeping(scene: &Scene, settings: &Settings, keeping: Keeping, observer: Observer) -> Rendering {
    render_watched(scene, settings, keeping, &(), observer)
}

/// As [`render_keeping`], every batch of it watched.
pub fn render_watched<W: Watch>(
    scene: &Scene,
    settings: &Settings,
    keeping: Keeping,
    watch: &W,
    observer: Observer,
) -> Rendering {
    let mut driver = Driver::new(scene, settings, keeping, watch);
    match settings.render.order {
        Order::Progressive => driver.run(observer),
        Order::Blocks => driver.run_blocks(observer),
    }
    let seconds = driver.start.elapsed().as_secs_f64();
    Rendering {
        estimate: driver.film.develop(),
        iterations: driver.iterations,
        samples: driver.samples,
        seconds,
        film_seconds: driver.start.elapsed().as_secs_f64() - seconds,
        guide: driver.guide,
        verdict: driver.worth.and_then(|worth| worth.verdict()),
        learnt_paths: driver.learnt_paths,
    }
}

/// Without a guide all samples are alike, whatever they seem to be.
fn combine(settings: &Settings) -> Combine {
    let (combine, method) = (settings.render.combine, settings.guiding.method);
    if combine == Combine::InverseVariance && method == GuidingMethod::None { Combine::All } else { combine }
}

/// Samples per pixel that an iteration plans at most.
const LONGEST: u32 = 1 << 30;

struct Driver<'a, W> {
    scene: &'a Scene,
    settings: &'a Settings,
    watch: &'a W,
    tiling: Tiling,
    film: Film,
    guide: Option<Guide>,
    keep: bool,
    learnt_paths: u64,
    seed: u64,
    efficiency: Option<Efficiency>,
    /// Where it is to be found out whether the guide pays.
    worth: Option<Worth>,
    iterations: Vec<IterationReport>,
    samples: u32,
    paths: u64,
    start: Instant,
}

impl<'a, W: Watch> Driver<'a, W> {
    fn new(scene: &'a Scene, settings: &'a Settings, Keeping { from, keep }: Keeping, watch: &'a W) -> Driver<'a, W> {
        let start = Instant::now();
        // a guide that is given or to be kept is wanted, whatever it pays
        let judged = settings.guiding.method == GuidingMethod::Auto && from.is_none() && !keep;
        let (learnt_paths, salt) = from.as_ref().map_or((0, 0), |trained| (trained.paths, trained.salt));
        let from = from.map(|trained| trained.guide);
        let (width, height) = (scene.camera.width, scene.camera.height);
        Driver {
            scene,
            settings,
            watch,
            tiling: Tiling::new(width, height),
            film: Film::new(width, height, combine(settings)),
            guide: from.or_else(|| Guide::new(&settings.guiding, scene.bounds(), scene.facets())),
            keep,
            learnt_paths,
            seed: settings.render.seed ^ salt,
            efficiency: None,
            worth: judged.then(|| Worth::new(settings.render.time.is_some())),
            iterations: Vec::new(),
            samples: 0,
            paths: 0,
            start,
        }
    }

    fn run(&mut self, observer: Observer) {
        // With a guide from before, iterations go on where those ended: after one of its length, the old is half forgotten.
        let pixels = self.scene.camera.width as u64 * self.scene.camera.height as u64;
        let mut planned = (self.learnt_paths / pixels).saturating_mul(2).clamp(1, LONGEST as u64) as u32;
        loop {
            let left = self.samples_left();
            if left == 0 {
                return;
            }
            let samples = iteration_samples(planned, left);
            if !self.iterate(samples, samples == left, observer) {
                return;
            }
            planned = (2 * planned).min(LONGEST);
        }
    }

    /// Samples per pixel that are left of the budget; under a time limit an estimate from the speed so far.
    fn samples_left(&self) -> u32 {
        let left = self.settings.render.spp - self.samples;
        match self.settings.render.time {
            Some(_) if self.samples == 0 => left,
            Some(limit) => {
                let elapsed = self.start.elapsed().as_secs_f64();
                let per_sample = elapsed / self.samples as f64;
                left.min(((limit - elapsed) / per_sample).round().max(0.0) as u32)
            }
            None => left,
        }
    }

    fn begin_iteration(&self) -> IterationReport {
        IterationReport {
            samples: 0,
            seconds: 0.0,
            learn_seconds: 0.0,
            film_seconds: 0.0,
            counters: Counters::default(),
            usable_states: self.guide.as_ref().map_or(0, |g| g.field().len()),
        }
    }

    /// One iteration, with one frozen guide unless updates are on-line; `false` where rendering is over.
    fn iterate(&mut self, samples: u32, last: bool, observer: Observer) -> bool {
        let start = Instant::now();
        // What nothing will be drawn from need not be learnt.
        let learn = self.guided() && (!last || self.keep || self.online());
        let mut report = self.begin_iteration();
        // Under a time limit the last iteration ends with the time, not with an estimated count.
        let open_ended = self.settings.render.time.is_some() && last;
        let target = if open_ended { self.settings.render.spp - self.samples } else { samples };
        let mut go_on = true;
        while report.samples < target && go_on {
            let pass = self.tiling.samples.min(target - report.samples);
            self.pass(pass, learn, &mut report);
            report.samples += pass;
            go_on = observer(&self.progress()) && !self.time_is_up(pass);
        }
        if let Some(guide) = self.guide.as_mut().filter(|_| learn && (go_on || self.keep)) {
            // An iteration that was cut short says too little of where states are to be refined or dropped.
            let whole = report.samples >= samples / 2;
            let end = || if whole { guide.end_iteration(report.samples) } else { guide.refresh() };
            report.learn_seconds += timed(end).as_secs_f64();
            self.learnt_paths = self.learnt_paths.max(report.counters.paths);
        }
        if go_on && self.guided() {
            self.weigh(&report.counters);
        }
        self.film.end_iteration();
        report.seconds = start.elapsed().as_secs_f64();
        self.iterations.push(report);
        go_on
    }

    /// Whether a guide is there, and in use.
    fn guided(&self) -> bool {
        self.guide.is_some() && self.worth.as_ref().is_none_or(Worth::pays)
    }

    /// What the noise of an iteration says of roulette, and of the guide.
    fn weigh(&mut self, counters: &Counters) {
        if let Some(worth) = self.worth.as_mut().filter(|_| self.samples == 1) {
            worth.begin(self.film.develop().mean.iter().map(|&c| luminance(c)).collect(), counters);
        }
        let Some(noise) = Noise::of(&self.film) else { return };
        if self.settings.integrator.roulette == Roulette::Guided {
            self.efficiency = efficiency::efficiency(&noise, counters).or(self.efficiency.take());
        }
        if let Some(worth) = &mut self.worth {
            worth.judge(&noise, counters);
        }
    }

    /// Adds `samples` to every pixel.
    fn pass(&mut self, samples: u32, learn: bool, report: &mut IterationReport) {
        for round in rounds(&self.tiling.pass(self.samples, samples), round_paths(self.online())) {
            self.round(&round, learn, report);
        }
        self.film.add_samples(samples, self.samples < FEATURE_SAMPLES);
        self.samples += samples;
    }

    /// Traces the tasks of a round; then the guide learns from it.
    fn round(&mut self, round: &[Task], learn: bool, report: &mut IterationReport) {
        let enough = self.guide.as_ref().is_some_and(|guide| guide.has_enough(report.counters.transitions));
        let learn = learn && (self.online() || !enough);
        let results = self.trace(round, learn);
        report.film_seconds += timed(|| {
            for (task, result) in round.iter().zip(&results) {
                self.film.add(&task.tile, &result.samples);
                report.counters.add(&result.counters);
                self.paths += result.counters.paths;
            }
        })
        .as_secs_f64();
        let online = self.online();
        if let Some(guide) = self.guide.as_mut().filter(|_| learn) {
            let recorders: Vec<_> = results.iter().filter_map(|result| result.recorder.as_ref()).collect();
            report.learn_seconds += timed(|| {
                guide.learn(&recorders);
                if online {
                    guide.refresh();
                }
            })
            .as_secs_f64();
        }
    }

    /// Whether the guide's snapshot follows what it learns, round by round.
    fn online(&self) -> bool {
        self.guide.is_some() && self.settings.guiding.updates == Updates::Online
    }

    /// All tasks of a round in parallel; results in the order of the tasks.
    fn trace(&self, round: &[Task], learn: bool) -> Vec<BatchResult> {
        let integrator = PathIntegrator {
            scene: self.scene,
            settings: &self.settings.integrator,
            guide: self.guide.as_ref().filter(|_| self.guided()).map(|guide| GuideUse {
                field: guide.field(),
                settings: &self.settings.guiding,
                learn,
                efficiency: self.efficiency.as_ref(),
            }),
            seed: self.seed,
            features: false,
        };
        let render = |batch: &mut Batch, task: &Task| {
            let mut probe = self.watch.begin(task);
            let integrator = PathIntegrator { features: task.first_sample < FEATURE_SAMPLES, ..integrator };
            let result = integrator.render_probed(task, batch, &mut probe);
            self.watch.end(task, probe);
            result
        };
        round.par_iter().map_init(Batch::new, render).collect()
    }

    fn pixels(&self) -> u64 {
        self.scene.camera.width as u64 * self.scene.camera.height as u64
    }

    fn progress(&self) -> Progress {
        let seconds = self.start.elapsed().as_secs_f64();
        let by_samples = self.paths as f64 / (self.pixels() as f64 * self.settings.render.spp as f64);
        let by_time = self.settings.render.time.map_or(0.0, |limit| seconds / limit);
        Progress { samples: self.samples, share: by_samples.max(by_time).min(1.0), seconds, paths: self.paths }
    }

    /// Whether the time is used, or another pass of `samples` would go beyond it by more than half of itself.
    fn time_is_up(&self, samples: u32) -> bool {
        let Some(limit) = self.settings.render.time else { return false };
        let elapsed = self.start.elapsed().as_secs_f64();
        elapsed + 0.5 * elapsed * samples as f64 / self.samples as f64 >= limit
    }
}

fn timed(f: impl FnOnce()) -> Duration {
    let start = Instant::now();
    f();
    start.elapsed()
}
