//! Iterations that are judged together.

use super::cost::PathCost;

/// Sums over iterations, weighted by their samples; or the means of these.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// Samples per pixel.
    pub samples: u32,
    /// Of one sample, pixel by pixel.
    pub variances: Vec<f64>,
    /// Of one sample.
    pub cost: PathCost,
}

impl Gathered {
    /// Adds an iteration with the `variances` and the `cost` of one of its samples.
    pub fn add(&mut self, variances: &[f64], samples: u32, cost: PathCost) {
        let weight = f64::from(samples);
        self.samples += samples;
        self.variances.resize(variances.len(), 0.0);
        self.variances.iter_mut().zip(variances).for_each(|(sum, variance)| *sum += weight * variance);
        self.cost.tracing += weight * cost.tracing;
        self.cost.whole += weight * cost.whole;
    }

    /// The means.
    pub fn mean(mut self) -> Gathered {
        let share = 1.0 / f64::from(self.samples.max(1));
        self.variances.iter_mut().for_each(|sum| *sum *= share);
        self.cost = PathCost { tracing: share * self.cost.tracing, whole: share * self.cost.whole };
        self
    }
}
