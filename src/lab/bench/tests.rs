//! What is recorded is what was rendered, and what is measured is of it.

use super::clock::Clock;
use super::record::{Kind, Recorder, Recording};
use super::replay::{RaySet, arranged, as_rendered, count, replay};
use super::*;
use crate::format;
use crate::integrator::Counters;
use crate::render::{GuideIo, Rendering, Stop, render as render_scene, render_watched};
use crate::scene::Scene;

/// The project's Cornell box, small.
fn cornell(more: &[&str]) -> (SceneFile, Scene) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let tiny = ["film.width=48", "film.height=40", "render.spp=12"];
    let set: Vec<String> = tiny.iter().chain(more).map(ToString::to_string).collect();
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    (description, scene)
}

fn counters(rendering: &Rendering) -> Counters {
    let mut sum = Counters::default();
    rendering.iterations.iter().for_each(|i| sum.add(&i.counters));
    sum
}

fn recorded(scene: &Scene, settings: &Settings) -> (Rendering, Recording) {
    let recorder = Recorder::default();
    let rendering = render_watched(scene, settings, GuideIo::default(), &recorder, &Stop::new(), &mut |_| true);
    (rendering, recorder.finish())
}

#[test]
fn every_ray_that_is_cast_is_recorded_once_and_the_picture_stays_the_same() {
    let (description, scene) = cornell(&[]);
    for method in [GuidingMethod::None, GuidingMethod::Adaptive, GuidingMethod::SdTree] {
        let settings = settings(&description, method);
        let plain = render_scene(&scene, &settings, &mut |_| true);
        let (watched, recording) = recorded(&scene, &settings);
        assert_eq!(plain.estimate.mean, watched.estimate.mean, "{method:?}: another picture");
        assert_eq!(plain.estimate.variance, watched.estimate.variance);
        let cast = counters(&plain);
        assert_eq!(recording.rays(Kind::Closest) as u64, cast.rays, "{method:?}");
        assert_eq!(recording.rays(Kind::Shadow) as u64, cast.shadow_rays, "{method:?}");
        assert!(cast.shadow_rays > 1000);
        let camera = recording.batches.iter().flatten().filter(|w| w.kind == Kind::Closest && w.depth == 1);
        assert_eq!(camera.map(|w| w.rays.len() as u64).sum::<u64>(), cast.paths);
        for wave in recording.batches.iter().flatten() {
            assert_eq!(wave.slots.len(), wave.rays.len(), "every ray belongs to a path");
        }
    }
}

