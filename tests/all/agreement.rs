//! A guide may change the noise, never the answer: whatever the settings, the picture's expectation is that of plain
//! path tracing.
//!
//! Every way of rendering is run again and again with seeds of its own; the runs' spread gives error bars that assume
//! nothing of how pixels, iterations and the guide hang together. The luminance of the picture and of its 4 × 4 blocks
//! is compared with unguided runs by Welch's t, safeguarded against rare bright paths. All comparisons of all scenes
//! together raise a false alarm with probability 10⁻⁴ (Šidák). "The same again" is a row in which nothing differs but
//! the seeds. All guided runs together are compared as well; a bias planted in them must be found.

use crate::common::hall::hall;
use crate::common::masked_lamp::masked_lamp;
use crate::common::still_life::{self, still_life};
use crate::common::{Loaded, Runs, build, build_with, describe, own, own_path, welch};
use crate::large::had_enough;
use phototaxis::embree::Isa;
use phototaxis::film::Combine;
use phototaxis::guiding::settings::{
    DirectionTable, GuideSampling, GuidingMethod, LearningRule, Placement, Rate, Updates,
};
use phototaxis::integrator::{LightSampler, Roulette};
use phototaxis::render::Settings;
use phototaxis::stats::sidak;

const FALSE_ALARM: f64 = 1e-4;
const RUNS: usize = 20;
const BASE_RUNS: usize = 192;
const SCENES: usize = 6;

