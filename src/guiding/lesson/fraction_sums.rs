//! What transitions say of the share of directions that the BSDF draws.
//!
//! A single render descends the Kullback–Leibler divergence from the integrand to the mixture step by step. Its derivative by the
//! share is a mean over transitions; taken at some shares at once it is known for all shares in between, and where it meets the
//! regularisation is where the steps would lead.

use crate::guiding::bsdf_fraction::BsdfFraction;
use crate::math::fixed::{fixed, value};
use serde::{Deserialize, Serialize};

/// The shares at which the derivative is taken.
const SHARES: [f32; 11] = [0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95, 0.98];

/// Sums over transitions that brought light where a guide was known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FractionSums {
    steps: u64,
    /// Of their contributions: f·cosθ·L over the density that the direction was drawn with.
    contribution: i128,
    /// Of contribution times (p_bsdf − p_guide) over the mixture's density, for each of [`SHARES`].
    slopes: [i128; SHARES.len()],
}

impl FractionSums {
    /// Adds a transition, by its contribution and the densities of BSDF and guide (the latter negative where none was known).
    pub fn add(&mut self, contribution: f32, bsdf_pdf: f32, guide_pdf: f32) {
        if !(contribution > 0.0 && contribution.is_finite() && guide_pdf >= 0.0) {
            return;
        }
        let slope = |s: f32| contribution * ((bsdf_pdf - guide_pdf) / (s * bsdf_pdf + (1.0 - s) * guide_pdf));
        let slopes = SHARES.map(slope);
        if slopes.iter().all(|slope| slope.is_finite()) {
            self.add_sums(&FractionSums { steps: 1, contribution: fixed(contribution), slopes: slopes.map(fixed) });
        }
    }

    pub fn add_sums(&mut self, other: &FractionSums) {
        self.steps = self.steps.saturating_add(other.steps);
        self.contribution = self.contribution.saturating_add(other.contribution);
        self.slopes.iter_mut().zip(other.slopes).for_each(|(sum, more)| *sum = sum.saturating_add(more));
    }

    pub fn is_sound(&self, visits: u64) -> bool {
        self.steps <= visits && self.contribution >= 0
    }

    /// Moves a share to where the divergence is least, by as much as all steps one after the other could. `origin` is the logit of
    /// the share that learning started at.
    pub fn teach(&self, fraction: &mut BsdfFraction, origin: f32) {
        let whole = value(self.contribution);
        if self.steps > 0 && whole > 0.0 {
            let slopes = self.slopes.map(|sum| value(sum) / whole);
            fraction.learn_all(self.steps, whole, origin, |share| between(&slopes, share));
        }
    }
}

/// The mean slope at any share, a straight line between two of those that are known.
fn between(slopes: &[f64; SHARES.len()], share: f64) -> f64 {
    let next = SHARES.partition_point(|&known| f64::from(known) < share).clamp(1, SHARES.len() - 1);
    let (low, high) = (f64::from(SHARES[next - 1]), f64::from(SHARES[next]));
    let at = ((share - low) / (high - low)).clamp(0.0, 1.0);
    slopes[next - 1] + (slopes[next] - slopes[next - 1]) * at
}
