//! The driver: iterations × passes × rounds, and the clock.

use super::end::{End, TimeLimit};
use super::round::{BufferPool, PendingResults};
use super::schedule::{Tiling, iteration_samples, iteration_seconds, round_paths, rounds};
use super::worth::Worth;
use super::{GuideIo, IterationReport, Observer, Progress, Rendering, Settings};
use crate::film::Combine;
use crate::film::accumulate::{FEATURE_SAMPLES, Film};
use crate::guiding::Guide;
use crate::guiding::settings::{GuidingMethod, Updates};
use crate::integrator::probe::Watch;
use crate::integrator::{Counters, RouletteNormalisation, Stop};
use crate::scene::Scene;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// Unguided samples are identically distributed, so they are weighted equally, whatever their estimated variances.
fn combine(settings: &Settings) -> Combine {
    let (combine, method) = (settings.render.combine, settings.guiding.method);
    if combine == Combine::InverseVariance && method == GuidingMethod::None { Combine::All } else { combine }
}

/// Samples per pixel that an iteration plans at most.
pub(super) const LONGEST: u32 = 1 << 30;

pub(super) struct Driver<'a, W> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    pub(super) watch: &'a W,
    pub(super) tiling: Tiling,
    pub(super) film: Film,
    pub(super) guide: Option<Guide>,
    pub(super) keep: bool,
    pub(super) learnt_paths: u64,
    pub(super) seed: u64,
    pub(super) efficiency: Option<RouletteNormalisation>,
    /// Where it is to be found out whether the guide pays.
    pub(super) worth: Option<Worth>,
    pub(super) iterations: Vec<IterationReport>,
    pub(super) samples: u32,
    pub(super) paths: u64,
    pub(super) start: Instant,
    pub(super) end: End<'a>,
    /// What the newest pass took, or nothing before the first.
    newest_pass: Duration,
    pub(super) traced: PendingResults,
    pub(super) spare: BufferPool,
}

