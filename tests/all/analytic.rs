//! Scenes whose radiance is known in closed form.

use crate::common::{Loaded, describe, load_written, mean_color, own_path};
use phototaxis::film::Combine;
use phototaxis::film::accumulate::Estimate;
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::integrator::{IntegratorSettings, Roulette};
use phototaxis::math::Rgb;
use phototaxis::render::Settings;
use phototaxis::stats::sidak;
use phototaxis::stats::ztest::{p_value, z_one_mean};
use std::f64::consts::PI;

/// False alarm of all means of the furnace together.
const LEVEL: f64 = 1e-5;

/// Mean of the first channel, and its standard error from the picture's own variances.
fn mean_and_error(picture: &Estimate) -> (f64, f64) {
    let variance: f64 = picture.variance.iter().map(|v| v.x as f64).sum();
    (mean_color(&picture.mean)[0], variance.sqrt() / picture.variance.len() as f64)
}

/// The furnace's sphere with another albedo.
fn furnace(albedo: f32) -> Loaded {
    let material = format!("material.glow={{type=\"diffuse\",reflectance={albedo},emission=1}}");
    let overrides = [material.as_str(), "film.width=16", "film.height=16", "render.spp=24"];
    crate::common::build(&describe(&own_path("furnace"), &overrides))
}

/// Radiance of paths of at most `depth` segments: 1 + a + … + a^(depth − 1).
fn series(a: f64, depth: u32) -> f64 {
    (1.0 - a.powi(depth as i32)) / (1.0 - a)
}

/// Every combination of depth, guide, next-event estimation, MIS and roulette.
fn furnace_settings(base: &Settings) -> Vec<Settings> {
    let mut all = Vec::new();
    for depth in [1, 2, 5, 400] {
        for method in [GuidingMethod::None, GuidingMethod::Grid] {
            for (next_event, mis) in [(true, true), (true, false), (false, true)] {
                for roulette in [Roulette::None, Roulette::Throughput] {
                    let mut s = base.clone();
                    (s.guiding.method, s.guiding.resolution) = (method, 8);
                    s.render.combine = Combine::All;
                    // without roulette, what comes after 80 bounces is below the digits that count
                    let max_depth = if roulette == Roulette::None { depth.min(80) } else { depth };
                    s.integrator = IntegratorSettings {
                        max_depth,
                        next_event,
                        mis,
                        roulette,
                        rr_depth: 2,
                        ..IntegratorSettings::default()
                    };
                    all.push(s);
                }
            }
        }
    }
    all
}

#[test]
fn the_furnace_is_as_bright_as_its_series() {
    let mut tested = Vec::new();
    for albedo in [0.2f32, 0.5, 0.8] {
        let loaded = furnace(albedo);
        for settings in furnace_settings(&loaded.settings) {
            let (mean, error) = mean_and_error(&loaded.estimate(&settings));
            let truth = series(albedo as f64, settings.integrator.max_depth);
            let way = format!("a = {albedo}, {:?}, {:?}", settings.guiding.method, settings.integrator);
            // rounding of a sum of at most 80 terms: where every path brings the same, there is no noise at all
            tested.push((way, mean, error.hypot(3e-6 * truth), truth));
        }
    }
    let level = sidak(LEVEL, tested.len());
    let mut largest = 0.0f64;
    for (way, mean, error, truth) in &tested {
        let z = z_one_mean(*mean, *error, *truth);
        largest = largest.max(z.abs());
        assert!(p_value(z) >= level, "{way}: {mean} ± {error}, not {truth} (z = {z:.1})");
        let planted = z_one_mean(mean * 1.1, *error, *truth);
        assert!(p_value(planted) < level, "{way}: a tenth more goes unseen");
    }
    println!("{} furnaces: the largest |z| is {largest:.2}", tested.len());
}

