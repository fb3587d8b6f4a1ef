//! Whether the guide pays: what decides for `guiding.method = "auto"`.
//!
//! Where a single sample hardly varies, there is little to gain, and learning would cost more: the first few samples tell.
//! Else each iteration is held against the first, which has nothing to be guided by, by the figure of merit of a Monte
//! Carlo estimator, 1/(variance · cost). A guide that loses, and no longer gains from one iteration to the next, has
//! shown that the scene needs none. The render then goes on without it, and no longer pays for learning.

use super::noise::Noise;
use crate::integrator::Counters;

/// Relative variance of one sample, of the first two or three of each pixel, below which no guide is worth its cost. Of
/// the scenes with references, those that gained nothing in half a minute had up to 2.2, those that gained 4.8 and more.
const CALM: f64 = 3.0;

/// Iterations in a row that the guide may lose without getting better.
const PATIENCE: u32 = 2;

/// A guide that gets better does so by at least this factor from one iteration to the next.
const PROGRESS: f64 = 1.1;

/// Samples per pixel before a picture says enough.
const MIN_SAMPLES: u32 = 15;

/// Share of all samples that may be outliers, as many pixels having no say in the variance: the same of few samples as
/// of many, so that both see as much of a long tail. At most so many pixels.
const OUTLIERS: f64 = 1e-4;
const MOST_OUTLIERS: f64 = 0.05;

/// What cost is counted in, where a clock must not decide: rays; a shadow ray with the choice of its light; a vertex
/// at which the guide was asked and drawn from. Fitted to profiles of a box of 36 triangles and a room of 300 000.
const SHADOW_COST: f64 = 0.5;
const GUIDE_COST: f64 = 0.8;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Whether the guide is in use.
    pub guided: bool,
    /// Of one early sample, relative to the picture.
    pub variance: f64,
    /// How the guide did in its newest iteration, where it was tried.
    pub trial: Option<Trial>,
}

/// The guide against none.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Trial {
    /// Of one sample; below 1 the guide's vary less.
    pub variance_ratio: f64,
    /// Of one sample; above 1 the guide's cost more.
    pub cost_ratio: f64,
}

impl Trial {
    /// Efficiency of rendering with the guide over that without.
    pub fn gain(&self) -> f64 {
        1.0 / (self.variance_ratio * self.cost_ratio)
    }
}

/// What was seen without a guide.
struct Unguided {
    /// Luminance of the first sample of each pixel.
    light: Vec<f32>,
    cost: f64,
}

/// Judges the guide, iteration by iteration.
pub struct Worth {
    /// Cost is what the clock says; else it is counted, so that the same seed always gives the same picture.
    clock: bool,
    unguided: Option<Unguided>,
    /// Of one early sample.
    variance: Option<f64>,
    trial: Option<Trial>,
    losses: u32,
}

impl Worth {
    pub fn new(clock: bool) -> Worth {
        Worth { clock, unguided: None, variance: None, trial: None, losses: 0 }
    }

    /// Whether the guide is to be used, and to learn.
    pub fn pays(&self) -> bool {
        self.losses < PATIENCE && self.variance.is_none_or(|variance| variance >= CALM)
    }

    /// What was found so far; `None` where nothing was.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(Verdict { guided: self.pays(), variance: self.variance?, trial: self.trial })
    }

    /// Takes the first iteration, of one sample per pixel: `light` is their luminance.
    pub fn begin(&mut self, light: Vec<f32>, counters: &Counters) {
        self.unguided = Some(Unguided { light, cost: self.cost(counters) });
    }

    /// Judges by an iteration. The first that is long enough shows how samples vary, later ones the guide.
    pub fn judge(&mut self, noise: &Noise, counters: &Counters) {
        let samples = counters.paths as f64 / noise.squares.len() as f64;
        let variance = noise.variance(outliers(samples));
        if self.variance.is_none() {
            self.variance = Some(variance);
        }
        let Some(unguided) = self.unguided.as_ref().filter(|_| self.pays() && noise.samples >= MIN_SAMPLES) else {
            return;
        };
        let trial = Trial {
            variance_ratio: variance / noise.variance_about(&unguided.light, outliers(1.0)),
            cost_ratio: self.cost(counters) / unguided.cost,
        };
        let before = self.trial.map_or(0.0, |trial| trial.gain());
        let loses = trial.gain() < 1.0 && trial.gain() < PROGRESS * before;
        self.losses = if loses { self.losses + 1 } else { 0 };
        self.trial = Some(trial);
    }

    /// Of one camera path.
    fn cost(&self, counters: &Counters) -> f64 {
        let whole = if self.clock {
            counters.total.as_secs_f64()
        } else {
            counters.rays as f64 + SHADOW_COST * counters.shadow_rays as f64 + GUIDE_COST * counters.guide_hits as f64
        };
        whole / counters.paths.max(1) as f64
    }
}

