//! Colours of vertices and of faces, from the file to the picture.

use crate::film::tile::{Tile, TileSamples};
use crate::format;
use crate::image::srgb::decode;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::Rgb;
use crate::scene::Scene;

const SIZE: u32 = 16;

/// A square from (-1, 0, -1) to (1, 0, 1), red at z = -1 and blue at z = 1.
const SQUARE: &str =
    "v -1 0 -1 0.8 0.1 0.1\nv 1 0 -1 0.8 0.1 0.1\nv 1 0 1 0.1 0.1 0.8\nv -1 0 1 0.1 0.1 0.8\nf 4 3 2 1\n";

/// The square fills the picture under a white sky.
const VIEW: &str = "[camera]\norigin = [0, 2, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nvfov = 53.13010235\n\
                    [film]\nwidth = 16\nheight = 16\n[[light]]\ntype = \"constant\"\nradiance = 1\n";

fn load(obj: &str, toml: &str) -> crate::Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), obj).unwrap();
    let (file, _) = format::parse(&format!("{VIEW}{toml}"), &folder.path().join("scene.toml"), &[]).unwrap();
    file.load_scene(1).map(|(scene, _)| scene)
}

fn render(scene: &Scene, samples: u32) -> TileSamples {
    let settings = &Default::default();
    let integrator = PathIntegrator { features: true, ..PathIntegrator::plain(scene, settings, 1) };
    let task = Task { tile: Tile { x: 0, y: 0, width: SIZE, height: SIZE }, first_sample: 0, samples };
    integrator.render(&task, &mut Batch::new()).samples
}

/// The colour at the height of a row of pixels, counted from above.
fn expected(row: u32) -> Rgb {
    let [red, blue] = [[0.8, 0.1, 0.1], [0.1, 0.1, 0.8]].map(|stored: [f32; 3]| Rgb::from(stored.map(decode)));
    red.lerp(blue, (row as f32 + 0.5) / SIZE as f32)
}

fn assert_albedo(scene: &Scene, tint: f32, what: &str) {
    let picture = render(scene, 1);
    for (i, aovs) in picture.features.iter().enumerate() {
        let expected = expected(i as u32 / SIZE) * tint;
        // a sample is anywhere in its pixel, over which colours change by 0.04
        let off = (aovs.albedo - expected).abs().max_element();
        assert!(off < 0.025, "{what}, pixel {i}: {} for {expected}", aovs.albedo);
    }
}

#[test]
fn a_model_without_materials_has_the_colours_of_its_vertices() {
    let scene = load(SQUARE, "[[mesh]]\npath = \"m.obj\"\n").unwrap();
    assert_albedo(&scene, 1.0, "no material");
    let samples = 64;
    let seen: Rgb = render(&scene, samples).sum.iter().sum();
    let mean = seen / (samples * SIZE * SIZE) as f32;
    let wanted = (0..SIZE).map(expected).sum::<Rgb>() / SIZE as f32;
    assert!((mean - wanted).abs().max_element() < 0.01, "{mean} for {wanted}");
}

#[test]
fn instances_have_them_too() {
    let text = "[[mesh]]\npath = \"m.obj\"\ngroup = \"g\"\n[[instance]]\ngroup = \"g\"\n";
    assert_albedo(&load(SQUARE, text).unwrap(), 1.0, "instance");
    let mirrored = "[[mesh]]\npath = \"m.obj\"\nscale = [-1, 1, 1]\n";
    assert_albedo(&load(SQUARE, mirrored).unwrap(), 1.0, "mirrored");
}

#[test]
fn materials_of_scene_files_take_them_where_they_say_so() {
    let material = |keys: &str| format!("[[mesh]]\npath = \"m.obj\"\nmaterial = \"a\"\n[material.a]\n{keys}\n");
    let colored = material("type = \"diffuse\"\nreflectance = { vertex_color = true, tint = 0.5 }");
    assert_albedo(&load(SQUARE, &colored).unwrap(), 0.5, "tint");
    let coated = material("type = \"principled\"\nbase_color = { vertex_color = true }\nspecular = 0\nroughness = 1");
    assert_albedo(&load(SQUARE, &coated).unwrap(), 1.0, "principled");
    let grey = render(&load(SQUARE, &material("type = \"diffuse\"\nreflectance = 0.25")).unwrap(), 1);
    assert!(grey.features.iter().all(|aovs| aovs.albedo == Rgb::splat(0.25)));
    let plain = SQUARE.replace(" 0.8 0.1 0.1", "").replace(" 0.1 0.1 0.8", "");
    let message = load(&plain, &colored).map(drop).unwrap_err().to_string();
    assert!(message.contains("m.obj: material `a` takes the colours of vertices, and there are none"), "{message}");
}

/// The square in two triangles: red where x > z, else blue.
const HALVES: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
                      property list uchar int vertex_indices\nproperty float red\nproperty float green\nproperty float blue\nend_header\n\
                      -1 0 -1\n1 0 -1\n1 0 1\n-1 0 1\n3 2 1 0 0.75 0.25 0\n3 3 2 0 0 0.25 0.75\n";

fn load_halves(ply: &str, toml: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.ply"), ply).unwrap();
    let (file, _) = format::parse(&format!("{VIEW}{toml}"), &folder.path().join("scene.toml"), &[]).unwrap();
    file.load_scene(1).unwrap().0
}

#[test]
fn faces_are_of_one_colour_each_wherever_they_stand() {
    let grouped = "[[mesh]]\npath = \"m.ply\"\ngroup = \"g\"\n[[instance]]\ngroup = \"g\"\n";
    let mirrored = "[[mesh]]\npath = \"m.ply\"\nscale = [-1, 1, 1]\n";
    for (text, side) in [("[[mesh]]\npath = \"m.ply\"\n", 1.0), (grouped, 1.0), (mirrored, -1.0)] {
        let scene = load_halves(HALVES, text);
        let picture = render(&scene, 64);
        for (i, (aovs, sum)) in picture.features.iter().zip(&picture.sum).enumerate() {
            let [x, z] = [i as u32 % SIZE, i as u32 / SIZE].map(|at| at as f32 + 0.5 - 0.5 * SIZE as f32);
            // pixels on the edge have a part of both
            if (side * x - z).abs() > 1.0 {
                let color = if side * x > z { Rgb::new(0.75, 0.25, 0.0) } else { Rgb::new(0.0, 0.25, 0.75) };
                assert_eq!(aovs.albedo, color * 64.0, "{text}: pixel {i}");
                // a white sky shows a flat surface in its colour; the rest is noise
                assert!((*sum / 64.0 - color).abs().max_element() < 0.2, "{text}: pixel {i}: {}", *sum / 64.0);
            }
        }
        let whole = picture.sum.iter().sum::<Rgb>() / (64 * SIZE * SIZE) as f32;
        let wanted = Rgb::new(0.375, 0.25, 0.375);
        assert!((whole - wanted).abs().max_element() < 0.01, "{text}: {whole} for {wanted}");
    }
    let hash = |ply: &str| load_halves(ply, mirrored).content_hash_text();
    assert_ne!(hash(HALVES), hash(&HALVES.replace("0.75 0.25 0\n", "0.5 0.25 0\n")));
}

#[test]
fn they_are_part_of_a_scene_as_its_hash_knows_it() {
    let mesh = "[[mesh]]\npath = \"m.obj\"\n";
    let hash = |obj: &str| load(obj, mesh).unwrap().content_hash_text();
    assert_ne!(hash(SQUARE), hash(&SQUARE.replace("0.8", "0.7")));
}
