//! The page of a comparison in a real browser: `tests/report/*.js` do what a reader does and write down what they find.
//!
//! Needs a Chromium, by `$CHROMIUM` or in the path; without one the test is skipped, and says so.

use super::common::browser::{self, browser};
use phototaxis::lab::compare::report::page;
use serde_json::{Value, json};
use std::path::Path;

/// Pixels of the test pictures; `tests/report/checks.js` knows them.
const SIZE: [u8; 2] = [16, 8];

const METHODS: [&str; 3] = ["none", "grid", "tree, fine"];

/// Number of the checks in `tests/report`.
const CHECKS: usize = 22;

/// A name that would end the tag it stands in if it were not escaped.
const SCENES: [&str; 2] = ["a<b", "hall"];

/// RFC 1951 without compression: one stored block.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let length = u16::try_from(bytes.len()).unwrap();
    let [low, high] = length.to_le_bytes();
    [&[1, low, high, !low, !high], bytes].concat()
}

/// RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |chunk: &[u8]| {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | usize::from(chunk.get(i).copied().unwrap_or(0)));
        let letter = |i: usize| if i <= chunk.len() { LETTERS[bits >> (18 - 6 * i) & 63] as char } else { '=' };
        [letter(0), letter(1), letter(2), letter(3)]
    };
    bytes.chunks(3).flat_map(group).collect()
}

/// Red tells the column, green the row, blue the picture; exponent 128 makes each value its mantissa over 256.
fn picture(scene: &str, method: &str, number: u8) -> Value {
    let [width, height] = SIZE;
    let texel = |i: u8| [10 * (i % width) + 5, 20 * (i / width) + 5, 40 * number + 20, 128];
    let texels: Vec<u8> = (0..width * height).flat_map(texel).collect();
    let budget = (number > 0).then_some("16 spp");
    json!({"scene": scene, "method": method, "budget": budget, "seed": budget.map(|_| 3), "width": width,
        "height": height, "rgbe": base64(&stored(&texels))})
}

fn pictures(scene: &str) -> Vec<Value> {
    let names = ["reference"].into_iter().chain(METHODS);
    names.zip(0..).map(|(method, number)| picture(scene, method, number)).collect()
}

fn around(value: Option<f64>, half: f64) -> Value {
    json!({"value": value, "mean": value, "low": value.map(|v| v - half), "high": value.map(|v| v + half)})
}

/// Scene `a<b` has a biased method and one that is better but not finite, `hall` a worse one and one that nothing is
/// known of; under the smaller budget the latter has no ratio.
fn cell(scene: &str, method: &str, budget: &str) -> Value {
    let small = budget == "4 spp";
    let (ratio, half) = match (scene, method) {
        (_, "none") => (1.0, 0.0),
        ("a<b", "grid") => (0.5, 0.1),
        ("a<b", _) => (4.0, 1.0),
        (_, "grid") => (0.25, 0.1),
        _ => (1.1, 0.3),
    };
    let (biased, finite) = (scene == "a<b" && method == "grid", scene != "a<b" || method != "tree, fine" || small);
    let undefined = small && scene == "hall" && method == "tree, fine";
    let mut cell = json!({"scene": scene, "method": method, "budget": budget, "runs": 3,
        "ratio": around((!undefined).then_some(ratio), half),
        "ratio_trimmed": around((!undefined).then_some(ratio.sqrt()), half / 2.0),
        "relmse_median": 0.02, "relmse_worst": 0.03, "non_finite": if finite { 0 } else { 2 },
        "bias": {"z": if biased { 9.0 } else { 0.5 }, "p": if biased { 1e-9 } else { 0.6 }, "biased": biased}});
    let measures = "wall_seconds samples mse relmse relmse_trimmed mape smape flip efficiency efficiency_trimmed \
        msamples_per_second mrays_per_second mean_path_length zero_share guide_bytes guide_states peak_bytes";
    measures.split_whitespace().for_each(|name| cell[name] = around(Some(2.0 / ratio), 0.01));
    cell
}