/// Share of the pixels that may be outliers, of so many samples each.
fn outliers(samples: f64) -> f64 {
    (OUTLIERS * samples).min(MOST_OUTLIERS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A grey picture whose samples have the given variance.
    fn noise(variance: f64) -> Noise {
        Noise { light: vec![1.0; 25], squares: vec![1.0; 25], relative: vec![variance; 25], samples: 30 }
    }

    /// A hundred paths of so many rays each.
    fn counters(rays: u64) -> Counters {
        Counters { paths: 100, rays: 100 * rays, total: Duration::from_secs(7), ..Counters::default() }
    }

    /// Samples of variance 4 without a guide, then iterations of the given variances.
    fn judged(clock: bool, first: &Counters, trials: &[f64], counters: &Counters) -> Worth {
        let mut worth = Worth::new(clock);
        worth.begin([vec![3.0; 13], vec![-1.0; 12]].concat(), first);
        worth.judge(&Noise { samples: 3, ..noise(4.0) }, first);
        trials.iter().for_each(|variance| worth.judge(&noise(*variance), counters));
        worth
    }

    #[test]
    fn a_guide_that_loses_and_gets_no_better_is_out_for_good() {
        let worth = |variances: &[f64]| judged(false, &counters(5), variances, &counters(10));
        let pays = |variances: &[f64]| worth(variances).pays();
        assert!(pays(&[]) && pays(&[3.2]) && pays(&[3.2, 3.2]));
        assert!(!pays(&[3.2, 3.2, 3.2]) && !pays(&[3.2, 3.6, 4.0, 0.4]));
        assert!(pays(&[12.0, 8.0, 6.0, 4.0, 3.6, 3.2]), "it gets better");
        assert!(pays(&[1.6, 1.6, 1.6, 1.6]), "it wins");
        let verdict = worth(&[2.4, 2.4, 2.4]).verdict().expect("it was tried");
        let trial = verdict.trial.expect("it was tried");
        assert!((trial.variance_ratio - 0.6).abs() < 1e-12 && trial.cost_ratio == 2.0 && !verdict.guided);
        assert!((trial.gain() - 1.0 / 1.2).abs() < 1e-12);
    }

    #[test]
    fn cost_is_counted_or_what_the_clock_says() {
        let guided = Counters { shadow_rays: 200, guide_hits: 100, ..counters(3) };
        let cost = |clock, counters: &Counters| {
            let worth = judged(clock, &self::counters(2), &[1.0], counters);
            worth.verdict().and_then(|verdict| verdict.trial).expect("it was tried").cost_ratio
        };
        assert!((cost(false, &guided) - (3.0 + 2.0 * SHADOW_COST + GUIDE_COST) / 2.0).abs() < 1e-12);
        let slow = Counters { total: Duration::from_secs(21), ..guided };
        assert!((cost(true, &slow) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn where_samples_hardly_vary_nothing_is_tried() {
        let mut worth = Worth::new(false);
        assert!(worth.verdict().is_none() && worth.pays());
        worth.judge(&Noise { samples: 3, ..noise(2.0) }, &counters(2));
        assert!(!worth.pays());
        worth.judge(&noise(9.0), &counters(2));
        let verdict = worth.verdict().expect("it was judged");
        assert!(!verdict.guided && verdict.trial.is_none() && (verdict.variance - 2.0).abs() < 1e-12);
    }
}
