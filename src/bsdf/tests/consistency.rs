//! What `sample`, `eval`, `pdf` and the rest say of each other; sides; extreme input.

use super::*;
use crate::Error;
use crate::bsdf::coat::Entering;
use crate::math::rng::Rng;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_6, PI};

/// Draws `n` samples and gives each to `check`.
fn for_samples(bsdf: &Bsdf, wo: Vec3, n: usize, mut check: impl FnMut(BsdfSample)) {
    let mut rng = Rng::new(51);
    for _ in 0..n {
        if let Some(sample) = bsdf.sample(wo, rng.f32(), rng.f32x2()) {
            check(sample);
        }
    }
}

#[test]
fn smooth_samples_have_the_weight_and_density_of_eval_pdf() {
    for material in &smooth_materials() {
        for wo in views() {
            let (bsdf, mut smooth) = (material.bsdf(), 0);
            for_samples(&bsdf, wo, 2000, |s| {
                assert!((s.wi.length() - 1.0).abs() < 1e-5, "{}: {}", material.name, s.wi);
                if s.delta {
                    return;
                }
                smooth += 1;
                let (value, pdf) = bsdf.eval_pdf(wo, s.wi);
                let same = (s.pdf - pdf).abs() <= 1e-5 * pdf
                    && (s.weight * pdf - value).abs().max_element() <= 1e-5 * value.max_element();
                assert!(same, "{} from {wo}: {s:?} {value} {pdf}", material.name);
                assert_eq!((value, pdf), (bsdf.eval(wo, s.wi), bsdf.pdf(wo, s.wi)));
            });
            assert!(smooth > 100, "{} from {wo}: {smooth}", material.name);
        }
    }
}

#[test]
fn delta_samples_carry_what_the_lobe_scatters() {
    for material in &delta_materials() {
        let bsdf = material.bsdf();
        assert!(!bsdf.has_smooth() && bsdf.roughness() == 0.0);
        for wo in views() {
            for_samples(&bsdf, wo, 100, |s| {
                assert!(s.delta && (s.wi.length() - 1.0).abs() < 1e-5);
                assert_eq!(bsdf.eval_pdf(wo, s.wi), (Rgb::ZERO, 0.0));
                // white clear materials lose nothing: the weight only undoes the scaling of radiance
                let albedo = bsdf.albedo(wo);
                let energy = s.weight * (s.eta * s.eta);
                let off = (energy - albedo).abs().max_element();
                assert!(off < 1e-5, "{} from {wo}: {s:?} {albedo}", material.name);
            });
        }
    }
}

#[test]
fn refraction_reports_its_indices() {
    let glass = dielectric(1.5, Ggx, 0.0, false);
    let rough = dielectric(1.5, Beckmann, 0.3, false);
    for material in [&glass, &rough] {
        for (wo, eta) in [(polar(0.5, 0.0), 1.5), (polar(2.9, 0.0), 1.0 / 1.5)] {
            for_samples(&material.bsdf(), wo, 1000, |s| {
                let expected = if s.wi.z * wo.z < 0.0 { eta } else { 1.0 };
                assert_eq!(s.eta, expected, "{}", material.name);
            });
        }
    }
    for_samples(&dielectric(1.5, Ggx, 0.0, true).bsdf(), polar(0.5, 0.0), 100, |s| {
        assert_eq!(s.eta, 1.0);
        assert!(s.wi.z > 0.0 || s.wi == -polar(0.5, 0.0));
    });
}