fn results() -> Value {
    let budgets = ["4 spp", "16 spp"];
    let drawing = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 30"><path class="s-ink" stroke="#24292f" d="M0 0L40 30"/></svg>"##;
    let chart = |scene: Option<&str>| {
        let id = scene.unwrap_or("all");
        json!({"id": id, "scene": scene, "title": "error", "kind": "error-time", "svg": drawing, "narrow": drawing})
    };
    let scene = |name: &&str| {
        json!({"name": name, "path": "scene.toml", "width": SIZE[0], "height": SIZE[1], "triangles": 12, "reference":
            {"source": "made", "path": "r.exr", "samples": 4096, "wall_seconds": 3.5, "relmse_noise": 1e-5}})
    };
    let cells = SCENES.map(|s| METHODS.map(|m| budgets.map(|b| cell(s, m, b)))).into_iter().flatten().flatten();
    json!({
        "format": 2, "title": "A </script> title", "command": "phototaxis compare scene.toml", "version": "0.1.0",
        "machine": {"cpu": "a processor", "threads": 2, "os": "a system"}, "baseline": "none", "confidence": 0.95,
        "scenes": SCENES.iter().map(scene).collect::<Vec<_>>(),
        "methods": METHODS.map(|name| json!({"name": name, "overrides": {"guiding.method": name},
            "baseline": name == "none"})),
        "budgets": budgets.map(|name| json!({"name": name, "wall_seconds": null, "spp": 4})),
        "runs": [], "cells": cells.collect::<Vec<_>>(), "date": "2026-01-02T03:04:05Z",
        "platform": {"commit": "abc", "compiled_for": "x86-64-v3", "embree": "4.3.0", "embree_isa": "avx2"},
        "overall": [overall("grid", 0.35), overall("tree, fine", 2.1)],
        "charts": [chart(None), chart(Some("a<b")), chart(Some("hall"))],
        "gallery": gallery(),
        "images": SCENES.iter().flat_map(|scene| pictures(scene)).collect::<Vec<_>>(),
    })
}

/// A geometric mean over both scenes, at the larger budget.
fn overall(method: &str, value: f64) -> Value {
    let mean = json!({"value": value, "low": 0.9 * value, "high": 1.1 * value, "scenes": 2, "left_out": [], "spread": 1.6,
        "least": {"scene": "hall", "value": 0.5 * value}, "most": {"scene": "a<b", "value": 2.0 * value}});
    json!({"method": method, "budget": "16 spp", "ratio": mean, "ratio_trimmed": mean})
}

/// `grid` fails in `a<b`, once with a reason and once without.
fn gallery() -> Value {
    let finding = |check: &str, colour: &str, why: Option<&str>| json!({"check": check, "colour": colour, "says": format!("what {check} says"), "why": why});
    let cell = |scene: &str, method: &str| {
        let (colour, findings) = match (scene, method) {
            ("a<b", "grid") => (
                "red",
                vec![
                    finding("unbiased", "red", Some("It <knows> nothing.")),
                    finding("memory", "red", None),
                    finding("finite", "green", None),
                ],
            ),
            (_, "none") => ("green", vec![finding("finite", "green", None)]),
            _ => ("amber", vec![finding("efficiency", "amber", None)]),
        };
        json!({"scene": scene, "method": method, "colour": colour, "runs": 3, "ratio": around(Some(0.5), 0.1),
            "relmse_median": 0.02, "relmse_worst": 0.08, "firefly_share": 0.1, "p": 0.5, "guide_bytes": 4096,
            "memory": 8192, "repeatable": true, "findings": findings, "picture": null})
    };
    let bounds = json!({"alarm": 0.01, "slower": 2.0, "fireflies": 0.5, "explosion": 10.0, "repeat": 8});
    json!({"bounds": bounds, "budget": "16 spp", "tested": 6, "level": 0.0017,
        "cells": SCENES.iter().flat_map(|s| METHODS.map(|m| cell(s, m))).collect::<Vec<_>>()})
}

/// The page with what watches it put before its scripts, and `checks` after them.
fn watched(checks: &[&str]) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/report");
    let script = |name: &&str| std::fs::read_to_string(folder.join(name)).unwrap();
    let checks: String = checks.iter().map(script).collect();
    page(&results().to_string())
        .replacen("<style>", &format!("<script>{}</script><style>", script(&"watch.js")), 1)
        .replacen("</body>", &format!("<script type=\"module\">{checks}</script></body>"), 1)
}

/// Panics unless all checks are passed under the conditions that were wanted.
fn assert_passed(verdicts: &[String], conditions: &str) {
    let (last, checks) = verdicts.split_last().unwrap();
    let failed: Vec<_> = checks.iter().filter(|line| !line.starts_with("ok ")).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!(checks.len(), CHECKS, "{checks:#?}");
    assert_eq!(last, conditions);
}

#[test]
fn page_does_what_it_says_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("SKIPPED: the page of a comparison was not tried: no Chromium in the path, nor by $CHROMIUM");
        return;
    };
    let html = watched(&["checks.js", "looks.js"]);
    assert_passed(&browser::verdicts(&browser, &html, &[]), "done, light, 1280 wide");
    let dark = ["--blink-settings=preferredColorScheme=0"];
    assert_passed(&browser::verdicts(&browser, &html, &dark), "done, dark, 1280 wide");
    // A browser's window has a least width, a frame has none.
    let quoted = html.replace('&', "&amp;").replace('"', "&quot;");
    let phone = format!(r#"<!DOCTYPE html><body><iframe width="375" height="800" srcdoc="{quoted}"></iframe></body>"#);
    assert_passed(&browser::verdicts(&browser, &phone, &[]), "done, light, 375 wide");
}
