//! Adaptive sampling: unbiased, and better for as many rays.

use super::*;
use crate::format;
use crate::math::{Rgb, luminance};
use crate::render::{Rendering, Settings, render};
use crate::scene::Scene;
use crate::stats::ztest::z_one_mean;
use std::path::Path;

/// A box of which the picture shows mostly what is about it.
fn cornell(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=128", "film.height=96", "camera.vfov=75", "guiding.method=none"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

fn rendered(scene: &Scene, settings: &Settings, seed: u64) -> Rendering {
    let mut settings = settings.clone();
    settings.render.seed = seed;
    render(scene, &settings, &mut |_| true)
}

/// Mean square of the difference of two pictures, relative to the truth with a floor, and their rays.
fn error(found: &Rendering, truth: &[Rgb]) -> f64 {
    let light: Vec<f64> = truth.iter().map(|&c| luminance(c).into()).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let square = |(c, l): (&Rgb, &f64)| (f64::from(luminance(*c)) - l).powi(2) / (l * l + (0.1 * mean).powi(2));
    found.estimate.mean.iter().zip(&light).map(square).sum::<f64>() / light.len() as f64
}

fn rays(rendering: &Rendering) -> f64 {
    let total = rendering.total();
    total.rays as f64 + 0.5 * total.shadow_rays as f64
}

#[test]
fn noisy_tiles_get_more_and_the_picture_is_better_for_as_many_rays() {
    let (scene, settings) = cornell(&["render.spp=2048", "render.seed=99"]);
    let truth = render(&scene, &settings, &mut |_| true).estimate.mean;
    let work = |set: &[&str]| {
        let (_, settings) = cornell(&[&["render.spp=96"][..], set].concat());
        let all: Vec<Rendering> = (0..3).map(|seed| rendered(&scene, &settings, seed)).collect();
        let work = all.iter().map(|one| error(one, &truth) * rays(one)).sum::<f64>() / all.len() as f64;
        (work, all)
    };
    let ((even, _), (adaptive, all)) = (work(&[]), work(&["render.adaptive=true"]));
    assert!(adaptive < 0.8 * even, "{adaptive} for adaptive samples, {even} for even ones");
    for one in &all {
        let (least, most, blank) = one.estimate.spread();
        assert!(one.samples == 96 && blank == 0 && most > 3 * least, "{least} to {most} samples");
        assert_eq!(one.adaptive_tiles, Some(32));
    }
}

#[test]
fn tiles_end_when_they_are_as_good_as_was_asked_for() {
    let (scene, settings) = cornell(&["render.spp=100000", "render.noise=0.1", "render.adaptive=true"]);
    let all: Vec<Rendering> = (0..3).map(|seed| rendered(&scene, &settings, seed)).collect();
    for one in &all {
        let (least, most, _) = one.estimate.spread();
        let said = one.relative_error.unwrap();
        assert!(said < 0.11 && most > 8 * least, "{least} to {most} samples, an error of {said}");
    }
    let again = rendered(&scene, &settings, 0);
    assert!(again.estimate.mean == all[0].estimate.mean && again.estimate.counts == all[0].estimate.counts);
}

/// Standard errors by which the light of parts of adaptive pictures is off, largest first, and the light itself.
fn off(scene: &Scene, settings: &Settings, seeds: u64, truth: &[(f64, f64)]) -> f64 {
    let parts = |rendering: &Rendering| parts(rendering, truth.len());
    let all: Vec<Vec<f64>> = (0..seeds).map(|seed| parts(&rendered(scene, settings, seed))).collect();
    let z = |k: usize| {
        let (mean, error) = mean_and_error(all.iter().map(|parts| parts[k]));
        z_one_mean(mean - truth[k].0, error.hypot(truth[k].1), 0.0).abs()
    };
    (0..truth.len()).map(z).fold(0.0, f64::max)
}

/// Mean light of rows of pixels.
fn parts(rendering: &Rendering, parts: usize) -> Vec<f64> {
    let all = &rendering.estimate.mean;
    let mean = |part: &[Rgb]| part.iter().map(|&c| f64::from(luminance(c))).sum::<f64>() / part.len() as f64;
    all.chunks(all.len() / parts).map(mean).collect()
}

fn mean_and_error(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt())
}

#[test]
fn adaptive_pictures_are_unbiased_with_a_guide_and_without() {
    const PARTS: usize = 3;
    const SEEDS: u64 = 10;
    let small = ["film.width=64", "film.height=48", "render.spp=80"];
    let (scene, settings) = cornell(&small);
    let even: Vec<Vec<f64>> =
        (100..100 + 2 * SEEDS).map(|seed| parts(&rendered(&scene, &settings, seed), PARTS)).collect();
    let truth: Vec<(f64, f64)> = (0..PARTS).map(|k| mean_and_error(even.iter().map(|parts| parts[k]))).collect();
    for set in [&["render.adaptive=true"][..], &["render.adaptive=true", "guiding.method=adaptive"]] {
        let (_, settings) = cornell(&[&small[..], set].concat());
        let off = off(&scene, &settings, SEEDS, &truth);
        // Student's t of few seeds: once in some thousand by chance, for three parts
        assert!(off < 5.0, "{set:?}: {off} standard errors");
    }
    // pictures that are darker by what nobody sees
    let dimmed: Vec<(f64, f64)> = truth.iter().map(|(mean, error)| (1.03 * mean, *error)).collect();
    let (_, settings) = cornell(&[&small[..], &["render.adaptive=true"]].concat());
    assert!(off(&scene, &settings, SEEDS, &dimmed) > 5.0, "a bias of three percent is not seen");
}

#[test]
fn samples_are_dealt_in_proportion_but_for_a_least_number() {
    let tiling = Tiling::new(100, 70);
    let tiles = tiling.tiles();
    let weights: Vec<Option<f64>> = (0..tiles.len()).map(|k| Some([0.0, 1.0, 3.0][k % 3])).collect();
    let samples = deal(&weights, 64.0, &tiles);
    let paths: u64 = samples.iter().zip(&tiles).map(|(&n, tile)| u64::from(n) * tile.pixels() as u64).sum();
    assert!((64 * 7000..64 * 7000 + 1024).contains(&paths), "{paths} paths");
    for k in (0..9).step_by(3) {
        assert!((16..=17).contains(&samples[k]), "{samples:?}");
        assert!((i64::from(samples[k + 2]) - 3 * i64::from(samples[k + 1])).abs() <= 4, "{samples:?}");
    }
    // nothing is known, and some tiles are done
    assert_eq!(deal(&[Some(0.0), Some(0.0)], 5.0, &tiles[..2]), [5, 5]);
    assert_eq!(deal(&[None, Some(0.5)], 5.0, &tiles[..2]), [0, 10]);
}
