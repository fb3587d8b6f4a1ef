//! Whether the guide pays: what decides for `guiding.method = "auto"`.
//!
//! First some samples are taken as if there were no guide, and nothing is learnt from them: a *yardstick*. It tells what a
//! sample costs, and so how many the budget holds; how samples vary; and how much of that comes from light that bounced,
//! which is all that a better choice of directions can help with. Where that is too small a part for any guide to pay, or the
//! budget too short to learn in, that is all. Else the guide learns, first from a sample as unguided as these, and each of its
//! iterations is held against the yardstick by the figure of merit of a Monte Carlo estimator, 1/(variance · cost). What the
//! trial has lost so far is reckoned in samples, and with it what the next iteration is expected to lose: once that is more than
//! a small share of the budget, and the guide does not win yet, the render goes on without it.

use super::cost::{CLOCK_STEP, Meter, Rendered};
use super::forecast::GainForecast;
use super::noise::Noise;
use super::verdict::{Reason, Trial, Verdict};
use crate::integrator::Counters;

/// Share of the variance that light has which bounced, below which no guide pays: were it to find all of that light without
/// noise, the rest would vary as before, and no guide measured cost less than 1.3 times as much as none.
const LEAST_SHARE: f64 = 1.0 - 1.0 / 1.3;

/// Relative variance of one sample's bounced light below which no guide is tried. So calm light is rendered by few samples,
/// and what is left of its noise are rare bright ones, which trials are too short to see: in a box with 0.4, trials promised
/// 1.3 times the efficiency of a guide that had 0.87. A hall with 1.2 gained as much as they said.
const CALM: f64 = 0.7;

/// Samples per pixel, and camera paths, of the least budget in which a guide learns soon enough to pay. With 0.2 million
/// paths every guide lost on rooms that it later rendered three times as well; yardstick, first lesson and two trials take
/// what some twenty unguided samples do.
const LEAST_SAMPLES: f64 = 32.0;
const LEAST_PATHS: f64 = 8e5;

/// Camera paths of the yardstick, its share of the budget, and samples per pixel at least and at most. Light that few
/// paths find is missed by few samples, and what they vary then says too little: of a room with the variance 50, three
/// samples told 15 to 83.
const YARDSTICK_PATHS: u64 = 1 << 15;
const YARDSTICK_SHARE: f64 = 0.02;
const YARDSTICK_SAMPLES: (u64, u64) = (2, 16);

/// Share of the budget that a trial may lose where the variance of bounced light is `RISKY` and no gain is expected. Where
/// it is more, the guide may win as much more, and its trial lose so; where it is less, less; within these bounds.
const LOSS: f64 = 0.05;
const RISKY: f64 = 5.0;
const RISK: (f64, f64) = (0.15, 5.0);

/// How often as much while a gain is expected. The guide of a staircase, which gains a tenth in the end, had lost 2 to 6 %
/// of the budget before it won.
const HOPE: f64 = 4.0;

/// By how many standard errors a trial may have seemed worse than it was.
const DOUBTS: f64 = 2.0;

/// Iterations in a row that the guide may lose without getting better, however long the budget.
const PATIENCE: u32 = 3;

/// A guide that gets better does so by at least this factor from one iteration to the next.
const PROGRESS: f64 = 1.1;

/// Share of all samples that may be outliers, as many pixels having no say in the variance: the same of few samples as
/// of many, so that both see as much of a long tail. At most so many pixels, and of a guide no more than of the yardstick, be
/// its trial ever so long: what a guide seldom looks for is in its tail, and in the picture. The guide of a box that lost a
/// fifth seemed to win.
const OUTLIERS: f64 = 1e-4;
const MOST_OUTLIERS: f64 = 0.05;

/// What was seen without a guide.
struct Unguided {
    /// Of the luminance of one sample, pixel by pixel; empty before something was learnt.
    variances: Vec<f64>,
    samples: u32,
    /// Samples per pixel of the yardstick alone.
    unlearnt: u32,
    /// Of one camera path.
    cost: f64,
    /// Variance of one sample's bounced light, and the share of it in all, as first seen.
    bounced: f64,
    share: f64,
}

