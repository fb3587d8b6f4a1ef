//! Renders that are shared among machines, or done again with another seed, and joined.

use super::{folder, names, phototaxis, scene, stderr, stdout};
use phototaxis::image::exr::{ExrFile, read_layers};
use serde_json::Value;
use std::path::Path;

const TINY: [&str; 5] = ["--size", "24x14", "--spp", "20", "-q"];

fn run(here: &Path, arguments: &[&str], code: i32) -> String {
    stderr(phototaxis(here).args(arguments).assert().code(code).get_output())
}

fn render(here: &Path, more: &[&str], code: i32) -> String {
    let door = scene("door.toml");
    run(here, &[&["render", door.to_str().unwrap()], &TINY[..], more].concat(), code)
}

fn picture(path: &Path) -> ExrFile {
    read_layers(path).unwrap()
}

#[test]
fn parts_make_one_picture_however_many_they_are() {
    let here = folder();
    let at = |name: &str| here.path().join(name);
    for (part, file) in [("1/1", "all"), ("1/3", "a"), ("2/3", "b"), ("3/3", "c")] {
        render(here.path(), &["--guide", "none", "--layers", "direct", "--part", part, "--film-out", file], 0);
    }
    assert_eq!(names(here.path()), ["a", "all", "b", "c"], "a part writes no picture");
    run(here.path(), &["merge", "all", "-o", "one.exr", "-q"], 0);
    run(here.path(), &["merge", "c", "a", "b", "-o", "three.exr", "-o", "three.png", "-q"], 0);
    let (one, three) = (picture(&at("one.exr")), picture(&at("three.exr")));
    assert!(one.channels == three.channels && one.channels.contains_key("direct.R"));
    assert_eq!(one.attributes.get("scene"), three.attributes.get("scene"));
    render(here.path(), &["--guide", "none", "-o", "whole.exr"], 0);
    let whole = picture(&at("whole.exr"));
    assert_eq!(one.attributes.get("sceneHash"), whole.attributes.get("sceneHash"));
    for (a, b) in one.channels["R"].iter().zip(&whole.channels["R"]) {
        assert!((a - b).abs() <= 1e-4 * b.abs() + 1e-9, "{a} and {b}");
    }
    let said = run(here.path(), &["merge", "a", "c", "-o", "x.exr"], 1);
    assert!(said.contains("c: the film: samples 6 to 12 before it are in no file"), "{said}");
    let said = run(here.path(), &["merge", "a", "whole.exr", "-o", "x.exr"], 1);
    assert!(said.contains("whole.exr: this is no film"), "{said}");
}

#[test]
fn parts_that_depend_on_each_other_are_refused() {
    let here = folder();
    let part = ["--part", "1/2", "--film-out", "a"];
    for (more, why) in [
        (&[][..], "--part needs --guide none, or --guide-in"),
        (&["--guide", "none", "--adaptive"], "cannot render adaptively"),
        (&["--guide", "none", "--set", "render.time=3"], "render.time or render.noise is given"),
        (&["--guide", "none", "--set", "render.order=blocks"], "needs render.order"),
    ] {
        let said = render(here.path(), &[&part[..], more].concat(), 1);
        assert!(said.contains(why), "{said}");
    }
    assert!(
        render(here.path(), &["--guide", "none", "--part", "1/21", "--film-out", "a"], 1).contains("have no 21 parts")
    );
    for wrong in [&["--part", "3/2", "--film-out", "a"][..], &["--part", "1/2"], &["--film-out", "a"]] {
        render(here.path(), wrong, 2);
    }
    render(here.path(), &[&part[..], &["-o", "a.exr"]].concat(), 2);
    assert_eq!(names(here.path()), [] as [&str; 0]);
}

#[test]
fn renders_with_other_seeds_are_joined() {
    let here = folder();
    for (seed, file) in [("1", "a"), ("2", "b"), ("1", "again")] {
        let checkpoint = format!("{file}.checkpoint");
        render(here.path(), &["--seed", seed, "-o", "x.exr", "--guide", "adaptive", "--checkpoint", &checkpoint], 0);
    }
    let mut command = phototaxis(here.path());
    command.args(["merge", "a.checkpoint", "b.checkpoint", "-o", "ab.exr", "-o", "ab.png", "-q", "--json", "-"]);
    let report: Value = serde_json::from_str(&stdout(command.assert().code(0).get_output())).unwrap();
    assert_eq!((&report["spp"], &report["spp_kept"]), (&Value::from(40), &Value::from(40)));
    assert!(here.path().join("ab.png").exists());
    let said = run(here.path(), &["merge", "a.checkpoint", "b.checkpoint", "again.checkpoint", "-o", "x.exr"], 1);
    assert!(said.contains("again.checkpoint: its render has the same seed as another"), "{said}");
    let said = run(here.path(), &["merge", "ab.exr", "b.checkpoint", "-o", "x.exr"], 1);
    assert!(said.contains("ab.exr: a picture does not say how"), "{said}");
    render(here.path(), &["-o", "x.exr", "--seed", "3", "--set", "film.width=25", "--checkpoint", "larger"], 0);
    let said = run(here.path(), &["merge", "a.checkpoint", "larger", "-o", "x.exr"], 1);
    assert!(said.contains("larger: the checkpoint: it is of another scene"), "{said}");
}
