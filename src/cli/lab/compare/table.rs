//! The table at the end of a comparison.

use crate::lab::compare::bias::ALARM;
use crate::lab::compare::cell::{Cell, Mean, Ratio};
use crate::lab::compare::overall::Overall;
use crate::lab::compare::plan::Plan;
use crate::lab::compare::record::{ReferenceRecord, Source};
use crate::lab::compare::store::Store;

const HEADINGS: [&str; 11] = [
    "method",
    "runs",
    "s",
    "spp",
    "relMSE [95 %]",
    "without worst 0.1 %",
    "FLIP",
    "efficiency × [95 %]",
    "bias p",
    "guide MiB",
    "segments",
];

/// The lines of it: the cells, scene by scene and budget by budget, and what they were compared with.
pub(crate) fn lines(plan: &Plan, store: &Store, cells: &[Cell], overall: &[Overall]) -> Vec<String> {
    let mut lines = Vec::new();
    for entry in &plan.scenes {
        let scene = entry.name();
        for budget in &plan.budgets {
            let here: Vec<&Cell> = cells.iter().filter(|c| c.scene == scene && c.budget == budget.name()).collect();
            if !here.is_empty() {
                lines.push(format!("{scene}, {}", budget.name()));
                lines.extend(aligned(&here.iter().map(|c| row(c)).collect::<Vec<_>>()));
                lines.push(String::new());
            }
        }
        if let Some(reference) = store.reference(&scene) {
            lines.push(format!("{scene}: {}", told(reference)));
        }
    }
    lines.extend(overall.iter().filter(|o| o.ratio.scenes > 1).map(over_scenes));
    let baseline = &plan.methods[plan.baseline].name;
    lines.push(format!("efficiency: 1/(relMSE × seconds), that of {baseline} = 1; bias: p below {ALARM} is marked *"));
    lines
}

/// The geometric mean, and how much scenes differ.
fn over_scenes(o: &Overall) -> String {
    let mean = &o.ratio;
    let [least, most] = [&mean.least, &mean.most]
        .map(|end| end.as_ref().map_or("-".into(), |e| format!("{:.2} ({})", e.value, e.scene)));
    let spread = mean.spread.map_or("-".into(), |s| format!("{s:.2}"));
    let missing =
        if mean.left_out.is_empty() { String::new() } else { format!("; without {}", mean.left_out.join(", ")) };
    format!(
        "{}, {}: geometric mean of the efficiency over {} scenes {}; from scene to scene a factor of {spread}, from {least} to \
         {most}{missing}",
        o.budget,
        o.method,
        mean.scenes,
        ratio(mean.ratio)
    )
}

fn row(cell: &Cell) -> [String; 11] {
    let number = |m: Mean, digits: usize| m.mean.map_or("-".into(), |x| format!("{x:.digits$}"));
    let mark = if cell.bias.biased == Some(true) { " *" } else { "" };
    [
        cell.method.clone(),
        cell.runs.to_string(),
        number(cell.wall_seconds, 2),
        number(cell.samples, 0),
        scientific(cell.relmse),
        scientific(cell.relmse_trimmed),
        number(cell.flip, 4),
        ratio(cell.ratio),
        cell.bias.p.map_or("-".into(), |p| format!("{p:.3}{mark}")),
        number(Mean { mean: cell.guide_bytes.mean.map(|b| b / 1048576.0), ..Mean::default() }, 2),
        number(cell.mean_path_length, 2),
    ]
}

fn scientific(m: Mean) -> String {
    match (m.mean, m.interval()) {
        (Some(mean), Some(i)) => format!("{mean:.3e} [{:.2e}, {:.2e}]", i.low, i.high),
        (Some(mean), None) => format!("{mean:.3e}"),
        (None, _) => "-".into(),
    }
}

fn ratio(r: Ratio) -> String {
    match (r.value, r.low.zip(r.high)) {
        (Some(value), Some((low, high))) if low < high => format!("{value:.2} [{low:.2}, {high:.2}]"),
        (Some(value), _) => format!("{value:.2}"),
        (None, _) => "-".into(),
    }
}

/// Columns as wide as they need to be; the first is flush left.
fn aligned(rows: &[[String; 11]]) -> Vec<String> {
    let heading = HEADINGS.map(String::from);
    let all: Vec<&[String; 11]> = std::iter::once(&heading).chain(rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..HEADINGS.len()).map(width).collect();
    let cell = |(k, text): (usize, &String)| match k {
        0 => format!("  {text:<w$}", w = widths[k]),
        _ => format!("{text:>w$}", w = widths[k]),
    };
    all.iter().map(|row| row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ")).collect()
}

fn told(reference: &ReferenceRecord) -> String {
    let origin = match (reference.source, reference.samples, reference.wall_seconds) {
        (Source::Made, Some(samples), Some(seconds)) => {
            format!("reference of {samples} spp, unguided, rendered in {seconds:.1} s")
        }
        _ => format!("reference {}", reference.path),
    };
    match reference.relmse_noise {
        Some(noise) => format!("{origin}; its own noise, a relMSE of {noise:.2e}, is taken off MSE and relMSE"),
        None => format!("{origin}; its noise is not known, counts as error, and bias cannot be tested"),
    }
}
