//! `bench`: every subcommand on a tiny scene, and what it refuses.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// A subcommand on one of the project's files, with more arguments.
fn bench(here: &Path, which: &str, file: &str, more: &[&str]) -> Output {
    let mut command = phototaxis(here);
    command.args(["bench", which]).arg(scene(file)).args(["--turns", "2", "--threads", "1"]).args(more);
    command.assert().code(0).get_output().clone()
}

/// The table that is printed, and the figures and the chart that are written.
fn all_outputs(which: &str, file: &str, more: &[&str]) -> (String, Value, String) {
    let here = folder();
    let outputs = ["--json", "figures.json", "--svg", "chart.svg"];
    let output = bench(here.path(), which, file, &[more, &outputs].concat());
    assert_eq!(names(here.path()), ["chart.svg", "figures.json"]);
    let read = |name: &str| std::fs::read_to_string(here.path().join(name)).unwrap();
    let figures: Value = serde_json::from_str(&read("figures.json")).unwrap();
    assert_eq!((&figures["bench"], &figures["turns"], &figures["threads"]), (&which.into(), &2.into(), &1.into()));
    assert_eq!(figures["confidence"], 0.5, "of two turns");
    assert!(read("chart.svg").starts_with("<svg "));
    (stdout(&output), figures, read("chart.svg"))
}

fn is_median(figure: &Value) -> bool {
    let of = |key: &str| figure[key].as_f64().unwrap();
    of("low") > 0.0 && of("low") <= of("median") && of("median") <= of("high")
}

#[test]
fn rays_compares_the_renderer_with_embree_alone() {
    let (table, figures, chart) = all_outputs("rays", "cornell.toml", &TINY);
    for word in ["16×12", "renderer Mrays/s", "Embree alone", "bounce 3 and on", "octants", "50 % intervals"] {
        assert!(table.contains(word), "{word} is missing in:\n{table}");
    }
    let whole = &figures["whole"][0];
    assert_eq!(whole["threads"], 1);
    for key in ["renderer", "embree", "stage", "share", "stage_share"] {
        assert!(is_median(&whole[key]), "{key}: {whole}");
    }
    assert_eq!(figures["paths"], 16 * 12 * 4);
    assert!(figures["rays"].as_u64().unwrap() > 16 * 12 * 4 && chart.contains("whole renderer"));
}

#[test]
fn render_shares_out_the_time() {
    let more = [&TINY[..], &["--spp", "32", "--methods", "none,grid"]].concat();
    let (table, figures, chart) = all_outputs("render", "cornell.toml", &more);
    assert!(table.contains("guide query") && chart.contains("next event"), "{table}");
    let methods = figures["methods"].as_array().unwrap();
    assert_eq!(methods.iter().map(|m| m["method"].as_str().unwrap()).collect::<Vec<_>>(), ["none", "grid"]);
    for method in methods {
        let shares = method["shares"].as_array().unwrap().iter().map(|s| s["share"].as_f64().unwrap());
        assert!((shares.sum::<f64>() - 1.0).abs() < 1e-9, "{method}");
        assert!(is_median(&method["msamples_per_second"]) && is_median(&method["mrays_per_second"]));
    }
}

#[test]
fn load_counts_bytes_and_asks_tobj() {
    let (table, figures, chart) = all_outputs("load", "cornell.obj", &[]);
    assert!(table.contains("tobj alone") && chart.contains("first pixel"), "{table}");
    for key in ["parse", "build", "first_pixel"] {
        assert!(is_median(&figures[key]), "{key}: {figures}");
    }
    assert_eq!(figures["triangles"], figures["tobj"]["triangles"]);
    assert!(figures["bytes_per_triangle"].as_f64().unwrap() > 12.0);
}

#[test]
fn embree_is_skipped_aloud_where_it_is_missing() {
    let here = folder();
    let mut command = phototaxis(here.path());
    command.args(["bench", "embree"]).arg(scene("cornell.toml")).args(TINY).env("PATH", here.path());
    let output = command.args(["--turns", "1", "--frames", "1", "--json", "-"]).assert().code(0).get_output().clone();
    assert!(stderr(&output).contains("SKIPPED: Embree's path tracer is not installed"), "{}", stderr(&output));
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert!(figures["pathtracer"].is_null() && is_median(&figures["phototaxis"]["mrays_per_second"]), "{figures}");
}