/// The same with roulette that goes by what the guide knows, and that leaves out shadow rays.
#[test]
fn the_furnace_with_guided_roulette() {
    let mut tested = Vec::new();
    for albedo in [0.2f32, 0.5, 0.8] {
        let loaded = furnace(albedo);
        for method in [GuidingMethod::Grid, GuidingMethod::Adaptive] {
            let mut settings = loaded.settings.clone();
            (settings.guiding.method, settings.integrator.roulette) = (method, Roulette::Guided);
            (settings.integrator.max_depth, settings.render.spp) = (400, 64);
            settings.render.combine = Combine::All;
            let rendering = loaded.render(&settings);
            let counters = &rendering.iterations.last().expect("there are iterations").counters;
            let asked = counters.shadow_rays as f64 / counters.rays as f64;
            let (mean, error) = mean_and_error(&rendering.estimate);
            println!("a = {albedo}, {method:?}: {asked:.3} shadow rays a ray, {mean:.5} ± {error:.5}");
            assert!(asked < 0.6, "every vertex casts a shadow ray");
            tested.push((format!("a = {albedo}, {method:?}"), mean, error, 1.0 / (1.0 - f64::from(albedo))));
        }
    }
    let level = sidak(LEVEL, tested.len());
    for (way, mean, error, truth) in &tested {
        assert!(p_value(z_one_mean(*mean, *error, *truth)) >= level, "{way}: {mean} ± {error}, not {truth}");
        let planted = z_one_mean(mean * 1.05, *error, *truth);
        assert!(p_value(planted) < level, "{way}: 5 % more goes unseen");
    }
}

/// A square of 2 × 2 in the plane y = 0 that faces up, and a camera above its centre that sees a small part of it.
const PLANE: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nusemtl floor\nf 1 2 3 4\n";
const ABOVE: &str = r#"
[camera]
origin = [0, 2, 0.5]
target = [0, 0, 0]
vfov = 1

[film]
width = 8
height = 8

[[mesh]]
path = "plane.obj"

[material.floor]
type = "diffuse"
reflectance = [0.25, 0.5, 0.75]

[render]
spp = 16
"#;

fn plane(more: &str) -> Loaded {
    load_written(&[("scene.toml", &format!("{ABOVE}{more}")), ("plane.obj", PLANE)], &[])
}

fn all_ways(loaded: &Loaded) -> [Estimate; 3] {
    [GuidingMethod::None, GuidingMethod::Grid, GuidingMethod::Adaptive].map(|method| {
        let mut settings = loaded.settings.clone();
        settings.guiding.method = method;
        // weights that are no whole numbers round, and what has no noise is to be seen to the last bit
        settings.render.combine = Combine::All;
        loaded.estimate(&settings)
    })
}

/// Whether every pixel is `truth` to the relative precision `relative`.
fn assert_all(picture: &Estimate, truth: Rgb, relative: f32) {
    for value in &picture.mean {
        assert!((*value - truth).abs().cmple(truth * relative).all(), "{value} is not {truth}");
    }
}

#[test]
fn a_plane_under_a_constant_sky_shows_its_albedo() {
    // directions drawn by the cosine carry no noise: L = ρ/π · ∫ L cosθ dω = ρ
    let loaded = plane("[[light]]\ntype = \"constant\"\nradiance = 1\n");
    let mut settings = loaded.unguided();
    settings.integrator.next_event = false;
    assert_all(&loaded.estimate(&settings), Rgb::new(0.25, 0.5, 0.75), 1e-6);
    for picture in all_ways(&loaded) {
        let (mean, error) = mean_and_error(&picture);
        let z = z_one_mean(mean, error, 0.25);
        println!("a plane of albedo 0.25 under a sky of 1: {mean:.5} ± {error:.5}");
        assert!(p_value(z) >= LEVEL && p_value(z_one_mean(1.1 * mean, error, 0.25)) < LEVEL, "{mean} ± {error}");
    }
}

#[test]
fn a_point_light_follows_the_inverse_square_and_the_cosine() {
    // at (x, h, 0) above the origin: E = I cosθ/d², L = ρE/π
    let (x, h) = (0.75f64, 1.0f64);
    let loaded = plane("[[light]]\ntype = \"point\"\nposition = [0.75, 1, 0]\nintensity = [3, 2, 1]\n");
    let squared = x * x + h * h;
    let per_intensity = (h / squared.sqrt() / squared / PI) as f32;
    let truth = Rgb::new(0.25, 0.5, 0.75) * Rgb::new(3.0, 2.0, 1.0) * per_intensity;
    for picture in all_ways(&loaded) {
        // pixels see ± 0.018 of the plane about the origin, over which E varies by ± 3·x·0.018/d² = 2.6 %
        assert_all(&picture, truth, 0.03);
        let mean = mean_color(&picture.mean)[0];
        println!("point light: {mean:.6}, in closed form {:.6}", truth.x);
        // the linear part cancels over the picture, the next is below 0.018² and the jitter of pixels 0.0005
        assert!((mean / truth.x as f64 - 1.0).abs() < 1.5e-3);
    }
}

