use super::*;
use crate::film::tile::Tile;
use crate::format;
use crate::geometry::Ray;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::Rgb;
use crate::scene::{Scene, obj};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

/// In metres: UTM coordinates, y up.
const FAR: DVec3 = DVec3::new(412_345.67, 123.25, 5_612_345.12);
const SIZE: u32 = 24;

/// A ball of radius 1 around `centre`, written to a tenth of a millimetre.
fn ball(centre: DVec3) -> String {
    let mut text = String::new();
    for (i, j) in (0..=12).flat_map(|i| (0..24).map(move |j| (i, j))) {
        let (theta, phi) = (f64::from(i) / 12.0 * PI, f64::from(j) / 24.0 * TAU);
        let p = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
        let p = (p * 1e4).round() / 1e4 + centre;
        let _ = writeln!(text, "v {:.4} {:.4} {:.4}", p.x, p.y, p.z);
    }
    for (i, j) in (0..12).flat_map(|i| (0..24).map(move |j| (i, j))) {
        let at = |i: u32, j: u32| i * 24 + j % 24 + 1;
        let _ = writeln!(text, "f {} {} {} {}", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
    text
}

fn load(path: &Path, settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
    let (file, _) = format::load(path, &settings).unwrap();
    file.load_scene(1).unwrap().0
}

/// A scene of the ball, written around `centre`, with more of a scene file's text.
fn scene(centre: DVec3, text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.obj"), ball(centre)).unwrap();
    let film = format!("[film]\nwidth = {SIZE}\nheight = {SIZE}\n");
    std::fs::write(folder.path().join("scene.toml"), film + text).unwrap();
    load(&folder.path().join("scene.toml"), &[])
}

/// How far off the surface is through each pixel; 0 where there is nothing.
fn depths(scene: &Scene) -> Vec<f32> {
    let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    let depth = |(x, y)| {
        let ray: Ray = scene.camera.ray(x, y, [0.5; 2]);
        let mut rays: crate::embree::HitBatch = crate::embree::HitBatch::with_capacity(1);
        rays.push(&ray);
        rays.trace(scene.geometry(), crate::embree::Coherence::Coherent);
        rays.hit(0).map_or(0.0, |_| rays.ray(0).tfar)
    };
    pixels.map(depth).collect()
}

fn assert_same_view(a: &Scene, b: &Scene, what: &str) {
    let (a, b) = (depths(a), depths(b));
    assert!(a.iter().filter(|&&depth| depth > 0.0).count() > 100, "{what}: the ball is seen");
    let silhouette = a.iter().zip(&b).filter(|(a, b)| (**a == 0.0) != (**b == 0.0)).count();
    let both = a.iter().zip(&b).filter(|(a, b)| **a > 0.0 && **b > 0.0);
    let worst = both.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(silhouette <= 2 && worst < 2e-3, "{what}: {silhouette} pixels of the silhouette, {worst} m");
}

fn light(scene: &Scene) -> Rgb {
    let settings = &Default::default();
    let integrator = PathIntegrator::plain(scene, settings, 1);
    let task = Task { tile: Tile { x: 0, y: 0, width: SIZE, height: SIZE }, first_sample: 0, samples: 16 };
    integrator.render(&task, &mut Batch::new()).samples.sum.iter().sum::<Rgb>() / (16 * SIZE * SIZE) as f32
}

const CAMERA: &str = "[camera]\norigin = [5, 1, 0.5]\ntarget = [0, 0, 0]\nvfov = 32\n";
const LIGHT: &str = "[[light]]\ntype = \"point\"\nposition = [4, 3, 1]\nintensity = 90\n";

fn local() -> Scene {
    scene(DVec3::ZERO, &format!("{CAMERA}{LIGHT}[[mesh]]\npath = \"ball.obj\"\n"))
}

#[test]
fn positions_are_moved_before_they_are_rounded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.obj");
    std::fs::write(&path, ball(FAR)).unwrap();
    let far = obj::load(&path).unwrap();
    std::fs::write(&path, ball(DVec3::ZERO)).unwrap();
    let near = obj::load(&path).unwrap();
    assert_eq!(near.origin, DVec3::ZERO);
    assert_eq!(far.origin, DVec3::new(412_346.0, 0.0, 5_612_345.0), "heights are small enough");
    for (far, near) in far.mesh.positions.iter().zip(&near.mesh.positions) {
        let moved = Vec3::from(*far).as_dvec3() + (far_origin() - FAR);
        assert!((moved - Vec3::from(*near).as_dvec3()).length() < 2e-5, "{far:?} {near:?}");
    }
    fn far_origin() -> DVec3 {
        DVec3::new(412_346.0, 0.0, 5_612_345.0)
    }
}

#[test]
fn files_near_0_keep_their_bits() {
    let text = "v 0.1 100.3 -7.77\nv 1e-3 120.25 3\nv 20.5 99.9999 3.3333333\nf 1 2 3\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("near.obj");
    std::fs::write(&path, text).unwrap();
    let model = obj::load(&path).unwrap();
    assert_eq!(model.origin, DVec3::ZERO);
    assert_eq!(model.mesh.positions, [[0.1, 100.3, -7.77], [1e-3, 120.25, 3.0], [20.5, 99.9999, 3.333_333_3]]);
}

#[test]
fn vertices_that_no_face_uses_have_no_part_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.obj");
    let far = ball(FAR);
    // a vertex at 0 behind all others, so that indices stay
    std::fs::write(&path, format!("{far}v 0 0 0\n")).unwrap();
    let marked = obj::load(&path).unwrap();
    std::fs::write(&path, far).unwrap();
    let plain = obj::load(&path).unwrap();
    assert_eq!(marked.origin, plain.origin);
    assert_eq!(marked.mesh.positions[..plain.mesh.positions.len()], plain.mesh.positions);
    assert_eq!(marked.mesh.triangles, plain.mesh.triangles);
    assert!(Bounds::of(&marked.mesh.positions) == Bounds::of(&plain.mesh.positions));
}

