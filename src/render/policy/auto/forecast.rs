//! What the guide is expected to gain in the rest of a render, by its trials so far.

use super::verdict::Trial;

/// The least factor by which the second and the third trial are expected to gain over the one before: the second has learnt
/// from three times as many samples, and the third is the first with guided roulette. Fitted: where a guide won in the end, the
/// factors were 1.3 to 4 and 1.1 to 2.7, or less than 1 where paths are split at a cost that pays later.
const MIN_FIRST_PROGRESS: [f64; 2] = [2.0, 1.3];

/// Later trials are expected to gain over the one before by the factor that the last did, up to `MAX_PROGRESS`, and less
/// from one to the next: the logarithm of the factor is multiplied by `PROGRESS_DECAY`.
const MAX_PROGRESS: f64 = 2.0;
const PROGRESS_DECAY: f64 = 0.6;

/// The guide after its newest trial. The unit of cost is that of an unguided sample per pixel.
#[derive(Clone, Copy, Debug)]
pub struct GainForecast {
    pub trial: Trial,
    /// How many trials there were.
    pub trials: u32,
    /// Samples per pixel of the newest.
    pub samples: f64,
    /// Cost of one of its samples, learning included.
    pub whole: f64,
    /// Its gain over that of the one before.
    pub progress: f64,
    /// What is left of the budget.
    pub left: f64,
}

/// What is expected of the rest of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Unguided samples that the guided ones are worth, for each that could be had instead.
    pub gain: f64,
    /// Unguided samples per pixel that the next iteration loses.
    pub loss: f64,
}

impl GainForecast {
    /// Goes through the iterations that are left. Each is twice as long as the one before and learnt from; the last takes what is
    /// left and is not.
    pub fn expected(&self) -> Expected {
        let least = MIN_FIRST_PROGRESS.get(self.trials as usize - 1).copied().unwrap_or(1.0);
        let mut progress = self.progress.clamp(least, MAX_PROGRESS);
        let (mut samples, mut variance, mut left) = (self.samples, self.trial.variance_ratio, self.left);
        let (mut unguided_worth, mut loss) = (0.0, None);
        loop {
            samples *= 2.0;
            variance /= progress;
            progress = progress.powf(PROGRESS_DECAY);
            let all = left / self.trial.cost_ratio;
            let last = all < 3.0 * samples;
            let (drawn, cost) = if last { (all, left) } else { (samples, samples * self.whole) };
            unguided_worth += drawn / variance;
            left -= cost;
            loss.get_or_insert((cost - drawn / variance).max(0.0));
            if last || left <= 0.0 {
                break;
            }
        }
        let gain = if self.left > 0.0 {
            unguided_worth / (self.left - left)
        } else {
            1.0 / (variance * self.trial.cost_ratio)
        };
        Expected { gain, loss: loss.unwrap_or(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(trials: u32, variance_ratio: f64, progress: f64, left: f64) -> Expected {
        let trial = Trial { variance_ratio, cost_ratio: 2.0 };
        GainForecast { trial, trials, samples: 8.0, whole: 2.5, progress, left }.expected()
    }

    #[test]
    fn the_last_iteration_is_all_that_is_left_and_nothing_learns_from_it() {
        // 40 samples for 80, each worth 1/0.4 unguided ones
        let Expected { gain, loss } = after(5, 0.4, 1.0, 80.0);
        assert!((gain - 1.25).abs() < 1e-12 && loss == 0.0, "{gain}, {loss}");
        let Expected { gain, loss } = after(5, 0.8, 1.0, 80.0);
        assert!((gain - 0.625).abs() < 1e-12 && (loss - 30.0).abs() < 1e-9, "{gain}, {loss}");
    }

    #[test]
    fn what_is_learnt_from_costs_more_and_progress_fades() {
        // 16 samples with learning, then 40 of the other 80
        let Expected { gain, loss } = after(5, 0.6, 1.0, 120.0);
        assert!((gain - 56.0 / 0.6 / 120.0).abs() < 1e-12 && (loss - (40.0 - 16.0 / 0.6)).abs() < 1e-9);
        let Expected { gain, .. } = after(5, 0.6, 1.2, 120.0);
        let expected = (16.0 * 1.2 + 40.0 * 1.2f64.powf(1.0 + PROGRESS_DECAY)) / 0.6 / 120.0;
        assert!((gain - expected).abs() < 1e-12, "{gain} and not {expected}");
    }

    #[test]
    fn more_is_expected_of_first_trials_and_nothing_beyond_reason() {
        let gain = |trials, progress| after(trials, 1.0, progress, 80.0).gain;
        for (trials, expected) in [(1, 1.0), (2, 0.65), (3, 0.5)] {
            assert!((gain(trials, 0.5) - expected).abs() < 1e-12, "after {trials}");
        }
        assert_eq!(gain(3, 100.0), gain(3, MAX_PROGRESS));
        assert!(after(1, 1.0, 1.0, 0.0).gain.is_finite(), "nothing is left");
    }
}
