use super::*;
use crate::format;
use crate::light::{LightSampleContext, LightSampler};
use crate::scene::Scene;
use glam::Vec3;

/// At this number every scene is made in less than a second.
const FEW: u64 = 100_000;

fn load(folder: &Path, name: &str) -> Scene {
    let (description, warnings) = format::load(&folder.join(format!("{name}.toml")), &[]).unwrap();
    let (scene, more) = description.load_scene(0).unwrap();
    assert!(warnings.is_empty() && more.is_empty(), "{name}: {warnings:?} {more:?}");
    scene
}

#[test]
fn scenes_load_without_a_warning_and_are_as_large_as_asked_for() {
    for (name, extent) in [("city", [100.0, 200.0]), ("forest", [40.0, 200.0]), ("terrain", [900.0, 1100.0])] {
        // four houses of a floor more or less cannot come nearer to ten thousand
        for triangles in [if name == "city" { 60_000 } else { 10_000 }, FEW] {
            let folder = tempfile::tempdir().unwrap();
            generate(name, triangles, folder.path()).unwrap();
            let scene = load(folder.path(), name);
            let share = scene.triangles() as f64 / triangles as f64;
            assert!((share - 1.0).abs() < 0.02, "{name}: {} of {triangles}", scene.triangles());
            let (low, high) = scene.bounds();
            let size = high - low;
            assert!((0.6 * extent[0]..=extent[1]).contains(&size.x), "{name}: {size}");
            assert!(size.z < extent[1] && size.y > 4.0 && size.y < 600.0, "{name}: {size}");
            assert!(((low + high) * 0.5 * Vec3::new(1.0, 0.0, 1.0)).length() < 0.1 * size.x, "{name} is centred");
        }
    }
}

#[test]
fn the_same_number_gives_the_same_bytes_and_another_number_others() {
    for (name, _) in SCENES {
        let folders = [FEW, FEW, FEW + 20_000].map(|n| {
            let folder = tempfile::tempdir().unwrap();
            let paths = generate(name, n, folder.path()).unwrap();
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), paths.len(), "no temporary file is left");
            (folder, paths)
        });
        let bytes = |k: usize, i: usize| std::fs::read(&folders[k].1[i]).unwrap();
        for i in 0..folders[0].1.len() {
            assert!(bytes(0, i) == bytes(1, i), "{name}: {:?}", folders[0].1[i]);
        }
        assert!((0..folders[0].1.len()).any(|i| bytes(0, i) != bytes(2, i)), "{name}");
    }
}

#[test]
fn numbers_out_of_range_and_other_names_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    for n in [0, 9_999, 30_000_001] {
        let message = generate("city", n, folder.path()).unwrap_err().to_string();
        assert!(message.contains(&n.to_string()) && message.contains("30000000"), "{message}");
    }
    assert!(generate("door", FEW, folder.path()).unwrap_err().to_string().contains("door"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_that_names_the_file() {
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: this system has no /dev/full");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("terrain.obj")).unwrap();
    let message = generate("terrain", FEW, folder.path()).unwrap_err().to_string();
    assert!(message.contains("terrain.obj") && message.contains("No space left"), "{message}");
    assert!(!folder.path().join("terrain.toml").exists(), "no scene file without its mesh");
}

#[test]
fn every_emitter_faces_away_from_its_body() {
    for name in ["city", "forest"] {
        let folder = tempfile::tempdir().unwrap();
        generate(name, FEW, folder.path()).unwrap();
        let scene = load(folder.path(), name);
        let (mut seen, mut rng) = (0, crate::math::rng::Rng::new(9));
        for _ in 0..60_000 {
            let p = Vec3::new(30.0 * (rng.f32() - 0.5), 3.0, 30.0 * (rng.f32() - 0.5));
            let ctx = LightSampleContext::unoriented(p);
            let Some(light) = scene.lights().sample(LightSampler::Power, &ctx, rng.f64(), rng.f32x2()) else {
                continue;
            };
            let Some(surface) = light.target.filter(|_| !light.delta) else { continue };
            // just before the light there is nothing, so what emits is its outside
            let origin = surface.point + surface.normal * 0.02;
            let ray = crate::geometry::Ray { org: origin, dir: -surface.normal, tfar: 0.04 };
            let hit = scene.geometry().intersect(&ray).expect("the light is there");
            let si = scene.interaction(&hit, surface.normal);
            assert!(si.front && scene.emission(&si) == light.radiance, "{name}: {}", surface.point);
            seen += 1;
        }
        assert!(seen > 100, "{name}: {seen}");
    }
}

#[test]
fn the_terrain_has_the_normals_of_its_shape_whatever_its_number_of_triangles() {
    let scenes = [10_000, FEW].map(|n| {
        let folder = tempfile::tempdir().unwrap();
        generate("terrain", n, folder.path()).unwrap();
        load(folder.path(), "terrain")
    });
    // coarse triangles pass over what normals still show
    let height = |scene: &Scene, x: f32, z: f32, likeness: f32| {
        let ray = crate::geometry::Ray { org: Vec3::new(x, 1e3, z), dir: Vec3::NEG_Y, tfar: f32::INFINITY };
        let hit = scene.geometry().intersect(&ray).expect("the sheet has no hole");
        let si = scene.interaction(&hit, Vec3::Y);
        assert!(si.front && si.ng.dot(si.frame.n) > likeness, "{x} {z}: {} {}", si.ng, si.frame.n);
        si.p.y
    };
    let mut rng = crate::math::rng::Rng::new(2);
    for _ in 0..400 {
        let [x, z] = rng.f32x2().map(|u| 980.0 * (u - 0.5));
        let [coarse, fine] = [0.2, 0.8].map(|likeness| height(&scenes[(likeness > 0.5) as usize], x, z, likeness));
        assert!((fine - terrain::height(x as f64, z as f64) as f32).abs() < 2.5, "{x} {z}");
        assert!((coarse - fine).abs() < 12.0, "{x} {z}: {coarse} {fine}");
    }
}
