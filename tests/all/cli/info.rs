//! `phototaxis info`.

use super::{folder, phototaxis, scene, stderr, stdout};
use serde_json::Value;
use std::path::Path;

fn info(here: &Path, file: &Path, arguments: &[&str]) -> std::process::Output {
    phototaxis(here).arg("info").arg(file).args(arguments).assert().code(0).get_output().clone()
}

fn json(here: &Path, file: &Path, arguments: &[&str]) -> Value {
    let output = info(here, file, &[arguments, &["--json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stdout(&output)))
}

/// A quad of 2 × 3 with a picture that is there and one with a picture that is not, and a lamp of area 1.
fn write_model(here: &Path) {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nv 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\nvt 0 0\nvt 1 0\nvt 1 1\n\
               usemtl wood\nf 1/1 2/2 3/3\nusemtl gone\nf 1/1 3/2 4/3\nusemtl lamp\nf 5 6 7 8\nusemtl nobody\nf 1 2 5\n";
    let mtl = "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nd 0.5\nnewmtl gone\nKd 0.2 0.4 0.6\nmap_Kd gone.png\n\
               newmtl lamp\nKd 0 0 0\nKe 2 2 2\n";
    std::fs::write(here.join("m.obj"), obj).unwrap();
    std::fs::write(here.join("m.mtl"), mtl).unwrap();
    image::RgbImage::from_pixel(7, 5, image::Rgb([9, 9, 9])).save(here.join("wood.png")).unwrap();
}

fn named<'a>(report: &'a Value, list: &str, name: &str) -> &'a Value {
    let items = report[list].as_array().unwrap();
    items.iter().find(|item| item["name"] == name).unwrap_or_else(|| panic!("no {name} in {list}: {report}"))
}

fn parameter<'a>(material: &'a Value, key: &str) -> &'a Value {
    let parameters = material["parameters"].as_array().unwrap();
    parameters.iter().find(|p| p["key"] == key).unwrap_or_else(|| panic!("no {key} in {material}"))
}

#[test]
fn a_model_is_listed_as_it_is_understood() {
    let here = folder();
    write_model(here.path());
    let report = json(here.path(), &here.path().join("m.obj"), &[]);
    assert_eq!((&report["schema"], &report["triangles"], &report["meshes"]), (&1.into(), &5.into(), &1.into()));
    assert_eq!(report["bounds"]["high"], serde_json::json!([2.0, 3.0, 5.0]));
    assert!(report["memory"]["embree"].as_u64().unwrap() > 0 && report["memory"]["meshes"].as_u64().unwrap() > 0);
    assert_eq!(report["camera"]["found"], true);
    let wood = named(&report, "materials", "wood");
    assert_eq!((&wood["type"], &wood["source"], &wood["area"]), (&"diffuse".into(), &"library".into(), &3.0.into()));
    assert!(parameter(wood, "reflectance")["value"]["texture"].as_str().unwrap().ends_with("wood.png"));
    assert_eq!(parameter(wood, "opacity")["value"], 0.5);
    assert_eq!(parameter(wood, "opacity")["from"], "library");
    assert_eq!(parameter(wood, "two_sided")["from"], "default");
    assert_eq!(named(&report, "materials", "nobody")["source"], "default");
}

