//! The policy of `guiding.method = "auto"`: the guide is used for as long as it pays.
//!
//! A [pilot](pilot) of unguided samples comes first. If too little of its noise is bounced light for any guide to pay, or the
//! budget is too short to learn in, the rest is rendered without a guide. Else the guide learns, first from one unguided
//! sample. Each of its later iterations is a trial, compared with the pilot by the figure of merit of a Monte Carlo
//! estimator, 1/(variance · cost). Gains and losses are counted in unguided samples per pixel. Once the guide does
//! not win yet, and what it has lost and is [expected](forecast) to lose next is more than a small share of the budget, the
//! render goes on without it.

mod cost;
mod forecast;
mod judged;
mod pilot;
mod verdict;

pub(crate) use verdict::{Reason, Trial, Verdict};

use super::super::noise::Noise;
use super::super::schedule::{LONGEST_ITERATION, doubled};
use super::super::{IterationReport, training};
use super::{Budget, FIRST_WITH_A_GUIDE, GuidePolicy, History, Iteration, Mode, Plan};
use cost::{CostMeter, PathCost};
use forecast::GainForecast;
use judged::Comparison;
use pilot::{Baseline, Pilot, first_samples, more_samples};

/// Samples per pixel from which the guide learns first: as few as with any other policy.
const FIRST_LESSON: u32 = 1;

/// Share of the budget that trials may lose where the relative variance of bounced light is `REFERENCE_VARIANCE` and no gain is
/// expected. It grows in proportion to that variance, as what a guide may win does, by factors within `LOSS_FACTORS`. The lower one
/// leaves the first trials of a render of 256 samples, which learn more than they gain, 1.5 % of it.
const LOSS_SHARE: f64 = 0.05;
const REFERENCE_VARIANCE: f64 = 5.0;
const LOSS_FACTORS: (f64, f64) = (0.3, 5.0);

/// Factor of the loss that is allowed while a gain is expected. Fitted: a guide that gained a tenth in the end had lost 2 to
/// 6 % of the budget before it won.
const EXPECTED_GAIN_FACTOR: f64 = 4.0;

/// Standard errors of the variance by which a trial may have seemed worse than it was.
const STANDARD_ERRORS: f64 = 2.0;

/// Trials in a row that the guide may lose without making progress, however long the budget.
const MAX_LOSSES_IN_A_ROW: u32 = 3;

/// Factor of the gain from one trial to the next that counts as progress.
const MIN_PROGRESS: f64 = 1.1;

/// Judges the guide, iteration by iteration.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Auto {
    meter: CostMeter,
    pixels: u64,
    pilot: Pilot,
    /// `None` until the pilot is over.
    baseline: Option<Baseline>,
    /// Unguided samples per pixel that the whole render holds; those that were spent so far, on learning too; and
    /// what of these the guide has lost, negative where it has gained.
    budget: f64,
    spent: f64,
    lost: f64,
    has_learnt: bool,
    reason: Reason,
    /// Relative variance of one unguided sample.
    variance: f64,
    /// The newest trial, how many there were, and how many at the end were lost without progress.
    trial: Option<Trial>,
    trials: u32,
    losses: u32,
}

impl GuidePolicy for Auto {
    fn next_iteration(&self, history: &History) -> Plan {
        let doubled = history.planned.map(doubled);
        if self.uses_guide() && self.trains() && !self.has_learnt {
            return Plan { mode: Mode::Guided, samples: FIRST_WITH_A_GUIDE, continues: false, trains: true };
        }
        let (mode, samples) = if self.baseline.is_none() {
            let more = || doubled.map(|doubled| more_samples(self.budget, history.samples).unwrap_or(doubled));
            (Mode::Pilot, more().unwrap_or_else(|| first_samples(self.pixels)))
        } else if !self.uses_guide() {
            (Mode::Unguided, LONGEST_ITERATION)
        } else if !self.has_learnt {
            (Mode::Guided, FIRST_LESSON)
        } else {
            (Mode::Guided, doubled.unwrap_or(FIRST_LESSON))
        };
        Plan { mode, samples, continues: !self.has_learnt, trains: false }
    }

    fn observe(&mut self, iteration: &Iteration) {
        if iteration.mode == Mode::Pilot {
            self.pilot.add_passes(self.meter, iteration.passes);
        }
        let Some(noise) = iteration.noise else { return };
        if iteration.mode == Mode::Pilot {
            let budget = self.unguided_samples(&iteration.budget);
            self.end_pilot(noise, iteration.bounced, budget);
            let trains = self.uses_guide() && self.trains();
            if let Some(baseline) = self.baseline.as_mut().filter(|_| trains) {
                baseline.variances = iteration.film.newest_variances().unwrap_or_default();
            }
            return;
        }
        // not those of earlier iterations, with which the film may weigh a short one
        let Some(variances) = iteration.film.newest_variances().filter(|_| iteration.mode == Mode::Guided) else {
            return;
        };
        if !self.has_learnt && !iteration.training.is_empty() {
            self.end_training(iteration.training);
        }
        let cost = self.meter.of_path(iteration.counters, iteration.learning);
        if self.has_learnt {
            self.judge(noise, &variances, iteration.samples, cost);
        } else {
            self.first_lesson(variances, iteration.all_samples, iteration.samples, cost);
        }
    }

    fn verdict(&self) -> Option<Verdict> {
        Some(Verdict {
            guided: self.uses_guide(),
            variance: self.variance,
            bounced: self.baseline.as_ref()?.bounced,
            budget: self.budget,
            lost: self.lost,
            reason: self.reason,
            trial: self.trial,
        })
    }
}

