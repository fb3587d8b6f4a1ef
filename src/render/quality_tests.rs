//! Renders that end by their noise.

use super::{Rendering, Settings, render};
use crate::film::blur::mean_without_largest;
use crate::format;
use crate::math::{Rgb, luminance};
use crate::scene::Scene;
use std::path::Path;

const SIDE: usize = 32;

fn cornell(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=32", "film.height=32", "render.spp=100000"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Share of the pixels, the noisiest, that do not count: about that of iterations as long as these.
const NOISIEST: f64 = 0.01;

/// Squares of the errors relative to the truth, pixel by pixel, with the floor that is said.
fn relative_squares(found: &[Rgb], truth: &[Rgb]) -> Vec<f64> {
    let light: Vec<f64> = truth.iter().map(|&c| luminance(c).into()).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let relative = |(c, l): (&Rgb, &f64)| (f64::from(luminance(*c)) - l).powi(2) / (l * l + (0.1 * mean).powi(2));
    found.iter().zip(&light).map(relative).collect()
}

fn ended_by(scene: &Scene, settings: &Settings, noise: f64, seed: u64) -> Rendering {
    let mut settings = settings.clone();
    (settings.render.noise, settings.render.seed) = (Some(noise), seed);
    render(scene, &settings, &mut |_| true)
}

#[test]
fn the_true_error_is_what_was_asked_for() {
    const RENDERS: u64 = 6;
    let (scene, mut settings) = cornell(&["guiding.method=none"]);
    (settings.render.spp, settings.render.seed) = (4096, 999);
    let truth = render(&scene, &settings, &mut |_| true).estimate.mean;
    assert_eq!(truth.len(), SIDE * SIDE);
    for set in [
        &["guiding.method=none"][..],
        &["guiding.method=none", "render.sampler=independent"],
        &["guiding.method=adaptive"],
    ] {
        let (scene, settings) = cornell(set);
        let mut samples = [0; 2];
        for (k, noise) in [0.16, 0.08].into_iter().enumerate() {
            let mut sums = vec![0.0; SIDE * SIDE];
            for seed in 0..RENDERS {
                let rendering = ended_by(&scene, &settings, noise, seed);
                let said = rendering.relative_error.unwrap();
                assert!(said <= noise && said > 0.5 * noise, "{set:?}: {said}");
                assert!((16..50000).contains(&rendering.samples), "{} samples", rendering.samples);
                samples[k] += rendering.samples;
                let squares = relative_squares(&rendering.estimate.mean, &truth);
                sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
            }
            let error = (mean_without_largest(sums, NOISIEST) / RENDERS as f64).sqrt();
            // what is asked for is an upper bound; a fifth more for the noise of estimates, and of the truth
            assert!((0.75 * noise..1.2 * noise).contains(&error), "{set:?}: {error} and not {noise}");
        }
        let ratio = f64::from(samples[1]) / f64::from(samples[0]);
        assert!((2.0..7.0).contains(&ratio), "{set:?}: half the noise takes {ratio} times the samples");
    }
}

#[test]
fn it_ends_by_samples_where_those_are_used_first_and_always_in_the_same_way() {
    let (scene, mut settings) = cornell(&["guiding.method=adaptive"]);
    let [a, b] = [(); 2].map(|()| ended_by(&scene, &settings, 0.15, 3));
    assert!(a.samples == b.samples && a.estimate.mean == b.estimate.mean);
    settings.render.spp = 20;
    let few = ended_by(&scene, &settings, 1e-9, 3);
    assert!(few.samples == 20 && few.relative_error.unwrap() > 0.01);
}
