//! A scene, a method and a budget: what all of its runs say together.

use super::bias::{self, Bias, ReferenceBlocks};
use super::plan::Plan;
use super::record::Run;
use super::schedule::order;
use super::store::Store;
use crate::stats::{Interval, LogSpread, Summary, log_ratio};
use serde::Serialize;
use std::collections::BTreeMap;

/// Confidence of all intervals.
pub(crate) const CONFIDENCE: f64 = 0.95;

/// A mean over runs of what is never negative, and its interval (Student's t of the logarithm), which needs two of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Mean {
    pub(crate) mean: Option<f64>,
    pub(crate) low: Option<f64>,
    pub(crate) high: Option<f64>,
}

/// A ratio and its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Ratio {
    pub(crate) value: Option<f64>,
    pub(crate) low: Option<f64>,
    pub(crate) high: Option<f64>,
    /// What the interval is made of.
    #[serde(skip)]
    pub(crate) spread: Option<LogSpread>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Cell {
    pub(crate) scene: String,
    pub(crate) method: String,
    pub(crate) budget: String,
    pub(crate) runs: usize,
    pub(crate) wall_seconds: Mean,
    pub(crate) samples: Mean,
    pub(crate) mse: Mean,
    pub(crate) relmse: Mean,
    pub(crate) relmse_trimmed: Mean,
    pub(crate) mape: Mean,
    pub(crate) smape: Mean,
    pub(crate) flip: Mean,
    /// 1 / E[relMSE · seconds]: the reciprocal of the mean of the runs' products.
    pub(crate) efficiency: Mean,
    pub(crate) efficiency_trimmed: Mean,
    /// Efficiency over the baseline's on the same scene and budget.
    pub(crate) ratio: Ratio,
    pub(crate) ratio_trimmed: Ratio,
    pub(crate) relmse_median: Option<f64>,
    pub(crate) relmse_worst: Option<f64>,
    pub(crate) bias: Bias,
    pub(crate) msamples_per_second: Mean,
    pub(crate) mrays_per_second: Mean,
    pub(crate) mean_path_length: Mean,
    pub(crate) zero_share: Mean,
    pub(crate) guide_bytes: Mean,
    pub(crate) guide_states: Mean,
    pub(crate) peak_bytes: Mean,
    pub(crate) non_finite: u64,
}

/// All cells that have runs, scene by scene, budget by budget, in the order of methods. `blocks` are those of the
/// references, by scene, where their variance is known.
pub(crate) fn cells(plan: &Plan, store: &Store, blocks: &BTreeMap<String, ReferenceBlocks>) -> Vec<Cell> {
    let runs: Vec<(usize, usize, usize, &Run)> = order(plan)
        .iter()
        .filter_map(|slot| Some((slot.scene, slot.budget, slot.method, store.find(plan, slot)?)))
        .collect();
    let of = |scene: usize, budget: usize, method: usize| -> Vec<&Run> {
        runs.iter().filter(|r| (r.0, r.1, r.2) == (scene, budget, method)).map(|r| r.3).collect()
    };
    let mut all = Vec::new();
    for scene in 0..plan.scenes.len() {
        let reference = blocks.get(&plan.scenes[scene].name());
        for budget in 0..plan.budgets.len() {
            let baseline = of(scene, budget, plan.baseline);
            for method in 0..plan.methods.len() {
                let own = of(scene, budget, method);
                let is_baseline = method == plan.baseline;
                all.extend(
                    (!own.is_empty()).then(|| Cell::new(&own, (!is_baseline).then_some(&baseline[..]), reference)),
                );
            }
        }
    }
    all
}

impl Cell {
    /// `baseline` is `None` for the baseline itself.
    fn new(runs: &[&Run], baseline: Option<&[&Run]>, reference: Option<&ReferenceBlocks>) -> Cell {
        let mean = |value: fn(&Run) -> f64| Mean::of(&values(runs, value));
        let mut errors = values(runs, |r| r.errors.relmse);
        errors.sort_unstable_by(f64::total_cmp);
        let views: Vec<&[f64]> = runs.iter().map(|r| r.blocks.as_slice()).collect();
        Cell {
            scene: runs[0].scene.clone(),
            method: runs[0].method.clone(),
            budget: runs[0].budget.clone(),
            runs: runs.len(),
            wall_seconds: mean(|r| r.wall_seconds),
            samples: mean(|r| r.samples.into()),
            mse: mean(|r| r.errors.mse),
            relmse: mean(|r| r.errors.relmse),
            relmse_trimmed: mean(|r| r.errors.relmse_trimmed),
            mape: mean(|r| r.errors.mape),
            smape: mean(|r| r.errors.smape),
            flip: mean(|r| r.errors.flip),
            efficiency: mean(cost).reciprocal(),
            efficiency_trimmed: mean(cost_trimmed).reciprocal(),
            ratio: ratio(runs, baseline, cost),
            ratio_trimmed: ratio(runs, baseline, cost_trimmed),
            relmse_median: finite(median(&errors)),
            relmse_worst: errors.last().copied().and_then(finite),
            bias: reference.map_or(Bias::default(), |reference| bias::test(&views, reference)),
            msamples_per_second: mean(|r| 1e-6 * r.paths as f64 / r.wall_seconds),
            mrays_per_second: mean(|r| 1e-6 * (r.rays + r.shadow_rays) as f64 / r.wall_seconds),
            mean_path_length: mean(|r| r.mean_path_length),
            zero_share: mean(|r| r.zero_share),
            guide_bytes: mean(|r| r.guide_bytes as f64),
            guide_states: mean(|r| r.guide_states as f64),
            peak_bytes: mean(|r| r.peak_bytes.map_or(f64::NAN, |b| b as f64)),
            non_finite: runs.iter().map(|r| r.non_finite).sum(),
        }
    }
}