/// Judges the guide, iteration by iteration.
pub struct Worth {
    meter: Meter,
    pixels: u64,
    /// Of bounced light, pixel by pixel: Σ x and Σ x² over the yardstick.
    bounced: Vec<[f32; 2]>,
    /// Costs of the passes of the yardstick, of a camera path each.
    passes: Vec<f64>,
    yardstick: Option<Unguided>,
    /// Unguided samples per pixel.
    budget: f64,
    /// Of these, what was rendered and learnt so far took, and what of it the guide has lost.
    spent: f64,
    lost: f64,
    /// Whether anything was learnt.
    learns: bool,
    reason: Reason,
    variance: f64,
    trial: Option<Trial>,
    trials: u32,
    losses: u32,
}

impl Worth {
    pub fn new(clock: bool, pixels: u64) -> Worth {
        Worth {
            meter: Meter { clock },
            pixels,
            bounced: vec![[0.0; 2]; pixels as usize],
            passes: Vec::new(),
            yardstick: None,
            budget: 0.0,
            spent: 0.0,
            lost: 0.0,
            learns: false,
            reason: Reason::Promising,
            variance: 0.0,
            trial: None,
            trials: 0,
            losses: 0,
        }
    }

    /// Whether the yardstick is still to be made.
    pub fn measures(&self) -> bool {
        self.yardstick.is_none()
    }

    /// Whether all samples so far were unguided.
    pub fn unguided(&self) -> bool {
        !self.learns
    }

    /// Samples per pixel that nothing is learnt from; all of them until the yardstick is made.
    pub fn unlearnt(&self) -> u32 {
        self.yardstick.as_ref().map_or(u32::MAX, |yardstick| yardstick.unlearnt)
    }

    /// Samples per pixel with which to begin.
    pub fn first_samples(&self) -> u32 {
        let (least, most) = YARDSTICK_SAMPLES;
        YARDSTICK_PATHS.div_ceil(self.pixels).clamp(least, most) as u32
    }

    /// Samples per pixel that the yardstick still takes after so many, once something is known of the budget.
    pub fn more_samples(&self, taken: u32) -> Option<u32> {
        let wanted = (YARDSTICK_SHARE * self.budget).min(YARDSTICK_SAMPLES.1 as f64) as u32;
        wanted.checked_sub(taken).filter(|&more| more > 0)
    }

    /// Whether the guide is to be used, and to learn.
    pub fn pays(&self) -> bool {
        !self.measures() && self.reason == Reason::Promising
    }

