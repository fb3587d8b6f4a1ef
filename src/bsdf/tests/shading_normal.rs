//! Surfaces about other normals than that of the shading frame: nothing leaks, nothing is lost or gained, and samples follow their
//! density.

use super::*;
use crate::math::rng::Rng;
use crate::stats::quadrature::{Rect, Refinement, integrate};
use crate::stats::{DirectionTest, Domain, sidak};
use std::f64::consts::{PI, TAU};

/// Slightly, much, and so far turned that much of the hemisphere is beyond its horizon.
fn normals() -> [Vec3; 3] {
    [polar(0.2, 0.5), polar(0.8, 3.0), polar(1.4, 5.5)]
}

fn turned_materials() -> Vec<Material> {
    let white = |m: Material| m.colored(Rgb::ONE, Rgb::ZERO);
    let kinds: [fn() -> Material; 7] = [
        || diffuse().colored(Rgb::ONE, Rgb::ZERO),
        || transmitter().colored(Rgb::splat(0.7), Rgb::splat(0.3)),
        || conductor(None, Ggx, 0.25),
        || dielectric(1.5, Ggx, 0.25, false),
        || plastic(Ggx, 0.0, false, Rgb::ONE),
        || conserving(Ggx, 0.3),
        || principled(ALL_LOBES),
    ];
    let all = kinds.iter().flat_map(|kind| normals().map(|normal| white(kind()).turned(normal)));
    all.chain(normals().map(|normal| transmitter().turned(normal))).collect()
}

#[test]
fn samples_follow_the_density() {
    let materials = turned_materials();
    let level = sidak(1e-6, materials.len() * views().len());
    for material in &materials {
        for wo in views() {
            // a seed without a draw at the very horizon, which has no weight
            let (bsdf, mut rng) = (material.bsdf(), Rng::new(74));
            let test = DirectionTest { depth: 2, samples: 100_000, ..DirectionTest::new(Domain::Sphere) };
            let sample = || {
                let s = bsdf.sample(wo, rng.f32(), rng.f32x2())?;
                (!s.delta).then_some(s.wi)
            };
            let report = test.run(sample, |wi| bsdf.pdf(wo, wi));
            assert!(report.passes(level), "{} from {wo}: {report}", material.name);
        }
    }
}

#[test]
fn samples_have_the_weight_of_eval() {
    for material in &turned_materials() {
        for wo in views() {
            let (bsdf, mut rng, mut smooth) = (material.bsdf(), Rng::new(72), 0);
            for s in (0..1000).filter_map(|_| bsdf.sample(wo, rng.f32(), rng.f32x2())).filter(|s| !s.delta) {
                let (value, pdf) = bsdf.eval_pdf(wo, s.wi);
                let same = (s.pdf - pdf).abs() <= 1e-5 * pdf
                    && (s.weight * pdf - value).abs().max_element() <= 1e-5 * value.max_element();
                assert!(same, "{} from {wo}: {s:?} {value} {pdf}", material.name);
                smooth += 1;
            }
            assert!(smooth > 50, "{} from {wo}: {smooth}", material.name);
        }
    }
}

/// ∫ eval dωi above and below the surface.
fn scattered(bsdf: &Bsdf, wo: Vec3) -> [f64; 2] {
    let refinement = Refinement { min_depth: 4, max_depth: 9, absolute: 1e-5, relative: 1e-4 };
    let integrand = |theta: f64, phi: f64| f64::from(bsdf.eval(wo, polar(theta as f32, phi as f32)).x) * theta.sin();
    [[0.0, 0.5 * PI], [0.5 * PI, PI]].map(|x| integrate(&integrand, Rect { x, y: [0.0, TAU] }, refinement))
}

/// A white furnace: as bright as the same BSDF is about a normal of its own, seen under the angle at which the turned one is seen.
#[test]
fn a_furnace_sees_the_albedo_of_the_surface_itself() {
    for material in turned_materials().iter().filter(|m| !m.name.starts_with("dielectric")) {
        for wo in [Vec3::Z, polar(0.6, 1.0), polar(1.3, 2.0), polar(1.5, 5.6), polar(2.4, 5.0)] {
            let bsdf = material.bsdf();
            let (flat, own) = bsdf.own_view(material.normal, wo);
            let ([above, below], [own_above, own_below]) = (scattered(&bsdf, wo), scattered(&flat, own));
            let reflected = [own_above, own_below];
            let reflected = if own.z > 0.0 { reflected } else { [reflected[1], reflected[0]] };
            let seen = if wo.z > 0.0 { [above, below] } else { [below, above] };
            for (seen, wanted) in seen.into_iter().zip(reflected) {
                assert!((seen - wanted).abs() < 3e-3, "{} from {wo}: {seen}, not {wanted}", material.name);
                // the principled model itself gains energy
                let white = seen < 1.003 || material.name.starts_with("Principled");
                assert!(white, "{} from {wo}: {seen}", material.name);
            }
        }
    }
}

