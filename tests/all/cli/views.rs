//! Where the camera stands that nobody has placed, as users meet it.

use super::{folder, phototaxis, stderr};
use std::path::Path;

/// A box of 2 × 2 × 2 and a smaller one on it, whose head says that z is up.
fn write_tower(folder: &Path, head: &str) {
    let corner = |low: [f32; 3], high: [f32; 3], k: usize| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
        format!("v {} {} {}\n", pick(0), pick(1), pick(2))
    };
    let boxes = [([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]), ([-0.3, -0.3, 2.0], [0.3, 0.3, 6.0])];
    let mut text = head.to_string();
    for (low, high) in boxes {
        (0..8).for_each(|k| text += &corner(low, high, k));
    }
    for first in [1, 9] {
        for [a, b, c, d] in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
            text += &format!("f {} {} {} {}\n", first + a, first + b, first + c, first + d);
        }
    }
    std::fs::write(folder.join("tower.obj"), text).unwrap();
}

/// What the program says of the camera when it renders the model.
fn note(here: &Path, arguments: &[&str]) -> String {
    let mut command = phototaxis(here);
    let tiny = ["--size", "32x24", "--spp", "1"];
    let output = command.args(["render", "tower.obj"]).args(tiny).args(arguments).assert().code(0).get_output().clone();
    let said = stderr(&output);
    said.lines().find(|line| line.starts_with("note: the camera")).map(str::to_string).unwrap_or_default()
}

