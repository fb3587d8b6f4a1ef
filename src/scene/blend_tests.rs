//! Two materials in one, from the file to the picture.

use crate::film::tile::{Tile, TileSamples};
use crate::format::tests::blocks::{BLOCKS, bound, compare, runs};
use crate::format::{self, SceneFile};
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::Rgb;
use crate::scene::Scene;
use crate::stats::Summary;
use crate::stats::ztest::z_one_mean;
use tempfile::TempDir;

const SQUARE: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 4/4 3/3 2/2 1/1\n";

/// A square of material `a` fills the picture; the sky is white.
const VIEW: &str = "[camera]\norigin = [0, 2, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nvfov = 40\n\
    [film]\nwidth = 12\nheight = 9\n[integrator]\nroulette = 'none'\n[[mesh]]\npath = 'm.obj'\nmaterial = 'a'\n";
const SKY: &str = "[[light]]\ntype = 'constant'\nradiance = 1\n";
/// From the side, so that a highlight is seen.
const LAMP: &str = "[[light]]\ntype = 'spot'\nposition = [1, 2, 0]\ndirection = [-1, -2, 0]\nintensity = 5\n";

/// All Z-tests here together raise a false alarm with a probability of 10⁻⁴ at most.
const LIMIT: f64 = 5.2;

fn load(text: &str) -> (TempDir, SceneFile) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), SQUARE).unwrap();
    image::GrayImage::from_fn(2, 1, |x, _| image::Luma([[51, 204][x as usize]]))
        .save(folder.path().join("w.png"))
        .unwrap();
    let (file, _) = format::parse(text, &folder.path().join("scene.toml"), &[]).unwrap();
    (folder, file)
}

/// Two materials `b` and `c`, and the blend `a` of them.
fn blend(b: &str, c: &str, weight: &str) -> String {
    format!(
        "[material.a]\ntype = 'blend'\nmaterials = ['b', 'c']\nweight = {weight}\n[material.b]\n{b}\n[material.c]\n{c}\n"
    )
}

fn samples(scene: &Scene, file: &SceneFile, seed: u64) -> TileSamples {
    let integrator = PathIntegrator { features: true, ..PathIntegrator::plain(scene, &file.integrator, seed) };
    let (width, height) = (scene.camera.width, scene.camera.height);
    let task = Task { tile: Tile { x: 0, y: 0, width, height }, first_sample: 0, samples: 64 };
    integrator.render(&task, &mut Batch::new()).samples
}

/// Mean of the picture and its standard error, by channel, of independent runs.
fn means(text: &str) -> [(f64, f64); 3] {
    let (_folder, file) = load(text);
    let scene = file.load_scene(1).unwrap().0;
    let of_run = |seed| samples(&scene, &file, seed).sum.iter().sum::<Rgb>() / (64 * 12 * 9) as f32;
    let all: Vec<Rgb> = (1..=24).map(of_run).collect();
    [0, 1, 2].map(|k| {
        let summary = Summary::of(&all.iter().map(|mean| f64::from(mean[k])).collect::<Vec<_>>()).unwrap();
        (summary.mean, summary.std_error().max(1e-5))
    })
}

#[test]
fn what_is_white_in_both_parts_is_white() {
    let parts = [
        "type = 'diffuse'\nreflectance = 1",
        "type = 'mirror'\nspecular_reflectance = 1",
        "type = 'conductor'\nalpha = 0.3\nspecular_reflectance = 1\nenergy_conserving = true",
        "type = 'null'",
        "type = 'diffuse'\nreflectance = 1\nopacity = 0.3",
    ];
    for (k, first) in parts.iter().enumerate() {
        for second in &parts[k..] {
            for weight in ["0", "0.3", "1", "{ texture = 'w.png', nearest = true }"] {
                let found = means(&format!("{VIEW}{SKY}{}", blend(first, second, weight)));
                for (mean, error) in found {
                    // a metal whose light between facets comes back is white within 0.005
                    let z = z_one_mean(mean, error.hypot(2e-3), 1.0);
                    assert!(z.abs() < LIMIT, "{first} and {second}, {weight}: {mean} ± {error}");
                }
            }
        }
    }
}

