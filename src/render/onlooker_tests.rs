//! Who looks at a render changes nothing of it, and sees what it would leave.

use super::super::{GuideIo, Order, Settings, Stop, render, render_shown};
use super::{Moment, Onlooker};
use crate::film::accumulate::Estimate;
use crate::format;
use crate::scene::Scene;
use std::path::Path;

fn door(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=48", "film.height=27", "render.layers=[\"direct\"]"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Looks whenever it can.
#[derive(Default)]
struct Curious {
    pictures: Vec<Estimate>,
    ended: usize,
}

impl Onlooker for Curious {
    fn is_due(&mut self, ends: bool) -> bool {
        self.ended += usize::from(ends);
        true
    }

    fn look(&mut self, moment: &Moment) {
        assert!(moment.coverage().iter().all(|share| (0.0..=1.0).contains(share)));
        self.pictures.push(moment.picture());
    }
}

fn watched(scene: &Scene, settings: &Settings) -> (Estimate, Curious) {
    let mut curious = Curious::default();
    let rendering = render_shown(scene, settings, GuideIo::default(), &(), &Stop::new(), (&mut |_| true, &mut curious));
    (rendering.estimate, curious)
}

fn is_same(a: &Estimate, b: &Estimate) -> bool {
    let counted_alike = (0..a.mean.len()).all(|i| a.count(i) == b.count(i));
    a.mean == b.mean && a.variance == b.variance && a.layers == b.layers && counted_alike
}

#[test]
fn looking_changes_nothing_and_the_last_look_sees_the_picture() {
    for set in
        [&["guiding.method=adaptive"][..], &["guiding.method=auto"], &["guiding.method=none", "render.order=blocks"]]
    {
        let (scene, mut settings) = door(set);
        settings.render.spp = 21;
        let plain = render(&scene, &settings, &mut |_| true).estimate;
        let (estimate, curious) = watched(&scene, &settings);
        assert!(is_same(&plain, &estimate), "{set:?}: another picture");
        assert!(curious.ended == 1 && is_same(curious.pictures.last().unwrap(), &estimate), "{set:?}");
        assert!(settings.render.order == Order::Blocks || curious.pictures.len() > 5);
    }
}

#[test]
fn each_look_sees_what_the_render_would_leave_if_it_ended_then() {
    let (scene, mut settings) = door(&["guiding.method=adaptive"]);
    settings.render.spp = 21;
    let (_, curious) = watched(&scene, &settings);
    for (k, seen) in curious.pictures.iter().enumerate() {
        let mut passes = 0;
        let ended = render(&scene, &settings, &mut |_| {
            passes += 1;
            passes <= k
        });
        assert!(is_same(seen, &ended.estimate), "after {} samples", seen.samples);
    }
}
