//! `phototaxis compare`, tiny.

use super::{folder, names, phototaxis, program, scene, stderr, stdout};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// Two methods, two budgets, 64 × 64 pixels, and a reference that takes no longer than it is worth here.
const SMALL: [&str; 12] = [
    "--methods",
    "none,grid",
    "--spp",
    "2,4",
    "--set",
    "film.width=64",
    "--set",
    "film.height=64",
    "--reference-time",
    "0.5",
    "--allow-noisy-reference",
    "-q",
];

fn compare(folder: &Path, runs: u32, more: &[&str], code: i32) -> Output {
    let mut command = phototaxis(folder);
    command.arg("compare").arg(scene("cornell.toml")).args(SMALL).args(["--runs", &runs.to_string()]).args(more);
    command.assert().code(code).get_output().clone()
}

fn results(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("compare-out/results.json")).unwrap()).unwrap()
}

#[test]
fn runs_figures_charts_and_pictures_are_written() {
    let here = folder();
    let output = compare(here.path(), 3, &[], 0);
    let out = here.path().join("compare-out");
    assert_eq!(
        names(&out),
        [
            "cells.csv",
            "charts",
            "images",
            "overall.csv",
            "references",
            "report.html",
            "results.csv",
            "results.json",
            "runs.jsonl",
            "table.tex"
        ]
    );
    assert_eq!(names(&out.join("images")), ["cornell_grid.exr", "cornell_none.exr"]);
    assert_eq!(names(&out.join("charts")).len(), 18, "six charts, each as SVG, PNG and PDF");
    check_stamps(&out.join("charts"));
    assert_eq!(std::fs::read_to_string(out.join("cells.csv")).unwrap().lines().count(), 5);
    assert_eq!(std::fs::read_to_string(out.join("overall.csv")).unwrap().lines().count(), 3);
    let table = stdout(&output);
    assert!(table.contains("cornell, 2 spp\n") && table.contains("cornell, 4 spp\n"), "{table}");
    assert_eq!(table.lines().filter(|line| line.starts_with("  grid ")).count(), 2, "{table}");
    assert!(table.contains("is taken off MSE and relMSE"), "{table}");
    let csv = std::fs::read_to_string(out.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 13);
    let results = results(here.path());
    check_head(&results);
    check_cells(&results);
    check_pictures(&results);
    assert!(!says_nan(&results), "{results:#}");
    assert!(says_nan(&serde_json::json!({"cells": [{"z": "NaN"}]})));
}

/// Every chart says what it was made with, whatever its form.
fn check_stamps(charts: &Path) {
    let stamp = |text: &str| ["phototaxis ", "Embree ", "compiled for "].iter().all(|part| text.contains(part));
    let path = |extension: &str| charts.join(format!("efficiency-cornell.{extension}"));
    assert!(stamp(&std::fs::read_to_string(path("svg")).unwrap()));
    assert!(stamp(&phototaxis::image::png::text(&path("png"), "Comment").unwrap()));
    assert!(stamp(&String::from_utf8_lossy(&std::fs::read(path("pdf")).unwrap())));
}

/// Whether a number became a text that is none. Pictures are Base64, in which those three letters come up by chance.
fn says_nan(value: &Value) -> bool {
    match value {
        Value::String(text) => text.contains("NaN"),
        Value::Array(items) => items.iter().any(says_nan),
        Value::Object(fields) => fields.iter().any(|(name, value)| name != "rgbe" && says_nan(value)),
        _ => false,
    }
}

fn check_head(results: &Value) {
    assert_eq!((&results["format"], &results["baseline"]), (&2.into(), &"none".into()));
    let platform = &results["platform"];
    assert!(
        ["version", "compiled_for", "embree", "embree_isa"].iter().all(|key| platform[key].is_string()),
        "{platform}"
    );
    assert!(platform["cpu"].is_string() || platform["cpu"].is_null());
    assert_eq!(results["date"].as_str().map(str::len), Some(20), "{}", results["date"]);
    let over = &results["overall"][0];
    assert_eq!((&over["method"], &over["ratio"]["scenes"]), (&"grid".into(), &1.into()));
    assert!(results["command"].as_str().unwrap().starts_with("phototaxis compare "), "{}", results["command"]);
    assert_eq!(results["methods"][1]["overrides"]["guiding.method"], "grid");
    assert_eq!(results["budgets"][0], serde_json::json!({"name": "2 spp", "wall_seconds": null, "spp": 2}));
    let reference = &results["scenes"][0]["reference"];
    assert_eq!((&reference["source"], &results["scenes"][0]["width"]), (&"made".into(), &64.into()));
    assert!(reference["relmse_noise"].as_f64().unwrap() > 0.0 && reference["samples"].as_u64().unwrap() >= 16);
}

