//! The driver: iterations × passes × rounds. It carries out what the policy plans, within the limits of the render.

use super::adaptive::Left;
use super::limits::{Limits, PassEnd};
use super::onlooker::{Moment, Occasion, Onlooker, in_watts};
use super::policy::{GuidePolicy, Mode};
use super::schedule::{Tiling, iteration_samples, round_paths, rounds};
use super::state::{CutPass, IterationOrder, Record, RenderState};
use super::tracer::{Target, Tracer};
use super::training::train;
use super::{IterationReport, Observer, Progress, Rendering, Settings};
use crate::film::accumulate::FEATURE_SAMPLES;
use crate::integrator::Task;
use crate::integrator::probe::Watch;
use crate::io::clock::WallClock;
use crate::scene::{Camera, Scene};

/// What is to be rendered; the same from the first iteration to the last.
#[derive(Clone, Copy)]
pub(super) struct Job<'a, W> {
    pub scene: &'a Scene,
    /// The scene's, or another.
    pub camera: &'a Camera,
    pub settings: &'a Settings,
    pub watch: &'a W,
    /// The guide will be used again: the last iteration too is learnt from.
    pub keep_guide: bool,
    /// The state may be asked for at any time.
    pub keeps_state: bool,
}

/// Renders from a state: its own are only what no checkpoint needs.
pub(super) struct Driver<'a, W> {
    job: Job<'a, W>,
    tiling: Tiling,
    limits: Limits<'a>,
    tracer: Tracer,
    state: RenderState,
    /// The iteration in whose middle the state is.
    record: Option<Record>,
}

