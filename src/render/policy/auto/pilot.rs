//! The pilot: unguided samples before anything is learnt. They tell what a sample costs, and so how many the budget holds;
//! how samples vary; and how much of that comes from light that bounced, all that a better choice of directions can help
//! with.

use super::super::super::noise::Noise;
use super::super::super::training;
use super::cost::CostMeter;
use super::judged::relative_variance;
use super::verdict::Reason;
use crate::integrator::Counters;

/// Share of the variance that light has which bounced, below which no guide pays: if it found all of that light without
/// noise, the rest would vary as before, and no guide measured cost less than 1.3 times as much as none.
pub const MIN_BOUNCED_SHARE: f64 = 1.0 - 1.0 / 1.3;

/// The least budget, in samples per pixel and in camera paths, in which a guide learns soon enough to pay. The pilot, the
/// first lesson and two trials take what some twenty unguided samples do. Fitted: with 0.2 million paths every guide lost on
/// rooms that it rendered three times as well with more.
pub const MIN_BUDGET_SAMPLES: f64 = 32.0;
/// The same of samples where the guide is trained on a small picture: pilot, training and a trial take what some five do.
pub const MIN_TRAINED_SAMPLES: f64 = 16.0;
pub const MIN_BUDGET_PATHS: f64 = 8e5;

/// Length of the pilot: camera paths at first, its share of the budget, and samples per pixel at least and at most. Few samples
/// miss light that few paths find, and then say too little of the variance: where it was 50, three samples told 15
/// to 83.
const PILOT_PATHS: u64 = 1 << 15;
const PILOT_SHARE: f64 = 0.02;
const PILOT_SAMPLES: (u64, u64) = (2, 16);

/// What was seen without a guide.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Baseline {
    /// Variance of the luminance of one sample by itself, pixel by pixel; empty until the guide has learnt.
    pub spreads: Vec<f64>,
    /// Samples per pixel behind it.
    pub samples: u32,
    /// Of tracing one camera path.
    pub cost: f64,
    /// Relative variance of one sample: of all light, and of the light that bounced.
    pub variance: f64,
    pub bounced: f64,
    /// The share of bounced light in the variance.
    pub bounced_share: f64,
}

/// A pilot under way.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Pilot {
    /// Costs of a camera path, pass by pass.
    costs: Vec<f64>,
}

/// Samples per pixel with which the pilot of a picture of `pixels` pixels begins.
pub fn first_samples(pixels: u64) -> u32 {
    let (least, most) = PILOT_SAMPLES;
    PILOT_PATHS.div_ceil(pixels).clamp(least, most) as u32
}

/// Samples per pixel that the pilot still takes after `taken`, where the budget holds `budget`.
pub fn more_samples(budget: f64, taken: u32) -> Option<u32> {
    let wanted = (PILOT_SHARE * budget).min(PILOT_SAMPLES.1 as f64) as u32;
    wanted.checked_sub(taken).filter(|&more| more > 0)
}

impl Pilot {
    pub fn add_passes(&mut self, meter: CostMeter, passes: &[Counters]) {
        self.costs.extend(passes.iter().map(|pass| meter.tracing_path(pass)));
    }

    /// Of a camera path. The first of several passes only warms caches.
    pub fn cost(&self) -> f64 {
        let warm = if self.costs.len() > 1 { &self.costs[1..] } else { &self.costs };
        warm.iter().sum::<f64>() / warm.len() as f64
    }

    /// What the pilot has found. `bounced` are Σ x and Σ x² of the luminance of bounced light, pixel by pixel.
    pub fn baseline(&self, noise: &Noise, bounced: &[[f32; 2]]) -> Baseline {
        let n = noise.samples as f64;
        let variance = |&[sum, squares]: &[f32; 2]| ((squares as f64 - (sum as f64).powi(2) / n) / (n - 1.0)).max(0.0);
        let bounced: Vec<f64> = bounced.iter().map(variance).collect();
        let bounced = relative_variance(noise, &bounced);
        let variance = relative_variance(noise, &noise.variances());
        let bounced_share = if variance > 0.0 { bounced / variance } else { 0.0 };
        Baseline { spreads: Vec::new(), samples: noise.samples, cost: self.cost(), variance, bounced, bounced_share }
    }
}

impl Baseline {
    /// Whether it makes sense to learn, in a picture of `pixels` pixels with a budget of so many unguided samples each.
    pub fn reason(&self, budget: f64, pixels: u64) -> Reason {
        let least = if training::samples(pixels, budget) > 0 { MIN_TRAINED_SAMPLES } else { MIN_BUDGET_SAMPLES };
        if self.bounced_share < MIN_BOUNCED_SHARE {
            Reason::Calm
        } else if budget < least || budget * (pixels as f64) < MIN_BUDGET_PATHS {
            Reason::Short
        } else {
            Reason::Promising
        }
    }
}
