//! The same scene, seed and budget give the same picture bit for bit, and the same guide, with any number of threads, by
//! one build of the program and at one instruction set of Embree's.

use crate::common::{Loaded, build_with, describe, load_written, own, own_path};
use phototaxis::embree::Isa;
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Updates};
use phototaxis::integrator::Roulette;
use phototaxis::math::Rgb;
use phototaxis::render::{Rendering, Settings};

/// Six tiles (their sides are 32 pixels), four iterations.
const SIZE: [&str; 3] = ["film.width=72", "film.height=40", "render.spp=22"];

/// All that a render leaves behind, as bits.
#[derive(PartialEq)]
struct Trace {
    mean: Vec<[u32; 3]>,
    variance: Vec<[u32; 3]>,
    /// States and bytes of the guide, and its answers at the states that iterations could draw from.
    guide: Option<(usize, usize)>,
    usable_states: Vec<usize>,
    guide_hits: u64,
    transitions: u64,
}

fn trace(rendering: &Rendering) -> Trace {
    let bits = |pixels: &[Rgb]| pixels.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
    let sum = |count: fn(&phototaxis::integrator::Counters) -> u64| {
        rendering.iterations.iter().map(|i| count(&i.counters)).sum()
    };
    Trace {
        mean: bits(&rendering.estimate.mean),
        variance: bits(&rendering.estimate.variance),
        guide: rendering.guide.as_ref().map(|g| (g.states(), g.bytes())),
        usable_states: rendering.iterations.iter().map(|i| i.usable_states).collect(),
        guide_hits: sum(|c| c.guide_hits),
        transitions: sum(|c| c.transitions),
    }
}

fn with_threads(threads: usize, loaded: &Loaded, settings: &Settings) -> Trace {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    trace(&pool.install(|| loaded.render(settings)))
}

/// A way of rendering, as a change of the defaults.
type Way = (&'static str, fn(&mut Settings));

const WAYS: [Way; 7] = [
    ("auto", |_| {}),
    ("unguided", |s| s.guiding.method = GuidingMethod::None),
    ("adaptive, guided roulette", |s| {
        // few visits are enough, so that cells are cut in a short render
        (s.guiding.method, s.guiding.refine_visits) = (GuidingMethod::Adaptive, 200.0);
        s.integrator.roulette = Roulette::Guided;
    }),
    ("grid of hemispheres, online", |s| {
        (s.guiding.method, s.guiding.table) = (GuidingMethod::Grid, DirectionTable::Hemisphere);
        s.guiding.updates = Updates::Online;
    }),
    ("SD-tree", |s| (s.guiding.method, s.guiding.leaf_samples) = (GuidingMethod::SdTree, 1000.0)),
    ("Voronoi", |s| s.guiding.method = GuidingMethod::Voronoi),
    ("little memory", |s| {
        s.guiding.method = GuidingMethod::Adaptive;
        (s.guiding.refine_visits, s.guiding.memory, s.guiding.learned_fraction) = (50.0, 2_000_000, Some(true));
    }),
];

/// A scene of ours, with the guide's defaults.
fn defaults(scene: &str) -> Loaded {
    let mut loaded = own(scene, &SIZE);
    loaded.settings.guiding = GuidingSettings::default();
    loaded
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for scene in ["wall", "door"] {
        let loaded = defaults(scene);
        for (name, change) in WAYS {
            let mut settings = loaded.settings.clone();
            change(&mut settings);
            let one = with_threads(1, &loaded, &settings);
            // so short a render is not worth a guide to `auto`; its trials are tested where they are judged
            let guided = !matches!(settings.guiding.method, GuidingMethod::None | GuidingMethod::Auto);
            assert_eq!(one.guide_hits > 0 && one.transitions > 0, guided, "the guide takes part where asked");
            for threads in [2, 3] {
                let more = with_threads(threads, &loaded, &settings);
                assert!(one == more, "{scene}, {name}: {threads} threads differ from one");
            }
            let (hits, usable) = (one.guide_hits, &one.usable_states);
            println!("{scene}, {name}: 1, 2 and 3 threads agree ({hits} draws from a guide of {usable:?} states)");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits_at_every_instruction_set() {
    for isa in Isa::available() {
        let mut loaded = build_with(isa, &describe(&own_path("wall"), &SIZE));
        loaded.settings.guiding = GuidingSettings::default();
        for (name, change) in &WAYS[1..3] {
            let mut settings = loaded.settings.clone();
            change(&mut settings);
            let one = with_threads(1, &loaded, &settings);
            assert!(one == with_threads(3, &loaded, &settings), "{}, {name}: 3 threads differ from one", isa.name());
            assert!(one.mean.iter().flatten().any(|bits| *bits != 0), "{}, {name}: all is black", isa.name());
        }
    }
}

/// What a surface of two materials is at a vertex is decided by the path's own numbers.
#[test]
fn any_number_of_threads_gives_the_same_bits_where_materials_are_mixed() {
    let mesh = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\nusemtl a\nf 4 3 2 1\nf 5 6 7 8\n";
    let text = "[camera]\norigin = [0, 1, 4]\ntarget = [0, 0.5, 0]\n[[mesh]]\npath = 'm.obj'\n[[light]]\ntype = 'constant'\nradiance = 1\n\
        [material.a]\ntype = 'blend'\nmaterials = ['b', 'c']\nweight = 0.4\n[material.b]\ntype = 'diffuse'\n[material.c]\ntype = 'conductor'\nalpha = 0.2\n";
    let mut loaded = load_written(&[("scene.toml", text), ("m.obj", mesh)], &SIZE);
    loaded.settings.guiding = GuidingSettings::default();
    for (name, change) in &WAYS[1..4] {
        let mut settings = loaded.settings.clone();
        change(&mut settings);
        let one = with_threads(1, &loaded, &settings);
        assert!(one.mean.iter().flatten().any(|bits| *bits != 0), "{name}: all is black");
        assert!(one == with_threads(3, &loaded, &settings), "{name}: 3 threads differ from one");
    }
}

#[test]
fn the_seed_alone_decides() {
    let loaded = defaults("wall");
    let mut settings = loaded.settings.clone();
    settings.integrator.roulette = Roulette::Guided;
    let first = trace(&loaded.render(&settings));
    assert!(first == trace(&loaded.render(&settings)), "the same seed twice");
    settings.render.seed += 1;
    let other = trace(&loaded.render(&settings));
    let equal = first.mean.iter().zip(&other.mean).filter(|(a, b)| a == b).count();
    println!("another seed: {equal} of {} pixels equal", first.mean.len());
    // only what sees nothing but the lamp, or nothing at all, may be equal
    assert!(equal < first.mean.len() / 100);
}

#[test]
fn a_longer_render_begins_like_a_shorter_one() {
    // what is learnt in an iteration does not depend on how many will follow
    let loaded = defaults("wall");
    let states = |spp: u32| -> Vec<usize> {
        let mut settings = loaded.settings.clone();
        settings.guiding.method = GuidingMethod::Adaptive;
        settings.render.spp = spp;
        loaded.render(&settings).iterations.iter().map(|i| i.usable_states).collect()
    };
    let (short, long) = (states(11), states(22));
    println!("usable states: {short:?} of a short render, {long:?} of a long one");
    assert!(short.len() < long.len() && short[..] == long[..short.len()]);
}