/// A way of rendering, as a change of the unguided settings.
type Way = (&'static str, fn(&mut Settings));

const UNGUIDED: [Way; 5] = [
    ("unguided, the same again", |_| {}),
    ("unguided, BSDF sampling only", bsdf_sampling_only),
    ("unguided, next-event estimation only", |s| s.integrator.mis = false),
    ("unguided, lights by power", |s| s.integrator.light_sampler = LightSampler::Power),
    ("unguided, no roulette", |s| s.integrator.roulette = Roulette::None),
];

/// Chance must find the lamps: that takes more samples.
fn bsdf_sampling_only(s: &mut Settings) {
    (s.integrator.next_event, s.render.spp) = (false, 64);
}

/// Of a grid of trees unless said otherwise.
const GUIDED: [Way; 55] = [
    ("grid, tree", |_| {}),
    ("grid, hemisphere", hemisphere),
    ("grid, sphere", sphere),
    ("adaptive, tree", adaptive),
    // so few paths that it takes no guide; what it gives with one is tested below
    ("auto", |s| {
        adaptive(s);
        (s.guiding.method, s.integrator.roulette) = (GuidingMethod::Auto, Roulette::Guided);
        (s.render.combine, s.render.spp) = (Combine::InverseVariance, 32);
    }),
    ("adaptive, hemisphere", |s| {
        adaptive(s);
        hemisphere(s);
    }),
    ("adaptive, sphere", |s| {
        adaptive(s);
        sphere(s);
    }),
    ("q-learning", |s| s.guiding.rule = LearningRule::QLearning),
    ("monte-carlo", |s| s.guiding.rule = LearningRule::MonteCarlo),
    ("blend", |s| (s.guiding.rule, s.guiding.blend_visits) = (LearningRule::Blend, 50.0)),
    ("vanishing", |s| s.guiding.rate = Rate::Vanishing),
    ("constant", |s| s.guiding.rate = Rate::Constant(0.1)),
    ("forgetting all", |s| s.guiding.rate = Rate::Forgetting(0.0)),
    ("roulette guided, never split", |s| guided_roulette(s, 1.0)),
    ("roulette guided, into 4", |s| guided_roulette(s, 4.0)),
    ("roulette guided, into 8", |s| guided_roulette(s, 8.0)),
    ("roulette guided, adaptive, monte-carlo", |s| {
        adaptive(s);
        guided_roulette(s, 8.0);
        s.guiding.rule = LearningRule::MonteCarlo;
    }),
    ("roulette guided, hemisphere, online", |s| {
        hemisphere(s);
        guided_roulette(s, 8.0);
        s.guiding.updates = Updates::Online;
    }),
    ("roulette guided, no next event", |s| {
        guided_roulette(s, 8.0);
        bsdf_sampling_only(s);
    }),
    ("roulette none", |s| s.integrator.roulette = Roulette::None),
    ("sampling q", |s| s.guiding.sampling = GuideSampling::Q),
    ("sampling q, hemisphere", |s| {
        hemisphere(s);
        s.guiding.sampling = GuideSampling::Q;
    }),
    ("sampling q, sphere", |s| {
        sphere(s);
        s.guiding.sampling = GuideSampling::Q;
    }),
    ("compensation", |s| s.guiding.mis_compensation = true),
    ("learnt fraction", |s| s.guiding.learned_fraction = Some(true)),
    ("learnt fraction, compensation", |s| {
        (s.guiding.learned_fraction, s.guiding.mis_compensation) = (Some(true), true)
    }),
    ("smoothing", |s| (hemisphere(s), s.guiding.smoothing = 0.5).0),
    ("no jitter", |s| s.guiding.jitter = false),
    ("no jitter, adaptive", |s| {
        adaptive(s);
        s.guiding.jitter = false;
    }),
    ("online", |s| s.guiding.updates = Updates::Online),
    ("online, adaptive", |s| {
        adaptive(s);
        s.guiding.updates = Updates::Online;
    }),
    ("no normals", |s| s.guiding.normals = false),
    ("1 stratum", |s| {
        hemisphere(s);
        s.guiding.strata = 1;
    }),
    ("1 cell", |s| s.guiding.resolution = 1),
    // small states take more samples to fill
    ("32 cells", |s| (s.guiding.resolution, s.guiding.rate, s.render.spp) = (32, Rate::Vanishing, 96)),
    ("trees cut to the last cell", |s| (s.guiding.split_share, s.guiding.split_visits) = (0.0, 0.0)),
    ("bsdf_fraction 0.05", |s| s.guiding.bsdf_fraction = 0.05),
    ("bsdf_fraction 1", |s| s.guiding.bsdf_fraction = 1.0),
    ("combine last", |s| s.render.combine = Combine::Last),
    // from 15 samples on the weighting has two groups of iterations to weigh
    ("combine inverse-variance", |s| (s.render.combine, s.render.spp) = (Combine::InverseVariance, 32)),
    ("no next event", bsdf_sampling_only),
    ("no MIS", |s| s.integrator.mis = false),
    ("little memory", |s| s.guiding.memory = 400_000),
    ("product", |s| s.guiding.sampling = GuideSampling::Product),
    ("glossy product", |s| s.guiding.sampling = GuideSampling::GlossyProduct),
    ("glossy product, adaptive", |s| {
        adaptive(s);
        s.guiding.sampling = GuideSampling::GlossyProduct;
    }),
    ("SD-tree", |s| sd_tree(s)),
    ("SD-tree, one leaf", |s| (sd_tree(s), s.guiding.leaf_samples = 1e9).0),
    ("SD-tree, no filters", |s| (sd_tree(s), (s.guiding.jitter, s.guiding.directional_filter) = (false, false)).0),
    ("SD-tree, fixed fraction", |s| (sd_tree(s), s.guiding.learned_fraction = Some(false)).0),
    ("Voronoi", |s| (s.guiding.method, s.guiding.sites) = (GuidingMethod::Voronoi, 200)),
    ("Voronoi, by area", |s| voronoi_by_area(s)),
    ("Voronoi, hemisphere", |s| (voronoi_by_area(s), s.guiding.table = DirectionTable::Hemisphere).0),
    ("Voronoi, sphere", |s| (voronoi_by_area(s), s.guiding.table = DirectionTable::Sphere).0),
    ("SD-tree, guided roulette", |s| (sd_tree(s), s.integrator.roulette = Roulette::Guided, s.render.spp = 32).0),
];

fn hemisphere(s: &mut Settings) {
    (s.guiding.table, s.guiding.strata) = (DirectionTable::Hemisphere, 4);
}

fn sphere(s: &mut Settings) {
    (s.guiding.table, s.guiding.strata) = (DirectionTable::Sphere, 4);
}

/// Cells that are cut after as few visits as a short render makes.
fn adaptive(s: &mut Settings) {
    (s.guiding.method, s.guiding.resolution, s.guiding.refine_visits) = (GuidingMethod::Adaptive, 4, 30.0);
}

fn guided_roulette(s: &mut Settings, max_split: f32) {
    (s.integrator.roulette, s.integrator.max_split) = (Roulette::Guided, max_split);
}

fn voronoi_by_area(s: &mut Settings) {
    (s.guiding.method, s.guiding.sites, s.guiding.placement) = (GuidingMethod::Voronoi, 200, Placement::Area);
}

/// Small leaves, so that a few samples divide the scene.
fn sd_tree(s: &mut Settings) {
    (s.guiding.method, s.guiding.leaf_samples) = (GuidingMethod::SdTree, 500.0);
}

/// With coated surfaces: each kind of state and of table, and what goes by the shares of their lobes.
const COATED: [Way; 12] = [
    ("grid, tree", |_| {}),
    ("grid, hemisphere", hemisphere),
    ("grid, sphere", sphere),
    ("adaptive, roulette guided, into 8", |s| {
        adaptive(s);
        guided_roulette(s, 8.0);
    }),
    ("monte-carlo", |s| s.guiding.rule = LearningRule::MonteCarlo),
    ("blend", |s| (s.guiding.rule, s.guiding.blend_visits) = (LearningRule::Blend, 50.0)),
    ("learnt fraction, online", |s| {
        (s.guiding.learned_fraction, s.guiding.updates) = (Some(true), Updates::Online);
    }),
    ("bsdf_fraction 0.05", |s| s.guiding.bsdf_fraction = 0.05),
    ("no next event", bsdf_sampling_only),
    ("product, roulette guided", |s| {
        guided_roulette(s, 8.0);
        s.guiding.sampling = GuideSampling::Product;
    }),
    ("SD-tree, roulette guided", |s| (sd_tree(s), guided_roulette(s, 8.0), s.render.spp = 32).1),
    ("Voronoi", |s| (s.guiding.method, s.guiding.sites) = (GuidingMethod::Voronoi, 200)),
];

/// The settings that all ways start from: states are large, so that a few samples fill them.
fn base(loaded: &Loaded) -> Settings {
    let mut settings = loaded.unguided();
    settings.render.spp = 16;
    settings.render.combine = Combine::All;
    settings.guiding.resolution = 8;
    settings
}

/// Values compared in one row: the picture and its blocks.
const VALUES: usize = 17;
const ROWS: usize = UNGUIDED.len() + GUIDED.len() + 1;

fn level() -> f64 {
    sidak(FALSE_ALARM, SCENES * ROWS * VALUES)
}

/// One row of the table: the smallest p-value and the root mean square of t over all values.
struct Row {
    smallest: f64,
    rms: f64,
    t_of_mean: f64,
}

impl Row {
    fn new(a: &Runs, b: &Runs) -> Row {
        let tests: Vec<(f64, f64)> = (0..VALUES).map(|k| welch(&a.summary(k), &b.summary(k))).collect();
        let squares: f64 = tests.iter().map(|(t, _)| t * t).sum();
        Row {
            smallest: tests.iter().map(|(_, p)| *p).fold(1.0, f64::min),
            rms: (squares / VALUES as f64).sqrt(),
            t_of_mean: tests[0].0,
        }
    }
}

/// Holds every way against plain path tracing. `planted` is a bias that the guided runs, taken together, would show.
fn agree(scene: &str, loaded: &Loaded, planted: f64) {
    agree_by(&GUIDED, scene, loaded, planted);
}

/// The same of some guided ways.
fn agree_by(guided_ways: &[Way], scene: &str, loaded: &Loaded, planted: f64) {
    let plain = loaded.runs(&base(loaded), BASE_RUNS, 1_000_000);
    let mean = plain.summary(0);
    println!("{scene}: unguided luminance {:.5} ± {:.5}", mean.mean, mean.std_error());
    let mut failures = Vec::new();
    let mut report = |name: &str, runs: &Runs| {
        let (row, mean) = (Row::new(runs, &plain), runs.summary(0));
        println!(
            "{scene}: {name:38} {:.5} ± {:.5}  t {:+.2}  rms t {:.2}  smallest p {:.1e}",
            mean.mean,
            mean.std_error(),
            row.t_of_mean,
            row.rms,
            row.smallest
        );
        if row.smallest < level() {
            failures.push(format!("{name} (p = {:.1e})", row.smallest));
        }
    };
    let mut guided = Vec::new();
    for (k, (name, change)) in UNGUIDED.iter().chain(guided_ways).enumerate() {
        let mut settings = base(loaded);
        if k >= UNGUIDED.len() {
            settings.guiding.method = GuidingMethod::Grid;
            change(&mut settings);
            // which is for `auto` to decide
            if settings.guiding.method != GuidingMethod::Auto {
                check_that_the_guide_takes_part(name, loaded, &settings);
            }
        } else {
            change(&mut settings);
        }
        let runs = loaded.runs(&settings, RUNS, 1000 * k as u64);
        report(name, &runs);
        if k >= UNGUIDED.len() {
            guided.push(runs);
        }
    }
    let together = Runs::together(guided);
    report("all guided runs together", &together);
    assert!(failures.is_empty(), "{scene}: not what plain path tracing gives: {}", failures.join(", "));
    let caught = Row::new(&together.scaled(1.0 + planted), &plain).smallest;
    println!("{scene}: a planted bias of {planted} has p = {caught:.1e} (threshold {:.1e})", level());
    assert!(caught < level(), "{scene}: a bias of {planted} goes unseen");
}

/// Without this the test could pass for want of a guide.
fn check_that_the_guide_takes_part(name: &str, loaded: &Loaded, settings: &Settings) {
    let rendering = loaded.render(settings);
    let counters = &rendering.iterations.last().expect("there are iterations").counters;
    let share = counters.guide_hits as f64 / counters.guide_queries as f64;
    assert!(share > 0.05, "{name}: the guide knew an answer at {share:.2} of the vertices only");
    let drawn = counters.guided_directions as f64 / counters.directions as f64;
    let draws = settings.guiding.bsdf_fraction < 1.0 || settings.guiding.learns_fraction();
    assert!(drawn > 0.02 || !draws, "{name}: the guide drew {drawn:.3} of the directions only");
    let mut plain = settings.clone();
    plain.integrator.roulette = Roulette::Throughput;
    let same = loaded.render(&plain).estimate.mean == rendering.estimate.mean;
    assert!(settings.integrator.roulette != Roulette::Guided || !same, "{name}: the roulette goes by the throughput");
}

/// What `auto` gives where it takes the guide. Only then has it samples of both kinds to weigh against each other.
#[test]
fn auto_with_a_guide() {
    let loaded = own("door", &["film.width=32", "film.height=18"]);
    let mut settings = loaded.unguided();
    (settings.render.spp, settings.render.combine) = (1440, Combine::All);
    let plain = loaded.runs(&settings, 16, 1_000_000);
    (settings.guiding.method, settings.integrator.roulette) = (GuidingMethod::Auto, Roulette::Guided);
    settings.render.combine = Combine::InverseVariance;
    let verdict = loaded.render(&settings).verdict.expect("it was judged");
    assert!(verdict.guided && verdict.trial.is_some(), "the guide was not taken: {verdict:?}");
    let auto = loaded.runs(&settings, 8, 0);
    let smallest = |runs: &Runs| Row::new(runs, &plain).smallest;
    let level = sidak(FALSE_ALARM, VALUES);
    let planted = auto.scaled(1.05);
    println!("door: auto with a guide: p = {:.1e}, 5 % more light p = {:.1e}", smallest(&auto), smallest(&planted));
    assert!(smallest(&auto) >= level, "not what plain path tracing gives");
    assert!(smallest(&planted) < level, "a bias of 0.05 goes unseen");
}

/// Guided roulette leaves out shadow rays whose outcome a region knows, in the light and behind a wall, and the picture's expectation
/// stays as it is.
#[test]
fn shadow_rays_that_are_left_out() {
    let level = sidak(FALSE_ALARM, 2 * VALUES);
    for (scene, spp) in [("cornell", 128), ("wall", 512)] {
        let loaded = own(scene, &["film.width=24", "film.height=24"]);
        let mut settings = loaded.unguided();
        (settings.render.spp, settings.render.combine) = (spp, Combine::All);
        let plain = loaded.runs(&settings, 16, 1_000_000);
        (settings.guiding.method, settings.integrator.roulette) = (GuidingMethod::Adaptive, Roulette::Throughput);
        let all = shadow_rays(&loaded, &settings);
        settings.integrator.roulette = Roulette::Guided;
        let some = shadow_rays(&loaded, &settings);
        let guided = loaded.runs(&settings, 8, 0);
        let [p, planted] = [1.0, 1.05].map(|factor| Row::new(&guided.scaled(factor), &plain).smallest);
        println!(
            "{scene}: {some:.3} shadow rays a ray, {all:.3} of all: p = {p:.1e}, 5 % more light p = {planted:.1e}"
        );
        assert!(some < 0.6 * all, "{scene}: hardly any shadow ray is left out");
        assert!(p >= level, "{scene}: not what plain path tracing gives");
        assert!(planted < level, "{scene}: a bias of 0.05 goes unseen");
    }
}

/// Shadow rays for each ray of paths, in the last iteration.
fn shadow_rays(loaded: &Loaded, settings: &Settings) -> f64 {
    let rendering = loaded.render(settings);
    let counters = &rendering.iterations.last().expect("there are iterations").counters;
    counters.shadow_rays as f64 / counters.rays as f64
}

/// Whatever instructions Embree uses, the picture's expectation is the same: unguided and with a guide, also through glass
/// and at glossy surfaces.
#[test]
fn every_instruction_set() {
    let cornell = describe(&own_path("cornell"), &["film.width=28", "film.height=28"]);
    let (_folder, still_life) = still_life::describe(&["film.width=40", "film.height=30"]);
    let level = sidak(FALSE_ALARM, 2 * 2 * Isa::available().count() * VALUES);
    for (scene, description) in [("cornell", cornell), ("still life", still_life)] {
        let own = build(&description);
        let plain = own.runs(&base(&own), BASE_RUNS, 1_000_000);
        for (k, isa) in Isa::available().enumerate() {
            let loaded = build_with(isa, &description);
            for method in [GuidingMethod::None, GuidingMethod::Grid] {
                let what = format!("{scene}, {}, {}", isa.name(), method.name());
                // seeds of its own: the same paths would agree for being the same
                let runs = with_method(&what, &loaded, method, 10_000 * (1 + k) as u64);
                let [p, planted] = [1.0, 1.05].map(|factor| Row::new(&runs.scaled(factor), &plain).smallest);
                println!("{what}: smallest p {p:.1e}, with 5 % more light {planted:.1e}");
                assert!(p >= level, "{what}: not the picture that Embree gives elsewhere");
                assert!(planted < level, "{what}: a bias of 0.05 goes unseen");
            }
        }
    }
}

fn with_method(what: &str, loaded: &Loaded, method: GuidingMethod, first_seed: u64) -> Runs {
    let mut settings = base(loaded);
    settings.guiding.method = method;
    if method != GuidingMethod::None {
        check_that_the_guide_takes_part(what, loaded, &settings);
    }
    loaded.runs(&settings, 3 * RUNS, first_seed)
}

#[test]
fn cornell() {
    agree("cornell", &own("cornell", &["film.width=28", "film.height=28"]), 0.02);
}

#[test]
fn wall() {
    agree("wall", &own("wall", &["film.width=24", "film.height=18"]), 0.02);
}

#[test]
fn door() {
    agree("door", &own("door", &["film.width=32", "film.height=18"]), 0.08);
}

/// A rough coat, a delta lobe and a clear coat over diffuse bases: the guide stands in for a part of each BSDF.
#[test]
fn coats() {
    let set = [
        "film.width=28",
        "film.height=28",
        r#"material.white={ type = "plastic", reflectance = 0.73, alpha = 0.25 }"#,
        r#"material.red={ type = "plastic", reflectance = [0.63, 0.06, 0.05], alpha = 0 }"#,
        r#"material.green={ type = "principled", base_color = [0.14, 0.45, 0.09], roughness = 0.5, clearcoat = 0.8 }"#,
    ];
    agree_by(&COATED, "coated cornell", &own("cornell", &set), 0.02);
}

/// So large that the guide has had enough before the picture's end.
#[test]
fn a_large_picture() {
    let loaded = hall(1, &["film.width=1024", "film.height=512", "integrator.max_depth=4"]);
    let mut settings = loaded.unguided();
    (settings.render.spp, settings.render.combine) = (1, Combine::All);
    let plain = loaded.runs(&settings, 12, 1_000_000);
    adaptive(&mut settings);
    settings.render.spp = 3;
    assert!(had_enough(&loaded.render(&settings)), "the picture is too small");
    let guided = loaded.runs(&settings, 6, 0);
    let smallest = |runs: &Runs| Row::new(runs, &plain).smallest;
    let level = sidak(FALSE_ALARM, VALUES);
    let planted = guided.scaled(1.05);
    println!("hall: guided p = {:.1e}, 5 % more light p = {:.1e}", smallest(&guided), smallest(&planted));
    assert!(smallest(&guided) >= level, "not what plain path tracing gives");
    assert!(smallest(&planted) < level, "a bias of 0.05 goes unseen");
}

#[test]
fn glass_gloss_and_textures() {
    agree("still life", &still_life(&["film.width=40", "film.height=30"]), 0.02);
}

#[test]
fn lamps_that_are_seen_through() {
    agree("masked lamps", &masked_lamp(&[]), 0.02);
}
