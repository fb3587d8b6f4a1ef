//! Scaling all emission scales the picture and changes nothing else: no decision goes by an absolute radiance.

use crate::common::{Loaded, build, describe, mean_color, own_path, scale_emission};
use phototaxis::bsdf::{BsdfDescription, DiffuseParameters};
use phototaxis::film::Combine;
use phototaxis::film::accumulate::Estimate;
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Updates};
use phototaxis::integrator::Roulette;
use phototaxis::math::Rgb;
use phototaxis::render::Settings;
use phototaxis::scene::description::MaterialDescription;
use phototaxis::texture::ColorTexture;

/// Enough samples for six iterations, which the weighting by variance groups in four.
const SMALL: [&str; 3] = ["film.width=32", "film.height=24", "render.spp=46"];

/// A scene of ours, its light scaled.
fn scaled(name: &str, lamp: &str, emission: Rgb, scale: f32) -> Loaded {
    let mut description = describe(&own_path(name), &SMALL);
    let black = BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Constant(Rgb::ZERO) });
    let material = MaterialDescription { bsdf: black, emission, ..MaterialDescription::default() };
    scale_emission(&mut description, scale, &[(lamp, material)]);
    build(&description)
}

fn picture(loaded: &Loaded, seed: u64, change: fn(&mut Settings)) -> Estimate {
    let mut settings = loaded.settings.clone();
    (settings.guiding, settings.render.combine) = (GuidingSettings::default(), Combine::All);
    settings.render.seed = seed;
    change(&mut settings);
    loaded.estimate(&settings)
}

const SCENES: [(&str, &str, Rgb); 3] = [
    ("cornell", "light", Rgb::new(32.0, 25.0, 16.0)),
    ("wall", "lamp", Rgb::new(28.0, 26.0, 22.5)),
    ("door", "lamp", Rgb::new(900.0, 810.0, 670.0)),
];

