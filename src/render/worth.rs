//! Whether the guide pays: what decides for `guiding.method = "auto"`.
//!
//! The first iteration has nothing to be guided by: its samples show what rendering without a guide would be like. Each
//! later iteration is held against it by the figure of merit of a Monte Carlo estimator, 1/(variance · cost). A guide
//! that loses, and no longer gains from one iteration to the next, has shown that the scene needs none: the render goes
//! on without it, and no longer pays for learning.

use super::noise::Noise;
use crate::integrator::Counters;

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

/// How the guide did in its newest iteration, against none.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Of one sample; below 1 the guide's vary less.
    pub variance_ratio: f64,
    /// Of one sample; above 1 the guide's cost more.
    pub cost_ratio: f64,
    /// Whether the guide is in use.
    pub guided: bool,
}

impl Verdict {
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
    losses: u32,
    verdict: Option<Verdict>,
}

impl Worth {
    pub fn new(clock: bool) -> Worth {
        Worth { clock, unguided: None, losses: 0, verdict: None }
    }

    /// Whether the guide is to be used, and to learn.
    pub fn pays(&self) -> bool {
        self.losses < PATIENCE
    }

    /// The newest verdict; `None` while the guide has not been tried.
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// Takes the first iteration, of one sample per pixel: `light` is their luminance.
    pub fn begin(&mut self, light: Vec<f32>, counters: &Counters) {
        self.unguided = Some(Unguided { light, cost: self.cost(counters) });
    }

    /// Judges by an iteration, if there is enough to judge by.
    pub fn judge(&mut self, noise: &Noise, counters: &Counters) {
        let Some(unguided) = self.unguided.as_ref().filter(|_| self.pays() && noise.samples >= MIN_SAMPLES) else {
            return;
        };
        let samples = counters.paths as f64 / noise.squares.len() as f64;
        let without = noise.variance_about(&unguided.light, outliers(1.0));
        let verdict = Verdict {
            variance_ratio: noise.variance(outliers(samples)) / without,
            cost_ratio: self.cost(counters) / unguided.cost,
            guided: true,
        };
        let before = self.verdict.map_or(0.0, |verdict| verdict.gain());
        let loses = verdict.gain() < 1.0 && verdict.gain() < PROGRESS * before;
        self.losses = if loses { self.losses + 1 } else { 0 };
        self.verdict = Some(Verdict { guided: self.pays(), ..verdict });
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

    /// Samples of variance 1 without a guide, then iterations of the given variances.
    fn judged(clock: bool, first: &Counters, trials: &[f64], counters: &Counters) -> Worth {
        let mut worth = Worth::new(clock);
        worth.begin([vec![2.0; 13], vec![0.0; 12]].concat(), first);
        trials.iter().for_each(|variance| worth.judge(&noise(*variance), counters));
        worth
    }

    #[test]
    fn a_guide_that_loses_and_gets_no_better_is_out_for_good() {
        let pays = |variances: &[f64]| judged(false, &counters(5), variances, &counters(10)).pays();
        assert!(pays(&[]) && pays(&[0.8]) && pays(&[0.8, 0.8]));
        assert!(!pays(&[0.8, 0.8, 0.8]) && !pays(&[0.8, 0.9, 1.0, 0.1]));
        assert!(pays(&[3.0, 2.0, 1.5, 1.0, 0.9, 0.8]), "it gets better");
        assert!(pays(&[0.4, 0.4, 0.4, 0.4]), "it wins");
        let verdict = judged(false, &counters(5), &[0.6, 0.6, 0.6], &counters(10)).verdict().expect("it was tried");
        assert_eq!(verdict, Verdict { variance_ratio: 0.6, cost_ratio: 2.0, guided: false });
        assert!((verdict.gain() - 1.0 / 1.2).abs() < 1e-12);
    }

    #[test]
    fn cost_is_counted_or_what_the_clock_says() {
        let guided = Counters { shadow_rays: 200, guide_hits: 100, ..counters(3) };
        let cost = |clock, counters: &Counters| {
            judged(clock, &self::counters(2), &[1.0], counters).verdict().expect("it was tried").cost_ratio
        };
        assert!((cost(false, &guided) - (3.0 + 2.0 * SHADOW_COST + GUIDE_COST) / 2.0).abs() < 1e-12);
        assert_eq!(cost(true, &Counters { total: Duration::from_secs(21), ..guided }), 3.0);
    }

    #[test]
    fn before_it_was_tried_there_is_no_verdict() {
        assert!(judged(true, &counters(2), &[], &counters(2)).verdict().is_none());
        let mut worth = judged(true, &counters(2), &[], &counters(2));
        worth.judge(&Noise { samples: 7, ..noise(1.0) }, &counters(2));
        assert!(worth.verdict().is_none());
    }
}