/// Neither black nor leaking: a white Lambertian surface is white from everywhere above, and nothing is below.
#[test]
fn white_is_white_from_everywhere() {
    for normal in normals() {
        let material = diffuse().colored(Rgb::ONE, Rgb::ZERO).turned(normal);
        for wo in views() {
            let (bsdf, mut rng) = (material.bsdf(), Rng::new(73));
            for _ in 0..2000 {
                let s = bsdf.sample(wo, rng.f32(), rng.f32x2()).expect("nothing is absorbed");
                assert!((s.weight.x - 1.0).abs() < 1e-4 && s.wi.z * wo.z >= 0.0, "{normal} {wo}: {s:?}");
            }
            assert_eq!((bsdf.albedo(wo), bsdf.lambertian()), (Rgb::ONE, None));
        }
    }
}

#[test]
fn where_nothing_is_folded_it_is_plain_normal_mapping() {
    let normal = polar(0.7, 0.0);
    let material = diffuse().colored(Rgb::ONE, Rgb::ZERO).turned(normal);
    for wi in [Vec3::Z, normal, polar(0.5, 3.0), polar(0.8, 0.3)] {
        let (value, pdf) = material.bsdf().eval_pdf(polar(0.3, 1.0), wi);
        let plain = wi.dot(normal).max(0.0) / std::f32::consts::PI;
        assert!((value.x - plain).abs() < 1e-6 && (pdf - plain).abs() < 1e-6, "{wi}: {value}, not {plain}");
    }
}

/// Plain normal mapping loses (1 − cos θ)/2 of a furnace's light below the surface of a Lambertian tilted by θ; folding brings it back.
#[test]
fn what_is_folded_has_a_closed_form() {
    for tilt in [0.2, 0.5, 0.9] {
        let normal = polar(tilt, 0.0);
        let material = diffuse().colored(Rgb::ONE, Rgb::ZERO).turned(normal);
        let bsdf = material.bsdf();
        for wi in [polar(1.5, 0.0), polar(1.4, 0.4), polar(1.2, 6.0), polar(1.0, 3.0)] {
            let cosines = wi.dot(normal).max(0.0) + mirrored(wi).dot(normal).max(0.0);
            let value = bsdf.eval(Vec3::Z, wi).x * std::f32::consts::PI;
            assert!((value - cosines).abs() < 1e-6, "{tilt} from {wi}: {value}, not {cosines}");
        }
        let refinement = Refinement { min_depth: 4, max_depth: 9, absolute: 1e-5, relative: 1e-4 };
        let plain =
            |theta: f64, phi: f64| f64::from(polar(theta as f32, phi as f32).dot(normal).max(0.0)) * theta.sin() / PI;
        let plain = integrate(&plain, Rect { x: [0.0, 0.5 * PI], y: [0.0, TAU] }, refinement);
        let folded = scattered(&bsdf, Vec3::Z)[0] - plain;
        let lost = 0.5 * (1.0 - f64::from(tilt).cos());
        assert!((folded - lost).abs() < 1e-3, "{tilt}: {folded}, not {lost}");
    }
}

/// From behind, a dent is a bump: the lit side is the other.
#[test]
fn two_sided_surfaces_are_turned_as_a_relief_is() {
    let material = diffuse().colored(Rgb::ONE, Rgb::ZERO).turned(polar(0.7, 0.0));
    let bsdf = material.bsdf();
    let above = bsdf.eval(Vec3::Z, polar(0.7, 0.0)).x;
    // the direction opposite to the normal is the one that the same facet faces from below
    assert!((bsdf.eval(Vec3::NEG_Z, -polar(0.7, 0.0)).x - above).abs() < 1e-6);
    assert!(bsdf.eval(Vec3::NEG_Z, mirrored(polar(0.7, 0.0))).x < 0.3 * above);
}

#[test]
fn mirrors_reflect_upwards() {
    let mirror = conductor(None, Ggx, 0.0).turned(polar(0.9, 0.0));
    for wo in [polar(0.3, 0.0), polar(0.9, 0.4), polar(1.4, 0.0), polar(1.4, 3.0)] {
        let s = mirror.bsdf().sample(wo, 0.3, [0.4, 0.6]).unwrap();
        assert!(s.delta && s.wi.z > 0.0 && s.weight == Rgb::ONE, "{wo}: {s:?}");
    }
    let s = mirror.bsdf().sample(polar(0.9, 0.0), 0.3, [0.4, 0.6]).unwrap();
    assert!((s.wi - polar(0.9, 0.0)).length() < 1e-6);
}
