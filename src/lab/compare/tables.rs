//! The figures of a comparison as tables: cells.csv and overall.csv for programs, table.tex for papers.

use super::cell::{Cell, Mean, Ratio};
use super::overall::{GeometricMean, Overall};
use super::plan::Plan;
use super::results::quoted;
use crate::draw::short;

/// The means of a cell, by name.
type Column = (&'static str, fn(&Cell) -> Mean);

const MEANS: [Column; 17] = [
    ("wall_seconds", |c| c.wall_seconds),
    ("samples", |c| c.samples),
    ("mse", |c| c.mse),
    ("relmse", |c| c.relmse),
    ("relmse_trimmed", |c| c.relmse_trimmed),
    ("mape", |c| c.mape),
    ("smape", |c| c.smape),
    ("flip", |c| c.flip),
    ("efficiency", |c| c.efficiency),
    ("efficiency_trimmed", |c| c.efficiency_trimmed),
    ("msamples_per_second", |c| c.msamples_per_second),
    ("mrays_per_second", |c| c.mrays_per_second),
    ("mean_path_length", |c| c.mean_path_length),
    ("zero_share", |c| c.zero_share),
    ("guide_bytes", |c| c.guide_bytes),
    ("guide_states", |c| c.guide_states),
    ("peak_bytes", |c| c.peak_bytes),
];

/// A row for each scene, method and budget; each figure with the ends of its interval. What is not known is empty.
pub(crate) fn cells_csv(cells: &[Cell]) -> String {
    let ends = |name: &str| format!("{name},{name}_low,{name}_high");
    let heads: Vec<String> = MEANS.iter().map(|(name, _)| *name).chain(["ratio", "ratio_trimmed"]).map(ends).collect();
    let mut text =
        format!("scene,method,budget,runs,{},relmse_median,relmse_worst,bias_z,bias_p,non_finite\n", heads.join(","));
    for cell in cells {
        let names = [&cell.scene, &cell.method, &cell.budget].map(|name| quoted(name));
        let means = MEANS.iter().flat_map(|(_, value)| {
            let m = value(cell);
            [m.mean, m.low, m.high]
        });
        let ratios = [cell.ratio, cell.ratio_trimmed].into_iter().flat_map(|r| [r.value, r.low, r.high]);
        let rest = [cell.relmse_median, cell.relmse_worst, cell.bias.z, cell.bias.p];
        let figures = means.chain(ratios).chain(rest).map(number);
        let row = names.into_iter().chain([cell.runs.to_string()]).chain(figures).chain([cell.non_finite.to_string()]);
        text += &(row.collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// A row for each method and budget: geometric means over scenes.
pub(crate) fn overall_csv(overall: &[Overall]) -> String {
    let columns = |name: &str| {
        ["", "_low", "_high", "_scenes", "_spread", "_least", "_least_scene", "_most", "_most_scene"]
            .map(|end| format!("{name}{end}"))
            .join(",")
    };
    let mut text = format!("method,budget,{},{}\n", columns("ratio"), columns("ratio_trimmed"));
    for row in overall {
        let names = [quoted(&row.method), quoted(&row.budget)];
        let figures = [&row.ratio, &row.ratio_trimmed].map(geometric);
        text += &(names.into_iter().chain(figures.into_iter().flatten()).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

fn geometric(mean: &GeometricMean) -> Vec<String> {
    let Ratio { value, low, high, .. } = mean.ratio;
    let mut row: Vec<String> = [value, low, high].map(number).into();
    row.extend([mean.scenes.to_string(), number(mean.spread)]);
    for end in [&mean.least, &mean.most] {
        row.extend([number(end.as_ref().map(|e| e.value)), end.as_ref().map_or(String::new(), |e| quoted(&e.scene))]);
    }
    row
}

fn number(x: Option<f64>) -> String {
    x.map_or(String::new(), |x| x.to_string())
}

/// Efficiencies over the baseline's at the largest budget as a table of LaTeX's package booktabs. It compiles as it is, and a paper takes
/// it in by `\input` with the package standalone. `says` becomes a comment.
pub(crate) fn latex(plan: &Plan, cells: &[Cell], overall: &[Overall], says: &str) -> String {
    let budget = plan.budgets.last().map_or(String::new(), |budget| budget.name());
    let others: Vec<&str> =
        plan.methods.iter().enumerate().filter(|(k, _)| *k != plan.baseline).map(|(_, m)| m.name.as_str()).collect();
    let row = |name: &str, ratios: Vec<Option<Ratio>>| {
        let texts = ratios.into_iter().map(|r| r.map_or("--".into(), ratio_in_latex));
        std::iter::once(escaped(name)).chain(texts).collect::<Vec<_>>().join(" & ") + " \\\\\n"
    };
    let mut body = String::new();
    for entry in &plan.scenes {
        let name = entry.name();
        let of = |method: &&str| {
            cells.iter().find(|c| c.scene == name && c.method == **method && c.budget == budget).map(|c| c.ratio)
        };
        body += &row(&name, others.iter().map(of).collect());
    }
    if plan.scenes.len() > 1 {
        let of =
            |method: &&str| overall.iter().find(|o| o.method == **method && o.budget == budget).map(|o| o.ratio.ratio);
        body += &format!("\\midrule\n{}", row("geometric mean", others.iter().map(of).collect()));
    }
    let heads: Vec<String> = std::iter::once("scene").chain(others.iter().copied()).map(escaped).collect();
    let comment: String = says.lines().map(|line| format!("% {line}\n")).collect();
    format!(
        "% Efficiency 1/(relMSE x seconds) over that of {} at {budget}, with 95 % intervals.\n{comment}\
         \\documentclass{{standalone}}\n\\usepackage{{booktabs}}\n\\begin{{document}}\n\
         \\begin{{tabular}}{{l{}}}\n\\toprule\n{} \\\\\n\\midrule\n{body}\\bottomrule\n\\end{{tabular}}\n\\end{{document}}\n",
        plan.methods[plan.baseline].name,
        "r".repeat(others.len()),
        heads.join(" & "),
    )
}

fn ratio_in_latex(r: Ratio) -> String {
    match (r.value, r.low.zip(r.high)) {
        (Some(value), Some((low, high))) => format!("{} [{}, {}]", short(value), short(low), short(high)),
        (Some(value), None) => short(value),
        (None, _) => "--".into(),
    }
}

/// Text as LaTeX has it.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{c}"),
        '~' => "\\textasciitilde{}".into(),
        '^' => "\\textasciicircum{}".into(),
        '\\' => "\\textbackslash{}".into(),
        _ => c.to_string(),
    };
    text.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::compare::cell::cells;
    use crate::lab::compare::fixtures;
    use crate::lab::compare::overall::overall;
    use crate::lab::compare::schedule::order;
    use crate::lab::compare::store::Store;
    use std::collections::BTreeMap;

    fn measured() -> (Plan, Vec<Cell>, Vec<Overall>) {
        let folder = tempfile::tempdir().unwrap();
        let mut plan = fixtures::plan();
        plan.methods[1].name = "grid_8 & more".into();
        let mut store = Store::open(&folder.path().join("runs.jsonl"), "", "").unwrap();
        order(&plan).iter().for_each(|slot| store.add(fixtures::run(&plan, slot)).unwrap());
        let cells = cells(&plan, &store, &BTreeMap::new());
        let all = overall(&plan, &cells);
        (plan, cells, all)
    }

    #[test]
    fn every_row_has_a_field_for_each_heading() {
        let (_, cells, all) = measured();
        for (text, rows) in [(cells_csv(&cells), 8), (overall_csv(&all), 2)] {
            let counts: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
            assert_eq!((counts.len(), counts.iter().min()), (rows + 1, counts.iter().max()), "{text}");
        }
        // the guided method's errors are half of the other's in both scenes
        assert!(overall_csv(&all).lines().nth(1).unwrap().starts_with("grid_8 & more,2 s,2,"), "{}", overall_csv(&all));
    }

    #[test]
    fn the_table_escapes_names_and_balances_its_environments() {
        let (plan, cells, all) = measured();
        let text = latex(&plan, &cells, &all, "by a test");
        assert!(text.contains("grid\\_8 \\& more") && text.contains("% by a test\n"), "{text}");
        assert!(text.contains("geometric mean & 2.00 ["), "{text}");
        for name in ["document", "tabular"] {
            let count = |word: &str| text.matches(&format!("\\{word}{{{name}}}")).count();
            assert_eq!((count("begin"), count("end")), (1, 1));
        }
        let rows: Vec<&str> = text.lines().filter(|line| line.contains(" & ")).collect();
        assert_eq!(rows.len(), 4, "heads, two scenes, the mean: {rows:?}");
    }
}