#[test]
fn origins_are_taken_where_steps_of_single_precision_show() {
    let origin = |low: [f64; 3], high: [f64; 3]| Bounds { low: low.into(), high: high.into() }.origin();
    // 2 m at 100 m: steps of 1/131072 m, of which 262144 are 2 m; at 1000 m: 1/16384 m
    assert_eq!(origin([99.0; 3], [101.0; 3]), DVec3::ZERO);
    assert_eq!(origin([999.2, 0.0, -1001.0], [1001.2, 2.0, -999.0]), DVec3::new(1000.0, 0.0, -1000.0));
    // a country of 600 km at UTM coordinates: steps of half a metre are enough for it
    assert_eq!(origin([2e5, 0.0, 5.2e6], [8e5, 3e3, 5.8e6]), DVec3::ZERO);
    // degrees
    assert_eq!(origin([13.401_1, 52.51, 0.0], [13.402_3, 52.510_8, 0.0001]), DVec3::new(13.402, 52.51, 0.0));
    assert_eq!(origin([5e6; 3], [5e6; 3]), DVec3::ZERO, "a point has no shape");
    assert_eq!(Bounds::EMPTY.origin(), DVec3::ZERO);
}

#[test]
fn a_transform_may_move_a_model_back() {
    let [x, y, z] = (-FAR).to_array();
    let back = scene(FAR, &format!("{CAMERA}{LIGHT}[[mesh]]\npath = \"ball.obj\"\ntranslate = [{x}, {y}, {z}]\n"));
    assert_eq!(back.origin(), DVec3::ZERO);
    assert_same_view(&local(), &back, "translate");
    // a quarter turn about the vertical axis, and millimetres
    let turned = DVec3::new(FAR.z, FAR.y, -FAR.x) * -1e-3;
    let small = scene(
        FAR,
        &format!(
            "[camera]\norigin = [0.005, 0.001, 0.0005]\ntarget = [0, 0, 0]\nvfov = 32\n{LIGHT}[[mesh]]\npath = \"ball.obj\"\n\
             scale = 0.001\nrotate = {{ axis = [0, 1, 0], angle = 90 }}\ntranslate = [{}, {}, {}]\n",
            turned.x, turned.y, turned.z
        ),
    );
    let (local, small) = (depths(&local()), depths(&small));
    let seen = local.iter().zip(&small).filter(|(a, b)| **a > 0.0 && **b > 0.0);
    let worst = seen.clone().map(|(a, b)| (a - 1e3 * b).abs()).fold(0.0, f32::max);
    assert!(seen.count() > 100 && worst < 2e-3, "{worst}");
}

#[test]
fn cameras_lights_and_instances_mean_what_the_file_says() {
    let at = |p: [f64; 3]| (DVec3::from(p) + FAR).to_array();
    let (eye, lamp) = (at([5.0, 1.0, 0.5]), at([4.0, 3.0, 1.0]));
    let view = format!(
        "[camera]\norigin = {eye:?}\ntarget = {:?}\nvfov = 32\n[[light]]\ntype = \"point\"\nposition = {lamp:?}\nintensity = 90\n",
        FAR.to_array()
    );
    let local = local();
    let expected = light(&local);
    assert!(expected.x > 0.01, "{expected}");
    let translate = FAR.to_array();
    let placements = [
        (FAR, "[[mesh]]\npath = \"ball.obj\"\n".to_string()),
        (DVec3::ZERO, format!("[[mesh]]\npath = \"ball.obj\"\ntranslate = {translate:?}\n")),
        (
            DVec3::ZERO,
            format!(
                "[[mesh]]\npath = \"ball.obj\"\ngroup = \"g\"\n[[instance]]\ngroup = \"g\"\ntranslate = {translate:?}\n"
            ),
        ),
        (FAR, "[[mesh]]\npath = \"ball.obj\"\ngroup = \"g\"\n[[instance]]\ngroup = \"g\"\n".to_string()),
    ];
    for (centre, placement) in placements {
        let far = scene(centre, &format!("{view}{placement}"));
        assert_eq!(far.origin(), DVec3::new(412_346.0, 0.0, 5_612_345.0), "{placement}");
        assert_same_view(&local, &far, &placement);
        let found = light(&far);
        assert!((found - expected).length() < 1e-3 * expected.length(), "{placement}: {found} for {expected}");
    }
}

#[test]
fn a_model_alone_is_seen_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.obj");
    let size = [format!("film.width={SIZE}"), format!("film.height={SIZE}")];
    let size: Vec<&str> = size.iter().map(String::as_str).collect();
    std::fs::write(&path, ball(DVec3::ZERO)).unwrap();
    let near = load(&path, &size);
    std::fs::write(&path, ball(FAR)).unwrap();
    let far = load(&path, &size);
    assert_same_view(&near, &far, "automatic camera");
    let (file, _) = format::load(&path, &[]).unwrap();
    let (_, warnings) = file.load_scene(1).unwrap();
    let said = "counted from (412346, 0, 5612345)";
    assert!(warnings.iter().any(|warning| warning.contains(said)), "{warnings:?}");
}
