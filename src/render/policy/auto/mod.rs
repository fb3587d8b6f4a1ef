//! The policy of `guiding.method = "auto"`: the guide is used for as long as it pays.
//!
//! A [pilot](pilot) of unguided samples comes first. If too little of its noise is bounced light for any guide to pay, or the
//! budget is too short to learn in, the rest is rendered without a guide. Else the guide learns, first from one unguided
//! sample. Each of its later iterations is a trial, compared with the pilot by variance and cost of a sample, and by how
//! evenly samples are [spread](evenness). Gains and losses are counted in unguided samples per pixel. While the guide does not
//! win yet, what it has lost and would lose in the next iteration is held against the share of the budget that learning may
//! cost. Where it is more, the render goes on without the guide.

mod cost;
mod evenness;
mod judged;
mod pilot;
mod verdict;

pub(crate) use verdict::{Reason, Trial, Verdict};

use super::super::noise::Noise;
use super::super::schedule::{LONGEST_ITERATION, doubled, is_last_iteration};
use super::super::{IterationReport, training};
use super::{Budget, FIRST_WITH_A_GUIDE, GuidePolicy, History, Iteration, Mode, Plan};
use cost::{CostMeter, PathCost};
use judged::{Comparison, Varying};
use pilot::{Baseline, Pilot, first_samples, more_samples};

/// Samples per pixel from which the guide learns first: as few as with any other policy.
const FIRST_LESSON: u32 = 1;

/// Share of the budget that the guide may lose before it wins: what learning is allowed to cost. With less, guides that win in the end
/// are given up in their first iterations; with more, those that never win are kept too long.
const LOSS_SHARE: f64 = 0.15;

/// Standard errors of the variance by which a trial may have seemed worse than it was.
const STANDARD_ERRORS: f64 = 2.0;

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
    /// The newest.
    trial: Option<Trial>,
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
                baseline.spreads = iteration.film.newest_spreads().unwrap_or_default();
            }
            return;
        }
        if iteration.mode != Mode::Guided {
            return;
        }
        let Some(newest) = Varying::newest(iteration.film, iteration.samples) else { return };
        if !self.has_learnt && !iteration.training.is_empty() {
            self.end_training(iteration.training);
        }
        let cost = self.meter.of_path(iteration.counters, iteration.learning);
        if self.has_learnt {
            self.judge(noise, &newest, cost);
        } else {
            self.first_lesson(newest, iteration.all_samples, cost);
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
    /// `spreads` are those of all `unguided` samples per pixel.
    fn first_lesson(&mut self, Varying { spreads, samples, .. }: Varying, unguided: u32, cost: PathCost) {
        let Some(baseline) = self.baseline.as_mut() else { return };
        (baseline.spreads, baseline.samples) = (spreads, unguided);
        let samples = samples as f64;
        self.has_learnt = true;
        self.spent += samples * cost.whole / baseline.cost;
        self.lost += samples * (cost.whole / baseline.cost - 1.0);
    }

    /// Judges a trial: `guided` samples after [`Self::first_lesson`].
    fn judge(&mut self, noise: &Noise, guided: &Varying, cost: PathCost) {
        let Some(baseline) = &self.baseline else { return };
        let samples = guided.samples as f64;
        let found = Comparison::new(noise, baseline, guided);
        let cost = PathCost { tracing: cost.tracing / baseline.cost, whole: cost.whole / baseline.cost };
        self.spent += samples * cost.whole;
        if !(found.guided > 0.0 && found.unguided > 0.0) {
            // all that varies are outliers, if light was found at all: that says nothing of the guide
            return;
        }
        let (variance_ratio, evenness) = (found.guided / found.unguided, found.evenness);
        let trial = Trial { variance_ratio, cost_ratio: cost.tracing, evenness };
        self.variance = found.unguided;
        self.lost += samples * cost.whole - trial.worth(samples, self.budget);
        let is_first = self.trial.replace(trial).is_none();
        // Light that few paths find makes the variance of few samples uncertain. The judgement takes the optimistic end.
        let variance_ratio = trial.variance_ratio / (1.0 + STANDARD_ERRORS * found.relative_error);
        let likely = Trial { variance_ratio, ..trial };
        let lost = self.lost + self.next_loss(&likely, 2.0 * samples, cost.whole);
        // What the first trial was drawn from was learnt from a sample or two; what the next is drawn from, from three times as many.
        if !is_first && likely.gain() < 1.0 && lost > LOSS_SHARE * self.budget {
            self.reason = Reason::Losing;
        }
    }

    /// Unguided samples per pixel that the next iteration loses if it does as `trial` did: one of so many samples, of which one costs
    /// `whole` with what is learnt from it, or the last one, which takes all that is left and from which nothing is learnt.
    fn next_loss(&self, trial: &Trial, samples: f64, whole: f64) -> f64 {
        let left = (self.budget - self.spent).max(0.0);
        let all = left / trial.cost_ratio;
        if is_last_iteration(samples, all) {
            // without the guide it is a group of its own too
            let unguided = left * (left / self.budget).powf(trial.evenness);
            unguided - trial.worth(all, self.budget)
        } else {
            samples * whole - trial.worth(samples, self.budget)
        }
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod render_tests;
