//! `phototaxis convert`.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};

#[test]
fn a_scene_is_written_with_its_files_and_renders() {
    let here = folder();
    let cornell = scene("cornell.toml");
    for out in ["a.toml", "b.xml"] {
        phototaxis(here.path()).arg("convert").arg(&cornell).arg(out).args(TINY).assert().code(0);
        let output = phototaxis(here.path()).args(["info", out]).assert().code(0).get_output().clone();
        assert!(stdout(&output).contains("16 x 12 pixels"), "{}", stdout(&output));
    }
    phototaxis(here.path()).args(["render", "b.xml", "--spp", "2", "-o", "b.png", "-q"]).assert().code(0);
    assert_eq!(names(here.path()), ["a files", "a.toml", "b files", "b.png", "b.xml"]);
}

#[test]
fn what_cannot_be_written_is_said() {
    let here = folder();
    let cornell = scene("cornell.toml");
    std::fs::copy(&cornell, here.path().join("own.toml")).unwrap();
    let lens = ["--set", "camera.aperture_radius=0.1"];
    let cases: [(&str, &[&str], &str); 3] = [
        ("a.obj", &[], "a scene is written as .toml, or for Mitsuba as .xml"),
        ("a.xml", &lens, "Mitsuba has no counterpart: a part of a picture, or a camera that is no pinhole"),
        ("none/a.toml", &[], "none"),
    ];
    for (out, more, said) in cases {
        let asserted = phototaxis(here.path()).arg("convert").arg(&cornell).arg(out).args(more).assert().code(1);
        assert!(stderr(asserted.get_output()).contains(said), "{}", stderr(asserted.get_output()));
    }
    let over = phototaxis(here.path()).args(["convert", "own.toml", "own.toml"]).assert().code(1);
    assert!(stderr(over.get_output()).contains("written over itself"), "{}", stderr(over.get_output()));
}
