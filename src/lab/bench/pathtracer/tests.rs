use super::stand_in::StandIn;
use super::*;
use crate::format;
use std::fs;

const SCENE: &str = "[film]\nwidth = 32\nheight = 24\n[[mesh]]\npath = \"room.obj\"\n[render]\nseed = 3\n";

/// A floor and, a unit above, a lamp that faces down.
const ROOM: &str = "mtllib room.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nusemtl floor\nf 4 3 2 1\n\
    v -0.5 1 -0.5\nv 0.5 1 -0.5\nv 0.5 1 0.5\nv -0.5 1 0.5\nusemtl lamp\nf 5 6 7 8\n";
const LIBRARY: &str = "newmtl floor\nKd 0.2 0.3 0.4\nnewmtl lamp\nKd 0 0 0\nKe 5 5 5\n";

fn room(more: &str) -> (SceneFile, Scene) {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{more}");
    for (name, text) in [("scene.toml", &text[..]), ("room.obj", ROOM), ("room.mtl", LIBRARY)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let (description, _) = format::load(&folder.path().join("scene.toml"), &[]).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    (description, scene)
}

const PLAN: EmbreePlan = EmbreePlan { spp: 2, frames: 3, depth: 4, albedo: 0.5, threads: 1 };

#[test]
fn a_stand_in_has_the_triangles_and_one_light_off_the_lamp() {
    let (description, scene) = room("");
    let stand_in = StandIn::write(&scene, &description, &PLAN).unwrap();
    let (own, warnings) = Scene::load(&stand_in.description.scene, 1, stand_in.description.render.build).unwrap();
    assert_eq!((warnings, own.triangles(), own.bounds()), (Vec::new(), 4, scene.bounds()));
    let p = stand_in.light.position;
    assert!(p.x.abs() < 1e-6 && p.z.abs() < 1e-6 && p.y < 1.0 && p.y > 0.97, "{p}");
    let d = &stand_in.description;
    assert_eq!((d.render.spp, d.integrator.max_depth, d.scene.film.width), (6, 4, 32));
    let text = fs::read_to_string(stand_in.model().with_extension("mtl")).unwrap();
    assert!(text.contains("Kd 0.5 0.5 0.5"), "{text}");
    let folder = stand_in.model();
    drop(stand_in);
    assert!(!folder.exists(), "nothing is left behind");
}

#[test]
fn the_scenes_own_point_light_comes_first() {
    let (description, scene) = room("[[light]]\ntype = \"point\"\nposition = [0.1, 0.5, 0.2]\nintensity = [1, 1, 1]\n");
    let stand_in = StandIn::write(&scene, &description, &PLAN).unwrap();
    assert_eq!(stand_in.light.position.to_array(), [0.1, 0.5, 0.2]);
}

/// A program that prints what Embree's prints, after burning some time.
#[cfg(unix)]
fn imposter(folder: &Path, figures: &str) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("pathtracer");
    fs::write(&path, format!("#!/bin/sh\necho \"$@\" > {}\n{figures}\n", folder.join("seen").display())).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[cfg(unix)]
#[test]
fn the_program_is_told_the_view_and_its_figures_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let figures =
        "echo BENCHMARK_RENDER_MIN 1; echo BENCHMARK_RENDER_AVG 10.0; echo BENCHMARK_RENDER_MRAYPS_AVG 0.0768";
    let program = imposter(folder.path(), figures);
    let (description, scene) = room("");
    let report = embree(&scene, &description, &PLAN, Some(&program), 1, 2).unwrap();
    let theirs = report.pathtracer.unwrap();
    // 32 × 24 × 2 samples a frame, ten frames a second; five rays each
    assert!((theirs.msamples_per_second.median - 0.015_36).abs() < 1e-9, "{theirs:?}");
    assert!((theirs.rays_per_sample - 5.0).abs() < 1e-9);
    let ours = report.phototaxis.msamples_per_second.median;
    assert!((theirs.ratio.low..=theirs.ratio.high).contains(&theirs.ratio.median) && ours > 0.0);
    let seen = fs::read_to_string(folder.path().join("seen")).unwrap();
    for word in ["--size 32 24", "--spp 2", "--max-path-length 4", "--threads 1", "--benchmark 1 4", "--pointlight 0"] {
        assert!(seen.contains(word), "{word} is missing in {seen}");
    }
}

#[cfg(unix)]
#[test]
fn a_program_that_fails_or_prints_nothing_is_an_error() {
    let (description, scene) = room("");
    for (figures, word) in [("exit 3", "failed with exit status: 3"), ("echo hello", "BENCHMARK_RENDER_AVG")] {
        let folder = tempfile::tempdir().unwrap();
        let program = imposter(folder.path(), figures);
        let error = embree(&scene, &description, &PLAN, Some(&program), 1, 1).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn without_the_program_only_ours_is_measured() {
    let (description, scene) = room("");
    let report = embree(&scene, &description, &PLAN, None, 1, 1).unwrap();
    assert!(report.pathtracer.is_none() && report.phototaxis.msamples_per_second.median > 0.0);
    let nowhere = tempfile::tempdir().unwrap();
    assert!(find_pathtracer(nowhere.path().as_os_str()).is_none());
    fs::write(nowhere.path().join("pathtracer"), "").unwrap();
    assert_eq!(find_pathtracer(nowhere.path().as_os_str()), Some(nowhere.path().join("pathtracer")));
}
