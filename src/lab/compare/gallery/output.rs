//! The matrix as tables: matrix.csv and stability.md.

use super::checks::short;
use super::matrix::{Matrix, MatrixCell};
use super::{Check, Colour};
use crate::lab::compare::plan::Plan;
use std::collections::BTreeMap;

/// What stands in for a sentence that nobody wrote.
const UNEXPLAINED: &str = "**UNEXPLAINED**";

/// A row for each cell, with a column for each check's verdict.
pub(crate) fn csv(matrix: &Matrix) -> String {
    let checks: Vec<&str> = Check::NAMES.iter().map(|(name, _)| *name).collect();
    let mut text = format!(
        "scene,method,verdict,{},runs,ratio,ratio_low,ratio_high,relmse_median,relmse_worst,firefly_share,p,\
         guide_bytes,memory,repeatable,why\n",
        checks.join(",")
    );
    for cell in &matrix.cells {
        text += &(csv_row(cell).join(",") + "\n");
    }
    text
}

fn csv_row(cell: &MatrixCell) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
    let colours = cell.findings.iter().map(|f| word(f.colour).to_owned());
    let why: Vec<&str> = cell.failures().map(|f| f.why.as_deref().unwrap_or("unexplained")).collect();
    let head = [quoted(&cell.scene), quoted(&cell.method), word(cell.colour).into()];
    let figures = [
        cell.runs.to_string(),
        number(cell.ratio.value),
        number(cell.ratio.low),
        number(cell.ratio.high),
        number(cell.relmse_median),
        number(cell.relmse_worst),
        number(cell.firefly_share),
        number(cell.p),
        cell.guide_bytes.to_string(),
        cell.memory.to_string(),
        cell.repeatable.map_or(String::new(), |same| same.to_string()),
        quoted(&why.join(" / ")),
    ];
    head.into_iter().chain(colours).chain(figures).collect()
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

fn word(colour: Colour) -> &'static str {
    match colour {
        Colour::Green => "green",
        Colour::Amber => "amber",
        Colour::Red => "red",
    }
}

/// The tables of docs/stability.md.
pub(crate) fn markdown(plan: &Plan, matrix: &Matrix) -> String {
    let b = &matrix.bounds;
    let says = format!(
        "{} runs a cell, {}. Each cell: verdict, efficiency over that of `{}`, worst over median run. ✓: all checks are \
         passed. ~: something is not known, or within its bound but worse than without a guide. **✗**: a check has \
         failed. The tests of bias of all {} cells together raise a false alarm with probability {} (each below \
         p = {:.1e}).",
        plan.runs, matrix.budget, plan.methods[plan.baseline].name, matrix.tested, b.alarm, matrix.level
    );
    format!("{says}\n\n{}\n{}\n{}", table(plan, matrix), totals(plan, matrix), failures(matrix))
}

fn table(plan: &Plan, matrix: &Matrix) -> String {
    let methods: Vec<&str> = plan.methods.iter().map(|m| m.name.as_str()).collect();
    let mut text = format!("| | {} |\n|---{}|\n", methods.join(" | "), "|---".repeat(methods.len()));
    for entry in &plan.scenes {
        let name = entry.name();
        let cell = |method: &&str| matrix.find(&name, method).map_or("–".into(), short_cell);
        let cells: Vec<String> = methods.iter().map(cell).collect();
        text += &format!("| `{name}` | {} |\n", cells.join(" | "));
    }
    text
}

fn short_cell(cell: &MatrixCell) -> String {
    let mark = match (cell.colour, &cell.picture) {
        (Colour::Green, _) => "✓".into(),
        (Colour::Amber, _) => "~".into(),
        (Colour::Red, Some(path)) => format!("[**✗**]({path})"),
        (Colour::Red, None) => "**✗**".into(),
    };
    let ratio = cell.ratio.value.map_or("–".into(), short);
    let spread = cell.relmse_worst.zip(cell.relmse_median).filter(|(_, median)| *median > 0.0);
    format!("{mark} {ratio}, {}", spread.map_or("–".into(), |(worst, median)| short(worst / median)))
}

/// How many cells of each method have each colour.
fn totals(plan: &Plan, matrix: &Matrix) -> String {
    let mut text = "| | ✓ | ~ | ✗ |\n|---|---|---|---|\n".to_owned();
    for method in &plan.methods {
        let count = |colour: Colour| {
            let own = matrix.cells.iter().filter(|c| c.method == method.name && c.colour == colour);
            own.count().to_string()
        };
        let counts = [Colour::Green, Colour::Amber, Colour::Red].map(count);
        text += &format!("| {} | {} |\n", method.name, counts.join(" | "));
    }
    text
}

/// What is red, under the sentence that tells why.
fn failures(matrix: &Matrix) -> String {
    let mut by_why: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for cell in &matrix.cells {
        for finding in cell.failures() {
            let place = format!("{}, {}", cell.scene, cell.method);
            let linked = cell.picture.as_ref().map_or(place.clone(), |path| format!("[{place}]({path})"));
            let line = format!("- {linked}: {}: {}", finding.check.name(), finding.says);
            by_why.entry(finding.why.as_deref().unwrap_or(UNEXPLAINED)).or_default().push(line);
        }
    }
    let group = |(why, lines): (&str, Vec<String>)| format!("{why}\n\n{}\n", lines.join("\n"));
    by_why.into_iter().map(group).collect::<Vec<_>>().join("\n")
}
