//! Adaptive sampling: unbiased, and better for as many rays.

use super::*;
use crate::format;
use crate::math::luminance;
use crate::render::{Rendering, Settings, render};
use crate::scene::Scene;
use std::path::Path;

/// A box of which the picture shows mostly what is about it.
fn cornell(set: &[&str]) -> (Scene, Settings) {
    let small = ["film.width=96", "film.height=64", "camera.vfov=75", "guiding.method=none"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

fn rendered(scene: &Scene, settings: &Settings, seeds: std::ops::Range<u64>) -> Vec<Rendering> {
    let with = |seed| {
        let mut settings = settings.clone();
        settings.render.seed = seed;
        render(scene, &settings, &mut |_| true)
    };
    seeds.map(with).collect()
}

/// Variance of pictures of different seeds, relative to their mean with a floor, times the rays of one.
fn work(all: &[Rendering]) -> f64 {
    let n = all.len() as f64;
    let light = |one: &Rendering, i: usize| f64::from(luminance(one.estimate.mean[i]));
    let means: Vec<f64> =
        (0..all[0].estimate.mean.len()).map(|i| all.iter().map(|one| light(one, i)).sum::<f64>() / n).collect();
    let floor = 0.1 * means.iter().sum::<f64>() / means.len() as f64;
    let relative = |(i, mean): (usize, &f64)| {
        let squares = all.iter().map(|one| (light(one, i) - mean).powi(2)).sum::<f64>();
        squares / (n - 1.0) / (mean * mean + floor * floor)
    };
    let variance = means.iter().enumerate().map(relative).sum::<f64>() / means.len() as f64;
    let rays = all.iter().map(Rendering::total).map(|total| total.rays as f64 + 0.5 * total.shadow_rays as f64);
    variance * rays.sum::<f64>() / n
}

#[test]
fn noisy_tiles_get_more_and_the_picture_is_better_for_as_many_rays() {
    let all = |set: &[&str]| {
        let (scene, settings) = cornell(&[&["render.spp=96"][..], set].concat());
        rendered(&scene, &settings, 0..3)
    };
    let (even, adaptive) = (all(&[]), all(&["render.adaptive=true"]));
    let ratio = work(&adaptive) / work(&even);
    eprintln!("adaptive pictures have {ratio:.2} times the variance for as many rays");
    assert!(ratio < 0.85, "{ratio}");
    for one in &adaptive {
        let (least, most, blank) = one.estimate.spread();
        assert!(one.samples == 96 && blank == 0 && most > 3 * least, "{least} to {most} samples");
        assert_eq!(one.adaptive_tiles, Some(32));
    }
}

#[test]
fn tiles_end_when_they_are_as_good_as_was_asked_for() {
    let (scene, settings) = cornell(&["render.spp=100000", "render.noise=0.15", "render.adaptive=true"]);
    let all = rendered(&scene, &settings, 0..2);
    for one in &all {
        let (least, most, _) = one.estimate.spread();
        let said = one.relative_error.unwrap();
        assert!(said < 0.16 && most > 3 * least, "{least} to {most} samples, an error of {said}");
    }
    let again = &rendered(&scene, &settings, 0..1)[0];
    assert!(again.estimate.mean == all[0].estimate.mean && again.estimate.counts == all[0].estimate.counts);
}

/// Mean light of parts of each picture, rows of pixels.
fn parts(all: &[Rendering], part: usize) -> (f64, f64) {
    let of = |one: &Rendering| {
        let pixels = one.estimate.mean.len() / PARTS;
        let light = one.estimate.mean[part * pixels..][..pixels].iter().map(|&c| f64::from(luminance(c)));
        light.sum::<f64>() / pixels as f64
    };
    let (values, n): (Vec<f64>, f64) = (all.iter().map(of).collect(), all.len() as f64);
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt())
}

const PARTS: usize = 2;

/// Standard errors by which the light of a part of the pictures is off, at most, where that of others is changed by a factor.
fn off(all: &[Rendering], others: &[Rendering], factor: f64) -> f64 {
    let z = |part: usize| {
        let ((own, own_error), (other, other_error)) = (parts(all, part), parts(others, part));
        ((own - factor * other) / own_error.hypot(other_error)).abs()
    };
    (0..PARTS).map(z).fold(0.0, f64::max)
}

#[test]
fn adaptive_pictures_are_unbiased_with_a_guide_and_without() {
    // Student's t of so few seeds: once in some thousand by chance
    const LIMIT: f64 = 5.0;
    let all = |set: &[&str], seeds| {
        let (scene, settings) = cornell(&[&["film.width=64", "film.height=32", "render.spp=80"][..], set].concat());
        rendered(&scene, &settings, seeds)
    };
    let even = all(&[], 100..116);
    for set in [&["render.adaptive=true"][..], &["render.adaptive=true", "guiding.method=adaptive"]] {
        let adaptive = all(set, 0..10);
        assert!(adaptive[0].adaptive_tiles.is_some());
        let off_by = |factor| off(&adaptive, &even, factor);
        assert!(off_by(1.0) < LIMIT, "{set:?}: {} standard errors", off_by(1.0));
        assert!(off_by(1.05) > LIMIT, "{set:?}: a bias of five percent is not seen, {} standard errors", off_by(1.05));
    }
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
