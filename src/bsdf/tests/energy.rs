//! White furnaces and reciprocity.

use super::*;
use crate::math::rng::Rng;
use crate::stats::quadrature::{Rect, Refinement, integrate};
use crate::stats::ztest::z_one_mean;
use std::f64::consts::{PI, TAU};

/// ∫ eval dωi of one channel over the sphere, per hemisphere, by quadrature.
fn scattered(bsdf: &Bsdf, wo: Vec3, channel: usize) -> f64 {
    let refinement = Refinement { min_depth: 4, max_depth: 9, absolute: 1e-6, relative: 1e-4 };
    let integrand =
        |theta: f64, phi: f64| (bsdf.eval(wo, polar(theta as f32, phi as f32))[channel] as f64) * theta.sin();
    let half = |x| integrate(&integrand, Rect { x, y: [0.0, TAU] }, refinement);
    half([0.0, 0.5 * PI]) + half([0.5 * PI, PI])
}

/// Mean and standard error of the weights of smooth samples.
fn sampled(bsdf: &Bsdf, wo: Vec3, channel: usize) -> (f64, f64) {
    let (mut rng, n) = (Rng::new(61), 100_000);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..n {
        let sample = bsdf.sample(wo, rng.f32(), rng.f32x2()).filter(|s| !s.delta);
        let w = sample.map_or(0.0, |s| s.weight[channel] as f64);
        (sum, squares) = (sum + w, squares + w * w);
    }
    let mean = sum / n as f64;
    (mean, ((squares / n as f64 - mean * mean) / n as f64).sqrt())
}

#[test]
fn quadrature_and_sampling_find_the_same_albedo() {
    for material in &smooth_materials() {
        for wo in [polar(0.1, 1.0), polar(1.0, 2.0), polar(1.45, 0.0), polar(2.3, 1.0)] {
            let bsdf = material.bsdf();
            let exact = scattered(&bsdf, wo, 1);
            let (mean, error) = sampled(&bsdf, wo, 1);
            // 5.5 standard errors, false alarm 4·10⁻⁸ each; 10⁻⁴ for single precision
            let z = z_one_mean(mean, error.max(1e-4 * exact / 5.5), exact);
            assert!(z.abs() < 5.5, "{} {wo}: {mean} ± {error}, {exact}", material.name);
        }
    }
}

#[test]
fn a_wrong_weight_would_be_noticed() {
    let metal = conductor(Some(COPPER), Ggx, 0.25);
    let (bsdf, wo) = (metal.bsdf(), polar(1.0, 2.0));
    let (mean, error) = sampled(&bsdf, wo, 1);
    assert!(z_one_mean(1.01 * mean, error, scattered(&bsdf, wo, 1)).abs() > 5.5);
}

/// Of a base of albedo R under a coat of albedo E the whole has R(1 − E) + E, whatever the coat's roughness: a white one loses
/// nothing.
#[test]
fn conserving_coats_add_to_their_base() {
    for alpha in [0.05, 0.3, 0.8] {
        for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.4, 2.0)] {
            let of = |reflectance: f32| conserving(Ggx, alpha).colored(Rgb::splat(reflectance), Rgb::ZERO);
            let traced = |material: Material| traced(&material, wo).x;
            let coat = traced(of(0.0));
            for reflectance in [0.1, 0.8, 1.0] {
                let (found, expected) = (traced(of(reflectance)), reflectance * (1.0 - coat) + coat);
                assert!((found - expected).abs() < 0.01, "{alpha} {wo} {reflectance}: {found} and {expected}");
                let said = of(reflectance).bsdf().albedo(wo).x;
                assert!((said - expected).abs() < 0.01, "{alpha} {wo} {reflectance}: {said} and {expected}");
            }
        }
    }
}

/// Mean weight of samples from `wo`, one channel each.
fn traced(material: &Material, wo: Vec3) -> Rgb {
    let bsdf = material.bsdf();
    let (mut rng, n) = (Rng::new(66), 100_000);
    (0..n).filter_map(|_| bsdf.sample(wo, rng.f32(), rng.f32x2())).map(|s| s.weight).sum::<Rgb>() / n as f32
}

