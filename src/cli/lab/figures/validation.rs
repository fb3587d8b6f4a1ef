//! What fitted settings are worth elsewhere: each key of the default guide is swept over the scenes, and for each scene the value that is
//! best on all the others is held against the one that is best there.

use super::Desk;
use super::scenes::{self, Content};
use super::steps::compare;
use crate::draw::short;
use anyhow::{Context as _, Result};
use serde_json::Value;

/// Keys of the guide `adaptive`, values to try, and which of them is the default.
const SWEEPS: [(&str, [&str; 3], usize); 7] = [
    ("resolution", ["8", "16", "32"], 1),
    ("refine_visits", ["1000", "4000", "16000"], 1),
    ("refine_difference", ["0.05", "0.1", "0.2"], 1),
    ("split_share", ["0.01", "0.02", "0.04"], 1),
    ("split_visits", ["16", "32", "64"], 1),
    ("retain", ["0.25", "0.5", "0.75"], 1),
    ("bsdf_fraction", ["0.25", "0.5", "0.75"], 1),
];

/// Efficiencies of a scene, by value of the key.
type Row = (String, Vec<f64>);

/// The table of all sweeps.
pub(super) fn table(desk: &mut Desk) -> Result<String> {
    let mut text = "| key | default | best on all scenes | regret of the default | regret, the scene left out | worst of these, and where |\n\
                    |---|---|---|---|---|---|\n"
        .to_string();
    let sweeps = if desk.arguments.quick { &SWEEPS[..1] } else { &SWEEPS[..] };
    for (key, values, default) in sweeps {
        let name = format!("validation-{key}");
        let method = format!("sweep:guiding.method=adaptive;guiding.{key}={}", values.join(","));
        scenes::write_plan(desk, &format!("{name}.toml"), &Content::Method(&method))?;
        let plan = desk.work(&format!("{name}.toml")).display().to_string();
        let (_, results) = compare(desk, vec!["--plan".into(), plan, "--no-images".into()], &name)?;
        text += &line(key, values, *default, &rows(&results)?);
    }
    Ok(text)
}

/// The scenes in which all values have an efficiency.
fn rows(results: &Value) -> Result<Vec<Row>> {
    let names = |key: &str| -> Result<Vec<&str>> {
        let list = results[key].as_array().with_context(|| format!("results.json has no {key}"))?;
        Ok(list.iter().filter_map(|entry| entry["name"].as_str()).collect())
    };
    let (scenes, methods) = (names("scenes")?, names("methods")?);
    let cells = results["cells"].as_array().context("results.json has no cells")?;
    let efficiency = |scene: &str, method: &str| {
        cells.iter().find(|c| c["scene"] == scene && c["method"] == method)?["efficiency"]["mean"].as_f64()
    };
    let row = |scene: &&str| {
        let all: Option<Vec<f64>> = methods.iter().map(|method| efficiency(scene, method)).collect();
        Some((scene.to_string(), all?))
    };
    Ok(scenes.iter().filter_map(row).collect())
}

fn line(key: &str, values: &[&str], default: usize, rows: &[Row]) -> String {
    if rows.len() < 2 {
        return format!("| `{key}` | {} | – | – | – | – |\n", values[default]);
    }
    let all: Vec<&Row> = rows.iter().collect();
    let elsewhere =
        |k: usize| best(&rows.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, row)| row).collect::<Vec<_>>());
    let left_out: Vec<f64> = rows.iter().enumerate().map(|(k, row)| regret(row, elsewhere(k))).collect();
    let worst = (0..rows.len()).max_by(|a, b| left_out[*a].total_cmp(&left_out[*b])).unwrap_or(0);
    format!(
        "| `{key}` | {} | {} | {} | {} | {}, `{}` |\n",
        values[default],
        values[best(&all)],
        short(mean(&rows.iter().map(|row| regret(row, default)).collect::<Vec<_>>())),
        short(mean(&left_out)),
        short(left_out[worst]),
        rows[worst].0
    )
}

/// The value whose efficiencies have the largest geometric mean.
fn best(rows: &[&Row]) -> usize {
    let score = |k: usize| rows.iter().map(|(_, efficiencies)| efficiencies[k].ln()).sum::<f64>();
    let count = rows.first().map_or(0, |row| row.1.len());
    (0..count).max_by(|a, b| score(*a).total_cmp(&score(*b))).unwrap_or(0)
}

/// How many times as efficient the scene's own best value is.
fn regret((_, efficiencies): &Row, chosen: usize) -> f64 {
    efficiencies.iter().copied().fold(0.0, f64::max) / efficiencies[chosen]
}

/// Geometric mean.
fn mean(values: &[f64]) -> f64 {
    (values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_that_is_left_out_has_no_say_in_its_own_value() {
        let rows =
            [("a".to_string(), vec![1.0, 2.0]), ("b".to_string(), vec![4.0, 1.0]), ("c".to_string(), vec![1.0, 1.0])];
        // over all: 4 to 2; without b: 1 to 2, so that b is given the second value, four times as bad as its own best
        assert_eq!(best(&rows.iter().collect::<Vec<_>>()), 0);
        let text = line("k", &["x", "y"], 1, &rows);
        // of the default y: 1, 4, 1; left out: a gets x (2), b gets y (4), c gets x (1)
        assert_eq!(text, "| `k` | y | x | 1.59 | 2.00 | 4.00, `b` |\n");
        assert!(line("k", &["x", "y"], 1, &rows[..1]).contains("–"));
    }
}