#[test]
fn diffuse_parts_are_what_their_mean_is() {
    let (b, c) = ("type = 'diffuse'\nreflectance = [0.9, 0.2, 0]", "type = 'diffuse'\nreflectance = [0.1, 0.4, 0.5]");
    let within = format!("{}[material.d]\ntype = 'blend'\nmaterials = ['a', 'b']\nweight = 0.5\n", blend(b, c, "0.6"));
    for (text, share) in [
        (blend(b, c, "0.25"), 0.25),
        // the picture is 0.2 on the left and 0.8 on the right; it is not decoded
        (blend(b, c, "{ texture = 'w.png', nearest = true }"), 0.5),
        (
            within
                .replace("material.a]", "material.x]")
                .replace("material.d]", "material.a]")
                .replace("['a', 'b']", "['x', 'b']"),
            0.3,
        ),
    ] {
        let found = means(&format!("{VIEW}{SKY}{text}"));
        let wanted = |share: f64| [0.9 - 0.8 * share, 0.2 + 0.2 * share, 0.5 * share];
        let z =
            |share: f64| (0..3).map(|k| z_one_mean(found[k].0, found[k].1, wanted(share)[k]).abs()).fold(0.0, f64::max);
        assert!(z(share) < LIMIT, "{share}: {found:?}");
        assert!(z(share + 0.02) > LIMIT, "another share must be seen");
    }
}

#[test]
fn unlike_parts_are_the_weighted_sum_of_their_pictures() {
    let parts = [
        "type = 'diffuse'\nreflectance = 0.5",
        "type = 'conductor'\nalpha = 0.3\nspecular_reflectance = [1, 0.8, 0.5]",
    ];
    let alone = |part: &str, seed| {
        let (_folder, file) = load(&format!("{VIEW}{LAMP}[material.a]\n{part}\n"));
        runs(&file, seed)
    };
    let (first, second) = (alone(parts[0], 1), alone(parts[1], 100));
    let sum = |share: f64| -> Vec<Vec<f64>> {
        let pairs = first.iter().zip(&second);
        pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| (1.0 - share) * a + share * b).collect()).collect()
    };
    let (_folder, file) = load(&format!("{VIEW}{LAMP}{}", blend(parts[0], parts[1], "0.4")));
    let mixed = runs(&file, 1000);
    let (t, mean) = compare(&mixed, &sum(0.4));
    assert!(t <= bound(BLOCKS), "t {t}, mean {mean}");
    assert!(compare(&mixed, &sum(0.5)).0 > bound(BLOCKS), "another share must be seen");
}

#[test]
fn opacities_of_parts_count_by_their_weights() {
    let black = |opacity: f32| format!("type = 'diffuse'\nreflectance = 0\nopacity = {opacity}");
    let white = "type = 'diffuse'\nreflectance = 1";
    for (text, wanted) in [
        (blend(&black(0.5), &black(1.0), "0.5"), 0.25),
        // of what is stopped two thirds are the second's
        (blend(&black(0.5), white, "0.5"), 0.75),
        (blend("type = 'null'", &black(1.0), "0.4"), 0.6),
        (blend("type = 'null'", &black(1.0), "0.4") + "[material.a.opacity]\ntexture = 'w.png'\nnearest = true\n", 0.8),
    ] {
        for (mean, error) in means(&format!("{VIEW}{SKY}{text}")) {
            assert!(z_one_mean(mean, error, wanted).abs() < LIMIT, "{text}: {mean} ± {error}, not {wanted}");
            assert!(z_one_mean(mean, error, wanted + 0.02).abs() > LIMIT, "{text}: more must be seen");
        }
    }
}

#[test]
fn albedo_is_the_weighted_mean_in_every_sample() {
    let (b, c) = ("type = 'diffuse'\nreflectance = 0.8", "type = 'diffuse'\nreflectance = [0.2, 0.4, 0]");
    let (_folder, file) = load(&format!("{VIEW}{SKY}{}", blend(b, c, "0.25")));
    for aovs in &samples(&file.load_scene(1).unwrap().0, &file, 1).features {
        let wanted = Rgb::new(0.65, 0.7, 0.6) * 64.0;
        assert!((aovs.albedo - wanted).abs().max_element() < 1e-3, "{}", aovs.albedo);
    }
}

/// What is chosen has no part in the light that a surface sends out, nor in how that is found.
#[test]
fn lamps_of_two_materials_shine_as_lamps_of_one() {
    let lamp = "[[mesh]]\npath = 'm.obj'\nmaterial = 'lamp'\nscale = 0.3\nrotate = { axis = [1, 0, 0], angle = 150 }\ntranslate = [0, 0.7, 0]\n\
        [material.a]\ntype = 'diffuse'\nreflectance = 0.5\n";
    let black = "type = 'diffuse'\nreflectance = 0";
    let one = format!("{VIEW}{lamp}[material.lamp]\n{black}\nemission = [3, 2, 1]\nemission_two_sided = true\n");
    let two = blend(black, black, "0.4")
        .replace("material.a]\n", "material.lamp]\nemission = [3, 2, 1]\nemission_two_sided = true\n");
    let [one, two] = [one, format!("{VIEW}{lamp}{two}")].map(|text| {
        let (_folder, file) = load(&text);
        samples(&file.load_scene(1).unwrap().0, &file, 3).sum
    });
    assert!(one.iter().any(|pixel| *pixel != Rgb::ZERO));
    assert_eq!(one, two);
}
