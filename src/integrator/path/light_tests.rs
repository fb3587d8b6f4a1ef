//! However lights are chosen, the picture is the same but for its noise.

use crate::film::tile::Tile;
use crate::format;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, IntegratorSettings, LightSampler, Task};
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;
use std::fmt::Write;

const SIZE: u32 = 16;
const BLOCK: u32 = 4;
const RUNS: u64 = 128;

/// A floor, a plastic board, a sheet that lets light through, and lamps of all kinds about them: on one side and on both, near
/// and far, in groups; with a point, a sun and a sky.
fn scene() -> Scene {
    let (mut obj, mut rng) = (String::from("mtllib scene.mtl\n"), Rng::new(61));
    let mut corners = 0;
    let mut quad = |obj: &mut String, material: &str, [o, u, v]: [Vec3; 3]| {
        for p in [o, o + u, o + u + v, o + v] {
            let _ = writeln!(obj, "v {} {} {}", p.x, p.y, p.z);
        }
        let _ = writeln!(obj, "usemtl {material}\nf {} {} {} {}", corners + 1, corners + 2, corners + 3, corners + 4);
        corners += 4;
    };
    quad(&mut obj, "floor", [Vec3::new(-4.0, 0.0, -4.0), Vec3::Z * 8.0, Vec3::X * 8.0]);
    quad(&mut obj, "block", [Vec3::new(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::new(0.2, 1.0, 0.3)]);
    quad(&mut obj, "sheet", [Vec3::new(0.5, 0.2, 0.5), Vec3::new(0.3, 1.0, 0.1), Vec3::Z * 1.5]);
    for k in 0..60 {
        let mut point = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
        let place = point() * Vec3::new(6.0, 1.0, 6.0) + Vec3::Y * if k % 3 == 0 { 0.8 } else { 2.5 };
        let (u, v) = (point() * 0.3, point() * 0.3);
        let material = ["lamp", "shade", "spark"][k % 3];
        quad(&mut obj, material, [place, u, v]);
    }
    let mtl = "newmtl floor\nKd 0.6 0.5 0.4\nnewmtl block\nKd 0.5 0.5 0.5\nnewmtl sheet\nKd 0.5 0.5 0.5\n\
        newmtl lamp\nKd 0 0 0\nKe 6 4 3\nnewmtl shade\nKd 0.2 0.2 0.2\nKe 1 2 3\nnewmtl spark\nKd 0 0 0\nKe 40 30 20\n";
    let toml = format!(
        "[camera]\norigin = [0, 2.5, 5]\ntarget = [0, 0.5, 0]\nvfov = 50\n[film]\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[mesh]]\npath = \"scene.obj\"\n[material.block]\ntype = \"plastic\"\nalpha = 0.2\n\
         [material.sheet]\ntype = \"diffuse_transmitter\"\n[material.shade]\nemission_two_sided = true\n\
         [[light]]\ntype = \"point\"\nposition = [1.5, 1, 1]\nintensity = 1\n\
         [[light]]\ntype = \"sun\"\ndirection = [1, -2, -1]\nirradiance = 1\nangular_diameter = 8\n\
         [[light]]\ntype = \"constant\"\nradiance = 0.1\n"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("scene.obj", &*obj), ("scene.mtl", mtl), ("scene.toml", &toml)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let (file, _) = format::load(&folder.path().join("scene.toml"), &[]).unwrap();
    file.load_scene(1).unwrap().0
}

/// By block of pixels, the mean over runs and its squared error.
fn blocks(scene: &Scene, settings: &IntegratorSettings, seeds: u64) -> Vec<(f64, f64)> {
    let side = SIZE / BLOCK;
    let run = |seed: u64| {
        let task = Task { tile: Tile { x: 0, y: 0, width: SIZE, height: SIZE }, first_sample: 0, samples: 4 };
        let integrator = PathIntegrator::plain(scene, settings, seeds + seed);
        let sums = integrator.render(&task, &mut Batch::new()).samples.sum;
        let mut blocks = vec![0.0; (side * side) as usize];
        for (k, sum) in (0..).zip(&sums) {
            let (x, y): (u32, u32) = (k % SIZE / BLOCK, k / SIZE / BLOCK);
            blocks[(y * side + x) as usize] += f64::from(sum.dot(Rgb::ONE));
        }
        blocks
    };
    let runs: Vec<Vec<f64>> = (0..RUNS).into_par_iter().map(run).collect();
    let n = RUNS as f64;
    let of_block = |k: usize| {
        let mean = runs.iter().map(|run| run[k]).sum::<f64>() / n;
        (mean, runs.iter().map(|run| (run[k] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
    };
    (0..(side * side) as usize).map(of_block).collect()
}

/// |z| < 5 in 32 blocks: a false alarm of 2·10⁻⁵.
#[test]
fn pictures_agree_however_lights_are_chosen() {
    let scene = scene();
    let settings = |light_sampler, mis| IntegratorSettings { light_sampler, mis, ..Default::default() };
    let power = blocks(&scene, &settings(LightSampler::Power, true), 0);
    let worst = |other: &[(f64, f64)], factor: f64| {
        let z = power.iter().zip(other).map(|(a, b)| (a.0 * factor - b.0) / (a.1 * factor * factor + b.1).sqrt());
        z.map(f64::abs).fold(0.0, f64::max)
    };
    for mis in [true, false] {
        let tree = blocks(&scene, &settings(LightSampler::Tree, mis), 1_000_000);
        assert!(worst(&tree, 1.0) < 5.0, "mis {mis}: {power:?} {tree:?}");
        assert!(worst(&tree, 1.15) > 5.0, "mis {mis}: a picture that is too bright would pass");
    }
}