#[test]
fn a_directional_light_gives_the_cosine_of_its_irradiance() {
    let loaded = plane("[[light]]\ntype = \"directional\"\ndirection = [0.6, -0.8, 0]\nirradiance = [1, 2, 3]\n");
    let truth = Rgb::new(0.25, 0.5, 0.75) * Rgb::new(1.0, 2.0, 3.0) * (0.8 / PI) as f32;
    for picture in all_ways(&loaded) {
        assert_all(&picture, truth, 1e-6);
    }
}

#[test]
fn an_emitter_that_is_seen_shows_its_radiance_to_the_last_bit() {
    let glowing = ABOVE.replace("reflectance = [0.25, 0.5, 0.75]", "reflectance = 0\nemission = [0.1, 1.7, 300.3]");
    let loaded = load_written(&[("scene.toml", &glowing), ("plane.obj", PLANE)], &[]);
    for picture in all_ways(&loaded) {
        assert!(picture.mean.iter().all(|v| *v == Rgb::new(0.1, 1.7, 300.3)), "{:?}", picture.mean[0]);
    }
    // its back is black, or bright as well where both sides emit
    let below = glowing.replace("origin = [0, 2, 0.5]", "origin = [0, -2, 0.5]");
    let back = load_written(&[("scene.toml", &below), ("plane.obj", PLANE)], &[]);
    assert_all(&back.estimate(&back.settings), Rgb::ZERO, 0.0);
    let twice = load_written(
        &[
            ("scene.toml", &below.replace("emission = [", "emission_two_sided = true\nemission = [")),
            ("plane.obj", PLANE),
        ],
        &[],
    );
    assert_all(&twice.estimate(&twice.settings), Rgb::new(0.1, 1.7, 300.3), 0.0);
}

#[test]
fn a_single_triangle_is_a_scene() {
    let triangle = "v -1 0 -1\nv 0 0 1\nv 1 0 -1\nf 1 2 3\n";
    let floor = "[material.floor]\ntype = \"diffuse\"\nreflectance = [0.25, 0.5, 0.75]\n";
    let scene = ABOVE.replace("vfov = 1\n", "vfov = 40\n").replace(floor, "")
        + "[[light]]\ntype = \"constant\"\nradiance = 2\n";
    let loaded = load_written(&[("scene.toml", &scene), ("plane.obj", triangle)], &[]);
    for picture in all_ways(&loaded) {
        // the triangle, grey of albedo one half, under a sky of radiance 2; beside its lower corner the sky itself
        assert_eq!(picture.mean[7 * 8], Rgb::splat(2.0));
        let centre = picture.mean[4 * 8 + 4];
        println!("one triangle: {centre} in the middle");
        assert!((centre - Rgb::ONE).abs().max_element() < 0.5, "{centre}");
    }
}

#[test]
fn without_light_all_is_black_and_finite() {
    let loaded = plane("[[light]]\ntype = \"constant\"\nradiance = 0\n");
    for picture in all_ways(&loaded) {
        assert!(picture.mean.iter().chain(&picture.variance).all(|v| *v == Rgb::ZERO));
    }
}

#[test]
fn where_no_light_is_described_a_sky_of_radiance_one_stands_in() {
    let folder = crate::common::written(&[("scene.toml", ABOVE), ("plane.obj", PLANE)]);
    let description = describe(&folder.path().join("scene.toml"), &[]);
    let (_, warnings) = description.load_scene(0).unwrap();
    assert!(warnings.iter().any(|w| w.contains("nothing emits light")), "{warnings:?}");
    let loaded = crate::common::build(&description);
    let mut settings = loaded.unguided();
    settings.integrator.next_event = false;
    assert_all(&loaded.estimate(&settings), Rgb::new(0.25, 0.5, 0.75), 1e-6);
}
