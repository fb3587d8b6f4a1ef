//! The verdicts on a cell, one by one.

use super::{Bounds, Check, Colour};
use crate::lab::compare::cell::{CONFIDENCE, Cell, Mean};
use crate::lab::compare::record::Run;
use crate::stats::{Summary, ratio_interval};
use serde::Serialize;

/// What is known of a cell.
pub(crate) struct Evidence<'a> {
    pub(crate) runs: &'a [&'a Run],
    pub(crate) cell: &'a Cell,
    /// Of the method that is compared with; `None` for itself.
    pub(crate) baseline: Option<(&'a [&'a Run], &'a Cell)>,
    /// Runs that there are to be.
    pub(crate) planned: usize,
    /// Bytes that the guide may take.
    pub(crate) memory: u64,
    /// Whether a render and its repetition with one thread were equal; `None` where that was not tried.
    pub(crate) repeatable: Option<bool>,
    /// p-value below which a cell is biased.
    pub(crate) level: f64,
    pub(crate) bounds: &'a Bounds,
}

/// What a check found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Finding {
    pub(crate) check: Check,
    pub(crate) colour: Colour,
    pub(crate) says: String,
    /// Of a red one: why, as the comparison's file has it.
    pub(crate) why: Option<String>,
}

/// A check: its verdict, and the figures behind it in words.
type Judge = fn(&Evidence) -> (Colour, String);

/// All checks, in the order of [`Check::NAMES`].
pub(crate) fn findings(e: &Evidence) -> Vec<Finding> {
    let checks: [Judge; 7] = [unbiased, finite, efficiency, fireflies, explosion, memory, repeatable];
    let found = checks.iter().zip(Check::NAMES);
    found
        .map(|(check, (_, name))| {
            let (colour, says) = check(e);
            Finding { check: name, colour, says, why: None }
        })
        .collect()
}

/// Pictures without any error need no test; others cannot do without one.
fn unbiased(e: &Evidence) -> (Colour, String) {
    let bias = &e.cell.bias;
    match bias.p {
        Some(p) if p < e.level => {
            let side = if bias.z.is_some_and(|z| z < 0.0) { "darker" } else { "brighter" };
            (Colour::Red, format!("{side} than the reference, p = {p:.1e}, below {:.1e}", e.level))
        }
        Some(p) => (Colour::Green, format!("p = {p:.2}")),
        None if faultless(e.runs) => (Colour::Green, "equal to the reference".into()),
        None => (Colour::Amber, "not tested: too few runs, or a reference without variance".into()),
    }
}

fn finite(e: &Evidence) -> (Colour, String) {
    let broken: u64 = e.runs.iter().map(|r| r.broken_pixels).sum();
    let undefined = e.runs.iter().filter(|r| !r.errors.relmse.is_finite()).count();
    match (e.cell.non_finite, broken, undefined) {
        (0, 0, 0) if e.runs.len() < e.planned => {
            (Colour::Amber, format!("{} of {} runs are there", e.runs.len(), e.planned))
        }
        (0, 0, 0) => (Colour::Green, "all values".into()),
        (samples, pixels, runs) => {
            let said = format!("{samples} samples and {pixels} pixels not finite, {runs} runs without an error figure");
            (Colour::Red, said)
        }
    }
}

fn efficiency(e: &Evidence) -> (Colour, String) {
    let Some((base, _)) = e.baseline else { return (Colour::Green, "what others are compared with".into()) };
    let (ratio, least) = (&e.cell.ratio, 1.0 / e.bounds.slower);
    match (ratio.value, ratio.low.zip(ratio.high)) {
        (Some(value), Some((low, high))) => {
            let colour = match (value, high) {
                (_, high) if high < least => Colour::Red,
                (value, high) if high < 1.0 || value < least => Colour::Amber,
                _ => Colour::Green,
            };
            (colour, format!("{} times the baseline's [{}, {}]", short(value), short(low), short(high)))
        }
        (Some(value), None) => (Colour::Amber, format!("{} times the baseline's, without an interval", short(value))),
        (None, _) if faultless(e.runs) && faultless(base) => {
            let speed = Summary::of(&pace(base)).zip(Summary::of(&pace(e.runs)));
            let Some(i) = speed.and_then(|(base, own)| ratio_interval(&base, &own, CONFIDENCE)) else {
                return (Colour::Amber, "no error in either; too few runs to compare their speeds".into());
            };
            let colour = if i.high < least { Colour::Red } else { Colour::Green };
            (colour, format!("no error in either, [{}, {}] times the samples per second", short(i.low), short(i.high)))
        }
        (None, _) => (Colour::Amber, "not known: the error is no larger than the reference's noise".into()),
    }
}

