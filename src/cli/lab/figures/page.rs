//! Tables in Markdown, from results.json.

use crate::draw::short;
use crate::lab::compare::forecast::said;
use anyhow::{Context as _, Result};
use serde_json::Value;

/// Tables of all scenes, a budget each, the largest first, with what must be known to read them.
pub(super) fn results(results: &Value, missing: &[String], seconds: f64) -> Result<String> {
    let names = |key: &str| -> Vec<String> {
        let list = results[key].as_array().into_iter().flatten();
        list.filter_map(|entry| Some(entry["name"].as_str()?.to_string())).collect()
    };
    let (scenes, methods, budgets) = (names("scenes"), names("methods"), names("budgets"));
    let baseline = results["baseline"].as_str().context("results.json has no baseline")?;
    let others: Vec<&String> = methods.iter().filter(|name| *name != baseline).collect();
    let runs = results["cells"].as_array().into_iter().flatten().filter_map(|c| c["runs"].as_u64()).max().unwrap_or(0);
    let threads = results["machine"]["threads"].as_u64().unwrap_or(0);
    let mut text = format!(
        "{} scenes, {runs} runs of a method in turns, {threads} threads. The last call took {}. Efficiency is 1/(relMSE · seconds), \
         learning counted, here over that of `{baseline}`, with 95 % intervals by the runs' spread; geometric means are over scenes, \
         and how much scenes differ is said apart.\n",
        scenes.len(),
        said(seconds)
    );
    if !missing.is_empty() {
        text +=
            &format!("\nNot measured, because these scenes are not part of this repository: {}.\n", missing.join(", "));
    }
    for budget in budgets.iter().rev() {
        text += &format!("\n### {budget}\n\n| scene | relMSE of `{baseline}` |");
        others.iter().for_each(|method| text += &format!(" `{method}` × |"));
        text += &format!("\n|---|---|{}\n", "---|".repeat(others.len()));
        for scene in &scenes {
            let relmse = find(results, scene, baseline, budget).and_then(|cell| cell["relmse"]["mean"].as_f64());
            text += &format!("| `{scene}` | {} |", relmse.map_or("–".into(), short));
            others.iter().for_each(|method| {
                text += &format!(
                    " {} |",
                    find(results, scene, method, budget).map_or("–".into(), |cell| ratio(&cell["ratio"]))
                );
            });
            text.push('\n');
        }
        text += &means(results, &others, budget);
    }
    Ok(text)
}

/// The last rows of a table: means over scenes.
fn means(results: &Value, others: &[&String], budget: &str) -> String {
    let of = |method: &str| {
        let all = results["overall"].as_array().into_iter().flatten();
        all.into_iter().find(|o| o["method"] == method && o["budget"] == budget)
    };
    let row = |name: &str, value: &dyn Fn(&Value) -> String| {
        let cells = others.iter().map(|method| format!(" {} |", of(method).map_or("–".into(), value)));
        format!("| {name} | |{}\n", cells.collect::<String>())
    };
    let number = |x: &Value| x.as_f64().map_or("–".into(), short);
    [
        row("**geometric mean**", &|o| ratio(&o["ratio"])),
        row("the same without the worst 0.1 % of pixels", &|o| ratio(&o["ratio_trimmed"])),
        row("spread over scenes, a factor", &|o| number(&o["ratio"]["spread"])),
        row("least and most", &|o| {
            format!("{}, {}", number(&o["ratio"]["least"]["value"]), number(&o["ratio"]["most"]["value"]))
        }),
    ]
    .concat()
}

/// One scene's methods at the largest budget, a row each.
pub(super) fn methods(results: &Value) -> Result<String> {
    let budget = results["budgets"].as_array().and_then(|b| b.last()).context("no budget")?;
    let mut text = "| method | relMSE | efficiency × | states |\n|---|---|---|---|\n".to_string();
    for cell in results["cells"].as_array().into_iter().flatten().filter(|c| c["budget"] == budget["name"]) {
        let number = |x: &Value| x["mean"].as_f64().map_or("–".into(), short);
        let name = cell["method"].as_str().unwrap_or("–");
        text += &format!(
            "| `{name}` | {} | {} | {} |\n",
            number(&cell["relmse"]),
            ratio(&cell["ratio"]),
            number(&cell["guide_states"])
        );
    }
    Ok(text)
}

/// Commands as a block of code.
pub(super) fn commands(commands: &[String]) -> String {
    commands.iter().map(|line| format!("    {line}\n")).collect()
}

/// Markdown whose links are plain text.
pub(super) fn without_links(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("](") {
        let (Some(open), Some((_, behind))) = (before.rfind('['), after.split_once(')')) else { break };
        plain += &before[..open];
        plain += &before[open + 1..];
        rest = behind;
    }
    plain + rest
}

fn find<'a>(results: &'a Value, scene: &str, method: &str, budget: &str) -> Option<&'a Value> {
    let cells = results["cells"].as_array()?;
    cells.iter().find(|c| c["scene"] == scene && c["method"] == method && c["budget"] == budget)
}

fn ratio(r: &Value) -> String {
    match (r["value"].as_f64(), r["low"].as_f64().zip(r["high"].as_f64())) {
        (Some(value), Some((low, high))) => format!("{} [{}, {}]", short(value), short(low), short(high)),
        (Some(value), None) => short(value),
        (None, _) => "–".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_table_has_a_row_for_each_scene_and_says_what_is_not_known() {
        let given = json!({"baseline": "none", "machine": {"threads": 2}, "scenes": [{"name": "a"}, {"name": "b"}],
            "methods": [{"name": "none"}, {"name": "auto"}], "budgets": [{"name": "2 s"}, {"name": "8 s"}],
            "cells": [{"scene": "a", "method": "none", "budget": "8 s", "runs": 3, "relmse": {"mean": 0.5}},
                {"scene": "a", "method": "auto", "budget": "8 s", "runs": 3, "ratio": {"value": 4.0, "low": 3.0, "high": 5.0}}],
            "overall": [{"method": "auto", "budget": "8 s", "ratio": {"value": 2.0, "low": 1.5, "high": 2.5, "spread": 1.7,
                "least": {"value": 1.0}, "most": {"value": 4.0}}, "ratio_trimmed": {"value": null}}]});
        let text = results(&given, &["hall".into()], 7200.0).unwrap();
        for part in [
            "2 scenes, 3 runs",
            "took 2.0 h",
            "repository: hall.",
            "| `a` | 0.500 | 4.00 [3.00, 5.00] |",
            "| `b` | – | – |",
            "| **geometric mean** | | 2.00 [1.50, 2.50] |",
            "| spread over scenes, a factor | | 1.70 |",
            "| least and most | | 1.00, 4.00 |",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        assert!(text.find("### 8 s") < text.find("### 2 s"), "the largest first");
    }

    #[test]
    fn links_lose_their_addresses_and_nothing_else() {
        assert_eq!(without_links("| [**✗**](a/b.png) 1 | [x](y) [open"), "| **✗** 1 | x [open");
    }
}
