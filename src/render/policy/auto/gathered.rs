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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longer_iterations_count_for_more() {
        let mut gathered = Gathered::default();
        gathered.add(&[1.0, 4.0], 1, PathCost { tracing: 5.0, whole: 6.0 });
        gathered.add(&[4.0, 1.0], 2, PathCost { tracing: 2.0, whole: 3.0 });
        let Gathered { samples, variances, cost } = gathered.mean();
        assert_eq!((samples, variances), (3, vec![3.0, 2.0]));
        assert_eq!((cost.tracing, cost.whole), (3.0, 4.0));
    }
}
