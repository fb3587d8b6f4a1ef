//! Warps and tables against their densities. χ² tests here raise a false alarm with probability 10⁻⁶ each.

use super::alias::AliasTable;
use super::rng::Rng;
use super::warp::*;
use crate::stats::{DirectionTest, Domain, chi2_discrete};
use glam::{Vec2, Vec3};

const LEVEL: f64 = 1e-6;

fn follows(domain: Domain, warp: impl Fn([f32; 2]) -> Vec3, pdf: impl Fn(Vec3) -> f32) {
    let mut rng = Rng::new(17);
    let report = DirectionTest::new(domain).run(|| Some(warp(rng.f32x2())), pdf);
    assert!(report.passes(LEVEL), "{report}");
    assert!((report.mass - 1.0).abs() < 1e-4, "{report}");
}

#[test]
fn directions_follow_their_densities() {
    follows(Domain::Hemisphere, square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf);
    follows(Domain::Hemisphere, square_to_uniform_hemisphere, square_to_uniform_hemisphere_pdf);
    follows(Domain::Sphere, square_to_uniform_sphere, |_| UNIFORM_SPHERE_PDF);
}

#[test]
fn a_warp_with_the_wrong_density_is_caught() {
    let mut rng = Rng::new(18);
    let report = DirectionTest::new(Domain::Hemisphere)
        .run(|| Some(square_to_cosine_hemisphere(rng.f32x2())), square_to_uniform_hemisphere_pdf);
    assert!(report.p_value < 1e-6, "{report}");
}

/// Counts over 8 × 8 equal cells of the unit square.
fn square_counts(mut draw: impl FnMut() -> [f32; 2]) -> Vec<u64> {
    let mut counts = vec![0; 64];
    for _ in 0..400_000 {
        let [x, y] = draw();
        counts[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
    }
    counts
}

#[test]
fn the_disk_and_the_triangle_are_covered_evenly() {
    let mut rng = Rng::new(19);
    // in (r², φ) of a disk the density is constant
    let disk = square_counts(|| {
        let p = square_to_disk(rng.f32x2());
        let phi = p.y.atan2(p.x).rem_euclid(std::f32::consts::TAU) / std::f32::consts::TAU;
        [p.length_squared(), phi].map(|v| v.clamp(0.0, super::ONE_MINUS_EPSILON))
    });
    let report = chi2_discrete(&disk, &[1.0 / 64.0; 64]);
    assert!(report.passes(LEVEL), "{report}");
    // folding the triangle's mirror image over fills the square
    let mut flips = Rng::new(20);
    let triangle = square_counts(|| {
        let [a, b] = square_to_triangle(rng.f32x2());
        assert!(a >= 0.0 && b >= 0.0 && a + b <= 1.0 + 1e-6);
        let p = if flips.f32() < 0.5 { [a, b] } else { [1.0 - a, 1.0 - b] };
        p.map(|v| v.clamp(0.0, super::ONE_MINUS_EPSILON))
    });
    let report = chi2_discrete(&triangle, &[1.0 / 64.0; 64]);
    assert!(report.passes(LEVEL), "{report}");
}

#[test]
fn inverses_give_the_square_back() {
    let mut rng = Rng::new(21);
    let mut worst = 0.0f32;
    for _ in 0..100_000 {
        let u = rng.f32x2();
        let near = |v: [f32; 2]| (v[0] - u[0]).abs().max((v[1] - u[1]).abs());
        worst = worst.max(near(disk_to_square(square_to_disk(u))));
        let w = square_to_uniform_hemisphere(u);
        assert!((w.length() - 1.0).abs() < 1e-5 && w.z >= 0.0, "{w}");
        worst = worst.max(near(uniform_hemisphere_to_square(w)));
        let below = Vec3::new(w.x, w.y, -w.z);
        assert_eq!(uniform_hemisphere_to_square(below), uniform_hemisphere_to_square(w));
    }
    // z keeps 2⁻²⁴ of r², so that r is off by up to 2·10⁻⁴ at the pole only
    assert!(worst < 3e-4, "{worst}");
}

#[test]
fn inverses_stay_in_the_square_at_its_corners_and_centre() {
    let edge = super::ONE_MINUS_EPSILON;
    for u in [[0.0, 0.0], [edge, edge], [0.0, edge], [edge, 0.0], [0.5, 0.5], [0.5, 0.0]] {
        let back = disk_to_square(square_to_disk(u));
        assert!((back[0] - u[0]).abs() < 1e-6 && (back[1] - u[1]).abs() < 1e-6, "{u:?} {back:?}");
    }
    for w in [Vec3::Z, Vec3::X, -Vec3::Y, Vec3::new(1.0, 1.0, 0.0).normalize(), -Vec3::Z] {
        let u = uniform_hemisphere_to_square(w);
        assert!(u.iter().all(|v| (0.0..1.0).contains(v)), "{w} {u:?}");
    }
    assert!(disk_to_square(Vec2::new(2.0, 0.0)).iter().all(|v| (0.0..1.0).contains(v)));
}

fn alias_counts(table: &AliasTable, rng: &mut Rng, n: u64) -> Vec<u64> {
    let mut counts = vec![0; table.len()];
    for _ in 0..n {
        counts[table.sample(rng.f32()).0] += 1;
    }
    counts
}

#[test]
fn alias_tables_follow_their_weights() {
    let mut rng = Rng::new(22);
    let uneven: Vec<f64> = (0..100).map(|i| if i % 7 == 0 { 0.0 } else { (i * i) as f64 }).collect();
    for weights in [vec![1.0], vec![3.0, 1.0], vec![0.0, 1e-3, 0.0, 5.0], vec![0.25; 12], uneven] {
        let table = AliasTable::new(&weights).unwrap();
        let sum: f64 = weights.iter().sum();
        let pmf: Vec<f64> = (0..table.len()).map(|i| table.pmf(i) as f64).collect();
        assert!(pmf.iter().zip(&weights).all(|(p, w)| (p - w / sum).abs() < 1e-7));
        let counts = alias_counts(&table, &mut rng, 1_000_000);
        if weights.len() == 1 {
            assert_eq!(counts, [1_000_000]);
        } else {
            let report = chi2_discrete(&counts, &pmf);
            assert!(report.passes(LEVEL), "{weights:?}: {report}");
        }
    }
    assert!(AliasTable::new(&[]).is_none() && AliasTable::new(&[0.0, 0.0]).is_none());
}

#[test]
fn an_alias_table_of_other_weights_is_caught() {
    let table = AliasTable::new(&[1.0, 1.05, 1.0, 0.95]).unwrap();
    let counts = alias_counts(&table, &mut Rng::new(23), 1_000_000);
    assert!(chi2_discrete(&counts, &[0.25; 4]).p_value < 1e-6);
}

#[test]
fn what_an_alias_table_leaves_of_its_number_is_uniform() {
    let table = AliasTable::new(&[0.1, 0.6, 0.05, 0.25]).unwrap();
    let mut rng = Rng::new(24);
    let mut counts = vec![vec![0u64; 16]; 4];
    for _ in 0..1_000_000 {
        let (i, rest) = table.sample(rng.f32());
        assert!((0.0..1.0).contains(&rest));
        counts[i][(rest * 16.0) as usize] += 1;
    }
    for c in counts {
        let report = chi2_discrete(&c, &[1.0 / 16.0; 16]);
        assert!(report.passes(LEVEL), "{report}");
    }
}
