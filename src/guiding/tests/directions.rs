//! Directions drawn, against the density that is claimed for them.

use super::*;
use crate::guiding::directional::{Directions, InFrame};
use crate::guiding::settings::GuideSampling;
use crate::stats::{Chi2Report, DirectionTest, Domain as Whole, sidak};

/// False alarm of each whole set of tests here.
const LEVEL: f64 = 1e-6;

/// Draws by the distribution, and asks it for its density at directions changed by `wrong`, in `frame`.
pub(super) fn chi2(
    d: &InFrame<impl Directions>,
    frame: &Frame,
    domain: Whole,
    rng: &mut Rng,
    wrong: impl Fn(Vec3) -> Vec3,
) -> Chi2Report {
    let cos_bins = if domain == Whole::Sphere { 12 } else { 6 };
    let test = DirectionTest { cos_bins, phi_bins: 16, samples: 50_000, depth: 3, domain };
    let sample = || {
        let w = frame.to_local(d.sample(rng.f64(), rng.f32x2()).0);
        // the way to world space and back rounds; what is below the horizon by more than that fails the test
        Some(if domain == Whole::Hemisphere && w.z > -1e-6 { w.with_z(w.z.max(0.0)) } else { w })
    };
    test.run(sample, |w| d.pdf(frame.to_world(wrong(w))))
}

/// What a row of K actions holds.
type Row = fn(&mut Rng, usize) -> Vec<f32>;

const ROWS: [(&str, Row); 5] = [
    ("flat", |_, k| vec![0.25; k]),
    ("random", |rng, k| (0..k).map(|_| rng.f32()).collect()),
    ("spiked", |rng, k| {
        let spike = rng.next_u32() as usize % k;
        (0..k).map(|a| if a == spike { 1e6 } else { 1.0 }).collect()
    }),
    ("mostly black", |rng, k| (0..k).map(|a| if a % 3 == 0 { rng.f32() } else { 0.0 }).collect()),
    ("tiny", |rng, k| (0..k).map(|_| 1e-30 * rng.f32()).collect()),
];

/// Turns by about seven degrees about an axis in the horizon.
pub(super) fn turned(w: Vec3) -> Vec3 {
    Frame::from_normal(Vec3::new(0.12, 0.05, 0.99).normalize()).to_world(w)
}

#[test]
fn directions_of_the_hemisphere_follow_their_density() {
    let mut rng = Rng::new(1);
    let cases: Vec<(u32, bool)> = [1, 2, 4, 12].into_iter().flat_map(|s| [(s, true), (s, false)]).collect();
    let level = sidak(LEVEL, cases.len() * ROWS.len());
    for (strata, normals) in &cases {
        for (name, make) in ROWS {
            let mut guide = guide(|s| (s.strata, s.normals) = (*strata, *normals));
            let n = unit(&mut rng);
            let key = state(&guide, point(&mut rng), n);
            let values = make(&mut rng, (strata * strata) as usize);
            teach(&mut guide, key, n, &values, 20);
            guide.end_iteration(1);
            let summary = summary(&guide, key);
            // an oriented state keeps its first normal, another takes that of the query
            let asked = if *normals { -n } else { n };
            let distribution = guide.field().distribution(&summary, asked);
            let kept = PackedDirection::new(n).unpack();
            let frame = Frame::from_normal(if *normals { kept } else { n });
            let report = chi2(&distribution, &frame, Whole::Hemisphere, &mut rng, |w| w);
            assert!(report.passes(level), "{name}, {strata} × {strata}, normals {normals}: {report}");
            assert!((report.mass - 1.0).abs() < 1e-3, "{name}: {report}");
            let wrong = chi2(&distribution, &frame, Whole::Hemisphere, &mut rng, turned);
            assert!(!wrong.passes(1e-6), "{name}, {strata} × {strata}: turned, and unseen: {wrong}");
        }
    }
    println!("{} rows follow their density; turned, none does", cases.len() * ROWS.len());
}