impl<'a, W: Watch> Driver<'a, W> {
    pub fn new(job: Job<'a, W>, state: RenderState, mut limits: Limits<'a>) -> Driver<'a, W> {
        let tiling = Tiling::new(job.camera.width, job.camera.height);
        limits.learns_all = job.keeps_state;
        Driver { job, tiling, limits, tracer: Tracer::default(), state, record: None }
    }

    /// The same in the middle of an iteration. `new_budget`: it may have been planned for another budget.
    pub fn in_the_middle(mut self, record: Record, new_budget: bool) -> Driver<'a, W> {
        let record = self.record.insert(record);
        if new_budget {
            let before = self.state.samples().saturating_sub(record.report.samples);
            record.reorder(before, self.job.settings.render.spp);
            self.state.adaptive.iter_mut().for_each(|adaptive| adaptive.change_budget());
        }
        self
    }

    /// Iterations over the whole picture, to the end of the budget or of the observer's patience.
    pub fn run(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) {
        while self.iterate(observer, onlooker) {}
    }

    /// One iteration, with one frozen guide unless updates are on-line, or the rest of one; `false` where rendering is over.
    pub fn iterate(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) -> bool {
        let resumed = self.record.take();
        let is_over = resumed.as_ref().is_some_and(|record| record.is_good || self.limits.time_is_up());
        let Some(mut record) = resumed.or_else(|| self.begin_iteration(observer)) else { return false };
        let go_on = !is_over && self.passes(&mut record, observer, onlooker);
        self.take_in(&mut record);
        let IterationOrder { samples, last, learn } = record.order;
        if learn && (go_on || self.job.keep_guide) && !self.limits.stop.is_urgent() {
            // An iteration that was broken off says too little of where states are to be refined or dropped.
            let whole = go_on || record.report.samples >= samples / 2;
            self.state.end_learning(whole, &mut record.report);
        }
        if go_on && (self.state.plan.mode == Mode::Pilot || (learn && (!last || self.job.keep_guide))) {
            self.state.weigh(&record, self.job.settings);
        }
        self.end_iteration(record);
        go_on
    }

    /// The record of the next iteration; `None` where nothing is left of the budget.
    fn begin_iteration(&mut self, observer: Observer) -> Option<Record> {
        if self.state.plan.trains && !self.is_online() {
            let before = Progress { training: true, ..self.progress() };
            train(&self.job, &self.limits, &mut self.state, &mut || observer(&before));
        }
        let left = self.samples_left();
        if left == 0 {
            return None;
        }
        let samples = iteration_samples(self.state.plan.samples, left);
        let order = IterationOrder { samples, last: samples == left, learn: false };
        let budget = Left { samples: left, noise: self.job.settings.render.noise };
        let order = self.state.allot(order, budget, &self.tiling);
        // Without a draw from it, nothing need be learnt.
        let learn = self.state.is_guided() && (!order.last || self.job.keep_guide || self.is_online());
        let order = IterationOrder { learn, ..order };
        Some(self.state.begin_iteration(order, self.job.keeps_state, self.is_online()))
    }

    /// Passes over the picture until each pixel has as many samples more as were ordered, or the iteration is to end; `false`
    /// where rendering is over. Under a time limit the last iteration ends with the time, not with an estimated count.
    fn passes(&mut self, record: &mut Record, observer: Observer, onlooker: &mut dyn Onlooker) -> bool {
        let (IterationOrder { samples, last, .. }, render) = (record.order, &self.job.settings.render);
        // tiles that are as good as they are to be get no more, whatever time is left
        let open_ended = render.time.is_some() && last && !(self.state.is_allotted() && render.noise.is_some());
        let before = self.state.samples() - record.report.samples;
        let target = if open_ended { render.spp.saturating_sub(before) } else { samples };
        // a pilot is short, and what it finds is needed
        let may_be_cut = !last && self.state.plan.mode != Mode::Pilot;
        let passes =
            self.state.adaptive.as_ref().filter(|_| self.state.is_allotted()).map(|adaptive| adaptive.passes());
        let is_whole = |record: &Record| match passes {
            Some(passes) if !open_ended => record.passes_done >= passes,
            _ => record.report.samples >= target,
        };
        while !is_whole(record) {
            // at least two passes, so that the noise of their mean shows in the difference of two halves
            let pass = self.tiling.samples.min(target.div_ceil(2)).min(target.saturating_sub(record.report.samples));
            let whole = if passes.is_some() { self.allotted_pass(record) } else { self.pass(pass, record) };
            record.passes_done += u32::from(whole);
            record.is_good = whole && self.is_good(record);
            let is_over = record.is_good || !whole || self.limits.stop.is_asked() || self.limits.time_is_up();
            let go_on = observer(&self.progress()) && !is_over;
            self.show(record, onlooker, !go_on || (last && is_whole(record)));
            if !go_on {
                return false;
            }
            if may_be_cut && self.limits.is_too_long(record.clock.elapsed()) {
                break;
            }
        }
        true
    }

    /// Whether the picture is as good as was asked for.
    fn is_good(&mut self, record: &mut Record) -> bool {
        let Some(noise) = self.job.settings.render.noise.filter(|_| self.state.can_end_by_error()) else {
            return false;
        };
        self.take_in(record);
        self.state.is_as_good(noise)
    }

    /// Adds `samples` to every pixel, or the rest of a pass that was cut; `false` where it was cut, and some pixels had theirs
    /// and others had not.
    fn pass(&mut self, samples: u32, record: &mut Record) -> bool {
        let (clock, resumed) = (WallClock::start(), record.cut.take());
        let new = || CutPass { first: self.state.samples(), samples, done: 0, learns: false };
        let CutPass { first, samples, done, .. } = resumed.unwrap_or_else(new);
        let (tasks, features) = (self.tiling.pass(first, samples), first < FEATURE_SAMPLES);
        if resumed.is_none() {
            record.begin_pass();
        }
        // they are counted with all others
        let counted = &tasks[..done.min(tasks.len())];
        counted.iter().for_each(|task| self.state.film.take_back_samples_in(&task.tile, task.samples, features));
        self.state.film.level();
        record.cut = self.rounds(&tasks, resumed, record);
        let film = &mut self.state.film;
        match &record.cut {
            None => film.add_samples(samples, features),
            Some(cut) => {
                let done = &tasks[..cut.done];
                done.iter().for_each(|task| film.add_samples_in(&task.tile, task.samples, features));
            }
        }
        record.count_samples(self.state.pixels);
        self.limits.newest_pass = clock.elapsed();
        record.cut.is_none()
    }

    /// As [`Self::pass`], where tiles get different numbers of samples.
    fn allotted_pass(&mut self, record: &mut Record) -> bool {
        let (clock, resumed) = (WallClock::start(), record.cut.take());
        let Some(adaptive) = &self.state.adaptive else { return true };
        let tasks = adaptive.tasks(&self.tiling, record.passes_done);
        if resumed.is_none() {
            record.begin_pass();
        }
        record.cut = self.rounds(&tasks, resumed, record);
        let before = resumed.map_or(0, |cut| cut.done);
        let done = record.cut.as_ref().map_or(tasks.len(), |cut| cut.done);
        let film = &mut self.state.film;
        tasks[before..done].iter().for_each(|task| film.add_samples_in(&task.tile, task.samples, false));
        film.level();
        if record.cut.is_none() {
            let passes = self.state.adaptive.as_ref().map_or(1, |adaptive| adaptive.passes());
            film.say_done(f64::from(record.passes_done + 1) / f64::from(passes));
        }
        record.count_samples(self.state.pixels);
        self.limits.newest_pass = clock.elapsed();
        record.cut.is_none()
    }

    /// Traces all tasks of a pass, or those that are left; what was done of it where it was cut.
    fn rounds(&mut self, tasks: &[Task], resumed: Option<CutPass>, record: &mut Record) -> Option<CutPass> {
        let Task { first_sample: first, samples, .. } = *tasks.first()?;
        let (online, learn) = (self.is_online(), record.order.learn);
        // no limit leaves pixels without any sample
        let end = if first > 0 { self.limits.next_pass() } else { self.limits.uncut() };
        let end = PassEnd { between_rounds: online, ..end };
        let mut target = Target { job: &self.job, state: &mut self.state, record, end };
        let (mut done, mut begin) = (resumed.map_or(0, |cut| cut.done), 0);
        for round in rounds(tasks, round_paths(online)) {
            let before = done.saturating_sub(begin).min(round.len());
            begin += round.len();
            if before == round.len() {
                continue;
            }
            let same_round = resumed.filter(|_| before > 0);
            if end.is_due() {
                let learns = same_round.is_some_and(|cut| cut.learns);
                return Some(CutPass { first, samples, done, learns });
            }
            let learns = same_round.map_or_else(|| self.tracer.learns(&mut target, learn), |cut| cut.learns);
            let traced = self.tracer.round(&mut target, &round[before..], learns);
            done += traced;
            if traced < round.len() - before {
                target.record.is_broken |= online && traced > 0;
                return Some(CutPass { first, samples, done, learns });
            }
        }
        None
    }

    /// A single iteration over all blocks, one block of the picture after the other, each with all of its samples. With on-line
    /// updates the guide of the last block knows all, that of the first nothing. The observer is asked between stretches of
    /// whole blocks; those that it does not want stay blank. A stop may also cut a stretch.
    pub fn run_blocks(&mut self, observer: Observer, onlooker: &mut dyn Onlooker) {
        let online = self.is_online();
        let (spp, length) = (self.job.settings.render.spp, round_paths(online));
        let order = IterationOrder { samples: spp, last: true, learn: online };
        let mut record = self.state.begin_iteration(order, self.job.keeps_state, online);
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
        self.end_iteration(record);
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
            let learns = self.tracer.learns(&mut target, learn);
            let traced = self.tracer.round(&mut target, &round, learns);
            for task in &round[..traced] {
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
        let occasion = match ends {
            _ if self.limits.stop.is_urgent() => Occasion::AtOnce,
            true => Occasion::Last,
            false => Occasion::Between,
        };
        if onlooker.is_due(occasion) {
            self.take_in(record);
            record.report.wall_seconds = record.clock.elapsed().as_secs_f64();
            let (spent, unit, keeps_guide) = (self.limits.spent(), self.job.scene.light_unit(), self.job.keep_guide);
            onlooker.look(&Moment { state: &self.state, record, spent, unit, keeps_guide, stop: self.limits.stop });
        }
    }

    fn end_iteration(&mut self, record: Record) {
        self.state.plan_next();
        if self.job.settings.render.noise.is_some() && self.state.is_allotted() {
            self.state.relative_error = self.state.error_so_far();
        }
        let wall_seconds = record.clock.elapsed().as_secs_f64();
        self.state.iterations.push(IterationReport { wall_seconds, ..record.report });
    }

    /// The picture, and all that is to be said of the render.
    pub fn finish(self) -> Rendering {
        let (mut state, clock) = (self.state, self.limits.clock);
        if state.samples() < self.job.settings.render.spp {
            state.film.join_rest();
        }
        let (wall_seconds, cpu) = (self.limits.elapsed(), self.limits.spent().cpu);
        let (samples, unit) = (state.samples(), self.job.scene.light_unit());
        let adaptive_tiles = state.is_allotted().then(|| self.tiling.side());
        Rendering {
            estimate: in_watts(state.film.finish(), unit),
            samples,
            wall_seconds,
            cpu,
            film_wall_seconds: clock.elapsed().as_secs_f64() - wall_seconds,
            verdict: state.policy.verdict(),
            relative_error: state.relative_error,
            adaptive_tiles,
            iterations: state.iterations,
            training: state.training,
            guide: state.guide,
            learnt_paths: state.learnt_paths,
        }
    }

    /// What a checkpoint keeps.
    pub fn into_state(self) -> RenderState {
        self.state
    }

    /// Samples per pixel that are left of the budget; under a time limit an estimate from the speed so far.
    fn samples_left(&self) -> u32 {
        if self.state.adaptive.as_ref().is_some_and(|adaptive| adaptive.is_complete()) {
            return 0;
        }
        let left = self.job.settings.render.spp.saturating_sub(self.state.samples());
        let Some((seconds, newest)) = self.limits.left().zip(self.state.iterations.last()) else { return left };
        // guided samples do not cost what unguided ones before them did
        let per_sample = newest.wall_seconds * self.state.pixels as f64 / newest.counters.paths.max(1) as f64;
        left.min((seconds / per_sample).round().max(0.0) as u32)
    }

    fn progress(&self) -> Progress {
        let RenderState { paths, pixels, .. } = self.state;
        let by_samples = paths as f64 / (pixels as f64 * self.job.settings.render.spp as f64);
        let share = by_samples.max(self.limits.share()).min(1.0);
        Progress { samples: self.state.samples(), share, wall_seconds: self.limits.elapsed(), paths, training: false }
    }

    fn is_online(&self) -> bool {
        self.state.is_online(self.job.settings)
    }
}
