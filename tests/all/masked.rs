//! Lamps that are seen through in part: what rays see of them is what next-event estimation must see.

use crate::common::{Loaded, mean_and_error, written};
use phototaxis::render::Settings;
use phototaxis::stats::sidak;
use phototaxis::stats::ztest::{p_value, z_one_mean};
use std::f64::consts::PI;

const FLOOR: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl floor\nf 1 2 3 4\n";
/// 1 ≤ x ≤ 2, |z| ≤ ½ at the height 1, shining down; u runs along x.
const LAMP: &str = "v 1 1 -0.5\nv 2 1 -0.5\nv 2 1 0.5\nv 1 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl lamp\n\
    f 1/1 2/2 3/3 4/4\n";
/// The floor is seen about the origin; only light that comes directly from the lamp counts.
const HEAD: &str = "[camera]\norigin = [0, 2, 0.5]\ntarget = [0, 0, 0]\nvfov = 0.5\n[film]\nwidth = 8\nheight = 8\n\
    [integrator]\nmax_depth = 2\n[guiding]\nmethod = 'none'\n[render]\nspp = 8000\ncombine = 'all'\n\
    [[mesh]]\npath = 'floor.obj'\n[material.floor]\ntype = 'diffuse'\nreflectance = 0.5\n";
const RADIANCE: f64 = 3.0;

/// All p-values together raise a false alarm with this probability.
const FALSE_ALARM: f64 = 1e-4;

/// The lamp's material with this opacity, and how the lamp stands: by itself, in a group, or mirrored in a group (its
/// front then is the other face, and u runs the other way).
fn lamp(opacity: &str, place: &str) -> Loaded {
    let material = format!("[material.lamp]\ntype = 'diffuse'\nreflectance = 0\nemission = {RADIANCE}\n{opacity}\n");
    let folder =
        written(&[("scene.toml", &format!("{HEAD}{material}{place}")), ("floor.obj", FLOOR), ("lamp.obj", LAMP)]);
    // the left half is opaque, the right lets three of four rays pass; the luminance is stored as it is
    let grey = |x: u32, _| image::Luma([if x == 0 { 255 } else { 51 }]);
    image::GrayImage::from_fn(2, 1, grey).save(folder.path().join("mask.png")).unwrap();
    crate::common::load(&folder.path().join("scene.toml"), &[])
}

/// Form factor from a point to the part x ≤ `x`, |z| ≤ ½ of a plane at the distance 1, x counted from above the point
/// (Howell's catalogue of configuration factors, B-3, twice).
fn form_factor(x: f64) -> f64 {
    let z = 0.5;
    let half = |a: f64, b: f64| a / a.hypot(1.0) * (b / a.hypot(1.0)).atan();
    2.0 * (half(x, z) + half(z, x)) / (2.0 * PI)
}

/// Reflected radiance of the floor: ρ·L·F, with the opacity of the near and of the far half.
fn truth(near: f64, far: f64) -> f64 {
    let (one, middle, two) = (form_factor(1.0), form_factor(1.5), form_factor(2.0));
    0.5 * RADIANCE * (near * (middle - one) + far * (two - middle))
}

/// How lamps are found, as a change of the settings.
type Way = (&'static str, fn(&mut Settings));

const WAYS: [Way; 3] = [
    ("BSDF sampling", |s| s.integrator.next_event = false),
    ("next-event estimation", |s| s.integrator.mis = false),
    ("MIS", |_| {}),
];

#[test]
fn lamps_of_any_opacity_light_as_much_however_they_are_found() {
    const TEXTURE: &str = "opacity = { texture = 'mask.png', nearest = true, channel = 'luminance' }";
    const ALONE: &str = "[[mesh]]\npath = 'lamp.obj'\n";
    const PLACED: &str = "[[mesh]]\npath = 'lamp.obj'\ngroup = 'lamp'\n[[instance]]\ngroup = 'lamp'\n";
    const MIRRORED: &str = "[[mesh]]\npath = 'lamp.obj'\ngroup = 'lamp'\n[[instance]]\ngroup = 'lamp'\nscale = [-1, 1, 1]\ntranslate = [3, 0, 0]\n";
    let cases = [
        ("opaque", "", ALONE, truth(1.0, 1.0)),
        ("half", "opacity = 0.5", ALONE, truth(0.5, 0.5)),
        ("half, in a group", "opacity = 0.5", PLACED, truth(0.5, 0.5)),
        ("none", "opacity = 0", ALONE, 0.0),
        ("texture", TEXTURE, ALONE, truth(1.0, 0.2)),
        ("texture, in a group", TEXTURE, PLACED, truth(1.0, 0.2)),
        ("texture, mirrored", TEXTURE, MIRRORED, truth(0.2, 1.0)),
    ];
    let level = sidak(FALSE_ALARM, cases.len() * WAYS.len());
    for (name, opacity, place, truth) in cases {
        let loaded = lamp(opacity, place);
        for (way, change) in WAYS {
            let mut settings = loaded.settings.clone();
            change(&mut settings);
            let (mean, error) = mean_and_error(&loaded.estimate(&settings));
            println!("{name}, {way}: {mean:.5} ± {error:.5}, in closed form {truth:.5}");
            // the picture sees ± 0.01 of the floor, over which the light's curvature is below 10⁻³
            let error = error.hypot(1e-3 * truth);
            assert!(p_value(z_one_mean(mean, error, truth)) >= level, "{name}, {way}: {mean} ± {error}, not {truth}");
            let planted = p_value(z_one_mean(1.1 * mean, error, truth)) < level;
            assert!(planted || truth == 0.0, "{name}, {way}: a tenth more goes unseen");
        }
    }
}
