//! A render goes on from its state alone.

use super::super::driver::{Driver, Job};
use super::super::limits::Limits;
use super::super::{GuideIo, Rendering, Settings, Stop, render};
use super::RenderState;
use crate::format;
use crate::scene::Scene;
use std::path::Path;

fn door(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=64", "film.height=36"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Renders with another driver for each iteration, which takes over nothing but the state, after `change`.
fn in_pieces(scene: &Scene, settings: &Settings, change: fn(&mut RenderState)) -> (usize, Rendering) {
    let stop = Stop::new();
    let mut state = RenderState::new(scene, &scene.camera, settings, GuideIo::default());
    for drivers in 0.. {
        let job = Job { scene, camera: &scene.camera, settings, watch: &(), keep_guide: false, keeps_state: false };
        let mut driver = Driver::new(job, state, Limits::from_now(None, &stop));
        if !driver.iterate(&mut |_| true, &mut ()) {
            return (drivers, driver.finish());
        }
        state = driver.into_state();
        change(&mut state);
    }
    unreachable!("a render ends")
}

#[test]
fn a_render_in_pieces_is_the_same_to_the_last_bit() {
    for (method, spp) in [("auto", 400), ("auto", 60), ("adaptive", 40), ("sdtree", 40), ("none", 40)] {
        let (scene, settings) = door(&[&format!("guiding.method={method}"), &format!("render.spp={spp}")]);
        let (whole, (drivers, pieces)) =
            (render(&scene, &settings, &mut |_| true), in_pieces(&scene, &settings, |_| ()));
        assert!(drivers == whole.iterations.len() && drivers > 1, "{method}: {drivers} iterations");
        assert_eq!(whole.verdict, pieces.verdict, "{method}");
        assert!(whole.estimate.mean == pieces.estimate.mean, "{method}, {spp} samples: another picture");
        assert!(whole.estimate.variance == pieces.estimate.variance, "{method}, {spp} samples: other noise");
    }
}

#[test]
fn what_a_state_loses_shows_in_the_picture() {
    type Change = fn(&mut RenderState);
    let changes: [(&str, Change); 4] = [
        ("roulette", |state| state.roulette = None),
        ("learnt samples", |state| state.learnt_samples = 0),
        ("the plan", |state| state.plan.samples += 1),
        ("the seed", |state| state.seed += 1),
    ];
    let (scene, settings) = door(&["guiding.method=adaptive", "render.spp=40"]);
    let whole = render(&scene, &settings, &mut |_| true).estimate.mean;
    for (what, change) in changes {
        assert!(in_pieces(&scene, &settings, change).1.estimate.mean != whole, "{what} makes no difference");
    }
}
