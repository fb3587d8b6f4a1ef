//! Rendering: a scene and settings in, a picture, its guide and an account of each iteration out.

mod adaptive;
pub(crate) mod checkpoint;
mod driver;
mod foresight;
pub mod guide_file;
pub(crate) mod lesson;
mod limits;
pub(crate) mod merge;
mod noise;
mod onlooker;
pub(crate) mod part;
mod policy;
mod roulette;
mod schedule;
mod sealed;
mod settings;
mod state;
mod tracer;
mod training;
mod view;
mod workers;

pub use checkpoint::Checkpoint;
pub(crate) use onlooker::Figures;
pub use onlooker::{Moment, Occasion, Onlooker};
pub(crate) use policy::{Mode, Reason, Trial, Verdict};
pub use settings::{Order, RenderSettings};

use crate::film::accumulate::Estimate;
use crate::guiding::Guide;
use crate::guiding::settings::GuidingSettings;
pub use crate::integrator::Stop;
use crate::integrator::probe::Watch;
use crate::integrator::{Counters, IntegratorSettings};
use crate::io::clock::{CpuClock, CpuTime, WallClock};
use crate::scene::Scene;
use driver::{Driver, Job};
use guide_file::LoadedGuide;
use limits::Limits;
use state::RenderState;
use std::time::Duration;
use workers::WorkerResult;

/// What to render with.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub integrator: IntegratorSettings,
    pub guiding: GuidingSettings,
    pub render: RenderSettings,
}

/// What one iteration did.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct IterationReport {
    /// Samples per pixel; on average, rounded down, where a pass was cut.
    pub samples: u32,
    pub wall_seconds: f64,
    /// Wall time of it in which the guide learnt and froze; of what some threads did beside others, on average over all.
    pub learn_wall_seconds: f64,
    /// Processor time of the same, of all threads together.
    pub learn_cpu: CpuTime,
    /// Wall time in which the picture took the samples of tiles, on average over all threads.
    pub film_wall_seconds: f64,
    pub counters: Counters,
    /// States that could be drawn from during the iteration.
    pub usable_states: usize,
}

impl IterationReport {
    /// Has the guide learn, which all threads may take part in.
    fn add_learning<R>(&mut self, learn: impl FnOnce() -> R) -> R {
        let (wall, cpu) = (WallClock::start(), CpuClock::process());
        let result = learn();
        self.learn_wall_seconds += wall.elapsed().as_secs_f64();
        self.learn_cpu += cpu.elapsed();
        result
    }

    /// Adds what threads did beside tracing.
    fn add_shares(&mut self, shares: &[WorkerResult]) {
        let average = |of: fn(&WorkerResult) -> Duration| {
            shares.iter().map(of).sum::<Duration>().as_secs_f64() / shares.len() as f64
        };
        self.film_wall_seconds += average(|share| share.film);
        self.learn_wall_seconds += average(|share| share.learning.0);
        self.learn_cpu += shares.iter().map(|share| share.learning.1).sum();
    }
}

/// How far a render is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples per pixel; on average, where blocks are rendered one after the other.
    pub samples: u32,
    /// Share of the budget that is used, in [0, 1].
    pub share: f64,
    pub wall_seconds: f64,
    pub paths: u64,
    /// The guide is being trained on a small picture, to which the figures do not refer.
    pub training: bool,
}

/// Watches a render; returns whether it should go on.
pub type Observer<'a> = &'a mut dyn FnMut(&Progress) -> bool;

/// A finished render.
pub struct Rendering {
    pub estimate: Estimate,
    pub iterations: Vec<IterationReport>,
    /// Those of the small picture on which the guide was trained before.
    pub training: Vec<IterationReport>,
    /// All samples per pixel that were traced, those of discarded iterations too; on average, rounded down, where a pass was
    /// cut.
    pub samples: u32,
    /// Wall time from the guide's making to the last sample, learning included.
    pub wall_seconds: f64,
    /// Processor time of the process over the same.
    pub cpu: CpuTime,
    /// Wall time that it took to make one picture of the samples.
    pub film_wall_seconds: f64,
    pub guide: Option<Guide>,
    /// Whether the guide paid; `None` where that was not asked, or too little was rendered to tell.
    pub verdict: Option<Verdict>,
    /// Camera paths of the last iteration from which the guide learnt.
    pub learnt_paths: u64,
    /// The newest estimate of the picture's relative error, where it was to end by that.
    pub relative_error: Option<f64>,
    /// Pixels along the tiles that got different numbers of samples, where they did.
    pub(crate) adaptive_tiles: Option<u32>,
}

