//! The paper's order of rendering, block after block with a guide that learns while it is used: it gives every pixel all
//! of its samples, depends on no number of threads, and changes the noise but not the answer.
//!
//! Means of independent runs are compared by Welch's t; all values together raise a false alarm with probability 10⁻⁴
//! (Šidák). A planted bias must be found.

use crate::common::{Loaded, Runs, own, welch};
use phototaxis::film::Combine;
use phototaxis::format;
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, Rate};
use phototaxis::lab::paper::presets;
use phototaxis::math::Rgb;
use phototaxis::render::{Order, Rendering, Settings, render};
use phototaxis::stats::sidak;

const FALSE_ALARM: f64 = 1e-4;
const RUNS: usize = 12;
const BASE_RUNS: usize = 64;
/// The picture and its blocks.
const VALUES: usize = 17;

/// `overrides`, then the settings of the preset `name`.
fn preset(name: &str, overrides: &[&'static str]) -> Loaded {
    let preset = presets().iter().find(|p| p.name == name).unwrap();
    let all: Vec<&str> = preset.overrides().chain(overrides.iter().copied()).collect();
    own(preset.view.scene, &all)
}

fn bits(pixels: &[Rgb]) -> Vec<[u32; 3]> {
    pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect()
}

#[test]
fn without_a_guide_the_order_changes_no_sample() {
    let loaded = own("wall", &["film.width=75", "film.height=40", "render.spp=42", "guiding.method=none"]);
    let mut settings = loaded.settings.clone();
    settings.render.combine = Combine::All;
    let progressive = loaded.render(&settings);
    settings.render.order = Order::Blocks;
    let blocks = loaded.render(&settings);
    assert_eq!((blocks.samples, blocks.estimate.samples, blocks.iterations.len()), (42, 42, 1));
    let paths = |r: &Rendering| r.iterations.iter().map(|i| i.counters.paths).sum::<u64>();
    assert_eq!((paths(&blocks), paths(&progressive)), (75 * 40 * 42, 75 * 40 * 42));
    for (a, b) in blocks.estimate.mean.iter().zip(&progressive.estimate.mean) {
        // sums of 42 numbers, by iterations and in one row
        assert!((*a - *b).abs().max_element() <= 1e-5 * b.max_element(), "{a} {b}");
    }
    // depths are means of the first samples, a few more or fewer
    let depth = |r: &Rendering| r.estimate.features.iter().map(|f| f.depth).sum::<f32>();
    assert!((depth(&blocks) / depth(&progressive) - 1.0).abs() < 1e-3, "{} {}", depth(&blocks), depth(&progressive));
}

#[test]
fn an_online_guide_in_blocks_depends_on_no_number_of_threads() {
    for name in ["fig2c", "fig2a"] {
        let loaded = preset(name, &["film.width=75", "film.height=40", "render.spp=22", "guiding.resolution=8"]);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let rendering = pool.install(|| loaded.render(&loaded.settings));
            let hits: u64 = rendering.iterations.iter().map(|i| i.counters.guide_hits).sum();
            let guide = rendering.guide.as_ref().map(|g| (g.states(), g.bytes()));
            (bits(&rendering.estimate.mean), bits(&rendering.estimate.variance), guide, hits)
        };
        let one = with(1);
        assert!(one.3 > 0, "{name}: the guide is used while it learns");
        for threads in [2, 3] {
            assert!(one == with(threads), "{name}: {threads} threads differ from one");
        }
    }
}

#[test]
fn blocks_that_were_not_rendered_are_black_and_say_so() {
    let loaded = own("cornell", &["film.width=128", "film.height=128", "render.spp=64", "guiding.method=none"]);
    let mut settings = loaded.settings.clone();
    (settings.render.order, settings.render.combine) = (Order::Blocks, Combine::Last);
    let full = loaded.render(&settings);
    let blank = |r: &Rendering, i: usize| r.estimate.count(i) == 0;
    assert!((0..128 * 128).all(|i| !blank(&full, i)));
    let stopped = render(&loaded.scene, &settings, &mut |_| false);
    let blanks = (0..128 * 128).filter(|&i| blank(&stopped, i)).count();
    assert!(blanks > 0 && blanks < 128 * 128 && blanks % 1024 == 0, "{blanks} pixels of whole blocks");
    for i in 0..128 * 128 {
        let expected = if blank(&stopped, i) { Rgb::ZERO } else { full.estimate.mean[i] };
        assert_eq!(stopped.estimate.mean[i], expected, "pixel {i}");
    }
    assert!(stopped.samples > 0 && stopped.samples < 64, "{}", stopped.samples);
}