fn check_cells(results: &Value) {
    let cells = results["cells"].as_array().unwrap();
    assert_eq!((cells.len(), results["runs"].as_array().unwrap().len()), (4, 12));
    for cell in cells {
        assert_eq!(cell["runs"], 3);
        for measure in ["wall_seconds", "relmse", "relmse_trimmed", "mse", "mape", "smape", "flip", "efficiency"] {
            assert!(cell[measure]["mean"].as_f64().unwrap() > 0.0, "{measure} of {cell}");
        }
        let p = cell["bias"]["p"].as_f64().unwrap();
        // the false alarm of each of four honest cells is 1 in 10 000 here
        assert!((1e-4..=1.0).contains(&p), "{cell}");
        let guided = cell["method"] == "grid";
        // two samples are one iteration, and nothing is learnt in the last
        let learnt = guided && cell["budget"] == "4 spp";
        assert_eq!(cell["guide_bytes"]["mean"].as_f64().unwrap() > 0.0, learnt, "{cell}");
        assert_eq!(cell["ratio"]["value"] == 1.0, !guided, "{cell}");
    }
    let run = &results["runs"][3];
    assert!(run["iterations"][0]["samples"] == 1 && run.get("blocks").is_none(), "{run}");
    let kinds: Vec<&str> = results["charts"].as_array().unwrap().iter().map(|c| c["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["error-time", "error-samples", "error-memory", "pareto", "path-length", "efficiency"]);
}

fn check_pictures(results: &Value) {
    let images = results["images"].as_array().unwrap();
    let of: Vec<&str> = images.iter().map(|i| i["method"].as_str().unwrap()).collect();
    assert_eq!(of, ["reference", "none", "grid"]);
    assert!(images.iter().all(|i| i["width"] == 64 && i["rgbe"].as_str().unwrap().len() > 1000));
    // the last of twelve seeds, counted from 0
    assert_eq!((&images[2]["seed"], &images[2]["budget"]), (&11.into(), &"4 spp".into()));
}

#[test]
fn an_interrupted_comparison_goes_on_with_the_same_pictures() {
    let here = folder();
    compare(here.path(), 3, &["--no-images"], 0);
    let whole = results(here.path());
    assert_eq!(whole["images"].as_array().unwrap().len(), 0);
    let log = here.path().join("compare-out/runs.jsonl");
    let text = std::fs::read_to_string(&log).unwrap();
    let kept: Vec<&str> = text.lines().take(7).collect();
    std::fs::write(&log, kept.join("\n") + "\n{\"run\":{\"sce").unwrap();
    compare(here.path(), 3, &["--no-images"], 0);
    let again = results(here.path());
    for (a, b) in whole["runs"].as_array().unwrap().iter().zip(again["runs"].as_array().unwrap()) {
        for same in ["seed", "method", "budget", "samples", "relmse", "flip", "rays"] {
            assert_eq!(a[same], b[same], "{same}");
        }
    }
    let lines = |text: &str| text.lines().map(String::from).collect::<Vec<_>>();
    let now = lines(&std::fs::read_to_string(&log).unwrap());
    assert_eq!((now.len(), &now[..7]), (14, &lines(&text)[..7]), "what was there stays");
    // more runs go on, other settings do not
    compare(here.path(), 4, &["--no-images"], 0);
    let longer = lines(&std::fs::read_to_string(&log).unwrap());
    assert_eq!((longer.len(), &longer[..14]), (18, &now[..]));
    let refused = compare(here.path(), 3, &["--set", "integrator.max_depth=3"], 1);
    assert!(stderr(&refused).contains("--restart"), "{}", stderr(&refused));
    compare(here.path(), 1, &["--set", "integrator.max_depth=3", "--restart", "--no-images"], 0);
    assert_eq!(names(&here.path().join("compare-out/references")).len(), 2, "one for each set of settings");
}

#[test]
fn wrong_settings_are_refused_before_anything_is_made() {
    let here = folder();
    let refused = |arguments: &[&str], code: i32, wanted: &str| {
        let mut command = phototaxis(here.path());
        command.arg("compare").args(arguments);
        let output = command.assert().code(code).get_output().clone();
        assert!(stderr(&output).contains(wanted), "{arguments:?}: {}", stderr(&output));
    };
    let cornell = scene("cornell.toml").display().to_string();
    refused(&[&cornell, "--methods", "none,gird", "--spp", "2"], 1, "unknown method `gird`: did you mean `grid`?");
    refused(&[&cornell, "--spp", "2", "--methods", "sweep:guiding.strat=2,4"], 1, "did you mean `strata`?");
    refused(&[&cornell, "--spp", "2", "--time", "1"], 2, "cannot be used with");
    refused(&[&cornell], 1, "needs budgets");
    refused(&["--spp", "2"], 1, "no scene");
    refused(&[&cornell, &cornell, "--spp", "2", "--reference", "r.exr"], 1, "--reference is for one scene");
    let plan = format!("spp = 2\n[[scene]]\npath = {cornell:?}\n[methods.a]\n\"guiding.metod\" = \"grid\"\n");
    std::fs::write(here.path().join("plan.toml"), plan).unwrap();
    refused(&["--plan", "plan.toml"], 1, "plan.toml:5:1: unknown key `metod` in [guiding]: did you mean `method`?");
    assert_eq!(names(here.path()), ["plan.toml"]);
}

#[test]
fn a_reference_that_is_too_noisy_is_refused() {
    let here = folder();
    let mut command = phototaxis(here.path());
    command.arg("compare").arg(scene("cornell.toml")).args(["--methods", "none", "--spp", "8", "--runs", "2"]);
    command.args(["--set", "film.width=16", "--set", "film.height=12", "--reference-time", "0.01"]);
    let strict = ["--reference-noise", "0.0001"];
    let output = command.args(strict).assert().code(1).get_output().clone();
    assert!(stderr(&output).contains("--allow-noisy-reference"), "{}", stderr(&output));
    assert_eq!(names(&here.path().join("compare-out/references")).len(), 1, "what was rendered is kept");
    let log = std::fs::read_to_string(here.path().join("compare-out/runs.jsonl")).unwrap();
    assert_eq!(log.lines().count(), 1, "no run was made before: {log}");
    assert!(stderr(&output).contains("--reference-time "), "the time that would do: {}", stderr(&output));
}

#[test]
fn comparisons_share_references() {
    let here = folder();
    let samples = |out: &str| {
        let mut command = phototaxis(here.path());
        command.arg("compare").arg(scene("cornell.toml")).args(SMALL).args(["--runs", "2", "-o", out]);
        command.args(["--references", "shared"]).assert().success();
        let text = std::fs::read_to_string(here.path().join(out).join("results.json")).unwrap();
        assert!(!here.path().join(out).join("references").exists());
        let results: Value = serde_json::from_str(&text).unwrap();
        results["scenes"][0]["reference"]["samples"].as_u64().unwrap()
    };
    let first = samples("a");
    assert_eq!(names(&here.path().join("shared")).len(), 1);
    assert_eq!(samples("b"), first, "a reference whose time is over is taken as it is");
}

#[test]
fn a_reference_that_is_no_picture_of_the_scene_is_refused() {
    let here = folder();
    let size = ["--set", "film.width=32", "--set", "film.height=24"];
    let render = |more: &[&str], name: &str| {
        let mut command = phototaxis(here.path());
        command.arg("render").arg(scene("cornell.toml")).args(size).args(["--spp", "64", "-q", "-o", name]).args(more);
        command.assert().code(0);
    };
    render(&[], "good.exr");
    // the camera turned about its axis: upside down, and left is right
    render(&["--set", "camera.up=[0, -1, 0]"], "turned.exr");
    render(&["--set", "camera.vfov=100"], "wide.exr");
    let compare = |reference: &str, code: i32| {
        let mut command = phototaxis(here.path());
        command.arg("compare").arg(scene("cornell.toml")).args(size).args([
            "--methods",
            "none",
            "--spp",
            "32",
            "--runs",
            "1",
        ]);
        command.args(["--allow-noisy-reference", "--reference", reference, "-o", reference.trim_end_matches(".exr")]);
        stderr(&command.assert().code(code).get_output().clone())
    };
    let said = compare("good.exr", 0);
    assert!(said.contains("to do: 1 runs, whose time pilot runs will tell"), "{said}");
    assert!(said.contains("the references are there; 1 runs take "), "{said}");
    let said = compare("turned.exr", 1);
    assert!(said.contains("turned.exr") && said.contains("turned by 180 degrees"), "{said}");
    let said = compare("wide.exr", 1);
    assert!(said.contains("this is no reference of cornell"), "{said}");
}

#[test]
fn a_file_says_what_is_compared_and_flags_change_it() {
    let here = folder();
    let made = here.path().join("made.exr");
    let mut render = phototaxis(here.path());
    let size = ["--set", "film.width=16", "--set", "film.height=12", "--spp", "64", "-q", "-o"];
    render.arg("render").arg(scene("cornell.toml")).args(size).arg(&made).assert().code(0);
    let plan = format!(
        "title = \"Two grids\"\nspp = [2, 4]\nruns = 2\nbaseline = \"fine\"\n[set]\nfilm.width = 16\nfilm.height = 12\n\
         [[scene]]\nname = \"box\"\npath = {:?}\nreference = \"made.exr\"\n\
         [methods.coarse]\nguiding.method = \"grid\"\nguiding.resolution = 4\n\
         [methods.fine]\nguiding.method = \"grid\"\nguiding.resolution = 32\n",
        scene("cornell.toml").display().to_string()
    );
    std::fs::write(here.path().join("plan.toml"), plan).unwrap();
    let arguments = ["--plan", "plan.toml", "--spp", "4", "--allow-noisy-reference", "-q", "-o", "out"];
    phototaxis(here.path()).arg("compare").args(arguments).assert().code(0);
    let text = std::fs::read(here.path().join("out/results.json")).unwrap();
    let results: Value = serde_json::from_slice(&text).unwrap();
    assert_eq!((&results["title"], &results["baseline"]), (&"Two grids".into(), &"fine".into()));
    assert_eq!((&results["scenes"][0]["name"], &results["budgets"][0]["spp"]), (&"box".into(), &4.into()));
    assert_eq!(results["scenes"][0]["reference"]["source"], "file");
    assert_eq!(results["methods"][0]["overrides"]["guiding.resolution"], 4);
    assert_eq!(results["cells"].as_array().unwrap().len(), 2);
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_writes_the_figures_so_far() {
    let here = folder();
    let log = here.path().join("compare-out/runs.jsonl");
    let mut command = std::process::Command::new(program());
    command.current_dir(here.path()).arg("compare").arg(scene("cornell.toml"));
    command.args(SMALL).args(["--runs", "10000"]).stdout(std::process::Stdio::null());
    let mut child = Ended(command.spawn().unwrap());
    let begun = std::time::Instant::now();
    while std::fs::read_to_string(&log).map_or(0, |text| text.lines().count()) < 4 {
        assert!(begun.elapsed().as_secs() < 120, "no runs came");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let kill = format!("kill -s INT {}", child.0.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(child.0.wait().unwrap().code(), Some(130));
    let lines = std::fs::read_to_string(&log).unwrap().lines().count();
    let results = results(here.path());
    assert_eq!(results["runs"].as_array().unwrap().len(), lines - 2, "all but the plan and the reference");
    assert!(!results["cells"].as_array().unwrap().is_empty());
}

/// A process that ends with the test, however that ends.
#[cfg(target_os = "linux")]
struct Ended(std::process::Child);

#[cfg(target_os = "linux")]
impl Drop for Ended {
    fn drop(&mut self) {
        // it has ended already where the test passed
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Figures of all runs but for what clocks tell.
fn measured(results: &Value) -> Vec<Value> {
    let fields = ["scene", "seed", "method", "budget", "samples", "relmse", "flip", "rays"];
    let of = |run: &Value| fields.iter().map(|field| run[field].clone()).collect();
    results["runs"].as_array().unwrap().iter().map(of).collect()
}

#[test]
fn machines_that_share_a_comparison_find_what_one_does() {
    let here = folder();
    compare(here.path(), 2, &[], 0);
    let alone = results(here.path());
    let references = here.path().join("compare-out/references");
    let reference = references.join(&names(&references)[0]);
    let reference = ["--reference", reference.to_str().unwrap(), "-o", "farm"];
    compare(here.path(), 2, &[&reference[..], &["--tasks"]].concat(), 0);
    let farm = here.path().join("farm");
    let graph: Value = serde_json::from_slice(&std::fs::read(farm.join("plan.json")).unwrap()).unwrap();
    let tasks: Vec<&str> =
        graph["tasks"].as_array().unwrap().iter().map(|task| task["name"].as_str().unwrap()).collect();
    assert_eq!(tasks, ["reference-1", "round-1", "round-2", "report-1"]);
    for task in tasks {
        phototaxis(&std::env::temp_dir()).args(["farm", "task", farm.to_str().unwrap(), task]).assert().success();
    }
    let shared: Value = serde_json::from_slice(&std::fs::read(farm.join("results.json")).unwrap()).unwrap();
    assert_eq!(measured(&shared), measured(&alone));
    assert_eq!(names(&farm.join("images")), ["cornell_grid.exr", "cornell_none.exr"]);
    // what is there is not done again, what is of another comparison is refused, and so is a gallery
    let lines = || std::fs::read_to_string(farm.join("runs.jsonl")).unwrap().lines().count();
    let before = lines();
    compare(here.path(), 2, &reference, 0);
    assert_eq!((lines(), before), (1 + 1 + 8, 1 + 1 + 8));
    let other =
        compare(here.path(), 2, &[&reference[..], &["--set", "film.height=32", "--task", "round-1"]].concat(), 1);
    assert!(super::stderr(&other).contains("another comparison"), "{}", super::stderr(&other));
    let none = compare(here.path(), 2, &[&reference[..], &["--task", "round-3"]].concat(), 1);
    assert!(super::stderr(&none).contains("no such task"), "{}", super::stderr(&none));
}