/// A vector that the note says.
fn vector(note: &str, key: &str) -> [f64; 3] {
    let text = note.split(&format!("camera.{key}=[")).nth(1).unwrap_or_else(|| panic!("no {key} in {note}"));
    let numbers: Vec<f64> = text.split(']').next().unwrap().split(", ").map(|x| x.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

#[test]
fn the_axis_that_is_up_is_chosen_or_said_by_the_file() {
    let here = folder();
    write_tower(here.path(), "");
    let standing = note(here.path(), &[]);
    assert!(!standing.contains("camera.up") && vector(&standing, "origin")[1] > 0.5, "y is up: {standing}");
    let chosen = note(here.path(), &["--up", "z"]);
    assert_eq!(vector(&chosen, "up"), [0.0, 0.0, 1.0]);
    assert!(vector(&chosen, "origin")[2] > 3.0 && vector(&chosen, "origin")[1] < 0.0, "{chosen}");
    write_tower(here.path(), "# units: m, up axis: Z\n");
    assert_eq!(note(here.path(), &[]), chosen);
    let over = note(here.path(), &["--up", "-y"]);
    assert_eq!(vector(&over, "up"), [0.0, -1.0, 0.0]);
    let wrong =
        phototaxis(here.path()).args(["render", "tower.obj", "--up", "w"]).assert().code(2).get_output().clone();
    assert!(stderr(&wrong).contains("possible values: x, y, z"), "{}", stderr(&wrong));
}

#[test]
fn what_is_said_makes_the_same_picture_and_single_keys_are_kept() {
    let here = folder();
    write_tower(here.path(), "");
    let found = note(here.path(), &["-o", "found.png", "--set", "camera.vfov=30"]);
    assert!(found.ends_with("camera.vfov=30"), "{found}");
    let lens = note(here.path(), &["--set", "camera.target=[0, 0, 1]"]);
    assert_eq!(vector(&lens, "target"), [0.0, 0.0, 1.0]);
    let place = note(here.path(), &["--set", "camera.origin=[9, 8, 7]"]);
    assert_eq!(vector(&place, "origin"), [9.0, 8.0, 7.0]);
    // what the note says, said
    let keys = ["origin", "target"].map(|key| format!("camera.{key}={:?}", vector(&found, key)));
    let said = ["-o", "said.png", "--set", "camera.vfov=30", "--set", &keys[0], "--set", &keys[1]];
    assert_eq!(note(here.path(), &said), "", "nothing is left to be found");
    let pixels = |name: &str| image::open(here.path().join(name)).unwrap().into_rgb8();
    assert!(pixels("found.png").pixels().any(|p| p.0 != pixels("found.png").get_pixel(0, 0).0));
    assert_eq!(pixels("found.png"), pixels("said.png"));
}

/// What the program says on standard error when it renders a scene of this text beside the model.
fn said_of(here: &Path, scene: &str, arguments: &[&str], code: i32) -> String {
    std::fs::write(here.join("scene.toml"), scene).unwrap();
    let mut command = phototaxis(here);
    let tiny = ["--size", "16x12", "--spp", "2", "-o", "a.png", "--json", "a.json"];
    stderr(&command.args(["render", "scene.toml"]).args(tiny).args(arguments).assert().code(code).get_output().clone())
}

const TOWER: &str = "[[mesh]]\npath = 'tower.obj'\n";

#[test]
fn a_black_picture_is_warned_of_with_the_likely_reason() {
    let here = folder();
    write_tower(here.path(), "");
    let from = |origin: &str| format!("[camera]\norigin = {origin}\ntarget = [0, 9, 0.5]\n{TOWER}");
    let point = "[[light]]\ntype = 'point'\nposition = [0, 0, 9]\nintensity = ";
    let cases = [
        (from("[0, 0, 9]"), "0", "nothing emits light"),
        (format!("[camera]\norigin = [0, 0, 90]\ntarget = [0, 0, 99]\n{TOWER}"), "1", "sees no surface"),
        (format!("[camera]\norigin = [0.1, 0.2, 1]\ntarget = [0, 0.9, 1]\n{TOWER}"), "1", "within a closed surface"),
        (
            format!("[camera]\norigin = [0, 0, -9]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n{TOWER}"),
            "1",
            "no light was found",
        ),
    ];
    for (scene, intensity, reason) in cases {
        let said = said_of(here.path(), &format!("{scene}{point}{intensity}\n"), &[], 0);
        let warning = said.lines().find(|line| line.starts_with("warning: the picture is black; "));
        assert!(warning.is_some_and(|warning| warning.contains(reason)), "{reason}: {said}");
        let report: serde_json::Value =
            serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
        assert!(report["black_picture"].as_str().is_some_and(|text| text.contains(reason)));
    }
    let lit =
        said_of(here.path(), &format!("[camera]\norigin = [0, 1, 30]\ntarget = [0, 0, 0]\n{TOWER}{point}1\n"), &[], 0);
    assert!(!lit.contains("black"), "{lit}");
}

#[test]
fn a_camera_is_chosen_by_name() {
    let here = folder();
    write_tower(here.path(), "");
    let scene = format!("[cameras.side]\norigin = [9, 1, 1]\ntarget = [0, 0, 1]\n[cameras.free]\nvfov = 50\n{TOWER}");
    assert!(!said_of(here.path(), &scene, &[], 0).contains("the camera stands"), "the first has a place");
    let free = said_of(here.path(), &scene, &["--camera", "free"], 0);
    assert!(free.contains("the camera stands") && free.contains("camera.vfov=50"), "{free}");
    let wrong = said_of(here.path(), &scene, &["--camera", "sid"], 1);
    assert!(wrong.contains("scene.toml: there is no camera `sid`: did you mean `side`?"), "{wrong}");
}

#[test]
fn a_camera_in_survey_coordinates_is_said_in_them() {
    let here = folder();
    write_tower(here.path(), "# Z-up\n");
    let near = note(here.path(), &[]);
    let text = std::fs::read_to_string(here.path().join("tower.obj")).unwrap();
    let moved = text.lines().map(|line| match line.strip_prefix("v ") {
        Some(rest) => {
            let p: Vec<f64> = rest.split(' ').map(|x| x.parse().unwrap()).collect();
            format!("v {} {} {}\n", p[0] + 4_500_000.0, p[1] + 5_600_000.0, p[2] + 300.0)
        }
        None => format!("{line}\n"),
    });
    std::fs::write(here.path().join("tower.obj"), moved.collect::<String>()).unwrap();
    let far = note(here.path(), &[]);
    for key in ["origin", "target"] {
        let [a, b] = [vector(&near, key), vector(&far, key)];
        let off = [b[0] - 4_500_000.0 - a[0], b[1] - 5_600_000.0 - a[1], b[2] - 300.0 - a[2]];
        assert!(off.iter().all(|x| x.abs() < 0.01), "{key}: {near}\n{far}");
    }
}
