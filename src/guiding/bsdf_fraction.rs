//! How many directions the BSDF draws, and how many the guide: learnt by gradient descent (Müller 2019).

use crate::math::is_amount;
use serde::{Deserialize, Serialize};

/// Adam's step size, and how fast its two moments forget (Kingma & Ba 2015).
const RATE: f64 = 0.01;
const FORGET: [f64; 2] = [0.9, 0.999];
/// Keeps a step finite whose moments are 0. Gradients are in units of their own mean, so this has no scale.
const EPSILON: f64 = 1e-8;
/// Pull towards the initial fraction.
const REGULARISATION: f64 = 0.01;
/// Largest |θ|.
const LIMIT: f64 = 20.0;

/// The fraction s = 1/(1 + e^−θ) of directions that are drawn from the BSDF. It descends the Kullback–Leibler
/// divergence from the integrand's own (normalised) density to the mixture s·p_bsdf + (1 − s)·p_guide.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Fraction {
    start: f64,
    theta: f64,
    moments: [f64; 2],
    /// FORGET to the power of the steps taken.
    powers: [f64; 2],
    /// Mean contribution, and of how many.
    mean: f64,
    count: u32,
}

impl Fraction {
    /// Starts at `fraction` in [0, 1].
    pub fn new(fraction: f32) -> Fraction {
        let fraction = fraction as f64;
        let start = (fraction / (1.0 - fraction)).ln().clamp(-LIMIT, LIMIT);
        Fraction { start, theta: start, moments: [0.0; 2], powers: [1.0; 2], mean: 0.0, count: 0 }
    }

    /// Whether these are numbers that learning can have come to.
    pub fn is_sound(&self) -> bool {
        let shares = |values: [f64; 2]| values.iter().all(|value| (0.0..=1.0).contains(value));
        let logits = [self.start, self.theta].iter().all(|logit| logit.abs() <= LIMIT);
        let moments = self.moments[0].is_finite() && is_amount(self.moments[1]);
        logits && moments && shares(self.powers) && is_amount(self.mean) && (self.mean > 0.0 || self.count == 0)
    }

    /// The fraction now.
    pub fn value(&self) -> f64 {
        1.0 / (1.0 + (-self.theta).exp())
    }

    /// One step for a direction whose contribution (f·cosθ·L over the density it was drawn with) is positive, and
    /// which the BSDF and the guide draw with the given densities.
    ///
    /// The gradient is weighted by the contribution over the mean contribution: that is the normalised integrand,
    /// so the light's unit has no say in the balance with the regularisation, nor in Adam's.
    pub fn learn(&mut self, contribution: f64, bsdf_pdf: f64, guide_pdf: f64) {
        self.count = self.count.saturating_add(1);
        self.mean += (contribution - self.mean) / self.count as f64;
        let s = self.value();
        let mixture = s * bsdf_pdf + (1.0 - s) * guide_pdf;
        if mixture <= 0.0 {
            return;
        }
        let slope = s * (1.0 - s) * ((bsdf_pdf - guide_pdf) / mixture);
        self.step(REGULARISATION * (self.theta - self.start) - contribution / self.mean * slope);
    }

    fn step(&mut self, gradient: f64) {
        for (i, observed) in [gradient, gradient * gradient].into_iter().enumerate() {
            self.moments[i] += (1.0 - FORGET[i]) * (observed - self.moments[i]);
            self.powers[i] *= FORGET[i];
        }
        let first = self.moments[0] / (1.0 - self.powers[0]);
        let second = self.moments[1] / (1.0 - self.powers[1]);
        self.theta = (self.theta - RATE * first / (second.sqrt() + EPSILON)).clamp(-LIMIT, LIMIT);
    }
}
