use super::*;
use crate::math::rng::Rng;
use crate::stats::quadrature::{Rect, Refinement, integrate};
use crate::stats::{DirectionTest, Domain, sidak};
use MicrofacetDistribution::{Beckmann, Ggx};

fn polar(theta: f32, phi: f32) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

#[test]
fn error_functions_are_as_exact_as_they_say() {
    for i in 1..4000 {
        let x = i as f32 * 1e-3;
        let truth = statrs::function::erf::erf(x as f64) as f32;
        assert!((erf(x) - truth).abs() < 5e-7, "{x}");
        let e = i as f32 / 4000.0;
        let truth = statrs::function::erf::erf_inv(e as f64) as f32;
        assert!((erf_inv(e) - truth).abs() < 1e-5 * truth && erf_inv(-e) == -erf_inv(e), "{e}");
    }
}

#[test]
fn facets_project_to_the_surface() {
    // ∫ D(m) cosθm dωm = 1 (Walter et al. 2007, eq. 4), and with G1 from any view: ∫ D_visible = 1
    let refinement = Refinement { min_depth: 5, max_depth: 12, absolute: 1e-8, relative: 1e-6 };
    let all = Rect { x: [0.0, 1.0], y: [0.0, std::f64::consts::TAU] };
    for (kind, alpha) in [(Ggx, 0.1), (Ggx, 0.7), (Beckmann, 0.1), (Beckmann, 0.7)] {
        let facets = Microfacet::new(kind, alpha);
        let normal = |cos: f64, phi: f64| polar(cos.acos() as f32, phi as f32);
        let projected = integrate(&|c, p| (facets.d(normal(c, p)) as f64) * c, all, refinement);
        assert!((projected - 1.0).abs() < 1e-4, "{kind:?} {alpha}: {projected}");
        for theta in [0.0, 0.8, 1.4, 1.57] {
            let wo = polar(theta, 0.5);
            let visible = integrate(&|c, p| facets.visible_pdf(wo, normal(c, p)) as f64, all, refinement);
            assert!((visible - 1.0).abs() < 1e-3, "{kind:?} {alpha} {theta}: {visible}");
        }
    }
}

#[test]
fn smith_at_known_values() {
    let wo = polar(std::f32::consts::FRAC_PI_4, 1.0);
    // GGX: 2/(1 + √(1 + α² tan²θ))
    assert!((Microfacet::new(Ggx, 1.0).g1(wo) - 2.0 / (1.0 + 2.0f32.sqrt())).abs() < 1e-6);
    // Beckmann, a = 1: 2/(1 + erf 1 + e⁻¹/√π) with erf 1 = 0.842701
    assert!((Microfacet::new(Beckmann, 1.0).g1(wo) - 0.975_489).abs() < 1e-5);
    for kind in [Ggx, Beckmann] {
        let facets = Microfacet::new(kind, 0.3);
        assert_eq!((facets.g1(Vec3::Z), facets.g1(Vec3::X)), (1.0, 0.0));
        assert!(facets.g1_over_cos(Vec3::X).is_finite());
    }
}

/// χ² of the sampler as seen from `wo`, against the density of `claimed`.
fn visible_normals(facets: Microfacet, claimed: Microfacet, wo: Vec3) -> crate::stats::Chi2Report {
    let mut rng = Rng::new(31);
    let depth = if facets.alpha() < 0.1 { 4 } else { 2 };
    DirectionTest { depth, ..DirectionTest::new(Domain::Hemisphere) }
        .run(|| Some(facets.sample_visible(wo, rng.f32x2())), |m| claimed.visible_pdf(wo, m))
}

#[test]
fn visible_normals_follow_their_density() {
    let thetas = [0.0, 0.4, 1.0, 1.4, 1.55];
    let alphas = [0.04, 0.1, 0.4, 1.0];
    // false alarm of the whole set: one in a million
    let level = sidak(1e-6, 2 * thetas.len() * alphas.len());
    for kind in [Ggx, Beckmann] {
        for alpha in alphas {
            for theta in thetas {
                let facets = Microfacet::new(kind, alpha);
                let report = visible_normals(facets, facets, polar(theta, 2.0));
                assert!(report.passes(level), "{kind:?} {alpha} {theta}: {report}");
            }
        }
    }
}

#[test]
fn visible_normals_of_another_surface_are_caught() {
    for kind in [Ggx, Beckmann] {
        let (facets, other) = (Microfacet::new(kind, 0.3), Microfacet::new(kind, 0.31));
        let report = visible_normals(facets, other, polar(1.0, 2.0));
        assert!(report.p_value < 1e-6, "{kind:?}: {report}");
    }
    let (ggx, beckmann) = (Microfacet::new(Ggx, 0.3), Microfacet::new(Beckmann, 0.3));
    assert!(visible_normals(ggx, beckmann, polar(0.5, 2.0)).p_value < 1e-6);
}

#[test]
fn extreme_views_and_numbers_stay_finite() {
    let edge = [0.0, 1e-7, 0.5, ONE_MINUS_EPSILON];
    for kind in [Ggx, Beckmann] {
        for alpha in [1e-4, 1e-3, 0.5, 1.0, 2.0] {
            let facets = Microfacet::new(kind, alpha);
            for wo in [Vec3::Z, Vec3::X, polar(std::f32::consts::FRAC_PI_2 - 1e-5, 3.0), polar(1e-4, 0.1)] {
                for u in edge.iter().flat_map(|&a| edge.map(|b| [a, b])) {
                    let m = facets.sample_visible(wo, u);
                    assert!((m.length() - 1.0).abs() < 1e-5 && m.z > 0.0, "{kind:?} {wo} {u:?} {m}");
                    assert!(facets.visible_pdf(wo, m).is_finite() && facets.d(m).is_finite());
                }
            }
        }
    }
}