#[test]
fn combinations_that_mean_nothing_are_refused() {
    let load = |overrides: &[&str]| {
        let overrides: Vec<String> = ["render.order=blocks"].iter().chain(overrides).map(ToString::to_string).collect();
        format::load(&crate::common::own_path("wall"), &overrides).map(|_| ()).map_err(|e| e.to_string())
    };
    let grid = ["guiding.method=grid", "guiding.table=sphere", "guiding.updates=online", "integrator.roulette=none"];
    assert_eq!(load(&grid), Ok(()));
    assert_eq!(load(&["guiding.method=none", "integrator.roulette=guided"]), Ok(()));
    let cases = [
        ("render.time=3", "no time"),
        ("guiding.updates=frozen", "online"),
        ("guiding.method=adaptive", "\"grid\""),
        ("guiding.method=voronoi", "\"grid\""),
        ("guiding.table=tree", "strata"),
        ("integrator.roulette=guided", "earlier iteration"),
    ];
    for (change, word) in cases {
        let error = load(&[&grid[..], &[change]].concat()).expect_err(change);
        assert!(error.contains(word) && error.contains("render.order") && error.contains("wall"), "{change}: {error}");
    }
}

/// A way of rendering, as a change of settings.
type Way = (&'static str, fn(&mut Settings));

/// The smallest p-value of all values of two sets of runs.
fn smallest(a: &Runs, b: &Runs) -> f64 {
    (0..VALUES).map(|k| welch(&a.summary(k), &b.summary(k)).1).fold(1.0, f64::min)
}

#[test]
fn learning_online_leaves_the_answer_as_it_is() {
    let loaded = own("wall", &["film.width=64", "film.height=48", "render.spp=24", "render.combine=all"]);
    let plain = loaded.runs(&loaded.unguided(), BASE_RUNS, 1_000_000);
    // States are large, so that few samples fill them; the BSDF's share keeps tails where no runs would show them.
    let base = || {
        let mut settings = loaded.unguided();
        let guiding = &mut settings.guiding;
        *guiding = preset("fig2c", &[]).settings.guiding;
        (guiding.method, guiding.resolution, guiding.strata, guiding.bsdf_fraction) = (GuidingMethod::Grid, 6, 6, 0.4);
        // four rounds or five: after the first, the guide is in use
        settings.render.spp = 48;
        settings
    };
    let ways: [Way; 5] = [
        ("progressive", |_| {}),
        ("blocks", |s| s.render.order = Order::Blocks),
        ("blocks, constant rate", |s| (s.render.order, s.guiding.rate) = (Order::Blocks, Rate::Constant(0.1))),
        ("blocks, sphere", |s| (s.render.order, s.guiding.table) = (Order::Blocks, DirectionTable::Sphere)),
        ("blocks, normals", |s| (s.render.order, s.guiding.normals) = (Order::Blocks, true)),
    ];
    let level = sidak(FALSE_ALARM, VALUES * (ways.len() + 1));
    let mut all = Vec::new();
    for (k, (name, change)) in ways.iter().enumerate() {
        let mut settings = base();
        change(&mut settings);
        let counters = loaded.render(&settings).iterations.last().unwrap().counters.clone();
        assert!(counters.guide_hits * 4 > counters.guide_queries, "{name}: the guide takes part");
        let runs = loaded.runs(&settings, RUNS, 1000 * (k as u64 + 1));
        let p = smallest(&runs, &plain);
        println!("{name:22} {:.5} for {:.5}, smallest p {p:.1e}", runs.summary(0).mean, plain.summary(0).mean);
        assert!(p > level, "{name}: not what plain path tracing gives (p = {p:.1e})");
        all.push(runs);
    }
    let together = Runs::together(all);
    assert!(smallest(&together, &plain) > level, "all together");
    let caught = smallest(&together.scaled(1.05), &plain);
    assert!(caught < level, "a bias of 5 % goes unseen (p = {caught:.1e})");
}