impl Auto {
    /// `by_clock`: by processor time and not by a count of what was done; `pixels` are those of the picture.
    pub fn new(by_clock: bool, pixels: u64) -> Auto {
        Auto {
            meter: CostMeter { by_clock },
            pixels,
            pilot: Pilot::default(),
            baseline: None,
            budget: 0.0,
            spent: 0.0,
            lost: 0.0,
            has_learnt: false,
            reason: Reason::Promising,
            variance: 0.0,
            trial: None,
            trials: 0,
            losses: 0,
        }
    }

    fn uses_guide(&self) -> bool {
        self.baseline.is_some() && self.reason == Reason::Promising
    }

    /// Unguided samples per pixel that a budget holds, by what one costs. Not by the time that has passed: caches were cold.
    fn unguided_samples(&self, budget: &Budget) -> f64 {
        let by_time = |cpu: f64| cpu / (self.pilot.cost() * self.pixels as f64);
        // a render that was begun for samples may go on for a time, and has counted no seconds
        budget.cpu_seconds.filter(|_| self.meter.by_clock).map_or(f64::INFINITY, by_time).min(budget.samples as f64)
    }

    /// Ends the pilot, unless the budget asks for a longer one.
    fn end_pilot(&mut self, noise: &Noise, bounced: &[[f32; 2]], budget: f64) {
        (self.budget, self.spent) = (budget, noise.samples as f64);
        if more_samples(budget, noise.samples).is_some() {
            return;
        }
        let baseline = self.pilot.baseline(noise, bounced);
        (self.variance, self.reason) = (baseline.variance, baseline.reason(budget, self.pixels));
        self.baseline = Some(baseline);
    }

    /// Whether there is a training before the first trial, and not an unguided sample per pixel.
    fn trains(&self) -> bool {
        training::samples(self.pixels, self.budget) > 0
    }

    /// Takes a training of these iterations.
    fn end_training(&mut self, iterations: &[IterationReport]) {
        let Some(baseline) = self.baseline.as_ref() else { return };
        let cost = |done: &IterationReport| {
            self.meter.of_path(&done.counters, done.learn_cpu).whole * done.counters.paths as f64
        };
        let samples = iterations.iter().map(cost).sum::<f64>() / (baseline.cost * self.pixels as f64);
        self.has_learnt = true;
        self.spent += samples;
        self.lost += samples;
    }

    /// Takes the iteration from which the guide has learnt first. It was drawn without a guide and adds to the baseline:
    /// `variances` are those of one of all `unguided` samples per pixel.
    fn first_lesson(&mut self, variances: Vec<f64>, unguided: u32, samples: u32, cost: PathCost) {
        let Some(baseline) = self.baseline.as_mut() else { return };
        (baseline.variances, baseline.samples) = (variances, unguided);
        let samples = samples as f64;
        self.has_learnt = true;
        self.spent += samples * cost.whole / baseline.cost;
        self.lost += samples * (cost.whole / baseline.cost - 1.0);
    }

    /// Judges a trial: `samples` guided samples per pixel after [`Self::first_lesson`], with the `variances` of one.
    fn judge(&mut self, noise: &Noise, variances: &[f64], samples: u32, cost: PathCost) {
        let Some(baseline) = &self.baseline else { return };
        let samples = samples as f64;
        let found = Comparison::new(noise, baseline, variances, samples);
        let (tracing, whole) = (cost.tracing / baseline.cost, cost.whole / baseline.cost);
        let bounced = baseline.bounced_share * found.spread;
        self.spent += samples * whole;
        if !(found.guided > 0.0 && found.unguided > 0.0) {
            // all that varies are outliers, if light was found at all: that says nothing of the guide
            return;
        }
        let trial = Trial { variance_ratio: found.guided / found.unguided, cost_ratio: tracing };
        self.variance = found.unguided;
        self.lost += samples * (whole - 1.0 / trial.variance_ratio);
        let progress = self.add_trial(trial);
        // Light that few paths find makes the variance of few samples uncertain. The judgement takes the optimistic end.
        let optimism = 1.0 + STANDARD_ERRORS * found.relative_error;
        let trial = Trial { variance_ratio: trial.variance_ratio / optimism, ..trial };
        let left = (self.budget - self.spent).max(0.0);
        let forecast = GainForecast { trial, trials: self.trials, samples, whole, progress, left };
        if self.losses >= MAX_LOSSES_IN_A_ROW || self.loses_too_much(&forecast, bounced) {
            self.reason = Reason::Losing;
        }
    }

    /// Counts a trial, and returns its gain over that of the one before; 1 for the first.
    fn add_trial(&mut self, trial: Trial) -> f64 {
        self.trials += 1;
        let progress = self.trial.replace(trial).map(|before| trial.gain() / before.gain());
        let stagnates = trial.gain() < 1.0 && progress.is_some_and(|p| p < MIN_PROGRESS);
        self.losses = if stagnates { self.losses + 1 } else { 0 };
        progress.unwrap_or(1.0)
    }

    /// Whether a guide that does not win yet would cost more than it may to go on with; `bounced` is the relative variance
    /// of bounced light.
    fn loses_too_much(&self, forecast: &GainForecast, bounced: f64) -> bool {
        let expected = forecast.expected();
        let by_gain = if expected.gain < 1.0 { 1.0 } else { EXPECTED_GAIN_FACTOR };
        let by_variance = (bounced / REFERENCE_VARIANCE).clamp(LOSS_FACTORS.0, LOSS_FACTORS.1);
        let limit = LOSS_SHARE * by_variance * by_gain * self.budget;
        forecast.trial.gain() < 1.0 && self.lost + expected.loss > limit
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod render_tests;
