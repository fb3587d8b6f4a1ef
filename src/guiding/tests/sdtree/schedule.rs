//! The SD-tree as the settings ask for it.

use super::*;
use crate::guiding::{Guide as FullGuide, Hue, RegionInfo, ShadowOutcome};

fn known_at(leaves: &FullGuide, p: Vec3) -> Option<&RegionInfo> {
    leaves.field().summary(leaves.field().locate(p, Vec3::Z, [0.5; 3])?.drawn)
}

/// `n` uniform directions; light comes from above, from the half of the cube with x > 0.5 twice as much.
fn record(leaves: &FullGuide, n: usize, rng: &mut Rng) -> Recorder {
    let mut recorder = Recorder::new();
    for _ in 0..n {
        let (p, w) = (Vec3::new(rng.f32(), rng.f32(), rng.f32()), square_to_uniform_sphere(rng.f32x2()));
        let light = if w.z < 0.0 { 0.0 } else { 1.0 + (p.x > 0.5) as u32 as f32 };
        let known = known_at(leaves, p);
        recorder.push(Transition {
            key: leaves
                .field()
                .locate(p, Vec3::Z, [rng.f32(), rng.f32(), rng.f32()])
                .expect("leaves are everywhere")
                .recorded,
            wi: PackedDirection::new(w),
            normal: PackedDirection::new(Vec3::Z),
            target: light,
            bootstrapped: light,
            pdf: UNIFORM_SPHERE_PDF,
            bsdf_pdf: UNIFORM_SPHERE_PDF,
            guide_pdf: known.map_or(-1.0, |summary| leaves.field().distribution(summary, Vec3::Z).pdf(w)),
            scattered: 1.0,
            hue: Hue::GREY,
            rays: 2,
            shadow: ShadowOutcome::NONE,
        });
    }
    recorder
}

fn trained(change: impl FnOnce(&mut GuidingSettings)) -> FullGuide {
    let mut settings = GuidingSettings { method: GuidingMethod::SdTree, ..GuidingSettings::default() };
    (settings.jitter, settings.leaf_samples) = (false, 4000.0);
    change(&mut settings);
    let mut leaves = FullGuide::new(&settings, (Vec3::ZERO, Vec3::ONE), std::iter::empty()).expect("there is a method");
    let mut rng = Rng::new(1);
    for _ in 0..3 {
        let recorders = [record(&leaves, 10_000, &mut rng), record(&leaves, 30_000, &mut rng)];
        leaves.learn(&recorders.iter().collect::<Vec<_>>());
        leaves.end_iteration(super::PICTURE);
    }
    leaves
}

#[test]
fn a_leaf_knows_what_arrives_in_it() {
    let leaves = trained(|_| ());
    assert!(leaves.states() > 8 && leaves.field().len() == leaves.states());
    for (x, light) in [(0.1, 1.0), (0.9, 2.0)] {
        let summary = known_at(&leaves, Vec3::new(x, 0.2, 0.3)).expect("all leaves are known");
        // six standard errors of the mean of 1250 samples that are as wide as their mean
        let tolerance = 0.17;
        let irradiance = std::f32::consts::PI * light / 2.0;
        assert!((summary.irradiance / irradiance - 1.0).abs() < tolerance, "{x}: {summary:?}");
        // the estimate is 4π·L for one half of the directions and 0 for the other
        let mean = 4.0 * std::f32::consts::PI * light / 2.0;
        let returns = leaves.store.get(summary.key).expect("it was frozen").returns;
        assert!((returns.mean / mean - 1.0).abs() < tolerance, "{x}: {returns:?}");
        assert!((returns.square / (2.0 * mean * mean) - 1.0).abs() < tolerance, "{x}: {returns:?}");
        assert_eq!(returns.rays, 2.0);
        let variance = returns.square - returns.mean * returns.mean;
        assert_eq!((summary.square, summary.variance), (returns.square / 2.0, variance / 2.0));
        let distribution = leaves.field().distribution(summary, Vec3::Z);
        let mut rng = Rng::new(2);
        let up = (0..1000).filter(|_| distribution.sample(0.0, rng.f32x2()).0.z > 0.0).count();
        // the filter spreads a little of the light over the horizon, and below it cells are large
        let down = distribution.pdf(-Vec3::Z);
        assert!(up > 900 && down < 0.2 * UNIFORM_SPHERE_PDF, "{x}: {up} of 1000 upwards");
    }
}

#[test]
fn the_share_of_the_bsdf_is_learnt_or_kept() {
    let share = |leaves: &FullGuide| known_at(leaves, Vec3::splat(0.3)).expect("known").bsdf_fraction;
    assert_eq!(share(&trained(|s| (s.learned_fraction, s.bsdf_fraction) = (Some(false), 0.3))), 0.3);
    // the BSDF wastes half of its directions, the guide none
    assert!(share(&trained(|_| ())) < 0.3);
}

#[test]
fn memory_bounds_the_leaves() {
    for memory in [10_000, 100_000] {
        let leaves = trained(|s| (s.memory, s.leaf_samples) = (memory, 10.0));
        assert!(leaves.bytes() as u64 <= memory, "{} bytes of {memory}", leaves.bytes());
        assert!(leaves.states() > 1);
    }
}
