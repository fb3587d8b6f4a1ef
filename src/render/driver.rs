//! The driver: iterations × passes × rounds. It carries out what the policy plans, within the limits of the render.

use super::limits::Limits;
use super::onlooker::{Moment, Onlooker, in_watts};
use super::policy::{GuidePolicy, Mode};
use super::schedule::{Tiling, iteration_samples, round_paths, rounds};
use super::state::{Record, RenderState};
use super::tracer::{Target, Tracer};
use super::{IterationReport, Observer, Progress, Rendering, Settings};
use crate::film::accumulate::FEATURE_SAMPLES;
use crate::integrator::Task;
use crate::integrator::probe::Watch;
use crate::io::clock::WallClock;
use crate::scene::Scene;

/// What is to be rendered; the same from the first iteration to the last.
pub(super) struct Job<'a, W> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub watch: &'a W,
    /// The guide will be used again: the last iteration too is learnt from.
    pub keep_guide: bool,
}

/// Renders from a state: its own are only what no checkpoint needs.
pub(super) struct Driver<'a, W> {
    job: Job<'a, W>,
    tiling: Tiling,
    limits: Limits<'a>,
    tracer: Tracer,
    state: RenderState,
}

impl<'a, W: Watch> Driver<'a, W> {
    pub fn new(job: Job<'a, W>, state: RenderState, limits: Limits<'a>) -> Driver<'a, W> {
        let tiling = Tiling::new(job.scene.camera.width, job.scene.camera.height);
        Driver { job, tiling, limits, tracer: Tracer::default(), state }
    }

    /// Iterations over the whole picture, to the end of the budget or of the observer's patience.
    pub fn run(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) {
        while self.iterate(observer, onlooker) {}
    }

    /// One iteration, with one frozen guide unless updates are on-line; `false` where rendering is over.
    pub fn iterate(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) -> bool {
        let left = self.samples_left();
        if left == 0 {
            return false;
        }
        let samples = iteration_samples(self.state.plan.samples, left);
        let (clock, last) = (WallClock::start(), samples == left);
        // Without a draw from it, nothing need be learnt.
        let learn = self.state.is_guided() && (!last || self.job.keep_guide || self.is_online());
        let mut record = self.state.begin_iteration();
        let go_on = self.passes((samples, last, learn), &mut record, observer, onlooker);
        self.take_in(&mut record);
        if learn && (go_on || self.job.keep_guide) && !self.limits.stop.is_urgent() {
            // An iteration that was broken off says too little of where states are to be refined or dropped.
            let whole = go_on || record.report.samples >= samples / 2;
            self.state.end_learning(whole, &mut record.report);
        }
        if go_on && (self.state.plan.mode == Mode::Pilot || (self.state.is_guided() && !last)) {
            self.state.weigh(&record, self.job.settings);
        }
        self.end_iteration(clock, record.report);
        go_on
    }

    /// Passes over the picture until each pixel has `samples` more, or the iteration is to end; `false` where rendering is
    /// over. Under a time limit the `last` iteration ends with the time, not with an estimated count.
    fn passes(
        &mut self,
        (samples, last, learn): (u32, bool, bool),
        record: &mut Record,
        observer: Observer,
        onlooker: &mut dyn Onlooker,
    ) -> bool {
        let (clock, render) = (WallClock::start(), &self.job.settings.render);
        let open_ended = render.time.is_some() && last;
        let target = if open_ended { render.spp - self.state.samples() } else { samples };
        // a pilot is short, and what it finds is needed
        let may_be_cut = !last && self.state.plan.mode != Mode::Pilot;
        while record.report.samples < target {
            // at least two passes, so that the noise of their mean shows in the difference of two halves
            let pass = self.tiling.samples.min(target.div_ceil(2)).min(target - record.report.samples);
            let whole = self.pass(pass, learn, record);
            let go_on =
                observer(&self.progress()) && whole && !self.limits.stop.is_asked() && !self.limits.time_is_up();
            self.show(record, onlooker, !go_on || (last && record.report.samples >= target));
            if !go_on {
                return false;
            }
            if may_be_cut && self.limits.is_too_long(clock.elapsed()) {
                break;
            }
        }
        true
    }

    /// Adds `samples` to every pixel; `false` where it was cut, and some pixels had theirs and others had not.
    fn pass(&mut self, samples: u32, learn: bool, record: &mut Record) -> bool {
        let (clock, before) = (WallClock::start(), self.state.samples());
        // no limit leaves pixels without any sample
        let end = if before > 0 { self.limits.next_pass() } else { self.limits.uncut() };
        let (tasks, features) = (self.tiling.pass(before, samples), before < FEATURE_SAMPLES);
        let mut done = Vec::with_capacity(tasks.len());
        record.begin_pass();
        let length = round_paths(self.is_online());
        let mut target = Target { job: &self.job, state: &mut self.state, record, end };
        for round in rounds(&tasks, length) {
            done.append(&mut self.tracer.round(&mut target, &round, learn));
        }
        let (whole, film) = (done.len() == tasks.len(), &mut self.state.film);
        match whole {
            true => film.add_samples(samples, features),
            false => done.iter().for_each(|task| film.add_samples_in(&task.tile, task.samples, features)),
        }
        record.count_samples(self.state.pixels);
        self.limits.newest_pass = clock.elapsed();
        whole
    }

    /// A single iteration over all blocks, one block of the picture after the other, each with all of its samples. With on-line
    /// updates the guide of the last block knows all, that of the first nothing. The observer is asked between stretches of
    /// whole blocks; those that it does not want stay blank. A stop may also cut a stretch.
    pub fn run_blocks(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) {
        let (clock, online) = (WallClock::start(), self.is_online());
        let (spp, length) = (self.job.settings.render.spp, round_paths(online));
        let mut record = self.state.begin_iteration();
        let stretches = self.tiling.blocks(spp, length);
        for (k, stretch) in (1..).zip(&stretches) {
            self.stretch(stretch, length, &mut record);
            let go_on = observer(&self.progress()) && !self.limits.stop.is_asked();
            self.show(&mut record, onlooker, !go_on || k == stretches.len());
            if !go_on {
                break;
            }
        }
        self.take_in(&mut record);
        if online {
            self.state.learnt_paths = self.state.learnt_paths.max(record.report.counters.paths);
        }
        self.end_iteration(clock, record.report);
    }

    /// Whole blocks, in rounds of `length` paths.
    fn stretch(&mut self, stretch: &[Task], length: usize, record: &mut Record) {
        // Frozen until an end that has no next iteration, a guide would learn for nobody.
        let (learn, end) = (self.is_online(), self.limits.uncut());
        let mut target = Target { job: &self.job, state: &mut self.state, record, end };
        for round in rounds(stretch, length) {
            if end.is_due() {
                break;
            }
            for task in self.tracer.round(&mut target, &round, learn) {
                let features = task.first_sample < FEATURE_SAMPLES;
                target.state.film.add_samples_in(&task.tile, task.samples, features);
            }
        }
        record.count_samples(self.state.pixels);
    }

    /// Picture and guide take what the last tasks of an iteration brought.
    fn take_in(&mut self, record: &mut Record) {
        let end = self.limits.uncut();
        self.tracer.take_in(&mut Target { job: &self.job, state: &mut self.state, record, end });
    }

    /// Lets an onlooker look that wants to, once the picture holds all that was traced.
    fn show(&mut self, record: &mut Record, onlooker: &mut dyn Onlooker, ends: bool) {
        if !self.limits.stop.is_urgent() && onlooker.is_due(ends) {
            self.take_in(record);
            onlooker.look(&Moment { film: &self.state.film, unit: self.job.scene.light_unit() });
        }
    }

    fn end_iteration(&mut self, clock: WallClock, mut report: IterationReport) {
        self.state.plan_next();
        report.wall_seconds = clock.elapsed().as_secs_f64();
        self.state.iterations.push(report);
    }

    /// The picture, and all that is to be said of the render.
    pub fn finish(self) -> Rendering {
        let (mut state, clock) = (self.state, self.limits.clock);
        if state.samples() < self.job.settings.render.spp {
            state.film.join_rest();
        }
        let (wall_seconds, cpu) = (self.limits.elapsed(), self.limits.cpu.elapsed());
        let (samples, unit) = (state.samples(), self.job.scene.light_unit());
        Rendering {
            estimate: in_watts(state.film.finish(), unit),
            samples,
            wall_seconds,
            cpu,
            film_wall_seconds: clock.elapsed().as_secs_f64() - wall_seconds,
            verdict: state.policy.verdict(),
            iterations: state.iterations,
            guide: state.guide,
            learnt_paths: state.learnt_paths,
        }
    }

    /// What a checkpoint keeps.
    #[cfg(test)]
    pub fn into_state(self) -> RenderState {
        self.state
    }

    /// Samples per pixel that are left of the budget; under a time limit an estimate from the speed so far.
    fn samples_left(&self) -> u32 {
        let left = self.job.settings.render.spp - self.state.samples();
        let Some((seconds, newest)) = self.limits.left().zip(self.state.iterations.last()) else { return left };
        // guided samples do not cost what unguided ones before them did
        let per_sample = newest.wall_seconds / newest.samples.max(1) as f64;
        left.min((seconds / per_sample).round().max(0.0) as u32)
    }

    fn progress(&self) -> Progress {
        let RenderState { paths, pixels, .. } = self.state;
        let by_samples = paths as f64 / (pixels as f64 * self.job.settings.render.spp as f64);
        let share = by_samples.max(self.limits.share()).min(1.0);
        Progress { samples: self.state.samples(), share, wall_seconds: self.limits.elapsed(), paths }
    }

    fn is_online(&self) -> bool {
        self.state.is_online(self.job.settings)
    }
}
