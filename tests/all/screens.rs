//! Lamps that shine by a picture: screens, and windows of a painted model. However they are found, a floor below is lit as much.

use crate::common::{Loaded, load, mean_and_error, written};
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::render::Settings;
use phototaxis::stats::sidak;
use phototaxis::stats::ztest::{p_value, z_one_mean};
use std::f64::consts::PI;
use tempfile::TempDir;

const FLOOR: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl floor\nf 1 2 3 4\n";
/// 1 ≤ x ≤ 2, |z| ≤ ½ at the height 1, shining down; u runs along x.
const LAMP: &str = "mtllib lamp.mtl\nv 1 1 -0.5\nv 2 1 -0.5\nv 2 1 0.5\nv 1 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl lamp\n\
    f 1/1 2/2 3/3 4/4\n";
/// The floor is seen about the origin; only light that comes directly from the lamp counts.
const HEAD: &str = "[camera]\norigin = [0, 2, 0.5]\ntarget = [0, 0, 0]\nvfov = 0.5\n[film]\nwidth = 8\nheight = 8\n\
    [integrator]\nmax_depth = 2\n[guiding]\nmethod = 'none'\n[render]\nspp = 3000\ncombine = 'all'\n\
    [[mesh]]\npath = 'floor.obj'\n[material.floor]\ntype = 'diffuse'\nreflectance = 0.5\n";

/// All p-values together raise a false alarm with this probability.
const FALSE_ALARM: f64 = 1e-4;

/// The pictures `halves.png` (white, and a grey that is 0.214 of white) and `spot.png` (black, one texel of 8 × 8 white) lie beside
/// the scene.
fn lamp(material: &str, library: &str, place: &str) -> TempDir {
    let scene = format!("{HEAD}{material}\n{place}");
    let library = format!("newmtl lamp\nKd 0 0 0\n{library}");
    let files = [("scene.toml", &*scene), ("floor.obj", FLOOR), ("lamp.obj", LAMP), ("lamp.mtl", &library)];
    let folder = written(&files);
    let halves = |x: u32, _| image::Luma([if x == 0 { 255u8 } else { 128 }]);
    image::GrayImage::from_fn(2, 1, halves).save(folder.path().join("halves.png")).unwrap();
    let spot = |x: u32, y| image::Luma([if (x, y) == (2, 5) { 255u8 } else { 0 }]);
    image::GrayImage::from_fn(8, 8, spot).save(folder.path().join("spot.png")).unwrap();
    folder
}

/// With independent samples, of which the variance says how good their mean is.
fn loaded(folder: &TempDir) -> Loaded {
    load(&folder.path().join("scene.toml"), &["render.sampler='independent'"])
}

/// Linear light of the grey 128.
const GREY: f64 = 0.215_860_5;

/// Form factor from a point to the part 0 ≤ x ≤ `x`, 0 ≤ z ≤ `z` of a plane at the distance 1, counted from above the point
/// (Howell's catalogue of configuration factors, B-3).
fn form_factor(x: f64, z: f64) -> f64 {
    let half = |a: f64, b: f64| a / a.hypot(1.0) * (b / a.hypot(1.0)).atan();
    (half(x, z) + half(z, x)) / (2.0 * PI)
}

/// Reflected radiance of the floor with these radiances of the near and of the far half.
fn truth(near: f64, far: f64) -> f64 {
    let to = |x: f64| 2.0 * form_factor(x, 0.5);
    0.5 * (near * (to(1.5) - to(1.0)) + far * (to(2.0) - to(1.5)))
}

/// The same of the one white texel, column 2 and row 5 from the top of eight: −⅛ ≤ z ≤ 0 in the lamp's frame, as v runs along z.
fn truth_of_spot(radiance: f64) -> f64 {
    let (left, right, near, far) = (1.0 + 2.0 / 8.0, 1.0 + 3.0 / 8.0, 2.0 / 8.0 - 0.5, 3.0 / 8.0 - 0.5);
    let strip = |z: f64| form_factor(right, z) - form_factor(left, z);
    0.5 * radiance * (strip(-near) - strip(-far))
}