#[test]
fn embree_does_the_same_work() {
    let path = std::env::var_os("PATH").unwrap_or_default();
    if phototaxis::lab::bench::find_pathtracer(&path).is_none() {
        eprintln!("SKIPPED: embree-tools is not installed");
        return;
    }
    // All of an open box is lit: at five segments, Embree asks for light once more than Phototaxis, which leaves out
    // shadow rays from surfaces that face away.
    let size = ["--set", "film.width=64", "--set", "film.height=64", "--frames", "2", "--depth", "5"];
    let (table, figures, _) = all_outputs("embree", "cornell.toml", &size);
    assert!(table.contains("Embree's pathtracer") && table.contains("× samples"), "{table}");
    let rays = |who: &str| figures[who]["rays_per_sample"].as_f64().unwrap();
    let (ours, theirs) = (rays("phototaxis"), rays("pathtracer"));
    assert!(ours < theirs && ours > 0.8 * theirs, "{ours} rays a sample against {theirs}");
    assert!(is_median(&figures["pathtracer"]["ratio"]));
}

#[test]
fn mitsuba_is_skipped_aloud_where_it_is_missing() {
    let here = folder();
    let mut command = phototaxis(here.path());
    command.args(["bench", "mitsuba"]).arg(scene("cornell.toml")).args(TINY).env("PATH", here.path());
    let output = command.args(["--turns", "1", "--json", "-"]).assert().code(0).get_output().clone();
    for variant in ["scalar_rgb", "llvm_ad_rgb"] {
        let said = format!("SKIPPED: Mitsuba's {variant} does not run by python3");
        assert!(stderr(&output).contains(&said), "{}", stderr(&output));
    }
    let figures: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(figures["missing"][1]["variant"], "llvm_ad_rgb");
    assert!(figures["mitsuba"].as_array().unwrap().is_empty(), "{figures}");
    assert!(is_median(&figures["phototaxis"]["mrays_per_second"]), "{figures}");
}

#[test]
fn mitsuba_renders_the_same_scene() {
    let Some(python) = std::env::var_os("PHOTOTAXIS_PYTHON") else {
        eprintln!("SKIPPED: PHOTOTAXIS_PYTHON names no Python that has Mitsuba");
        return;
    };
    let more = ["--set", "film.width=64", "--set", "film.height=64", "--python", python.to_str().unwrap()];
    let (table, figures, chart) = all_outputs("mitsuba", "cornell.toml", &more);
    for variant in figures["mitsuba"].as_array().unwrap() {
        assert!(is_median(&variant["ratio"]) && table.contains(variant["variant"].as_str().unwrap()), "{variant}");
        assert!(variant["agreement"]["worst"].as_f64().unwrap() < 1.0, "{variant}");
    }
    assert!(table.contains("scalar_rgb") && chart.contains("Mitsuba scalar_rgb"), "{table}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let here = folder();
    std::fs::write(here.path().join("empty.obj"), "v 0 0 0\n").unwrap();
    let cornell = scene("cornell.toml");
    let cornell = cornell.to_str().unwrap();
    let cases: [(&[&str], &str); 12] = [
        (&["rays", "none.toml"], "none.toml"),
        (&["render", "none.toml"], "none.toml"),
        (&["load", "none.obj"], "none.obj"),
        (&["load", "empty.obj"], "no triangles"),
        (&["embree", "none.toml"], "none.toml"),
        (&["embree", cornell, "--program", "none"], "no such program"),
        (&["mitsuba", "none.toml"], "none.toml"),
        (&["mitsuba", cornell, "--python", "none"], "no such program"),
        (&["mitsuba", cornell, "--set", "integrator.mis=false"], "Mitsuba has no counterpart"),
        (&["rays", cornell, "--svg", "chart.png"], "written as .svg"),
        (&["rays", cornell, "--json", "no/folder.json"], "its folder does not exist"),
        (&["render", cornell, "--set", "film.width=0"], "film.width"),
    ];
    for (arguments, word) in cases {
        let output = phototaxis(here.path()).arg("bench").args(arguments).assert().code(1).get_output().clone();
        assert!(stderr(&output).contains(word), "{arguments:?}: {}", stderr(&output));
        assert_eq!(stdout(&output), "");
    }
    let cases: [(&[&str], &str); 4] = [
        (&[], "Usage"),
        (&["rays", "a.toml", "--turns", "0"], "'0' for '--turns"),
        (&["render", "a.toml", "--methods", "none,voodoo"], "voodoo"),
        (&["embree", "a.toml", "--albedo", "2"], "(0, 1]"),
    ];
    for (arguments, word) in cases {
        let output = phototaxis(here.path()).arg("bench").args(arguments).assert().code(2).get_output().clone();
        assert!(stderr(&output).contains(word), "{arguments:?}: {}", stderr(&output));
    }
    assert_eq!(names(here.path()), ["empty.obj"]);
}
