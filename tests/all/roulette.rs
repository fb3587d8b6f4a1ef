//! How long paths get.

use crate::common::{Loaded, own};
use phototaxis::guiding::settings::{GuidingMethod, LearningRule};
use phototaxis::integrator::Roulette;
use phototaxis::render::Settings;

/// Segments of a path in the last iteration.
fn segments(loaded: &Loaded, change: impl Fn(&mut Settings)) -> f64 {
    let mut settings = loaded.settings.clone();
    change(&mut settings);
    let rendering = loaded.render(&settings);
    let counters = &rendering.iterations.last().expect("there are iterations").counters;
    counters.rays as f64 / counters.paths as f64
}

#[test]
fn gloss_of_which_a_guide_knows_nothing_ends_paths_by_its_albedo() {
    let metal = r#"={ type = "conductor", alpha = 0.1, specular_reflectance = 0.4 }"#;
    let metals = ["white", "red", "green"].map(|name| format!("material.{name}{metal}"));
    let more = ["film.width=64", "film.height=64", "render.spp=32", "integrator.rr_depth=1"];
    let all: Vec<&str> = metals.iter().map(String::as_str).chain(more).collect();
    let loaded = own("cornell", &all);
    let unguided = segments(&loaded, |s| s.guiding.method = GuidingMethod::None);
    let guided = segments(&loaded, |s| {
        (s.guiding.method, s.integrator.roulette) = (GuidingMethod::Adaptive, Roulette::Guided);
    });
    println!("{unguided:.3} segments without a guide, {guided:.3} with one");
    // 70 000 paths, of which the numbers of segments vary by less than 1: six standard errors of the difference are 0.03
    assert!((guided - unguided).abs() < 0.03, "{guided} and {unguided}");
}

/// Roulette's moments are of the same targets whatever the guide learns, so that a comparison of rules is none of splitting. With moments
/// of what each rule learns, paths are 2.4 (`monte-carlo`) and 1.9 times (`blend`) as long as with `expected-sarsa`, with these 1.2 and
/// 1.0 times. The table of `q-learning` expects too much light by itself, and splits by that.
#[test]
fn a_learning_rule_is_not_a_rule_of_splitting() {
    let loaded = own("door", &["film.width=64", "film.height=36", "render.spp=127", "guiding.method=adaptive"]);
    let of = |rule| segments(&loaded, |s| (s.guiding.rule, s.integrator.roulette) = (rule, Roulette::Guided));
    let usual = of(LearningRule::ExpectedSarsa);
    for rule in [LearningRule::MonteCarlo, LearningRule::Blend] {
        let segments = of(rule);
        println!("{rule:?}: {segments:.2} segments, {usual:.2} by means");
        assert!((0.7..1.4).contains(&(segments / usual)), "{rule:?}: {segments} and {usual}");
    }
}