#[test]
fn a_clock_changes_no_picture() {
    let (description, scene) = cornell(&[]);
    let settings = settings(&description, GuidingMethod::Grid);
    let plain = render_scene(&scene, &settings, &mut |_| true);
    let clock = Clock::default();
    let watched = render_watched(&scene, &settings, GuideIo::default(), &clock, &Stop::new(), &mut |_| true);
    assert_eq!(plain.estimate.mean, watched.estimate.mean);
    let split = clock.split().unwrap();
    assert!((split.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{split:?}");
    // the guide alone may be too short, on a busy machine, to be told from a stamp
    let long = split.shares.iter().filter(|share| **share > 0.0).count();
    assert!(long >= 6 && split.shares.iter().all(|share| *share >= 0.0), "a guided render has all stages: {split:?}");
}

#[test]
fn replayed_rays_meet_what_they_met_in_the_render() {
    let (description, scene) = cornell(&[]);
    let (_, recording) = recorded(&scene, &settings(&description, GuidingMethod::None));
    let strands = as_rendered(&recording);
    let found: usize = recording.batches.iter().flatten().map(|wave| wave.found).sum();
    assert_eq!(replay(scene.geometry(), &strands, 16).1, found, "the same calls give the same hits");
    let all = recording.rays(Kind::Closest) + recording.rays(Kind::Shadow);
    assert_eq!(count(&strands), all);
    assert!(found > all / 10 && found < all, "{found} of {all} rays met something: they do not test much");
    for width in [1, 8] {
        let other = replay(scene.geometry(), &strands, width).1;
        assert!(other.abs_diff(found) <= 1 + all / 10_000, "{width} wide: {other} against {found}");
    }
}

#[test]
fn orders_hold_the_same_rays_and_sets_hold_all() {
    let (description, scene) = cornell(&[]);
    let (_, recording) = recorded(&scene, &settings(&description, GuidingMethod::None));
    let bits = |strands: &[replay::Strand]| {
        let mut all = replay::bits(strands);
        all.sort_unstable();
        all
    };
    let mut sum = 0;
    for set in RaySet::ALL {
        let [paths, waves, octants] = RayOrder::ALL.map(|order| arranged(&recording, set, order));
        assert_eq!(bits(&paths), bits(&waves), "{set:?}");
        assert_eq!(bits(&octants), bits(&waves), "{set:?}");
        sum += count(&waves);
    }
    assert_eq!(sum, count(&as_rendered(&recording)));
    let camera = RayOrder::ALL.map(|order| replay::bits(&arranged(&recording, RaySet::Camera, order)));
    assert_ne!(camera[0], camera[1], "blocks of 4×4 pixels are not rows");
}

#[test]
fn figures_of_rays_are_whole() {
    let (description, scene) = cornell(&["render.spp=4"]);
    let report = rays(&scene, &description, 2, 2).unwrap();
    assert_eq!(report.paths, 48 * 40 * 4);
    assert_eq!(report.whole.iter().map(|f| f.threads).collect::<Vec<_>>(), [1, 2]);
    // five sets, two counts of threads, three orders, three widths
    assert_eq!(report.replays.len(), 5 * 2 * 3 * 3);
    let per_set = |set| report.replays.iter().find(|f| f.set == set).unwrap().rays as u64;
    assert_eq!(RaySet::ALL.map(per_set).iter().sum::<u64>(), report.rays + report.shadow_rays);
    for f in report.whole.iter() {
        assert!(f.renderer.median > 0.0 && f.embree.median > 0.0 && f.share.median > 0.0, "{f:?}");
    }
    assert!(report.replays.iter().all(|f| f.mrays_per_second.median > 0.0 && f.ratio.median > 0.0));
}

#[test]
fn shares_of_stages_sum_to_one() {
    let (description, scene) = cornell(&[]);
    let methods = [GuidingMethod::None, GuidingMethod::Grid];
    let reports = render(&scene, &description, &methods, 2).unwrap();
    for report in &reports {
        let sum: f64 = report.shares.iter().map(|s| s.share).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{report:?}");
        assert!(report.shares.iter().all(|s| (-1e-3..1.0).contains(&s.share)), "{report:?}");
    }
    let of = |report: &MethodReport, stage: &str| report.shares.iter().find(|s| s.stage == stage).unwrap().share;
    for stage in ["guide query", "record", "learn"] {
        assert_eq!(of(&reports[0], stage), 0.0, "nothing is learnt without a guide");
    }
    for stage in ["intersect", "record", "learn"] {
        assert!(of(&reports[1], stage) > 0.0, "{stage}: {:?}", reports[1]);
    }
}

#[test]
fn one_batch_is_too_little_to_tell_stages_apart() {
    let (description, scene) = cornell(&["film.width=8", "film.height=8", "render.spp=1"]);
    let error = render(&scene, &description, &[GuidingMethod::None], 1).unwrap_err().to_string();
    assert!(error.contains("too few samples"), "{error}");
}

#[test]
fn loading_counts_what_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n").unwrap();
    let (description, _) = format::load(&path, &[]).unwrap();
    let report = load(&description, 1, 2).unwrap();
    assert_eq!((report.triangles, report.tobj.triangles), (2, Some(2)));
    // at least four positions, six indices and two materials
    assert!(report.mesh_bytes >= 4 * 12 + 2 * 12 + 2 * 4 && report.embree_bytes > 0, "{report:?}");
    assert!(report.first_pixel.median >= report.build.median && report.parse.median > 0.0);
    // a continued line is legal, and more than tobj knows
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3\n").unwrap();
    let report = load(&description, 1, 1).unwrap();
    assert!(report.triangles == 1 && report.tobj.wall_seconds.is_none() && report.tobj.failure.is_some(), "{report:?}");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 x\n").unwrap();
    assert!(load(&description, 1, 1).unwrap_err().to_string().contains("two.obj:5"));
}