/// Red where that is certain, and unguided pictures do not have so much of their error in so few pixels, and less in sum.
fn fireflies(e: &Evidence) -> (Colour, String) {
    if faultless(e.runs) {
        return (Colour::Green, "no error".into());
    }
    let share = worst_pixels(e.runs);
    let Some(mean) = share.mean else { return (Colour::Amber, "not known".into()) };
    let elsewhere = e.baseline.is_some_and(|(runs, cell)| {
        let few = worst_pixels(runs).mean.is_some_and(|share| share <= e.bounds.fireflies);
        few && in_worst(e.cell) > in_worst(cell)
    });
    let colour = match (mean > e.bounds.fireflies, share.low) {
        (true, Some(low)) if low > e.bounds.fireflies && elsewhere => Colour::Red,
        (true, _) => Colour::Amber,
        (false, _) => Colour::Green,
    };
    let ends = share.interval().map_or(String::new(), |i| format!(" [{:.0}, {:.0}]", 100.0 * i.low, 100.0 * i.high));
    (colour, format!("{:.0} %{ends} of a run's error in the worst 0.1 % of the pixels", 100.0 * mean))
}

/// Share of a run's relMSE in its worst pixels; undefined where a run's error is no larger than the reference's noise.
pub(crate) fn worst_pixels(runs: &[&Run]) -> Mean {
    let share =
        |r: &&Run| if r.errors.relmse > 0.0 { 1.0 - r.errors.relmse_trimmed / r.errors.relmse } else { f64::NAN };
    Mean::of(&runs.iter().map(share).collect::<Vec<_>>())
}

/// relMSE in the worst pixels.
fn in_worst(cell: &Cell) -> Option<f64> {
    Some(cell.relmse.mean? - cell.relmse_trimmed.mean?)
}

/// Red where unguided runs do not, and none of them is as bad.
fn explosion(e: &Evidence) -> (Colour, String) {
    if faultless(e.runs) {
        return (Colour::Green, "no error".into());
    }
    let Some((median, worst)) = spread(e.cell) else { return (Colour::Amber, "not known".into()) };
    let explodes = |(median, worst): (f64, f64)| worst > e.bounds.explosion * median;
    let base = e.baseline.and_then(|(_, cell)| spread(cell));
    let colour = match explodes((median, worst)) {
        true if base.is_some_and(|base| !explodes(base) && worst > base.1) => Colour::Red,
        true => Colour::Amber,
        false => Colour::Green,
    };
    (colour, format!("the worst of {} runs is {} times the median one", e.runs.len(), short(worst / median)))
}

fn spread(cell: &Cell) -> Option<(f64, f64)> {
    cell.relmse_median.filter(|median| *median > 0.0).zip(cell.relmse_worst)
}

fn memory(e: &Evidence) -> (Colour, String) {
    let most = largest_guide(e.runs);
    let colour = if most <= e.memory { Colour::Green } else { Colour::Red };
    (colour, format!("{most} of {} bytes", e.memory))
}

/// Of all runs.
pub(crate) fn largest_guide(runs: &[&Run]) -> u64 {
    runs.iter().map(|r| r.guide_bytes).max().unwrap_or(0)
}

fn repeatable(e: &Evidence) -> (Colour, String) {
    let spp = e.bounds.repeat;
    match e.repeatable {
        Some(true) => (Colour::Green, format!("equal to the last bit, by all threads and by one, {spp} spp")),
        Some(false) => (Colour::Red, format!("two renders of {spp} spp with the same seed differ")),
        None => (Colour::Amber, "not tried".into()),
    }
}

/// Whether no run has any error at all.
fn faultless(runs: &[&Run]) -> bool {
    runs.iter().all(|r| r.errors.mse == 0.0)
}

/// Seconds for a sample per pixel, run by run.
fn pace(runs: &[&Run]) -> Vec<f64> {
    runs.iter().map(|r| r.wall_seconds / f64::from(r.samples)).collect()
}

/// Three digits.
pub(crate) fn short(x: f64) -> String {
    match x.abs() {
        size if size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.1}"),
        size if size >= 0.01 => format!("{x:.2}"),
        _ => format!("{x:.1e}"),
    }
}
