//! What a comparison says over all of its scenes: geometric means of the ratios to the baseline.
//!
//! Two questions have two answers. How sure is the mean over *these* scenes: its interval, from the spread of the runs alone.
//! How much do scenes differ: the geometric standard deviation of their ratios, and the scenes at the ends.

use super::cell::{CONFIDENCE, Cell, Ratio};
use super::plan::Plan;
use crate::stats::LogSpread;
use serde::Serialize;

/// A method at a budget, over all scenes that have a ratio.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Overall {
    pub(crate) method: String,
    pub(crate) budget: String,
    /// By relMSE of all pixels, and without the worst 0.1 %.
    pub(crate) ratio: GeometricMean,
    pub(crate) ratio_trimmed: GeometricMean,
}

/// The geometric mean of ratios, one for each scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct GeometricMean {
    #[serde(flatten)]
    pub(crate) ratio: Ratio,
    /// Scenes in it, and the names of those that have no ratio.
    pub(crate) scenes: usize,
    pub(crate) left_out: Vec<String>,
    /// The scenes' geometric standard deviation, a factor of at least 1; of two scenes or more. The runs' own noise is in it.
    pub(crate) spread: Option<f64>,
    pub(crate) least: Option<Extreme>,
    pub(crate) most: Option<Extreme>,
}

/// A scene and its ratio.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Extreme {
    pub(crate) scene: String,
    pub(crate) value: f64,
}

/// Budget by budget, in the order of methods, without the baseline.
pub(crate) fn overall(plan: &Plan, cells: &[Cell]) -> Vec<Overall> {
    let others = |k: &usize| *k != plan.baseline;
    let mut all = Vec::new();
    for budget in plan.budgets.iter().map(|budget| budget.name()) {
        for method in (0..plan.methods.len()).filter(others).map(|k| plan.methods[k].name.clone()) {
            let own: Vec<&Cell> = cells.iter().filter(|c| c.method == method && c.budget == budget).collect();
            if !own.is_empty() {
                let mean = |ratio: fn(&Cell) -> Ratio| {
                    geometric_mean(&own.iter().map(|c| (c.scene.as_str(), ratio(c))).collect::<Vec<_>>())
                };
                let (ratio, ratio_trimmed) = (mean(|c| c.ratio), mean(|c| c.ratio_trimmed));
                all.push(Overall { budget: budget.clone(), method, ratio, ratio_trimmed });
            }
        }
    }
    all
}

fn geometric_mean(ratios: &[(&str, Ratio)]) -> GeometricMean {
    let known: Vec<(&str, f64, Option<LogSpread>)> =
        ratios.iter().filter_map(|(scene, r)| Some((*scene, r.value?, r.spread))).collect();
    let missing = ratios.iter().filter(|(_, r)| r.value.is_none()).map(|(scene, _)| scene.to_string());
    let n = known.len() as f64;
    let logs: Vec<f64> = known.iter().map(|(_, value, _)| value.ln()).collect();
    let mean = logs.iter().sum::<f64>() / n;
    let value = mean.exp();
    // scenes are independent: the variance of a mean is the sum of the variances over n²
    let spreads: Option<Vec<LogSpread>> = known.iter().map(|(_, _, spread)| *spread).collect();
    let spread = spreads.filter(|s| !s.is_empty()).map(|s| LogSpread::sum(&s).times(1.0 / (n * n)));
    let factor = spread.and_then(|spread| spread.factor(CONFIDENCE));
    let extreme = |&(scene, value, _): &(&str, f64, Option<LogSpread>)| Extreme { scene: scene.into(), value };
    GeometricMean {
        ratio: Ratio {
            value: value.is_finite().then_some(value),
            low: factor.map(|f| value / f),
            high: factor.map(|f| value * f),
            spread,
        },
        scenes: known.len(),
        left_out: missing.collect(),
        spread: (known.len() > 1).then(|| deviation(&logs, mean).exp()),
        least: known.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(extreme),
        most: known.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(extreme),
    }
}

fn deviation(values: &[f64], mean: f64) -> f64 {
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(value: f64, variance: f64) -> Ratio {
        Ratio { value: Some(value), low: None, high: None, spread: Some(LogSpread { variance, freedom: 8.0 }) }
    }

    #[test]
    fn three_scenes_by_hand() {
        let found = geometric_mean(&[("a", known(1.0, 0.01)), ("b", known(4.0, 0.01)), ("c", Ratio::default())]);
        // √(1·4); variance (0.01 + 0.01)/4, 16 degrees of freedom, t = 2.1199: half width 0.149900
        assert!((found.ratio.value.unwrap() - 2.0).abs() < 1e-12);
        assert!((found.ratio.high.unwrap() / 2.0 - 0.149_900_f64.exp()).abs() < 1e-4, "{found:?}");
        assert!((found.ratio.low.unwrap() * found.ratio.high.unwrap() - 4.0).abs() < 1e-9);
        // the logarithms differ from their mean by ln 2 each: √(2 ln²2 / 1)
        assert!((found.spread.unwrap() - (2f64.sqrt() * 2f64.ln()).exp()).abs() < 1e-9);
        assert_eq!((found.scenes, &found.left_out[..]), (2, &["c".to_string()][..]));
        assert_eq!((found.least.unwrap().scene, found.most.unwrap().scene), ("a".into(), "b".into()));
    }

    #[test]
    fn nothing_known_is_no_mean_and_a_scene_of_one_run_no_interval() {
        assert_eq!(geometric_mean(&[("a", Ratio::default())]).ratio.value, None);
        let found = geometric_mean(&[("a", known(2.0, 0.01)), ("b", Ratio { value: Some(8.0), ..Ratio::default() })]);
        assert_eq!((found.ratio.value.map(f64::round), found.ratio.low), (Some(4.0), None));
    }
}
