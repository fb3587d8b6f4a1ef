//! Pictures are finite and right however bright the light is, and however little of it is found.

use crate::common::{Loaded, load_written, mean_color};
use phototaxis::film::accumulate::Estimate;
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::integrator::Roulette;
use phototaxis::math::Rgb;

const METHODS: [GuidingMethod; 5] =
    [GuidingMethod::None, GuidingMethod::Auto, GuidingMethod::Adaptive, GuidingMethod::Grid, GuidingMethod::SdTree];

/// A lamp over a floor, on whose other side stands a wall.
const MODEL: &str = "mtllib m.mtl
v -0.5 1.5 -0.5\nv 0.5 1.5 -0.5\nv 0.5 1.5 0.5\nv -0.5 1.5 0.5\nusemtl lamp\nf 1 2 3 4
v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nusemtl wall\nf -1 -2 -3 -4
v -2 0 -2\nv -2 2 -2\nv 2 2 -2\nv 2 0 -2\nf -1 -2 -3 -4
";

const CAMERA: &str =
    "[camera]\norigin = [0, 1.2, 3]\ntarget = [0, 0.2, 0]\nvfov = 45\n[film]\nwidth = 16\nheight = 16\n";

/// The scene with a lamp of the radiance `emission`, and `lights` beside it.
fn lit(emission: f64, lights: &str) -> Loaded {
    let materials =
        format!("newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe {emission:e} {emission:e} {emission:e}\n");
    let scene = format!("{CAMERA}[[mesh]]\npath = 'm.obj'\n{lights}");
    load_written(&[("m.obj", MODEL), ("m.mtl", &materials), ("scene.toml", &scene)], &["render.spp=64"])
}

fn picture(loaded: &Loaded, method: GuidingMethod) -> Estimate {
    let mut settings = loaded.settings.clone();
    settings.guiding.method = method;
    // learnt as soon as possible, so that all that is learnt is put to use
    (settings.guiding.learned_fraction, settings.integrator.roulette) = (Some(true), Roulette::Guided);
    loaded.estimate(&settings)
}

fn check_finite(picture: &Estimate, what: &str) {
    // a pixel may be below 0: what roulette expects of paths that it splits is taken away
    let finite = picture.mean.iter().chain(&picture.variance).all(|v| v.is_finite());
    let varies = picture.variance.iter().all(|v| v.min_element() >= 0.0);
    assert!(finite && varies && picture.mean.iter().sum::<Rgb>().min_element() >= 0.0, "{what}: {:?}", picture.mean);
}

/// Powers of two change no digit, so that pictures are the same to the last bit, down to numbers with fewer digits.
#[test]
fn lamps_of_any_radiance_give_the_same_picture() {
    let one = lit(1.0, "");
    for method in METHODS {
        let wanted = picture(&one, method);
        assert!(mean_color(&wanted.mean)[1] > 0.01);
        for exponent in [-120, -100, 66, 100, 126] {
            let factor = 2f64.powi(exponent);
            let found = picture(&lit(factor, ""), method);
            check_finite(&found, &format!("{method:?}, × 2^{exponent}"));
            let scaled = |(a, b): (&glam::Vec3, &glam::Vec3)| (a.as_dvec3() * factor).as_vec3() == *b;
            assert!(wanted.mean.iter().zip(&found.mean).all(scaled), "{method:?}, × 2^{exponent}");
        }
        for factor in [1e-30, 1e20, 1e30] {
            let found = picture(&lit(factor, ""), method);
            check_finite(&found, &format!("{method:?}, × {factor:e}"));
            let ratio = mean_color(&found.mean)[1] / mean_color(&wanted.mean)[1] / factor;
            // rounding turns a path here and there
            assert!((ratio - 1.0).abs() < 0.02, "{method:?}, × {factor:e}: {ratio}");
        }
    }
}