/// A way of rendering, as a change of the defaults; and whether the picture's parts are weighed by their variance.
type Way = (&'static str, bool, fn(&mut Settings));

const WAYS: [Way; 9] = [
    ("auto, by variance", true, |s| s.render.combine = Combine::InverseVariance),
    ("unguided", false, |s| s.guiding.method = GuidingMethod::None),
    ("adaptive", false, |s| (s.guiding.method, s.guiding.refine_visits) = (GuidingMethod::Adaptive, 200.0)),
    ("adaptive, guided roulette", false, |s| {
        (s.guiding.method, s.guiding.refine_visits) = (GuidingMethod::Adaptive, 200.0);
        s.integrator.roulette = Roulette::Guided;
    }),
    ("grid of hemispheres, online", false, |s| {
        (s.guiding.method, s.guiding.table) = (GuidingMethod::Grid, DirectionTable::Hemisphere);
        s.guiding.updates = Updates::Online;
    }),
    ("grid, learnt fraction, by variance", true, |s| {
        (s.guiding.method, s.guiding.learned_fraction) = (GuidingMethod::Grid, Some(true));
        (s.render.combine, s.integrator.roulette) = (Combine::InverseVariance, Roulette::None);
    }),
    ("grid of spheres, last", false, |s| {
        (s.guiding.method, s.guiding.table) = (GuidingMethod::Grid, DirectionTable::Sphere);
        (s.guiding.mis_compensation, s.render.combine) = (true, Combine::Last);
    }),
    ("SD-tree", false, |s| {
        (s.guiding.method, s.guiding.leaf_samples) = (GuidingMethod::SdTree, 1000.0);
        s.integrator.roulette = Roulette::Throughput;
    }),
    ("Voronoi", false, |s| s.guiding.method = GuidingMethod::Voronoi),
];

/// The scene's picture, and that under light scaled by each factor, all ways.
fn with_each(factors: &[f32], mut check: impl FnMut(&str, bool, f32, &Estimate, &Estimate)) {
    for (name, lamp, emission) in SCENES {
        let pictures = |scale: f32| {
            let loaded = scaled(name, lamp, emission, scale);
            WAYS.map(|(.., change)| picture(&loaded, 0, change))
        };
        let one = pictures(1.0);
        assert!(one.iter().all(|picture| picture.mean.iter().any(|p| *p != Rgb::ZERO)));
        for factor in factors {
            for ((a, b), (way, weighed, _)) in one.iter().zip(&pictures(*factor)).zip(WAYS) {
                check(&format!("{name} × {factor:e}, {way}"), weighed, *factor, a, b);
            }
        }
    }
}

#[test]
fn a_power_of_two_scales_every_bit() {
    with_each(&[2.0f32.powi(-20), 2.0f32.powi(20)], |what, _, factor, a, b| {
        let equal = |a: &[Rgb], b: &[Rgb], k: f32| a.iter().zip(b).filter(|(a, b)| **a * k == **b).count();
        let (means, variances) = (equal(&a.mean, &b.mean, factor), equal(&a.variance, &b.variance, factor * factor));
        println!("{what}: {means} means and {variances} variances of {} are equal", a.mean.len());
        assert_eq!((means, variances), (a.mean.len(), a.mean.len()), "{what}");
    });
}

/// Rounding may turn a rare decision (which stratum, which lamp), after which a path is another one. Everything else
/// is the same to rounding, but for weights that iterations get by their variance: every path has a say in those.
///
/// A path that is turned early teaches a state something else, and then all later draws from that state have other
/// densities. A guide that learns on-line is turned by any such path. But no absolute number in the program would come and go with the
/// seed: what differs with some seeds must not with another.
#[test]
fn any_factor_scales_the_picture_to_rounding() {
    const SEEDS: u64 = 4;
    for (name, lamp, emission) in SCENES {
        let one = scaled(name, lamp, emission, 1.0);
        for factor in [1e-6, 1e6] {
            let other = scaled(name, lamp, emission, factor);
            for way in WAYS {
                let same =
                    |seed| is_scaled(&format!("{name} × {factor:e}, seed {seed}"), &one, &other, factor, way, seed);
                assert!((0..SEEDS).any(same), "{name} × {factor:e}, {}: other pictures with every seed", way.0);
            }
        }
    }
}

/// Whether the pictures are the same to rounding, but for turned paths.
fn is_scaled(what: &str, one: &Loaded, other: &Loaded, factor: f32, way: Way, seed: u64) -> bool {
    let (way, weighed, change) = way;
    let (a, b) = (picture(one, seed, change), picture(other, seed, change));
    let tolerance = if weighed { 1e-2 } else { 1e-4 };
    // what roulette expects is added and taken away, so that a pixel may be near 0 by parts that are not, or below
    let least = 0.1 * mean_color(&a.mean)[1] as f32;
    let off =
        |(a, b): &(&Rgb, &Rgb)| (**b / factor - **a).abs().max_element() > tolerance * a.abs().max_element().max(least);
    let turned = a.mean.iter().zip(&b.mean).filter(off).count();
    let difference = mean_color(&b.mean)[1] / factor as f64 / mean_color(&a.mean)[1] - 1.0;
    println!("{what}, {way}: {turned} of {} pixels differ, means by {difference:.1e}", a.mean.len());
    turned * 50 < a.mean.len() && difference.abs() < 1e-3
}

/// The tests above would not see a factor that acts on one lamp only.
#[test]
fn a_lamp_left_behind_is_noticed() {
    let (name, lamp, emission) = SCENES[0];
    let (one, other) =
        (scaled(name, lamp, emission, 1.0), scaled(name, lamp, emission * Rgb::new(1.0, 1.0, 1.001), 4.0));
    let (a, b) = (picture(&one, 0, WAYS[3].2), picture(&other, 0, WAYS[3].2));
    let equal = a.mean.iter().zip(&b.mean).filter(|(a, b)| **a * 4.0 == **b).count();
    println!("one channel of the lamp off by a thousandth: {equal} of {} pixels equal", a.mean.len());
    assert!(equal * 2 < a.mean.len());
}