#[test]
fn smooth_glass_bends_by_snell() {
    let glass = dielectric(1.5, Ggx, 0.0, false);
    // 30° in glass leaves at asin(0.75); 60° is totally reflected
    let wo = polar(PI - FRAC_PI_6, 0.0);
    let s = glass.bsdf().sample(wo, 0.999, [0.5; 2]).unwrap();
    assert!((s.wi - Vec3::new(-0.75, 0.0, (1.0f32 - 0.5625).sqrt())).length() < 1e-6);
    let f = fresnel::dielectric(FRAC_PI_6.cos(), 1.0 / 1.5).0;
    assert!((s.pdf - (1.0 - f)).abs() < 1e-6 && (s.weight.x - 2.25).abs() < 1e-5, "{s:?}");
    let wo = polar(PI - FRAC_PI_3, 0.0);
    let s = glass.bsdf().sample(wo, 0.999, [0.5; 2]).unwrap();
    assert!(s.wi.z < 0.0 && s.weight == Rgb::ONE && s.pdf == 1.0);
}

#[test]
fn panes_reflect_from_both_faces() {
    let pane = dielectric(1.5, Ggx, 0.0, true);
    // 0.04 once; 2·0.04/1.04 with all that goes to and fro
    let s = pane.bsdf().sample(Vec3::Z, 0.0, [0.5; 2]).unwrap();
    assert!((s.pdf - 0.08 / 1.04).abs() < 1e-6 && s.wi == Vec3::Z);
}

#[test]
fn two_sided_materials_look_alike_from_behind_and_one_sided_ones_black() {
    for material in &smooth_materials() {
        let (both, front) = (material.sided(true), material.sided(false));
        if !both.bsdf().kind().traits().1 {
            continue;
        }
        let (both, front) = (both.bsdf(), front.bsdf());
        let (wo, wi) = (polar(0.7, 1.0), polar(0.75, 4.1));
        let (behind, below) = (mirrored(wo), mirrored(wi));
        assert_eq!(both.eval_pdf(wo, wi), front.eval_pdf(wo, wi));
        assert!(both.pdf(wo, wi) > 0.0);
        assert_eq!(both.eval_pdf(behind, below), front.eval_pdf(wo, wi));
        assert_eq!(both.albedo(behind), front.albedo(wo));
        for (o, i) in [(wo, below), (behind, wi), (behind, below)] {
            assert_eq!(front.eval_pdf(o, i), BLACK, "{}", material.name);
        }
        assert_eq!((both.eval_pdf(wo, below), both.eval_pdf(behind, wi)), (BLACK, BLACK));
        assert!(front.sample(behind, 0.3, [0.4, 0.6]).is_none());
        assert_eq!(front.albedo(behind), Rgb::ZERO);
        let (a, b) = (both.sample(wo, 0.3, [0.4, 0.6]), both.sample(behind, 0.3, [0.4, 0.6]));
        assert_eq!(a.map(|s| mirrored(s.wi)), b.map(|s| s.wi));
    }
}

#[test]
fn traits_of_the_kinds() {
    let grey = diffuse();
    assert_eq!(grey.bsdf().lambertian(), Some(grey.colors[0]));
    assert_eq!(grey.bsdf().roughness(), 1.0);
    assert!(transmitter().bsdf().lambertian().is_none());
    assert_eq!(conductor(None, Ggx, 0.25).bsdf().roughness(), 0.25);
    assert_eq!(plastic(Ggx, 0.0, true, Rgb::ONE).bsdf().roughness(), 1.0);
    assert!(smooth_materials().iter().all(|m| m.bsdf().has_smooth()));
}

#[test]
fn every_type_of_the_list_is_whole() {
    let mut numbers = std::collections::BTreeSet::new();
    for &(name, kind) in BsdfType::NAMES {
        let mut description = kind.bsdf();
        assert_eq!((kind.name(), description.bsdf_type()), (name, kind));
        assert!(numbers.insert(description.number()), "{name} has the number of another type");
        let model = BsdfModel::new(&description, true, &mut BsdfTables::default()).unwrap();
        assert_eq!(model.at([Rgb::ONE; 2]).kind().traits().1, kind.is_opaque(), "{name}");
        let mut textures = 0;
        crate::fields::each_texture(&mut description, |_| textures += 1);
        assert!(textures <= 2, "{name} has more textures than a BSDF has colours");
    }
}