/// What an efficiency is the reciprocal of.
fn cost(run: &Run) -> f64 {
    run.errors.relmse * run.wall_seconds
}

fn cost_trimmed(run: &Run) -> f64 {
    run.errors.relmse_trimmed * run.wall_seconds
}

fn values(runs: &[&Run], value: fn(&Run) -> f64) -> Vec<f64> {
    runs.iter().map(|r| value(r)).collect()
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Of sorted values, at least one.
fn median(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    0.5 * (sorted[(n - 1) / 2] + sorted[n / 2])
}

/// Baseline's cost over the runs' own. Both have seeds of their own, so that they are independent.
fn ratio(runs: &[&Run], baseline: Option<&[&Run]>, cost: fn(&Run) -> f64) -> Ratio {
    let Some(baseline) = baseline else {
        return Ratio { value: Some(1.0), low: Some(1.0), high: Some(1.0), spread: None };
    };
    let (own, base) = (values(runs, cost), values(baseline, cost));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let value = mean(&base) / mean(&own);
    let spread = Summary::of(&base).zip(Summary::of(&own)).and_then(|(b, o)| log_ratio(&b, &o));
    let factor = spread.and_then(|spread| spread.factor(CONFIDENCE));
    let (low, high) = (factor.map(|f| value / f), factor.map(|f| value * f));
    Ratio { value: finite(value).filter(|r| *r > 0.0), low, high, spread }
}

impl Mean {
    pub(crate) fn of(values: &[f64]) -> Mean {
        let mean = finite(values.iter().sum::<f64>() / values.len() as f64);
        let interval = Summary::of(values).and_then(|s| s.confidence_of_positive(CONFIDENCE));
        Mean { mean, low: interval.map(|i| i.low), high: interval.map(|i| i.high) }
    }

    /// Interval and mean of 1/x; an end that is not positive has no reciprocal.
    fn reciprocal(self) -> Mean {
        let invert = |x: Option<f64>| x.filter(|x| *x > 0.0).map(f64::recip);
        Mean { mean: invert(self.mean), low: invert(self.high), high: invert(self.low) }
    }

    /// The interval, where there is one.
    pub(crate) fn interval(&self) -> Option<Interval> {
        Some(Interval { low: self.low?, high: self.high? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::compare::fixtures::{plan, run};
    use crate::lab::compare::schedule::Slot;

    fn with(relmse: f64, seconds: f64) -> Run {
        let slot = Slot { scene: 0, method: 0, budget: 0, run: 0, seed: 0 };
        let mut run = run(&plan(), &slot);
        (run.wall_seconds, run.errors.relmse) = (seconds, relmse);
        run
    }

    #[test]
    fn efficiency_and_ratio_by_hand() {
        let own = [with(0.1, 2.0), with(0.2, 2.0), with(0.3, 2.0)];
        let base = [with(0.4, 4.0), with(0.4, 4.0), with(0.4, 4.0)];
        let (own, base): (Vec<&Run>, Vec<&Run>) = (own.iter().collect(), base.iter().collect());
        let cell = Cell::new(&own, Some(&base), None);
        // mean cost 0.4, standard error 0.2/√3, t(2) = 4.3027: a factor of e^1.24209 to either side
        assert!((cell.efficiency.mean.unwrap() - 2.5).abs() < 1e-12);
        let factor = 1.242_086_f64.exp();
        assert!((cell.efficiency.low.unwrap() * factor - 2.5).abs() < 1e-3, "{:?}", cell.efficiency);
        assert!((cell.efficiency.high.unwrap() / factor - 2.5).abs() < 1e-3, "{:?}", cell.efficiency);
        assert!((cell.ratio.value.unwrap() - 4.0).abs() < 1e-12);
        let (low, high) = (cell.ratio.low.unwrap(), cell.ratio.high.unwrap());
        assert!(low < 4.0 && high > 4.0 && (low * high - 16.0).abs() < 1e-9);
        assert_eq!((cell.relmse_median, cell.relmse_worst), (Some(0.2), Some(0.3)));
        assert_eq!(
            Cell::new(&base, None, None).ratio,
            Ratio { value: Some(1.0), low: Some(1.0), high: Some(1.0), spread: None }
        );
    }

    #[test]
    fn one_run_has_no_interval_and_what_is_not_finite_no_number() {
        let one = with(0.1, 2.0);
        let cell = Cell::new(&[&one], Some(&[&one]), None);
        assert_eq!((cell.relmse.mean, cell.relmse.low), (Some(0.1), None));
        assert_eq!((cell.ratio.value, cell.ratio.low), (Some(1.0), None));
        let broken = with(f64::NAN, 2.0);
        let cell = Cell::new(&[&one, &broken], Some(&[&one, &one]), None);
        assert_eq!((cell.relmse.mean, cell.relmse_worst, cell.ratio.value), (None, None, None));
        let text = serde_json::to_string(&cell).unwrap();
        assert!(text.contains("\"relmse\":{\"mean\":null,\"low\":null,\"high\":null}"), "{text}");
    }
}
