//! Directions drawn, against the density that is claimed for them.

use super::*;
use crate::geometry::Frame;
use crate::stats::{Chi2Report, DirectionTest, Domain, sidak};

/// False alarm of each whole set of tests here.
const LEVEL: f64 = 1e-6;

/// Draws by the distribution, and asks it for its density at directions changed by `wrong`, in the state's frame.
fn chi2(d: &GuidingDistribution, frame: &Frame, rng: &mut Rng, wrong: impl Fn(Vec3) -> Vec3) -> Chi2Report {
    let test = DirectionTest { cos_bins: 6, phi_bins: 16, samples: 50_000, depth: 2, domain: Domain::Hemisphere };
    let sample = || {
        let w = frame.to_local(d.sample(rng.f32(), rng.f32x2()));
        // the way to world space and back rounds; what is below the horizon by more than that fails the test
        Some(if w.z > -1e-6 { w.with_z(w.z.max(0.0)) } else { w })
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

#[test]
fn directions_follow_their_density() {
    let mut rng = Rng::new(1);
    let cases: Vec<(u32, bool)> = [1, 2, 4, 12].into_iter().flat_map(|s| [(s, true), (s, false)]).collect();
    let level = sidak(LEVEL, cases.len() * ROWS.len());
    for (strata, normals) in &cases {
        for (name, make) in ROWS {
            let mut guide = guide(|s| (s.strata, s.normals) = (*strata, *normals));
            let key = state(&guide, point(&mut rng), unit(&mut rng));
            let values = make(&mut rng, (strata * strata) as usize);
            teach(&mut guide, key, &values, 20);
            guide.end_iteration();
            let distribution = guide.field().distribution(key).expect("twenty visits are enough");
            let frame = guide.field().grid().frame(key);
            let report = chi2(&distribution, frame, &mut rng, |w| w);
            assert!(report.passes(level), "{name}, {strata} × {strata}, normals {normals}: {report}");
            assert!((report.mass - 1.0).abs() < 1e-3, "{name}: {report}");
            // the same density, turned by a few degrees about an axis in the horizon
            let turned = Frame::from_normal(Vec3::new(0.12, 0.05, 0.99).normalize());
            let wrong = chi2(&distribution, frame, &mut rng, |w| turned.to_world(w));
            assert!(!wrong.passes(1e-6), "{name}, {strata} × {strata}: turned, and unseen: {wrong}");
        }
    }
    println!("{} rows follow their density; turned, none does", cases.len() * ROWS.len());
}

#[test]
fn directions_lie_above_the_plane_of_the_state() {
    let mut rng = Rng::new(2);
    for _ in 0..50 {
        let mut guide = guide(|_| ());
        let n = unit(&mut rng);
        let key = state(&guide, point(&mut rng), n);
        teach(&mut guide, key, &[1.0; 144], 1);
        guide.end_iteration();
        let distribution = guide.field().distribution(key).expect("144 visits are enough");
        let frame = guide.field().grid().frame(key);
        // bins of normals reach 27° from their centre, in the corners of the cube
        assert!(frame.n.dot(n) > 0.89, "{} for {n}", frame.n);
        for _ in 0..200 {
            let w = distribution.sample(rng.f32(), rng.f32x2());
            assert!(w.is_normalized() && w.dot(frame.n) > -1e-6 && distribution.pdf(w).is_finite());
        }
        assert_eq!(distribution.pdf(-frame.n), 0.0);
    }
}

#[test]
fn what_is_drawn_goes_by_radiance_times_cosine() {
    let mut guide = guide(|s| s.strata = 4);
    let key = state(&guide, Vec3::splat(0.5), Vec3::Y);
    let mut values = [1.0f32; 16];
    values[5] = 3.0;
    teach(&mut guide, key, &values, 1000);
    guide.end_iteration();
    let field = guide.field();
    let distribution = field.distribution(key).expect("enough visits");
    let strata = Strata::new(4);
    let total: f32 = values.iter().zip(strata.cosines()).map(|(q, cos)| q * cos).sum();
    for (action, value) in values.iter().enumerate() {
        let w = field.grid().frame(key).to_world(strata.direction(action, [0.5; 2]));
        assert_eq!(field.action(key, w), Some(action));
        let expected = value * strata.cosines()[action] / (total * strata.solid_angle());
        // a thousand visits leave a thousandth of a lean towards the state's mean
        let pdf = distribution.pdf(w);
        assert!((pdf / expected - 1.0).abs() < 3e-3, "action {action}: {pdf}, not {expected}");
    }
    let irradiance = total * strata.solid_angle();
    assert!((distribution.irradiance / irradiance - 1.0).abs() < 1e-3);
}