#[test]
fn nothing_is_infinite_at_the_edges() {
    let edge = [0.0, 1e-7, 0.5, crate::math::ONE_MINUS_EPSILON];
    let mut materials = smooth_materials();
    materials.extend(delta_materials());
    for kind in [Ggx, Beckmann] {
        for alpha in [1e-4, 1e-3, 10.0] {
            materials.push(conductor(Some(COPPER), kind, alpha));
            materials.push(dielectric(1.5, kind, alpha, false));
            materials.push(plastic(kind, alpha, true, Rgb::ONE));
        }
    }
    let black = diffuse().colored(Rgb::ZERO, Rgb::ZERO);
    materials.extend([black, transmitter().colored(Rgb::ZERO, Rgb::ZERO)]);
    let grazing = [Vec3::X, polar(FRAC_PI_2 - 1e-5, 1.0), Vec3::new(1.0, 0.0, 1e-30), -Vec3::Z];
    for material in &materials {
        let bsdf = material.bsdf();
        for wo in views().into_iter().chain(grazing) {
            for wi in views().into_iter().chain(grazing).chain([wo, -wo, mirrored(wo)]) {
                let (value, pdf) = bsdf.eval_pdf(wo, wi);
                let fine = value.is_finite() && value.min_element() >= 0.0;
                assert!(fine && pdf.is_finite() && pdf >= 0.0, "{} {wo} {wi}", material.name);
            }
            assert!(bsdf.albedo(wo).is_finite());
            for (a, b, c) in edge.iter().flat_map(|&a| edge.map(|b| (a, b, edge[1]))) {
                for u in [[b, c], [c, b], [b, b]] {
                    let Some(s) = bsdf.sample(wo, a, u) else { continue };
                    let fine = s.wi.is_finite() && s.weight.is_finite() && s.pdf.is_finite();
                    assert!(fine && s.pdf > 0.0, "{} {wo} {a} {u:?} {s:?}", material.name);
                }
            }
        }
    }
}

#[test]
fn parameters_out_of_their_domain_are_refused() {
    let metal = |eta_k, alpha| {
        BsdfDescription::Conductor(ConductorParameters {
            eta_k,
            specular_reflectance: WHITE,
            alpha,
            distribution: Ggx,
            energy_conserving: false,
        })
    };
    let glass = |int_ior, alpha, thin| {
        BsdfDescription::Dielectric(DielectricParameters {
            int_ior,
            ext_ior: 1.0,
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
            alpha,
            distribution: Ggx,
            thin,
        })
    };
    for bad in [
        metal(None, -0.1),
        metal(None, f32::NAN),
        metal(Some((Rgb::ZERO, Rgb::ZERO)), 0.1),
        metal(Some((Rgb::ONE, -Rgb::ONE)), 0.1),
        glass(0.0, 0.0, false),
        glass(f32::INFINITY, 0.0, false),
        glass(1.5, 0.1, true),
    ] {
        let model = BsdfModel::new(&bad, true, &mut BsdfTables::default());
        assert!(matches!(model, Err(Error::Scene(_))), "{bad:?}");
    }
    // rough glass of index 1 is no glass
    let none = BsdfModel::new(&glass(1.0, 0.3, false), true, &mut BsdfTables::default()).unwrap();
    let s = none.at([Rgb::ONE; 2]).sample(Vec3::Z, 0.5, [0.5; 2]).unwrap();
    assert!(s.delta && s.wi == -Vec3::Z && s.weight == Rgb::ONE);
}

/// Roughnesses between those of all lobes there are, and that of diffuse ones.
const ALPHAS: [f32; 6] = [1e-4, 0.04, 0.08, 0.3, 0.9, DIFFUSE];

