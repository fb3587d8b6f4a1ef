//! Help, usage errors, and the commands beside `render`.

use super::{TINY, folder, names, phototaxis, program, scene, stderr, stdout};
use serde_json::Value;

#[test]
fn help_names_every_command_and_the_exit_codes() {
    let here = folder();
    let help = stdout(&phototaxis(here.path()).arg("--help").assert().code(0).get_output().clone());
    for word in ["render", "error", "bench", "paper", "inspect", "generate", "Exit codes: 0", "130"] {
        assert!(help.contains(word), "{word} is missing in:\n{help}");
    }
    let help = stdout(&phototaxis(here.path()).args(["render", "--help"]).assert().code(0).get_output().clone());
    for word in [
        "--output",
        "--spp",
        "--time",
        "--guide",
        "--guide-in",
        "--guide-out",
        "--guide-layers",
        "--set",
        "--json",
        "--quiet",
        "Examples:",
    ] {
        assert!(help.contains(word), "{word} is missing in:\n{help}");
    }
}

#[test]
fn wrong_usage_is_exit_code_2_and_says_what() {
    let here = folder();
    let cases: [(&[&str], &str); 7] = [
        (&[], "Usage"),
        (&["paint"], "'paint'"),
        (&["render"], "<SCENE>"),
        (&["render", "a.toml", "--spp", "0"], "'0' for '--spp"),
        (&["render", "a.toml", "--spp", "-3"], "-3"),
        (&["render", "a.toml", "--time", "nan"], "positive number of seconds"),
        (&["render", "a.toml", "--guide", "voodoo"], "voodoo"),
    ];
    for (arguments, word) in cases {
        let output = phototaxis(here.path()).args(arguments).assert().code(2).get_output().clone();
        assert!(stderr(&output).contains(word), "{arguments:?}: {}", stderr(&output));
        assert_eq!(stdout(&output), "");
    }
    assert!(names(here.path()).is_empty());
}

#[test]
fn generate_lists_and_writes_scenes() {
    let here = folder();
    let list = stdout(&phototaxis(here.path()).arg("generate").assert().code(0).get_output().clone());
    for name in ["door", "wall", "cornell", "furnace", "city", "forest", "terrain"] {
        assert!(list.lines().any(|line| line.split(' ').next() == Some(name)), "{name} is missing in:\n{list}");
    }
    let written = phototaxis(here.path()).args(["generate", "cornell", "--out", "new/place"]).assert().code(0);
    assert_eq!(stdout(written.get_output()).lines().count(), 3);
    for extension in ["toml", "obj", "mtl"] {
        let file = format!("cornell.{extension}");
        let ours = std::fs::read(here.path().join("new/place").join(&file)).unwrap();
        assert_eq!(ours, std::fs::read(scene(&file)).unwrap(), "{file}");
    }
    let large = ["generate", "terrain", "--triangles", "12000", "--out", "land"];
    let written = phototaxis(here.path()).args(large).assert().code(0);
    assert_eq!(stdout(written.get_output()).lines().next(), Some("land/terrain.toml"));
    for (scene, triangles, word) in [("door", "20000", "one size"), ("city", "99", "10000")] {
        let arguments = ["generate", scene, "--triangles", triangles, "--out", "none"];
        let refused = phototaxis(here.path()).args(arguments).assert().code(1).get_output().clone();
        assert!(stderr(&refused).contains(word) && !here.path().join("none").exists(), "{}", stderr(&refused));
    }
    let unknown = phototaxis(here.path()).args(["generate", "castle"]).assert().code(1).get_output().clone();
    assert!(stderr(&unknown).contains("castle") && stderr(&unknown).contains("furnace"), "{}", stderr(&unknown));
}

/// Two renders of one scene: `a.exr`, and `b.exr` with another seed.
fn two_pictures(here: &std::path::Path) {
    for (file, seed) in [("a.exr", "1"), ("b.exr", "2")] {
        let arguments = ["--spp", "2", "--seed", seed, "-o", file, "--quiet"];
        phototaxis(here).arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments).assert().code(0);
    }
}

#[test]
fn error_is_zero_for_a_picture_against_itself_and_positive_for_other_noise() {
    let here = folder();
    two_pictures(here.path());
    let measure = |image: &str| -> Value {
        let output = phototaxis(here.path())
            .args(["error", image, "--reference", "a.exr"])
            .assert()
            .code(0)
            .get_output()
            .clone();
        serde_json::from_str(&stdout(&output)).unwrap()
    };
    let (same, other) = (measure("a.exr"), measure("b.exr"));
    for key in ["mse", "relmse", "relmse_trimmed", "mape", "smape"] {
        assert_eq!(same["images"][0][key].as_f64(), Some(0.0), "{key}");
        assert!(other["images"][0][key].as_f64().unwrap() > 0.0, "{key}: {other}");
    }
}

#[test]
fn error_summarises_several_pictures() {
    let here = folder();
    two_pictures(here.path());
    let arguments = ["error", "a.exr", "b.exr", "--reference", "a.exr"];
    let output = phototaxis(here.path()).args(arguments).assert().code(0).get_output().clone();
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let of = |k: usize| report["images"][k]["relmse"].as_f64().unwrap();
    let mean = report["relmse"]["mean"].as_f64().unwrap();
    assert!((mean - 0.5 * (of(0) + of(1))).abs() < 1e-12);
    assert!(report["relmse"]["low"].as_f64().unwrap() < mean && report["relmse"]["high"].as_f64().unwrap() > mean);
    assert!(report["relmse_of_reference"].as_f64().unwrap() > 0.0, "two samples have a variance");
}

#[test]
fn error_refuses_what_cannot_be_compared() {
    let here = folder();
    two_pictures(here.path());
    let small = ["--set", "film.width=8", "--spp", "1", "-o", "small.exr", "-q"];
    phototaxis(here.path()).arg("render").arg(scene("cornell.toml")).args(small).assert().code(0);
    std::fs::write(here.path().join("text.exr"), "no picture").unwrap();
    for (image, word) in [("small.exr", "16 × 12"), ("text.exr", "text.exr"), ("none.exr", "none.exr")] {
        let output = phototaxis(here.path())
            .args(["error", image, "--reference", "a.exr"])
            .assert()
            .code(1)
            .get_output()
            .clone();
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
    }
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let here = folder();
    let mut child = std::process::Command::new(program())
        .args(["generate", "door", "--out"])
        .arg(here.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).starts_with("error: standard output"), "{}", stderr(&output));
}
