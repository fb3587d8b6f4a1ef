//! Samplers against their densities, by χ²; delta samples count as what the density leaves.

use super::*;
use crate::math::rng::Rng;
use crate::stats::{Chi2Report, DirectionTest, Domain, sidak};

/// False alarm of each whole set of tests here.
const LEVEL: f64 = 1e-6;

fn run(bsdf: &Bsdf, wo: Vec3, pdf: impl Fn(Vec3) -> f32) -> Chi2Report {
    let mut rng = Rng::new(41);
    let depth = if bsdf.roughness() < 0.1 { 3 } else { 2 };
    let test = DirectionTest { depth, samples: 200_000, ..DirectionTest::new(Domain::Sphere) };
    let sample = || {
        let s = bsdf.sample(wo, rng.f32(), rng.f32x2())?;
        (!s.delta).then_some(s.wi)
    };
    test.run(sample, pdf)
}

#[test]
fn every_kind_follows_its_density() {
    let materials = smooth_materials();
    let level = sidak(LEVEL, materials.len() * views().len());
    for material in &materials {
        for wo in views() {
            let bsdf = material.bsdf();
            let report = run(&bsdf, wo, |wi| bsdf.pdf(wo, wi));
            assert!(report.passes(level), "{} from {wo}: {report}", material.name);
        }
    }
}

#[test]
fn densities_of_another_kind_are_caught() {
    let wo = polar(0.9, 1.0);
    let pairs = [
        (conductor(None, Ggx, 0.25), conductor(None, Ggx, 0.26)),
        (conductor(None, Beckmann, 0.25), conductor(None, Ggx, 0.25)),
        (dielectric(1.5, Ggx, 0.25, false), dielectric(1.52, Ggx, 0.25, false)),
        (plastic(Ggx, 0.2, true, Rgb::ONE), plastic(Ggx, 0.2, true, Rgb::splat(0.9))),
        (principled(ALL_LOBES), principled(PrincipledParameters { roughness: 0.32, ..ALL_LOBES })),
    ];
    for (truth, lie) in &pairs {
        let (bsdf, other) = (truth.bsdf(), lie.bsdf());
        let report = run(&bsdf, wo, |wi| other.pdf(wo, wi));
        assert!(report.p_value < 1e-6, "{}: {report}", truth.name);
    }
    // the right density, mirrored about the surface or turned by a degree
    let metal = conductor(None, Ggx, 0.1);
    let bsdf = metal.bsdf();
    assert!(run(&bsdf, wo, |wi| bsdf.pdf(wo, mirrored(wi))).p_value < 1e-6);
    let turned = polar(0.9, 1.0 + 0.017);
    assert!(run(&bsdf, wo, |wi| bsdf.pdf(turned, wi)).p_value < 1e-6);
}

#[test]
fn delta_lobes_are_chosen_as_often_as_they_say() {
    let mut materials = delta_materials();
    materials.push(plastic(Ggx, 0.0, true, Rgb::ONE));
    for material in &materials {
        for wo in views() {
            let (bsdf, n) = (material.bsdf(), 100_000);
            let mut rng = Rng::new(43);
            let (mut reflected, mut transmitted) = ((0u32, 0.0f32), (0u32, 0.0f32));
            for s in (0..n).filter_map(|_| bsdf.sample(wo, rng.f32(), rng.f32x2())) {
                if s.delta {
                    let lobe = if s.wi.z * wo.z > 0.0 { &mut reflected } else { &mut transmitted };
                    *lobe = (lobe.0 + 1, s.pdf);
                }
            }
            for (count, p) in [reflected, transmitted] {
                // six standard deviations of a binomial: false alarm 2·10⁻⁹ each
                let sigma = (n as f32 * p * (1.0 - p)).max(0.0).sqrt();
                let off = (count as f32 - n as f32 * p).abs();
                assert!(off <= 6.0 * sigma + 0.5, "{} from {wo}: {count}, p = {p}", material.name);
            }
        }
    }
}