#[test]
fn lobes_of_less_roughness_are_those_of_the_lowest_numbers() {
    let (mut rng, mut parted) = (Rng::new(52), 0);
    for material in &smooth_materials() {
        for (wo, alpha) in views().into_iter().flat_map(|wo| ALPHAS.map(|alpha| (wo, alpha))) {
            let (bsdf, sharp) = (material.bsdf(), material.bsdf().sharp_probability(wo, alpha));
            parted += u32::from(sharp > 0.0 && sharp < 1.0);
            // E[weight of the rough lobes] by their draws alone, and by all: the same, and 0 if only sharp ones are drawn
            let (mut by_rough, mut by_all, n) = (Vec::new(), Vec::new(), 4000);
            for _ in 0..n {
                let (lobe, u) = (rng.f32(), rng.f32x2());
                let Some(s) = bsdf.sample(wo, lobe, u).filter(|s| !s.delta) else {
                    by_all.push(0.0);
                    by_rough.push(0.0);
                    continue;
                };
                let (f, pdf) = bsdf.eval_pdf_rough(wo, s.wi, alpha);
                let (whole, whole_pdf) = bsdf.eval_pdf(wo, s.wi);
                assert!(pdf <= whole_pdf * 1.0001 && (f - whole * 1.0001).max_element() <= 0.0, "{}", material.name);
                assert!(lobe < sharp || pdf > 0.0, "{} {alpha}: a rough lobe drew what it does not", material.name);
                by_all.push((f.y / whole_pdf) as f64);
                by_rough.push(if lobe < sharp { 0.0 } else { (f.y / pdf) as f64 });
            }
            let [a, b] = [by_all, by_rough].map(|values| crate::stats::Summary::of(&values).unwrap());
            let z = (a.mean - b.mean) / (a.std_error().hypot(b.std_error()) + 1e-5 * a.mean.max(1e-30));
            assert!(z.abs() < 6.0, "{} from {wo}, alpha {alpha}: {a:?}, {b:?}", material.name);
        }
    }
    assert!(parted > 50, "{parted} BSDFs in parts");
}

#[test]
fn all_lobes_are_rougher_than_nothing_and_diffuse_ones_reflect_their_albedo() {
    for material in &smooth_materials() {
        for wo in views() {
            let bsdf = material.bsdf();
            let (mut rng, mut sum, n) = (Rng::new(53), Rgb::ZERO, 20_000);
            for _ in 0..n {
                let wi = crate::math::warp::square_to_uniform_sphere(rng.f32x2());
                let whole = bsdf.eval_pdf_rough(wo, wi, f32::MIN_POSITIVE);
                assert_eq!(whole, bsdf.eval_pdf(wo, wi), "{}", material.name);
                sum += bsdf.eval_pdf_rough(wo, wi, DIFFUSE).0 * (4.0 * PI / n as f32);
            }
            // 6 standard errors of an integrand that varies about as much as it is; the principled base is not quite
            // Lambert's, and sheen is not in its albedo
            let tolerance = if matches!(bsdf.kind(), BsdfKind::Principled(_)) { 0.5 } else { 0.07 };
            let translucent = matches!(bsdf.kind(), BsdfKind::DiffuseTransmitter(_));
            let albedo = bsdf.diffuse_albedo(wo);
            let near = (sum - albedo).abs().max_element() <= tolerance * albedo.max_element();
            assert!(near || (translucent && albedo == Rgb::ZERO), "{} from {wo}: {sum} {albedo}", material.name);
        }
    }
}

#[test]
fn coats_are_tabulated_once() {
    let mut tables = BsdfTables::default();
    let refracted = Entering::Refracted;
    let first = tables.coat(1.5, 0.2, Ggx, refracted);
    assert!(std::sync::Arc::ptr_eq(&first, &tables.coat(1.5, 0.2, Ggx, refracted)));
    assert!(!std::sync::Arc::ptr_eq(&first, &tables.coat(1.5, 0.2, Beckmann, refracted)));
    assert!(!std::sync::Arc::ptr_eq(&first, &tables.coat(1.5, 0.2, Ggx, Entering::All)));
}
