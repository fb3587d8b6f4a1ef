//! Several renders are one of all their samples, unbiased.

use super::super::checkpoint::{Header, open};
use super::super::{GuideIo, Moment, Occasion, Onlooker, Rendering, Settings, Stop, render_shown};
use super::Merged;
use crate::format;
use crate::math::{Rgb, luminance};
use crate::render::Checkpoint;
use crate::scene::Scene;
use std::path::Path;

fn door(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=32", "film.height=18", "render.layers=[\"direct\", \"cryptomatte\"]"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Keeps the end of a render.
struct Keeper<'a>(&'a Header<()>, &'a Path);

impl Onlooker for Keeper<'_> {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        occasion == Occasion::Last
    }

    fn look(&mut self, moment: &Moment) {
        moment.write_checkpoint(self.1, self.0).unwrap();
    }

    fn keeps_state(&self) -> bool {
        true
    }
}

fn rendered(scene: &Scene, settings: &Settings, seed: u64, spp: u32) -> (Rendering, Checkpoint) {
    let folder = tempfile::tempdir().unwrap();
    let (header, path) = (Header::new(scene, settings, ()), folder.path().join("a"));
    let mut settings = settings.clone();
    (settings.render.seed, settings.render.spp) = (seed, spp);
    let mut keeper = Keeper(&header, &path);
    let shown = (&mut |_: &_| true, &mut keeper);
    let rendering = render_shown(scene, &settings, GuideIo::default(), &(), &Stop::new(), (shown.0, shown.1));
    let checkpoint = open::<()>(&path).unwrap().read_of_any_seed(scene, &settings).unwrap();
    (rendering, checkpoint)
}

fn merged(scene: &Scene, checkpoints: impl IntoIterator<Item = Checkpoint>) -> Rendering {
    let mut all = checkpoints.into_iter();
    let mut merged = Merged::new(all.next().unwrap());
    all.for_each(|other| merged.add(other).unwrap());
    merged.finish(scene)
}

fn light(rendering: &Rendering) -> f64 {
    let all = &rendering.estimate.mean;
    all.iter().map(|&c| f64::from(luminance(c))).sum::<f64>() / all.len() as f64
}

#[test]
fn unguided_samples_count_alike_whatever_render_they_are_of() {
    let (scene, settings) = door(&["guiding.method=none"]);
    let (one, a) = rendered(&scene, &settings, 1, 8);
    let (other, b) = rendered(&scene, &settings, 2, 24);
    let both = merged(&scene, [a, b]);
    assert_eq!((both.samples, both.estimate.samples), (32, 32));
    let mixed = |a: Rgb, b: Rgb| (a * 8.0 + b * 24.0) / 32.0;
    let near = |x: Rgb, y: Rgb| (x - y).abs().max_element() <= 1e-5 * y.max_element() + 1e-12;
    for i in 0..both.estimate.mean.len() {
        let of = |r: &Rendering| (r.estimate.mean[i], r.estimate.layers[0].1[i], r.estimate.features[i].depth);
        let ((x, lx, dx), (y, ly, dy), (z, lz, dz)) = (of(&one), of(&other), of(&both));
        assert!(near(z, mixed(x, y)) && near(lz, mixed(lx, ly)), "pixel {i}");
        assert!((dz - (dx * 8.0 + dy * 24.0) / 32.0).abs() <= 1e-4 * dz, "pixel {i}");
    }
    let ids = &both.estimate.ids;
    assert!(ids.samples.iter().all(|&n| n == 32));
    assert!(ids.counts.iter().all(|kinds| kinds[0].iter().map(|(_, count)| count).sum::<u16>() <= 32));
}

#[test]
fn the_same_seed_is_refused() {
    let (scene, settings) = door(&["guiding.method=none"]);
    let [a, b, c] = [(1, 4), (2, 4), (1, 8)].map(|(seed, spp)| rendered(&scene, &settings, seed, spp).1);
    let mut all = Merged::new(a);
    all.add(b).unwrap();
    assert!(all.add(c).unwrap_err().contains("the same seed"));
}

#[test]
fn guided_renders_joined_are_unbiased_and_less_noisy() {
    const PAIRS: u64 = 12;
    let (scene, settings) = door(&["guiding.method=adaptive"]);
    let (_, plain) = door(&["guiding.method=none"]);
    let mut lights = [Vec::new(), Vec::new(), Vec::new()];
    for pair in 0..PAIRS {
        let (one, a) = rendered(&scene, &settings, 2 * pair + 10, 15);
        let (other, b) = rendered(&scene, &settings, 2 * pair + 11, 31);
        lights[0].push(light(&merged(&scene, [a, b])));
        lights[1].extend([light(&one), light(&other)]);
        lights[2].push(light(&rendered(&scene, &plain, 1000 + pair, 100).0));
    }
    let [joined, single, plain] = lights.map(|all| {
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        (mean, all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0), n)
    });
    // a false alarm once in 16,000
    let z = (joined.0 - plain.0) / (joined.1 / joined.2 + plain.1 / plain.2).sqrt();
    assert!(z.abs() < 4.0, "{joined:?} and {plain:?}: z = {z}");
    assert!((plain.1 / plain.2).sqrt() < 0.05 * plain.0, "the test would not see a bias of a fifth");
    assert!(joined.1 < single.1, "{joined:?} and {single:?}");
}