#[test]
fn directions_of_the_sphere_follow_their_density() {
    let mut rng = Rng::new(3);
    let cases: Vec<(u32, GuideSampling)> =
        [2, 4, 12].into_iter().flat_map(|s| [(s, GuideSampling::Q), (s, GuideSampling::QCos)]).collect();
    let level = sidak(LEVEL, cases.len() * ROWS.len());
    let world = Frame { s: Vec3::X, t: Vec3::Y, n: Vec3::Z };
    for (strata, sampling) in &cases {
        for (name, make) in ROWS {
            let mut guide = guide(|s| {
                (s.table, s.normals) = (DirectionTable::Sphere, false);
                (s.strata, s.sampling) = (*strata, *sampling);
            });
            let key = state(&guide, point(&mut rng), unit(&mut rng));
            let values = make(&mut rng, (2 * strata * strata) as usize);
            teach(&mut guide, key, Vec3::Y, &values, 20);
            guide.end_iteration(1);
            let (summary, n) = (summary(&guide, key), unit(&mut rng));
            let distribution = guide.field().distribution(&summary, n);
            let report = chi2(&distribution, &world, Whole::Sphere, &mut rng, |w| w);
            assert!(report.passes(level), "{name}, {strata}, {sampling:?}, {n}: {report}");
            assert!((report.mass - 1.0).abs() < 1e-3, "{name}: {report}");
            // the table of one normal taken for that of another
            let other = guide.field().distribution(&summary, turned(n));
            let test = |w: Vec3| other.pdf(w);
            let sampled =
                DirectionTest { cos_bins: 12, phi_bins: 16, samples: 50_000, depth: 3, domain: Whole::Sphere };
            let wrong = sampled.run(|| Some(distribution.sample(rng.f64(), rng.f32x2()).0), test);
            // without cosines both normals may have the same strata above the horizon; a spike leaves the rest no draws
            let few = *sampling == GuideSampling::Q || name == "spiked";
            assert!(few || !wrong.passes(1e-6), "{name}, {strata}, {sampling:?}: another normal, and unseen: {wrong}");
            let wrong = chi2(&distribution, &world, Whole::Sphere, &mut rng, turned);
            assert!(!wrong.passes(1e-6), "{name}, {strata}, {sampling:?}: turned, and unseen: {wrong}");
        }
    }
}

#[test]
fn what_the_sphere_draws_goes_by_radiance_and_the_cosine_of_the_query() {
    for sampling in [GuideSampling::Q, GuideSampling::QCos] {
        let mut guide =
            guide(|s| (s.table, s.normals, s.strata, s.sampling) = (DirectionTable::Sphere, false, 4, sampling));
        let key = state(&guide, Vec3::splat(0.5), Vec3::Y);
        let values: Vec<f32> = (0..32).map(|k| 1.0 + (k % 5) as f32).collect();
        teach(&mut guide, key, Vec3::Y, &values, 1000);
        guide.end_iteration(1);
        let (strata, n) = (Strata::new(Domain::Sphere, 4), Vec3::new(0.6, 0.48, 0.64));
        let cos = |k: usize| strata.direction(k, [0.5; 2]).dot(n).max(0.0);
        let weight = |k: usize| values[k] * if sampling == GuideSampling::Q { cos(k).ceil() } else { cos(k) };
        let total: f32 = (0..32).map(weight).sum();
        let summary = summary(&guide, key);
        let distribution = guide.field().distribution(&summary, n);
        for k in 0..32 {
            let expected = weight(k) / (total * strata.solid_angle());
            let pdf = distribution.pdf(strata.direction(k, [0.5; 2]));
            assert!((pdf - expected).abs() <= 3e-3 * expected, "{sampling:?}, {k}: {pdf}, not {expected}");
        }
        // of no normal in particular: π times the mean over the sphere
        let irradiance = std::f32::consts::PI * values.iter().sum::<f32>() / 32.0;
        assert!((summary.irradiance / irradiance - 1.0).abs() < 1e-3);
    }
}

#[test]
fn directions_lie_above_the_plane_of_the_state() {
    let mut rng = Rng::new(2);
    for table in [DirectionTable::Hemisphere, DirectionTable::Tree] {
        for _ in 0..50 {
            let mut guide = guide(|s| s.table = table);
            let n = unit(&mut rng);
            let key = state(&guide, point(&mut rng), n);
            look_around(&mut guide, &mut rng, (key, n), 200, |_| 1.0);
            guide.end_iteration(1);
            let summary = summary(&guide, key);
            let distribution = guide.field().distribution(&summary, -n);
            for _ in 0..200 {
                let w = distribution.sample(rng.f64(), rng.f32x2()).0;
                // the normal is packed: wrong by less than 1e-4
                assert!(w.is_normalized() && w.dot(n) > -2e-4 && distribution.pdf(w).is_finite());
            }
            assert_eq!(distribution.pdf(-n), 0.0);
        }
    }
}