/// Whatever its roughness, a conserving metal that reflects everything is white; one of colour F reflects about F, a little less
/// as light of several reflections is F² and darker. Without the option the roughest loses a third.
#[test]
fn conserving_metals_lose_nothing_between_facets() {
    for kind in [Ggx, Beckmann] {
        for alpha in [0.05, 0.3, 0.8] {
            for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.4, 2.0)] {
                let white = traced(&conserving_metal(None, kind, alpha), wo);
                assert!((white - Rgb::ONE).abs().max_element() < 0.01, "{kind:?} {alpha} {wo}: {white}");
            }
        }
    }
    let gold = Rgb::new(0.9, 0.6, 0.1);
    let found = traced(&conserving_metal(None, Ggx, 0.25).colored(gold, Rgb::ZERO), Vec3::Z);
    let losing = traced(&conductor(None, Ggx, 0.25).colored(gold, Rgb::ZERO), Vec3::Z);
    assert!(losing.cmplt(found).all() && found.cmplt(gold).all(), "{losing} {found} {gold}");
    assert!(traced(&conductor(None, Ggx, 1.0), polar(0.8, 1.0)).x < 0.8);
}

/// The principled metal likewise, with constant and with pictured roughness.
#[test]
fn conserving_principled_metals_lose_nothing_between_facets() {
    let metal = |roughness: f32, energy_conserving: bool| {
        let set =
            PrincipledParameters { metallic: 1.0, roughness, energy_conserving, ..PrincipledParameters::default() };
        principled(set).colored(Rgb::ONE, Rgb::ZERO)
    };
    let pictured = |roughness: f32| {
        let set = PrincipledParameters { energy_conserving: true, ..PrincipledParameters::default() };
        pictured(set).colored(Rgb::ONE, Rgb::new(1.0, roughness, 0.5))
    };
    for roughness in [0.3, 0.55, 0.93] {
        for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.3, 2.0)] {
            for material in [metal(roughness, true), pictured(roughness)] {
                let white = traced(&material, wo).x;
                assert!((white - 1.0).abs() < 0.01, "{} {wo}: {white}", material.name);
            }
        }
    }
    assert!(traced(&metal(0.93, false), polar(0.8, 1.0)).x < 0.8);
}

#[test]
fn no_white_material_gains_energy() {
    let white = |m: Material| m.colored(Rgb::ONE, Rgb::ZERO);
    let mut materials = vec![white(diffuse()), white(transmitter())];
    for kind in [Ggx, Beckmann] {
        for alpha in [0.05, 0.3, 0.8] {
            materials.push(conductor(None, kind, alpha));
            materials.push(dielectric(1.5, kind, alpha, false));
            materials.push(white(plastic(kind, alpha, true, Rgb::ONE)));
            materials.push(white(conserving(kind, alpha)));
        }
    }
    for material in &materials {
        for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.4, 2.0), polar(2.4, 0.0)] {
            let bsdf = material.bsdf();
            // radiance scaled by refraction is energy again when divided by that scale
            let (mut rng, mut sum) = (Rng::new(62), 0.0);
            let n = 40_000;
            for s in (0..n).filter_map(|_| bsdf.sample(wo, rng.f32(), rng.f32x2())) {
                sum += s.weight.max_element() * s.eta * s.eta;
            }
            assert!(sum / n as f32 <= 1.005, "{} {wo}: {}", material.name, sum / n as f32);
        }
    }
}

#[test]
fn white_metal_and_glass_lose_little_where_facets_are_flat() {
    for material in [conductor(None, Ggx, 0.05), conductor(None, Beckmann, 0.1), dielectric(1.5, Ggx, 0.05, false)] {
        let bsdf = material.bsdf();
        let (mut rng, mut sum) = (Rng::new(63), 0.0);
        for s in (0..40_000).filter_map(|_| bsdf.sample(polar(0.5, 0.0), rng.f32(), rng.f32x2())) {
            sum += s.weight.x * s.eta * s.eta;
        }
        assert!((sum / 40_000.0 - 1.0).abs() < 0.01, "{}: {}", material.name, sum / 40_000.0);
    }
}

