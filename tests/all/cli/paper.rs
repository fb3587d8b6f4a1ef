//! `phototaxis paper`, tiny.

use super::{folder, names, phototaxis, stderr, stdout};
use phototaxis::image::exr::read_rgb;
use serde_json::Value;

#[test]
fn the_list_names_every_picture_of_the_paper() {
    let here = folder();
    let list = stdout(&phototaxis(here.path()).args(["paper", "--list"]).assert().code(0).get_output().clone());
    for name in ["fig1a", "fig1b", "fig1c", "fig1d", "fig1e", "fig1f", "fig2a", "fig2d", "fig3", "fig3-normals"] {
        assert!(list.lines().any(|line| line.split(' ').next() == Some(name)), "{name} is missing in:\n{list}");
    }
    assert!(names(here.path()).is_empty());
}

#[test]
fn pictures_figures_and_a_table_are_written() {
    let here = folder();
    let small = ["--scale", "0.1", "--spp", "4", "--reference-spp", "8", "--out", "new/place"];
    let run = |presets: &[&str]| {
        let only = presets.iter().flat_map(|name| ["--only", name]);
        phototaxis(here.path()).arg("paper").args(small).args(only).assert().code(0).get_output().clone()
    };
    let output = run(&["fig1c", "fig1a", "fig1d"]);
    let out = here.path().join("new/place");
    let mut expected: Vec<String> = ["fig1a", "fig1c", "fig1d"]
        .iter()
        .flat_map(|name| ["exr", "json", "png"].map(|extension| format!("{name}.{extension}")))
        .chain(["door.mtl", "door.obj", "door.toml", "paper.json", "reference-door.exr"].map(String::from))
        .collect();
    expected.sort();
    assert_eq!(names(&out), expected);
    let lines: Vec<String> = stdout(&output).lines().map(String::from).collect();
    assert_eq!(lines.len(), 5, "headings, rule, three rows:\n{}", lines.join("\n"));
    assert!(lines[2].starts_with("| fig1a |") && lines[2].contains("| 1.00 |"), "{}", lines[2]);
    let file: Value = serde_json::from_slice(&std::fs::read(out.join("paper.json")).unwrap()).unwrap();
    check_rows(&file["presets"]);
    assert!(file["platform"]["embree_isa"].is_string(), "{file}");
    let picture = read_rgb(&out.join("fig1c.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (26, 14));

    let reference = std::fs::read(out.join("reference-door.exr")).unwrap();
    let again = run(&["fig1d"]);
    assert!(!stderr(&again).contains("reference"), "it is there already: {}", stderr(&again));
    assert_eq!(std::fs::read(out.join("reference-door.exr")).unwrap(), reference);
}

fn check_rows(rows: &Value) {
    let rows = rows.as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["preset"].as_str().unwrap()).collect();
    assert_eq!(names, ["fig1a", "fig1c", "fig1d"]);
    for row in rows {
        assert_eq!(row["spp"], 4);
        assert!(row["relmse"].as_f64().unwrap() > 0.0 && row["wall_seconds"].as_f64().unwrap() > 0.0, "{row}");
        let lengths = row["path_lengths"].as_array().unwrap();
        assert!(lengths.iter().all(|l| (1.0..=16.0).contains(&l.as_f64().unwrap())), "{row}");
        let guided = row["preset"] != "fig1d";
        assert_eq!(row["guide_bytes"].as_u64().unwrap() > 0, guided, "{row}");
    }
    let iterations = |k: usize| rows[k]["path_lengths"].as_array().unwrap().len();
    assert!(iterations(0) > 1 && iterations(1) == 1, "progressive and in one go");
}

#[test]
fn an_unknown_preset_is_refused_before_anything_is_rendered() {
    let here = folder();
    let arguments = ["paper", "--only", "fig9"];
    let output = phototaxis(here.path()).args(arguments).assert().code(1).get_output().clone();
    assert!(stderr(&output).contains("fig9") && stderr(&output).contains("fig1a"), "{}", stderr(&output));
    assert!(names(here.path()).is_empty());
}

#[test]
fn what_was_learnt_is_drawn_beside_what_is_traced() {
    let here = folder();
    let small = ["--scale", "0.1", "--spp", "64", "--reference-spp", "8", "--only", "fig1f", "-q"];
    phototaxis(here.path()).arg("paper").args(small).assert().code(0);
    for name in ["fig1f-latlong.png", "fig1f-latlong.exr", "fig1f-hemisphere.png", "fig1f-hemisphere.exr"] {
        assert!(here.path().join("paper").join(name).exists(), "{name} is missing");
    }
    let rows: Value = serde_json::from_slice(&std::fs::read(here.path().join("paper/paper.json")).unwrap()).unwrap();
    let q = &rows["presets"][0]["q"];
    let positive = |key: &str| q[key].as_f64().unwrap() > 0.0;
    assert!(positive("learnt_irradiance") && positive("traced_irradiance") && positive("directions"), "{q}");
}

#[test]
fn rates_are_charted_against_visits() {
    let here = folder();
    let output = phototaxis(here.path()).args(["rates", "--spp", "7"]).assert().code(0).get_output().clone();
    assert!(
        stdout(&output).lines().filter(|line| line.starts_with("vanishing rate")).count() >= 2,
        "{}",
        stdout(&output)
    );
    let rates: Value = serde_json::from_slice(&std::fs::read(here.path().join("rates/rates.json")).unwrap()).unwrap();
    assert_eq!(rates["curves"].as_array().unwrap().len(), 6);
    assert!(rates["platform"]["embree_isa"].is_string(), "{rates}");
    for name in ["rates.svg", "rates.png"] {
        assert!(std::fs::metadata(here.path().join("rates").join(name)).unwrap().len() > 1000, "{name}");
    }
    let wrong = phototaxis(here.path()).args(["rates", "--albedo", "1"]).assert().code(2).get_output().clone();
    assert!(stderr(&wrong).contains("not including, 1"), "{}", stderr(&wrong));
}
