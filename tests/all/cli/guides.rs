//! Guides that outlive a render, and what `phototaxis inspect` shows of them.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use phototaxis::image::exr::{ExrFile, read_layers};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// So few states that a tiny picture teaches them all something.
const COARSE: [&str; 2] = ["--set", "guiding.resolution=4"];

/// Runs a command on `cornell`, tiny, and coarse where there is a guide to be so.
fn run(here: &Path, command: &str, arguments: &[&str], code: i32) -> Output {
    let mut program = phototaxis(here);
    program.arg(command).arg(scene("cornell.toml")).args(TINY);
    if !arguments.iter().any(|argument| ["none", "guiding.method=none"].contains(argument)) {
        program.args(COARSE);
    }
    program.args(arguments).assert().code(code).get_output().clone()
}

/// A guide that has learnt, `a.guide`.
fn learn(here: &Path) {
    run(here, "render", &["--spp", "64", "-q", "-o", "a.exr", "--guide-out", "a.guide"], 0);
}

fn values<'a>(picture: &'a ExrFile, name: &str) -> &'a [f32] {
    picture.channels.get(name).unwrap_or_else(|| panic!("no {name} among {:?}", picture.channels.keys()))
}

#[test]
fn a_kept_guide_serves_another_camera() {
    let here = folder();
    learn(here.path());
    assert_eq!(names(here.path()), ["a.exr", "a.guide"]);
    let other = ["--set", "camera.origin=[0.1, 0.3, 1]", "--set", "film.height=20", "--guide-in", "a.guide", "-q"];
    let asked = ["--spp", "2", "-o", "b.exr", "--json", "-"];
    let output = run(here.path(), "render", &[&other[..], &asked].concat(), 0);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["iterations"].as_array().unwrap().len(), 1, "it goes on where the other ended: {report}");
    assert!(report["guide"]["hit_share"].as_f64().unwrap() > 0.5, "{report}");
}

#[test]
fn guides_that_do_not_fit_are_refused_with_the_reason() {
    let here = folder();
    learn(here.path());
    let whole = std::fs::read(here.path().join("a.guide")).unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(here.path().join(name), bytes).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    write("damaged.guide", &damaged);
    write("short.guide", &whole[..whole.len() - 1]);
    let mut newer = whole;
    newer[8] += 1;
    write("newer.guide", &newer);
    write("text.guide", b"no guide");
    let cases: [(&[&str], &str); 9] = [
        (&["--guide-in", "none.guide"], "none.guide: No such file"),
        (&["--guide-in", "damaged.guide"], "damaged.guide: the guide is damaged"),
        (&["--guide-in", "short.guide"], "short.guide: the guide is truncated"),
        (&["--guide-in", "newer.guide"], "newer.guide: the guide is of version 10"),
        (&["--guide-in", "text.guide"], "text.guide: this is not a guide's file"),
        (&["--guide-in", "a.guide", "--set", "guiding.resolution=5"], "guiding.resolution was 4 and is 5"),
        (&["--guide-in", "a.guide", "--set", "integrator.mis=false"], "integrator.mis was true and is false"),
        (&["--guide-in", "a.guide", "--set", "guiding.memory=65536"], "guiding.memory"),
        (&["--guide-in", "a.guide", "--guide", "none"], "--guide-in needs a guide"),
    ];
    for (arguments, word) in cases {
        let output = run(here.path(), "render", &[arguments, &["--spp", "2", "-o", "b.exr"]].concat(), 1);
        assert!(stderr(&output).starts_with("error: ") && stderr(&output).contains(word), "{}", stderr(&output));
    }
    let mut program = phototaxis(here.path());
    let arguments = ["--guide-in", "a.guide", "-o", "b.exr"];
    let other = program.arg("render").arg(scene("furnace.toml")).args(arguments).assert().code(1).get_output().clone();
    assert!(stderr(&other).contains("a.guide: the guide was learnt in another scene"), "{}", stderr(&other));
    assert!(!here.path().join("b.exr").exists());
}

#[test]
fn options_that_could_do_nothing_are_refused() {
    let here = folder();
    let cases: [(&[&str], &str); 4] = [
        (&["--guide", "none", "--guide-out", "a.guide"], "--guide-out needs a guide"),
        (&["--guide", "none", "--guide-layers"], "--guide-layers needs a guide"),
        (&["--guide-layers", "-o", "a.png"], "--guide-layers needs a picture in EXR"),
        (&["--guide-out", "no/a.guide"], "no/a.guide: its folder does not exist"),
    ];
    for (arguments, word) in cases {
        let output = run(here.path(), "render", &[arguments, &["--spp", "1"]].concat(), 1);
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
    }
    assert!(names(here.path()).is_empty());
}

#[test]
fn guide_layers_are_in_the_exr_when_asked_for() {
    let here = folder();
    run(here.path(), "render", &["--spp", "64", "-q", "-o", "a.exr"], 0);
    let plain = read_layers(&here.path().join("a.exr")).unwrap();
    assert!(!plain.channels.keys().any(|name| name.starts_with("guide.")));
    run(here.path(), "render", &["--spp", "64", "-q", "-o", "b.exr", "--guide-layers"], 0);
    let picture = read_layers(&here.path().join("b.exr")).unwrap();
    assert_eq!(values(&plain, "R"), values(&picture, "R"), "looking changes nothing");
    check_guide_layers(&picture);
}