#[test]
fn albedos_are_what_is_scattered() {
    // diffuse kinds and rough plastic: to the accuracy of the tables
    let mut materials = vec![diffuse(), transmitter()];
    for kind in [Ggx, Beckmann] {
        materials.extend([0.1, 0.3, 0.8].map(|alpha| plastic(kind, alpha, true, Rgb::ONE)));
        materials.extend([0.1, 0.3, 0.8].map(|alpha| conserving_metal(None, kind, alpha)));
    }
    for material in &materials {
        for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.3, 2.0)] {
            let (bsdf, albedo) = (material.bsdf(), material.bsdf().albedo(wo));
            for channel in 0..3 {
                let truth = scattered(&bsdf, wo, channel);
                let off = (albedo[channel] as f64 - truth).abs();
                assert!(off < 3e-3, "{} {wo}: {albedo} {truth}", material.name);
            }
        }
    }
    // the others: an estimate
    let estimates = [
        conductor(Some(COPPER), Ggx, 0.3),
        dielectric(1.5, Beckmann, 0.3, false),
        principled(TILES),
        principled(ALL_LOBES),
    ];
    for material in &estimates {
        for wo in [Vec3::Z, polar(0.8, 1.0)] {
            let (bsdf, mut rng) = (material.bsdf(), Rng::new(64));
            let mut sum = 0.0;
            for s in (0..40_000).filter_map(|_| bsdf.sample(wo, rng.f32(), rng.f32x2())) {
                sum += s.weight.y * s.eta * s.eta;
            }
            let (truth, albedo) = (sum / 40_000.0, bsdf.albedo(wo).y);
            assert!((albedo - truth).abs() < 0.1, "{} {wo}: {albedo} {truth}", material.name);
        }
    }
}

#[test]
fn a_coat_beside_its_base_adds_its_highlight_to_it() {
    for kind in [Ggx, Beckmann] {
        let (both, grey) = (additive(kind, 0.2), Rgb::new(0.5, 0.4, 0.1));
        let coat = plastic(kind, 0.2, false, Rgb::splat(0.5)).colored(Rgb::ZERO, Rgb::ZERO);
        for (wo, wi) in [(polar(0.3, 0.0), polar(0.35, 3.0)), (polar(1.0, 0.2), polar(0.6, 2.5))] {
            let wanted = grey * (wi.z * std::f32::consts::FRAC_1_PI) + coat.bsdf().eval(wo, wi);
            let found = both.bsdf().eval(wo, wi);
            assert!((found - wanted).abs().max_element() < 1e-5, "{kind:?} {wo} {wi}: {found}, not {wanted}");
        }
    }
}

#[test]
fn smooth_plastic_without_absorption_keeps_all_energy() {
    let material = plastic(Ggx, 0.0, true, Rgb::ONE).colored(Rgb::ONE, Rgb::ZERO);
    for wo in [Vec3::Z, polar(1.0, 0.0), polar(1.5, 0.0)] {
        let bsdf = material.bsdf();
        let (f, _) = fresnel::dielectric(wo.z, 1.5);
        let whole = scattered(&bsdf, wo, 0) + f as f64;
        assert!((whole - 1.0).abs() < 1e-3, "{wo}: {whole}");
        assert!((bsdf.albedo(wo).x - 1.0).abs() < 1e-3);
    }
}

#[test]
fn light_may_take_any_path_backwards() {
    let mut rng = Rng::new(65);
    for material in &smooth_materials() {
        let bsdf = material.bsdf();
        let eta_of = |w: Vec3| match bsdf.kind() {
            BsdfKind::RoughDielectric(d) if w.z < 0.0 => d.eta,
            _ => 1.0,
        };
        for _ in 0..2000 {
            let (a, b) = (
                crate::math::warp::square_to_uniform_sphere(rng.f32x2()),
                crate::math::warp::square_to_uniform_sphere(rng.f32x2()),
            );
            // f(a, b)/η_b² is symmetric when radiance is carried (Veach 1997, §5.2)
            let there = bsdf.eval(a, b) * (eta_of(b) / eta_of(a)).powi(2) / b.z.abs();
            let back = bsdf.eval(b, a) / a.z.abs();
            let off = (there - back).abs().max_element();
            // far tails of Beckmann's exponential keep two digits in single precision
            let fine = off <= 2e-3 * there.max_element() + 1e-5;
            assert!(fine, "{} {a} {b}: {there} {back}", material.name);
        }
    }
}

#[test]
fn principled_gains_no_more_than_burleys_lobes_do() {
    // known excess of the model: retro-reflection and sheen of a white, rough, dielectric base at grazing angles
    let worst = PrincipledParameters {
        roughness: 1.0,
        specular: 0.5,
        sheen: 1.0,
        sheen_tint: 0.0,
        ..PrincipledParameters::default()
    };
    let excess = principled(worst).colored(Rgb::ONE, Rgb::ZERO);
    let cases = [(principled(TILES), 1.0), (principled(ALL_LOBES), 1.05), (excess, 1.6)];
    for (material, most) in &cases {
        for wo in [Vec3::Z, polar(0.8, 1.0), polar(1.4, 2.0), polar(1.5, 2.0)] {
            let whole = scattered(&material.bsdf(), wo, 0);
            assert!(whole <= *most, "{} {wo}: {whole}", material.name);
        }
    }
}
