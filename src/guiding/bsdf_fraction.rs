//! The share of directions that the BSDF draws, the guide drawing the others: learnt by gradient descent, region by
//! region (Müller 2019, "Practical Path Guiding in Production", §10.5.2).

use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Adam's step size, how fast its two moments forget, and what keeps a step finite whose moments are 0 (Kingma & Ba
/// 2015). Gradients are in units of their own mean, so the last has no scale.
const RATE: f32 = 0.01;
const FORGET_FIRST: f32 = 0.9;
const FORGET_SECOND: f32 = 0.999;
const EPSILON: f32 = 1e-8;
/// Pull towards the initial fraction.
const REGULARISATION: f32 = 0.01;
/// Halvings of the range of θ: to the last bit of single precision.
const BISECTIONS: usize = 32;
/// Largest |θ|.
const LIMIT: f32 = 20.0;

/// 1 − βⁿ by the number of steps n, for both moments, until it is 1 to the last bit: powers take longer than a step.
static SEEN_FIRST: LazyLock<Vec<f32>> = LazyLock::new(|| seen(FORGET_FIRST, 200));
static SEEN_SECOND: LazyLock<Vec<f32>> = LazyLock::new(|| seen(FORGET_SECOND, 20_000));

fn seen(forget: f32, steps: i32) -> Vec<f32> {
    (0..=steps).map(|steps| 1.0 - forget.powi(steps)).collect()
}

#[inline]
fn bias_correction(seen: &[f32], steps: u32) -> f32 {
    seen[(steps as usize).min(seen.len() - 1)]
}

/// The fraction s = 1/(1 + e^−θ) of directions that are drawn from the BSDF. It descends the Kullback–Leibler
/// divergence from the integrand's own (normalised) density to the mixture s·p_bsdf + (1 − s)·p_guide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BsdfFraction {
    theta: f32,
    /// Running moments of the gradient.
    first: f32,
    second: f32,
    /// Mean contribution of all steps.
    mean: f32,
    steps: u32,
}

impl BsdfFraction {
    /// Starts at a given [`logit`].
    pub fn at(origin: f32) -> BsdfFraction {
        BsdfFraction { theta: origin, ..BsdfFraction::default() }
    }

    /// The fraction now.
    #[inline]
    pub fn value(&self) -> f32 {
        1.0 / (1.0 + (-self.theta).exp())
    }

    /// Whether these are numbers that learning can have come to.
    pub fn is_sound(&self) -> bool {
        let amounts = [self.second, self.mean].iter().all(|v| v.is_finite() && *v >= 0.0);
        self.theta.abs() <= LIMIT && self.first.is_finite() && amounts && (self.mean > 0.0 || self.steps == 0)
    }

    /// One step for a direction whose contribution (f·cosθ·L over the density it was drawn with) is positive, where a
    /// guide was known (else its density is negative). `origin` is the [`logit`] of the fraction that it started at.
    ///
    /// The gradient is weighted by the contribution over the mean contribution: that is the normalised integrand,
    /// so the light's unit has no say in the balance with the regularisation, nor in Adam's.
    #[inline]
    pub fn learn(&mut self, contribution: f32, bsdf_pdf: f32, guide_pdf: f32, origin: f32) {
        let s = self.value();
        let mixture = s * bsdf_pdf + (1.0 - s) * guide_pdf;
        if !(contribution > 0.0 && contribution.is_finite() && mixture > 0.0 && guide_pdf >= 0.0) {
            return;
        }
        let slope = s * (1.0 - s) * ((bsdf_pdf - guide_pdf) / mixture);
        if !slope.is_finite() {
            return;
        }
        self.steps = self.steps.saturating_add(1);
        self.mean += (contribution - self.mean) / self.steps as f32;
        self.step(REGULARISATION * (self.theta - origin) - contribution / self.mean * slope);
    }

    /// Learns from so many directions at once, whose contributions have the sum `whole`: goes to where the divergence and the
    /// regularisation balance, by as much as so many steps could. `slope` is the mean of (p_bsdf − p_guide) over the mixture's
    /// density at any share of the BSDF, weighed by contributions.
    pub fn learn_all(&mut self, steps: u64, whole: f64, origin: f32, slope: impl Fn(f64) -> f64) {
        let gradient = |theta: f64| {
            let share = 1.0 / (1.0 + (-theta).exp());
            f64::from(REGULARISATION) * (theta - f64::from(origin)) - share * (1.0 - share) * slope(share)
        };
        let (limit, far) = (f64::from(LIMIT), f64::from(RATE) * steps as f64);
        let [mut low, mut high] = [-far, far].map(|by| (f64::from(self.theta) + by).clamp(-limit, limit));
        // the gradient rises from below 0 to above it
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if gradient(middle) > 0.0 { high = middle } else { low = middle }
        }
        let before = f64::from(self.mean) * f64::from(self.steps);
        let all = f64::from(self.steps) + steps as f64;
        *self = BsdfFraction {
            theta: (0.5 * (low + high)) as f32,
            first: 0.0,
            second: 0.0,
            mean: ((before + whole) / all).clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32,
            steps: u64::from(self.steps).saturating_add(steps).min(u32::MAX.into()) as u32,
        };
    }

    /// One step of Adam.
    #[inline]
    fn step(&mut self, gradient: f32) {
        self.first += (1.0 - FORGET_FIRST) * (gradient - self.first);
        self.second += (1.0 - FORGET_SECOND) * (gradient * gradient - self.second);
        let first = self.first / bias_correction(&SEEN_FIRST, self.steps);
        let second = self.second / bias_correction(&SEEN_SECOND, self.steps);
        self.theta = (self.theta - RATE * first / (second.sqrt() + EPSILON)).clamp(-LIMIT, LIMIT);
    }
}

/// θ of a fraction in [0, 1].
pub fn logit(fraction: f32) -> f32 {
    (fraction / (1.0 - fraction)).ln().clamp(-LIMIT, LIMIT)
}