#[test]
fn textures_are_listed_with_their_sizes_and_what_is_wrong_with_them() {
    let here = folder();
    write_model(here.path());
    std::fs::write(here.path().join("gone.png"), "no picture").unwrap();
    let toml = "[[mesh]]\npath = 'm.obj'\n[material.wood]\ntype = 'diffuse'\n[material.gone]\ntype = 'diffuse'\n";
    std::fs::remove_file(here.path().join("gone.png")).unwrap();
    let report = json(here.path(), &here.path().join("m.obj"), &[]);
    let pictures = report["textures"].as_array().unwrap();
    assert_eq!(pictures.len(), 2);
    assert_eq!((&pictures[0]["error"], &pictures[0]["materials"]), (&"missing".into(), &serde_json::json!(["gone"])));
    assert_eq!((&pictures[1]["width"], &pictures[1]["height"]), (&7.into(), &5.into()));
    assert_eq!(pictures[1]["error"], Value::Null);
    let warnings = report["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|w| w.as_str().unwrap().contains("gone.png")), "{warnings:?}");
    // a scene file that says otherwise has no pictures left
    std::fs::write(here.path().join("s.toml"), toml).unwrap();
    let report = json(here.path(), &here.path().join("s.toml"), &["--set", "material.wood.reflectance=0.25"]);
    assert_eq!(report["textures"].as_array().map(Vec::len), Some(0));
    let wood = named(&report, "materials", "wood");
    assert_eq!(wood["source"], "scene file");
    assert_eq!(parameter(wood, "reflectance")["value"], serde_json::json!([0.25, 0.25, 0.25]));
}

#[test]
fn lights_are_listed_with_their_power() {
    let here = folder();
    write_model(here.path());
    let report = json(here.path(), &here.path().join("m.obj"), &[]);
    let lights = report["lights"].as_array().unwrap();
    let lamp = lights.iter().find(|light| light["material"] == "lamp").unwrap();
    // radiance · π · area
    assert!((lamp["power"].as_f64().unwrap() - 2.0 * std::f64::consts::PI).abs() < 1e-5, "{lamp}");
    assert_eq!((&lamp["kind"], &lamp["triangles"], &lamp["area"]), (&"surface".into(), &2.into(), &1.0.into()));
    let toml = "[[mesh]]\npath = 'm.obj'\n[[light]]\ntype = 'point'\nposition = [0, 9, 0]\nintensity = 3\n";
    std::fs::write(here.path().join("s.toml"), toml).unwrap();
    let report = json(here.path(), &here.path().join("s.toml"), &[]);
    let point = report["lights"].as_array().unwrap().iter().find(|light| light["kind"] == "point").unwrap().clone();
    // 4π · intensity
    assert!((point["power"].as_f64().unwrap() - 12.0 * std::f64::consts::PI).abs() < 1e-4, "{point}");
    assert_eq!(
        (&point["added"], &point["parameters"]["intensity"]),
        (&false.into(), &serde_json::json!([3.0, 3.0, 3.0]))
    );
    std::fs::write(here.path().join("dark.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let dark = json(here.path(), &here.path().join("dark.obj"), &[]);
    assert_eq!((&dark["lights"][0]["kind"], &dark["lights"][0]["added"]), (&"constant".into(), &true.into()));
}

#[test]
fn cameras_and_instances_are_listed() {
    let here = folder();
    write_model(here.path());
    let toml = "[cameras.side]\norigin = [9, 1, 1]\ntarget = [0, 0, 1]\n[cameras.top]\nvfov = 30\n[[mesh]]\npath = 'm.obj'\n\
                group = 'a'\n[[instance]]\ngroup = 'a'\n[[instance]]\ngroup = 'a'\ntranslate = [9, 0, 0]\n";
    std::fs::write(here.path().join("s.toml"), toml).unwrap();
    let report = json(here.path(), &here.path().join("s.toml"), &[]);
    assert_eq!(report["cameras"], serde_json::json!(["side", "top"]));
    assert_eq!((&report["camera"]["found"], &report["camera"]["origin"][0]), (&false.into(), &9.0.into()));
    assert_eq!((&report["triangles"], &report["instances"]), (&10.into(), &2.into()));
    assert_eq!(named(&report, "materials", "lamp")["area"], 2.0);
    let top = json(here.path(), &here.path().join("s.toml"), &["--camera", "top"]);
    assert_eq!((&top["camera"]["found"], &top["camera"]["vfov"]), (&true.into(), &30.0.into()));
}

#[test]
fn people_read_the_same() {
    let here = folder();
    let said = stdout(&info(here.path(), &scene("cornell.toml"), &[]));
    for part in [
        "triangles    38 in 1 meshes",
        "of the scene file: perspective, origin",
        "lights\n",
        "surfaces of ",
        "reflectance = [",
    ] {
        assert!(said.contains(part), "{part} is missing in: {said}");
    }
}

#[test]
fn a_file_that_cannot_be_rendered_is_refused() {
    let here = folder();
    std::fs::write(here.path().join("a.obj"), "v 0 0 zero\n").unwrap();
    for (file, message) in
        [("a.obj", "a.obj:1:7: `zero` is not a number"), ("none.obj", "none.obj"), ("a.blend", "not a scene")]
    {
        let output = phototaxis(here.path()).args(["info", file]).assert().code(1).get_output().clone();
        assert!(stderr(&output).starts_with("error: ") && stderr(&output).contains(message), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
    }
}