    /// What was found so far; `None` where nothing was.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(Verdict {
            guided: self.pays(),
            variance: self.variance,
            bounced: self.yardstick.as_ref()?.bounced,
            budget: self.budget,
            lost: self.lost,
            reason: self.reason,
            trial: self.trial,
        })
    }

    /// Adds to what is known of bounced light in a pixel.
    pub fn add_bounced(&mut self, pixel: usize, [sum, squares]: [f32; 2]) {
        self.bounced[pixel][0] += sum;
        self.bounced[pixel][1] += squares;
    }

    /// Takes a pass of the yardstick over the picture: counters before and after.
    pub fn add_pass(&mut self, before: &Counters, after: &Counters) {
        let paths = (after.paths - before.paths).max(1) as f64;
        self.passes.push((self.meter.drawing(after) - self.meter.drawing(before)).max(CLOCK_STEP) / paths);
    }

    /// Of an unguided camera path, once the yardstick has a pass. Where it has several, the first only warms caches.
    pub fn cost(&self) -> f64 {
        let warm = if self.passes.len() > 1 { &self.passes[1..] } else { &self.passes };
        warm.iter().sum::<f64>() / warm.len() as f64
    }

    /// Ends the yardstick, unless it is to be longer; `budget` are the samples per pixel that could be had without a guide.
    pub fn begin(&mut self, noise: &Noise, budget: f64) {
        let n = noise.samples as f64;
        (self.budget, self.spent) = (budget, n);
        if self.more_samples(noise.samples).is_some() {
            return;
        }
        let of_bounced = |[sum, squares]: [f32; 2]| ((squares as f64 - (sum as f64).powi(2) / n) / (n - 1.0)).max(0.0);
        let bounced: Vec<f64> = std::mem::take(&mut self.bounced).into_iter().map(of_bounced).collect();
        let bounced = noise.variance_of(&bounced, outliers(n));
        self.variance = noise.variance_of(&noise.variances(), outliers(n));
        let share = if self.variance > 0.0 { bounced / self.variance } else { 0.0 };
        self.reason = if share < LEAST_SHARE || bounced < CALM {
            Reason::Calm
        } else if budget < LEAST_SAMPLES || budget * (self.pixels as f64) < LEAST_PATHS {
            Reason::Short
        } else {
            Reason::Promising
        };
        let cost = self.cost();
        self.yardstick = Some(Unguided {
            variances: Vec::new(),
            samples: noise.samples,
            unlearnt: noise.samples,
            cost,
            bounced,
            share,
        });
    }

    /// Takes the iteration after, of which the guide learns first: it is unguided, too, and adds to the yardstick.
    /// `variances` are those of one sample of both, `samples` per pixel.
    pub fn learnt(&mut self, variances: Vec<f64>, samples: u32, rendered: &Rendered) {
        let (_, whole) = self.meter.of_path(rendered);
        let Some(yardstick) = self.yardstick.as_mut() else { return };
        (yardstick.variances, yardstick.samples) = (variances, samples);
        self.learns = true;
        let samples = rendered.samples as f64;
        self.spent += samples * whole / yardstick.cost;
        self.lost += samples * (whole / yardstick.cost - 1.0);
    }

    /// Judges by an iteration of guided samples, after [`Self::learnt`]. `variances` are those of one of them.
    pub fn judge(&mut self, noise: &Noise, variances: &[f64], rendered: &Rendered) {
        let Some(yardstick) = &self.yardstick else { return };
        let samples = rendered.samples as f64;
        let before = outliers(yardstick.samples as f64);
        let after = before.min(outliers(samples));
        let unguided = noise.variance_of(&yardstick.variances, before);
        let (drawing, whole) = self.meter.of_path(rendered);
        let (drawing, whole) = (drawing / yardstick.cost, whole / yardstick.cost);
        let guided = noise.variance_of(variances, after);
        if !(guided > 0.0 && unguided > 0.0) {
            // all that varies is outliers, if it found any light: that says nothing of the guide
            self.spent += samples * whole;
            return;
        }
        let trial = Trial { variance_ratio: guided / unguided, cost_ratio: drawing };
        let doubt = noise.doubt(&yardstick.variances, before).hypot(noise.doubt(variances, after));
        let risk = yardstick.share * noise.spread(&yardstick.variances, before) / RISKY;
        self.variance = unguided;
        self.lost += samples * (whole - 1.0 / trial.variance_ratio);
        self.spent += samples * whole;
        self.trials += 1;
        let progress = self.trial.replace(trial).map(|before| trial.gain() / before.gain());
        self.losses = if trial.gain() < 1.0 && progress.is_some_and(|p| p < PROGRESS) { self.losses + 1 } else { 0 };
        // few samples of light that few paths find say too little of how they vary: the guide has the benefit of the doubt
        let trial = Trial { variance_ratio: trial.variance_ratio / (1.0 + DOUBTS * doubt), ..trial };
        let (progress, left) = (progress.unwrap_or(1.0), (self.budget - self.spent).max(0.0));
        let outlook = GainForecast { trial, trials: self.trials, samples, whole, progress, left };
        if self.losses >= PATIENCE || self.is_dear(&outlook, risk) {
            self.reason = Reason::Losing;
        }
    }

    /// Whether a guide that does not win yet would cost more than it may to go on with.
    fn is_dear(&self, outlook: &GainForecast, risk: f64) -> bool {
        let expected = outlook.expected();
        let hope = if expected.gain < 1.0 { 1.0 } else { HOPE };
        let limit = LOSS * risk.clamp(RISK.0, RISK.1) * hope * self.budget;
        outlook.trial.gain() < 1.0 && self.lost + expected.loss > limit
    }
}

/// Share of the pixels that may be outliers, of so many samples each.
fn outliers(samples: f64) -> f64 {
    (OUTLIERS * samples).min(MOST_OUTLIERS)
}

#[cfg(test)]
#[path = "worth_tests.rs"]
mod tests;