type Way = (&'static str, fn(&mut Settings));

const WAYS: [Way; 4] = [
    ("BSDF sampling", |s| s.integrator.next_event = false),
    ("next-event estimation", |s| s.integrator.mis = false),
    ("MIS", |_| {}),
    ("a guide", |s| s.guiding.method = GuidingMethod::Grid),
];

#[test]
fn screens_light_as_much_however_they_are_found() {
    const ALONE: &str = "[[mesh]]\npath = 'lamp.obj'\n";
    const PLACED: &str = "[[mesh]]\npath = 'lamp.obj'\ngroup = 'lamp'\n[[instance]]\ngroup = 'lamp'\n";
    const MIRRORED: &str = "[[mesh]]\npath = 'lamp.obj'\ngroup = 'lamp'\n[[instance]]\ngroup = 'lamp'\nscale = [-1, 1, 1]\ntranslate = [3, 0, 0]\n";
    let written = |more: &str| format!("[material.lamp]\ntype = 'diffuse'\nreflectance = 0\n{more}");
    let halves = written("emission = { texture = 'halves.png', nearest = true, tint = [3, 2, 1] }");
    let half_seen = format!("{halves}\nopacity = 0.5");
    let by_mask = format!("{halves}\nopacity = {{ texture = 'halves.png', nearest = true, channel = 'luminance' }}");
    let spot = written("emission = { texture = 'spot.png', nearest = true, tint = 100 }");
    let stored = 128.0 / 255.0;
    let cases = [
        ("scene file", &*halves, ALONE, truth(3.0, 3.0 * GREY)),
        ("in a group", &halves, PLACED, truth(3.0, 3.0 * GREY)),
        ("mirrored", &halves, MIRRORED, truth(3.0 * GREY, 3.0)),
        ("half seen through", &half_seen, ALONE, truth(1.5, 1.5 * GREY)),
        ("seen through by a mask", &by_mask, MIRRORED, truth(3.0 * GREY * stored, 3.0)),
        ("a spot", &spot, ALONE, truth_of_spot(100.0)),
    ];
    let level = sidak(FALSE_ALARM, cases.len() * WAYS.len());
    for (name, material, place, truth) in cases {
        let loaded = loaded(&lamp(material, "", place));
        for (way, change) in WAYS {
            let mut settings = loaded.settings.clone();
            change(&mut settings);
            let (mean, error) = mean_and_error(&loaded.estimate(&settings));
            println!("{name}, {way}: {mean:.5} ± {error:.5}, in closed form {truth:.5}");
            // the picture sees ± 0.01 of the floor, over which the light's curvature is below 10⁻³
            let error = error.hypot(1e-3 * truth);
            assert!(p_value(z_one_mean(mean, error, truth)) >= level, "{name}, {way}: {mean} ± {error}, not {truth}");
            // few directions of the BSDF meet a spot
            let factor = if name == "a spot" { 2.0 } else { 1.2 };
            let planted = p_value(z_one_mean(factor * mean, error, truth)) < level;
            assert!(planted, "{name}, {way}: {factor} times as much goes unseen");
            let drawn_by_texel = error < 0.02 * truth || way == "BSDF sampling" || way == "a guide";
            assert!(drawn_by_texel, "{name}, {way}: {error} is much for {truth}");
        }
    }
}

/// `map_Ke` multiplies `Ke`, and shines alone where `Ke` is black or not said (Blender). Without next-event estimation nothing but
/// the emission at the point that is met counts.
#[test]
fn libraries_shine_by_their_pictures() {
    const ALONE: &str = "[[mesh]]\npath = 'lamp.obj'\n";
    let scale = "-s 0 0 0 -o 0.25 0.5 0";
    let cases = [
        (format!("map_Ke {scale} halves.png"), 1.0),
        (format!("Ke 0 0 0\nmap_Ke {scale} halves.png"), 1.0),
        (format!("Ke 3 3 3\nmap_Ke {scale} halves.png"), 3.0),
        ("Ke 3 3 3".to_string(), 3.0),
    ];
    for (library, radiance) in cases {
        let loaded = loaded(&lamp("", &library, ALONE));
        let (mean, error) = mean_and_error(&loaded.estimate(&loaded.settings));
        let z = z_one_mean(mean, error.hypot(1e-3 * mean), truth(radiance, radiance));
        assert!(p_value(z) > 1e-5, "{library}: {mean} ± {error}, not {}", truth(radiance, radiance));
    }
}

/// Emission in a picture, a million times as bright, is a million times as bright a floor, to the last bits.
#[test]
fn the_unit_of_light_goes_by_the_brightest_texel() {
    const ALONE: &str = "[[mesh]]\npath = 'lamp.obj'\n";
    let picture = |tint: &str| {
        let emission = format!("emission = {{ texture = 'spot.png', tint = {tint} }}");
        let loaded = loaded(&lamp(&format!("[material.lamp]\ntype = 'diffuse'\n{emission}"), "", ALONE));
        let mut settings = loaded.settings.clone();
        settings.render.spp = 16;
        loaded.estimate(&settings)
    };
    let (one, many) = (picture("1"), picture("1048576e6"));
    assert!(one.mean.iter().any(|p| p.x > 0.0));
    for (one, many) in one.mean.iter().zip(&many.mean) {
        assert!((many.x / 1_048_576e6 - one.x).abs() <= 1e-5 * one.x, "{one} {many}");
    }
}