/// The layers of a guide that knows most of what is seen.
fn check_guide_layers(picture: &ExrFile) {
    let [fraction, visits, state] = ["guide.fraction.Y", "guide.visits.Y", "guide.state.Y"].map(|n| values(picture, n));
    assert!(fraction.iter().all(|&x| x == 0.0 || x == 0.5), "{fraction:?}");
    assert!(fraction.iter().filter(|&&x| x == 0.5).count() > fraction.len() / 4, "{fraction:?}");
    for ((&fraction, &visits), &state) in fraction.iter().zip(visits).zip(state) {
        assert_eq!(visits > 0.0, state > 0.0, "{visits} visits of state {state}");
        assert!(fraction == 0.0 || visits >= 16.0, "guided after {visits} visits");
        assert!(state.fract() == 0.0 && state < 16_777_216.0, "{state}");
    }
    let distinct: std::collections::BTreeSet<u32> = state.iter().map(|x| x.to_bits()).collect();
    assert!(distinct.len() > 10, "only {} states", distinct.len());
}

#[test]
fn inspect_writes_pictures_and_figures() {
    let here = folder();
    learn(here.path());
    let asked = ["--guide-in", "a.guide", "--pixel", "8,11", "--truth-samples", "4", "-o", "new/place"];
    let output = run(here.path(), "inspect", &[&asked[..], &["--json", "a.json"]].concat(), 0);
    for word in ["correlation with the truth", "bytes per state", "visits 100 to 1000"] {
        assert!(stdout(&output).contains(word), "{word} is missing in:\n{}", stdout(&output));
    }
    let folder = here.path().join("new/place");
    let all = ["hemisphere.exr", "hemisphere.png", "latlong.exr", "latlong.png", "states.exr", "states.png"];
    assert_eq!(names(&folder), all);
    check_guide_layers(&read_layers(&folder.join("states.exr")).unwrap());
    for name in ["hemisphere", "latlong"] {
        let picture = read_layers(&folder.join(name).with_extension("exr")).unwrap();
        ["learnt.Y", "traced.Y"].into_iter().for_each(|layer| {
            let light = values(&picture, layer);
            assert!(light.iter().all(|&x| x >= 0.0) && light.iter().any(|&x| x > 0.0), "{name}, {layer}");
        });
        assert!(image::open(folder.join(name).with_extension("png")).is_ok());
    }
    check_report(&serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap());
}

fn check_report(report: &Value) {
    let number =
        |path: &str| report.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {report}"));
    assert_eq!((number("/schema"), number("/pixel/0"), number("/pixel/1")), (1.0, 8.0, 11.0));
    assert!((number("/normal/1") - 1.0).abs() < 1e-4, "this pixel shows the floor: {report}");
    assert_eq!(report["state"]["key"].as_str().map(str::len), Some(16));
    assert_eq!(report["state"]["usable"].as_bool(), Some(true));
    assert!(number("/radiance/correlation").abs() <= 1.0 && number("/radiance/truth_noise") > 0.0);
    assert!(number("/radiance/learnt_irradiance") > 0.0 && number("/radiance/traced_irradiance") > 0.0);
    let states = number("/guide/states");
    let decades = report["guide"]["visits"].as_array().unwrap();
    assert_eq!(decades.iter().map(|d| d["states"].as_f64().unwrap()).sum::<f64>(), states);
    let [mean, low, high] = ["mean", "min", "max"].map(|k| number(&format!("/guide/{k}_bytes")));
    assert!(0.0 < low && low <= mean && mean <= high && number("/guide/bytes") >= states * low);
    assert!(["not_met_share", "unusable_share"].iter().all(|k| (0.0..1.0).contains(&number(&format!("/guide/{k}")))));
    assert!(number("/guide/tree_nodes") >= states);
}

#[test]
fn inspect_trains_a_guide_where_none_is_given() {
    let here = folder();
    let asked = ["--spp", "64", "-q", "--pixel", "8,11", "--truth-samples", "2", "-o", ".", "--json", "-"];
    let report: Value = serde_json::from_slice(&run(here.path(), "inspect", &asked, 0).stdout).unwrap();
    assert!(report["state"]["visits"].as_f64().unwrap() > 0.0, "{report}");
}

#[test]
fn inspect_refuses_what_it_cannot_show() {
    let here = folder();
    let cases: [(&[&str], i32, &str); 5] = [
        (&["--pixel", "16,0"], 1, "pixel 16,0 is not in the picture: it has 16 × 12 pixels"),
        (&["--pixel", "1"], 2, "expected X,Y"),
        (&["--pixel", "8,11", "--set", "guiding.method=none"], 1, "guiding.method is none"),
        (&["--pixel", "8,11", "--spp", "4", "--guide-in", "a.guide"], 2, "cannot be used with"),
        (&["--pixel", "8,11", "--set", "camera.target=[0, 90, 0]", "--set", "camera.up=[1, 0, 0]"], 1, "no surface"),
    ];
    for (arguments, code, word) in cases {
        let output = run(here.path(), "inspect", &[arguments, &["-o", "new"]].concat(), code);
        assert!(stderr(&output).contains(word), "{}", stderr(&output));
    }
    assert!(names(here.path()).is_empty());
}