#[test]
fn what_is_drawn_goes_by_radiance_times_cosine() {
    for sampling in [GuideSampling::QCos, GuideSampling::Q] {
        let mut guide = guide(|s| (s.strata, s.sampling) = (4, sampling));
        let key = state(&guide, Vec3::splat(0.5), Vec3::Y);
        let mut values = [1.0f32; 16];
        values[5] = 3.0;
        teach(&mut guide, key, Vec3::Y, &values, 1000);
        guide.end_iteration(1);
        let strata = Strata::new(Domain::Hemisphere, 4);
        let weight = |k: usize| values[k] * if sampling == GuideSampling::Q { 1.0 } else { strata.cosines()[k] };
        let total: f32 = (0..16).map(weight).sum();
        let summary = summary(&guide, key);
        let distribution = guide.field().distribution(&summary, Vec3::Y);
        let frame = Frame::from_normal(PackedDirection::new(Vec3::Y).unpack());
        for action in 0..16 {
            let expected = weight(action) / (total * strata.solid_angle());
            // a thousand visits leave a thousandth of a lean towards the state's mean
            let pdf = distribution.pdf(frame.to_world(strata.direction(action, [0.5; 2])));
            assert!((pdf / expected - 1.0).abs() < 3e-3, "{sampling:?}, action {action}: {pdf}, not {expected}");
        }
        let lit = || values.iter().zip(strata.cosines()).map(|(q, cos)| q * cos);
        let irradiance = lit().sum::<f32>() * strata.solid_angle();
        let peak = std::f32::consts::TAU * lit().fold(0.0, f32::max);
        assert!((summary.irradiance / irradiance - 1.0).abs() < 1e-3 && (summary.peak / peak - 1.0).abs() < 1e-3);
    }
}

#[test]
fn compensation_leaves_out_what_the_bsdf_covers() {
    let density = |compensation: bool| {
        let mut guide = guide(|s| (s.strata, s.mis_compensation) = (2, compensation));
        let key = state(&guide, Vec3::splat(0.5), Vec3::Y);
        teach(&mut guide, key, Vec3::Y, &[1.0, 1.0, 1.0, 5.0], 10_000);
        guide.end_iteration(1);
        let (summary, strata) = (summary(&guide, key), Strata::new(Domain::Hemisphere, 2));
        let frame = Frame::from_normal(PackedDirection::new(Vec3::Y).unpack());
        let distribution = guide.field().distribution(&summary, Vec3::Y);
        let pdf = |k: usize| distribution.pdf(frame.to_world(strata.direction(k, [0.5; 2]))) * strata.solid_angle();
        [0, 1, 2, 3].map(pdf)
    };
    let near = |a: [f32; 4], b: [f32; 4]| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-3);
    // strata of one hemisphere's quarter have the same cosine; the mean of Q is 2, half of which the BSDF has
    assert!(near(density(false), [0.125, 0.125, 0.125, 0.625]), "{:?}", density(false));
    assert!(near(density(true), [0.0, 0.0, 0.0, 1.0]), "{:?}", density(true));
}

#[test]
fn smoothing_gives_a_stratum_its_share_of_the_neighbours() {
    let mut guide = guide(|s| (s.strata, s.smoothing) = (2, 0.5));
    let key = state(&guide, Vec3::splat(0.5), Vec3::Y);
    teach(&mut guide, key, Vec3::Y, &[4.0, 0.0, 0.0, 0.0], 10_000);
    guide.end_iteration(1);
    let (summary, strata) = (summary(&guide, key), Strata::new(Domain::Hemisphere, 2));
    let frame = Frame::from_normal(PackedDirection::new(Vec3::Y).unpack());
    let distribution = guide.field().distribution(&summary, Vec3::Y);
    // own half, and half of the mean of two neighbours: 2, 1, 1, 0
    for (k, expected) in [0.5, 0.25, 0.25, 0.0].into_iter().enumerate() {
        let pdf = distribution.pdf(frame.to_world(strata.direction(k, [0.5; 2]))) * strata.solid_angle();
        assert!((pdf - expected).abs() < 1e-3, "{k}: {pdf}, not {expected}");
    }
}