impl<'a, W: Watch> Driver<'a, W> {
    pub(super) fn new(
        scene: &'a Scene,
        settings: &'a Settings,
        GuideIo { from, keep }: GuideIo,
        watch: &'a W,
        stop: &'a Stop,
    ) -> Driver<'a, W> {
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
            worth: judged.then(|| Worth::new(settings.render.time.is_some(), width as u64 * height as u64)),
            iterations: Vec::new(),
            samples: 0,
            paths: 0,
            start,
            end: End { stop, deadline: None },
            newest_pass: Duration::ZERO,
            traced: PendingResults::default(),
            spare: BufferPool::default(),
        }
    }

    pub(super) fn run(&mut self, observer: Observer) {
        // With a guide from before, iterations go on where those ended: after one of its length, the old is half forgotten.
        let pixels = self.scene.camera.width as u64 * self.scene.camera.height as u64;
        let mut planned = (self.learnt_paths / pixels).saturating_mul(2).clamp(1, LONGEST as u64) as u32;
        planned = self.worth.as_ref().map_or(planned, Worth::first_samples);
        loop {
            let left = self.samples_left();
            if left == 0 {
                return;
            }
            let samples = iteration_samples(planned, left);
            if !self.iterate(samples, samples == left, observer) {
                return;
            }
            planned = self.next_length(planned);
        }
    }

    /// What came of it.
    pub(super) fn finish(mut self) -> Rendering {
        if self.samples < self.settings.render.spp {
            self.film.join_rest();
        }
        let seconds = self.start.elapsed().as_secs_f64();
        let (mut estimate, unit) = (self.film.resolve(), self.scene.light_unit());
        estimate.mean.par_iter_mut().for_each(|mean| *mean = unit.radiance(*mean));
        estimate.variance.par_iter_mut().for_each(|variance| *variance = unit.squared_radiance(*variance));
        Rendering {
            estimate,
            iterations: self.iterations,
            samples: self.samples,
            seconds,
            film_seconds: self.start.elapsed().as_secs_f64() - seconds,
            guide: self.guide,
            verdict: self.worth.and_then(|worth| worth.verdict()),
            learnt_paths: self.learnt_paths,
        }
    }

    /// Samples per pixel that are left of the budget; under a time limit an estimate from the speed so far.
    fn samples_left(&self) -> u32 {
        let left = self.settings.render.spp - self.samples;
        match self.time_limit() {
            Some(limit) => self.iterations.last().map_or(left, |newest| {
                // what guided samples cost is not what those before them did
                let per_sample = newest.seconds / newest.samples.max(1) as f64;
                left.min((limit.left() / per_sample).round().max(0.0) as u32)
            }),
            None => left,
        }
    }

    pub(super) fn begin_iteration(&self) -> IterationReport {
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
            let before = report.counters.clone();
            let whole = self.pass(pass, learn, &mut report);
            if let Some(worth) = self.worth.as_mut().filter(|worth| worth.measures()) {
                worth.add_pass(&before, &report.counters);
            }
            go_on = observer(&self.progress()) && whole && !self.end.stop.is_asked() && !self.time_is_up();
            if !last && self.takes_too_long(start) {
                break;
            }
        }
        self.take_in(&mut report);
        let in_time = !self.end.is_urgent();
        if let Some(guide) = self.guide.as_mut().filter(|_| learn && (go_on || self.keep) && in_time) {
            // An iteration that was broken off says too little of where states are to be refined or dropped.
            let whole = go_on || report.samples >= samples / 2;
            let end = || if whole { guide.end_iteration(report.samples) } else { guide.refresh() };
            report.learn_seconds += timed(end).as_secs_f64();
            self.learnt_paths = self.learnt_paths.max(report.counters.paths);
        }
        if go_on && (self.measures() || (self.guided() && !last)) {
            self.weigh(&report);
        }
        // what no guide had a part in is all alike
        if self.worth.as_ref().is_none_or(|worth| !worth.unguided()) {
            self.film.end_iteration();
        }
        report.seconds = start.elapsed().as_secs_f64();
        self.iterations.push(report);
        go_on
    }

    /// Adds `samples` to every pixel; `false` where it was cut, and some pixels had theirs and others had not.
    fn pass(&mut self, samples: u32, learn: bool, report: &mut IterationReport) -> bool {
        let start = Instant::now();
        // the clock leaves no pixel without any
        self.end.deadline = self.time_limit().filter(|_| self.samples > 0).and_then(|t| t.deadline(self.newest_pass));
        let (tasks, features) = (self.tiling.pass(self.samples, samples), self.samples < FEATURE_SAMPLES);
        let mut done = Vec::with_capacity(tasks.len());
        for round in rounds(&tasks, round_paths(self.online())) {
            done.append(&mut self.round(&round, learn, report));
        }
        let whole = done.len() == tasks.len();
        match whole {
            true => self.film.add_samples(samples, features),
            false => done.iter().for_each(|task| self.film.add_samples_in(&task.tile, task.samples, features)),
        }
        self.count_samples(report);
        self.newest_pass = start.elapsed();
        whole
    }

    /// Samples per pixel so far, on average where a pass was cut.
    pub(super) fn count_samples(&mut self, report: &mut IterationReport) {
        self.samples = (self.paths / self.pixels()) as u32;
        report.samples = (report.counters.paths / self.pixels()) as u32;
    }

    /// Whether the guide's snapshot follows what it learns, round by round.
    pub(super) fn online(&self) -> bool {
        self.guide.is_some() && self.settings.guiding.updates == Updates::Online
    }

    pub(super) fn pixels(&self) -> u64 {
        self.scene.camera.width as u64 * self.scene.camera.height as u64
    }

    pub(super) fn progress(&self) -> Progress {
        let seconds = self.start.elapsed().as_secs_f64();
        let by_samples = self.paths as f64 / (self.pixels() as f64 * self.settings.render.spp as f64);
        let by_time = self.time_limit().map_or(0.0, |limit| seconds / limit.seconds);
        Progress { samples: self.samples, share: by_samples.max(by_time).min(1.0), seconds, paths: self.paths }
    }

    /// Whether an iteration that began then has used all the time that it may, which only the last may go beyond.
    fn takes_too_long(&self, began: Instant) -> bool {
        let Some(limit) = self.settings.render.time.filter(|_| !self.measures()) else { return false };
        iteration_seconds(limit - (began - self.start).as_secs_f64()) < began.elapsed().as_secs_f64()
    }

    fn time_limit(&self) -> Option<TimeLimit> {
        self.settings.render.time.map(|seconds| TimeLimit { start: self.start, seconds })
    }

    /// Whether there is no time for another pass.
    fn time_is_up(&self) -> bool {
        self.time_limit().is_some_and(|limit| limit.is_over(self.newest_pass))
    }
}

pub(super) fn timed(f: impl FnOnce()) -> Duration {
    let start = Instant::now();
    f();
    start.elapsed()
}
