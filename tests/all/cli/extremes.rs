//! Pictures with pixels that are not finite: written, counted, named, and never taken for good ones.

use super::{TINY, folder, names, phototaxis, stderr, stdout};
use phototaxis::image::Layer;
use phototaxis::image::exr::{Metadata, Window, read_layers, write};
use phototaxis::math::Rgb;
use serde_json::Value;

/// A triangle under two skies, the sum of which is beyond single precision.
const SKIES: &str = "[[mesh]]\npath = 'm.obj'\n[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]
[[light]]\ntype = 'constant'\nradiance = 3e38\n[[light]]\ntype = 'constant'\nradiance = 3e38\n";

#[test]
fn a_pixel_that_is_not_finite_is_named_and_an_exit_code() {
    let here = folder();
    let put = |name: &str, text: &str| std::fs::write(here.path().join(name), text).unwrap();
    put("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    put("skies.toml", SKIES);
    let run = |more: &[&str], code: i32| {
        let arguments = ["render", "skies.toml", "--spp", "4", "-q", "-o", "a.exr", "-o", "a.png", "--json", "-"];
        phototaxis(here.path()).args(arguments).args(TINY).args(more).assert().code(code).get_output().clone()
    };
    let output = run(&[], 3);
    assert!(
        stderr(&output).contains("pixels are not finite; the first is (0, 0), in channel R"),
        "{}",
        stderr(&output)
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let pixels = report["non_finite_pixels"].as_u64().unwrap();
    assert!(pixels > 100 && report["non_finite_samples"] == 0, "{report}");
    assert_eq!(report["first_non_finite_pixel"]["channel"], "R");
    assert_eq!(names(here.path()), ["a.exr", "a.png", "m.obj", "skies.toml"]);
    let picture = read_layers(&here.path().join("a.exr")).unwrap();
    assert_eq!(picture.channels["R"].iter().filter(|v| !v.is_finite()).count() as u64, pixels);
    assert!(picture.channels["variance.R"].iter().all(|v| v.is_finite()));
    // half as bright, the sum is a number
    put("skies.toml", &SKIES.replace("3e38", "1.5e38"));
    let output = run(&[], 0);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["non_finite_pixels"] == 0 && report["first_non_finite_pixel"].is_null(), "{report}");
    assert_eq!(stderr(&output), "");
}

#[test]
fn error_names_pictures_that_are_not_finite() {
    let here = folder();
    let picture = |name: &str, value: f32| {
        let mut pixels = [Rgb::ONE; 6];
        pixels[4].y = value;
        let layers = vec![Layer::color("", &pixels)];
        write(&here.path().join(name), &Window::full(3, 2), layers, &Metadata::default()).unwrap();
    };
    picture("good.exr", 1.5);
    picture("bad.exr", f32::NAN);
    let run = |image: &str, reference: &str, code: i32| {
        let mut command = phototaxis(here.path());
        command.args(["error", image, "--reference", reference]).assert().code(code).get_output().clone()
    };
    let output = run("bad.exr", "good.exr", 3);
    assert!(stderr(&output).contains("bad.exr: 1 pixel is not finite; the first is (1, 1), in channel G"));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["images"][0]["non_finite_pixels"], 1);
    assert!(stderr(&run("good.exr", "bad.exr", 3)).contains("bad.exr: 1 pixel"));
    let report: Value = serde_json::from_str(&stdout(&run("good.exr", "good.exr", 0))).unwrap();
    assert_eq!(report["images"][0]["non_finite_pixels"], 0);
}