impl Rendering {
    /// All that was done, training too.
    pub(crate) fn all_iterations(&self) -> impl Iterator<Item = &IterationReport> {
        self.training.iter().chain(&self.iterations)
    }

    /// What all of it did.
    pub(crate) fn total(&self) -> Counters {
        self.all_iterations().fold(Counters::default(), |mut sum, iteration| {
            sum.add(&iteration.counters);
            sum
        })
    }
}

/// The guide before and after a render.
#[derive(Default)]
pub struct GuideIo {
    /// What to begin with; `None` begins with nothing.
    pub from: Option<LoadedGuide>,
    /// The guide will be used again: the last iteration too is learnt from.
    pub keep: bool,
}

/// Renders until the budget of samples or of time is used, or the observer has seen enough.
pub fn render(scene: &Scene, settings: &Settings, observer: Observer) -> Rendering {
    render_keeping(scene, settings, GuideIo::default(), observer)
}

/// As [`render`], with a guide that was learnt before, or will be used after.
pub fn render_keeping(scene: &Scene, settings: &Settings, keeping: GuideIo, observer: Observer) -> Rendering {
    render_until(scene, settings, keeping, &Stop::new(), observer)
}

/// As [`render_keeping`], or until `stop` asks for its end, which may cut a pass: the picture then has more samples in some
/// pixels than in others.
pub fn render_until(
    scene: &Scene,
    settings: &Settings,
    keeping: GuideIo,
    stop: &Stop,
    observer: Observer,
) -> Rendering {
    render_watched(scene, settings, keeping, &(), stop, observer)
}

/// As [`render_until`], every batch of it watched.
pub fn render_watched<W: Watch>(
    scene: &Scene,
    settings: &Settings,
    keeping: GuideIo,
    watch: &W,
    stop: &Stop,
    observer: Observer,
) -> Rendering {
    render_shown(scene, settings, keeping, watch, stop, (observer, &mut ()))
}

/// As [`render_watched`], with somebody who looks at it between passes.
pub fn render_shown<W: Watch>(
    scene: &Scene,
    settings: &Settings,
    keeping: GuideIo,
    watch: &W,
    stop: &Stop,
    (observer, onlooker): (Observer, &mut dyn Onlooker),
) -> Rendering {
    let (limits, keeps_state) = (Limits::from_now(settings.render.time, stop), onlooker.keeps_state());
    let job = Job { scene, camera: &scene.camera, settings, watch, keep_guide: keeping.keep, keeps_state };
    let mut state = RenderState::new(scene, &scene.camera, settings, keeping);
    if onlooker.wants_error() {
        state.film = state.film.that_tells_its_error(true);
    }
    let mut driver = Driver::new(job, state, limits);
    match settings.render.order {
        Order::Progressive => driver.run(observer, onlooker),
        Order::Blocks => driver.run_blocks(observer, onlooker),
    }
    driver.finish()
}

/// Goes on with a render: within the budget of `settings`, in which the time counts from the render's first beginning. With the
/// budget that it had, it ends with the picture that it would have ended with; `new_budget`, with another.
pub fn resume<W: Watch>(
    scene: &Scene,
    settings: &Settings,
    (from, new_budget): (Checkpoint, bool),
    watch: &W,
    stop: &Stop,
    (observer, onlooker): (Observer, &mut dyn Onlooker),
) -> Rendering {
    let Checkpoint { state, record, spent, keeps_guide } = from;
    let limits = Limits::from_now(settings.render.time, stop).after(spent);
    let job = Job {
        scene,
        camera: &scene.camera,
        settings,
        watch,
        keep_guide: keeps_guide,
        keeps_state: onlooker.keeps_state(),
    };
    let mut driver = Driver::new(job, state, limits).in_the_middle(record, new_budget);
    driver.run(observer, onlooker);
    driver.finish()
}

#[cfg(test)]
mod edge_tests;

#[cfg(test)]
mod quality_tests;

#[cfg(test)]
mod sampler_tests;