#[test]
fn other_lights_of_any_strength_give_the_same_picture() {
    let kinds: [fn(f64) -> String; 3] = [
        |k| format!("[[light]]\ntype = 'constant'\nradiance = {k:e}\n"),
        |k| format!("[[light]]\ntype = 'point'\nposition = [1, 1, 1]\nintensity = {k:e}\n"),
        |k| format!("[[light]]\ntype = 'directional'\ndirection = [0.2, -1, -0.3]\nirradiance = {k:e}\n"),
    ];
    for light in kinds {
        let picture = |factor: f64| picture(&lit(0.0, &light(factor)), GuidingMethod::Adaptive);
        let wanted = mean_color(&picture(1.0).mean)[1];
        assert!(wanted > 0.001, "{}", light(1.0));
        for factor in [1e-30, 1e20, 1e30] {
            let found = picture(factor);
            check_finite(&found, &light(factor));
            let ratio = mean_color(&found.mean)[1] / wanted / factor;
            assert!((ratio - 1.0).abs() < 0.02, "{}: {ratio}", light(factor));
        }
    }
}

/// Lights that are brighter than others by more than squares hold in single precision.
#[test]
fn a_lamp_beside_a_far_brighter_light_is_no_trouble() {
    for method in METHODS {
        let loaded = lit(1e25, "[[light]]\ntype = 'constant'\nradiance = 1e-5\n");
        let (found, alone) = (picture(&loaded, method), picture(&lit(1e25, ""), method));
        check_finite(&found, &format!("{method:?}"));
        let ratio = mean_color(&found.mean)[1] / mean_color(&alone.mean)[1];
        assert!((ratio - 1.0).abs() < 0.1, "{method:?}: {ratio}");
    }
}

/// A dark room whose small lamp stands behind a wall and is found by chance alone: iterations that find nothing in one half of
/// the pixels, by which those of the other half are weighed, come now and then.
const DARK: &str = "mtllib m.mtl\nusemtl wall
v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\nv -2 2 -2\nv 2 2 -2\nv 2 2 2\nv -2 2 2\nf 5 6 7 8
v -2 0 -2\nv 2 0 -2\nv 2 2 -2\nv -2 2 -2\nf 9 10 11 12\nv -2 0 2\nv -2 2 2\nv 2 2 2\nv 2 0 2\nf 13 14 15 16
v -2 0 -2\nv -2 2 -2\nv -2 2 2\nv -2 0 2\nf 17 18 19 20\nv 2 0 -2\nv 2 0 2\nv 2 2 2\nv 2 2 -2\nf 21 22 23 24
v 0 0 -2\nv 0 2 -2\nv 0 2 0.8\nv 0 0 0.8\nf 25 26 27 28
usemtl lamp\nv -1.06 1.99 -0.56\nv -0.94 1.99 -0.56\nv -0.94 1.99 -0.44\nv -1.06 1.99 -0.44\nf 29 30 31 32
";

#[test]
fn a_dark_room_has_no_pixel_that_is_not_finite() {
    let camera =
        "[camera]\norigin = [0.15, 1.1, 1.9]\ntarget = [0.02, 0.3, -1]\nvfov = 50\n[film]\nwidth = 24\nheight = 16\n";
    let rest = "[[mesh]]\npath = 'm.obj'\n[integrator]\nmax_depth = 5\nnext_event = false\n[guiding]\nmethod = 'grid'\nresolution = 6\n";
    let materials = "newmtl wall\nKd 0.6 0.6 0.6\nnewmtl lamp\nKd 0 0 0\nKe 60 60 60\n";
    let files = [("m.obj", DARK), ("m.mtl", materials), ("scene.toml", &format!("{camera}{rest}"))];
    let loaded = load_written(&files, &["render.spp=16"]);
    let mut light = 0.0;
    for seed in 0..64 {
        let mut settings = loaded.settings.clone();
        settings.render.seed = seed;
        let found = loaded.estimate(&settings);
        check_finite(&found, &format!("seed {seed}"));
        light += mean_color(&found.mean)[1] / 64.0;
    }
    assert!(light > 0.0, "nothing found the lamp");
}
