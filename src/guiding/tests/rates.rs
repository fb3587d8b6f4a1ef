//! How much a visit changes: what each rate makes of targets that stay, and of targets that depend on the table.

use super::*;

const RATES: [Rate; 3] = [Rate::Forgetting(0.5), Rate::Vanishing, Rate::Constant(0.1)];

/// A guide of one stratum, and the state that is visited.
fn one_value(rate: Rate) -> (Guide, RegionId) {
    let guide = guide(|s| (s.strata, s.rate) = (1, rate));
    let key = state(&guide, Vec3::splat(0.3), Vec3::X);
    (guide, key)
}

fn find(guide: &mut Guide, key: RegionId, targets: impl Iterator<Item = f32>) {
    learn(guide, targets.map(|target| visit(key, Vec3::X, Vec3::X, target)));
}

#[test]
fn noisy_targets_converge_to_their_mean() {
    let mut rng = Rng::new(3);
    for rate in RATES {
        let (mut guide, key) = one_value(rate);
        let mut visits = 0;
        for round in 0..8 {
            // exponential with mean 7, the standard deviation of which is 7 as well
            let n = 64 << round;
            find(&mut guide, key, (0..n).map(|_| -7.0 * (1.0 - rng.f32()).ln()));
            visits += n;
            guide.end_iteration(1);
        }
        // the sum of the squares of the targets' weights
        let squares: f32 = match rate {
            Rate::Vanishing => 1.0 / visits as f32,
            Rate::Constant(alpha) => alpha / (2.0 - alpha),
            // round r has the weight n·2^(r − 7) of 64·(2⁷ + 2⁵ + …): 4^r over the sum of these
            Rate::Forgetting(_) => {
                let weight = |r: i32| 0.5f32.powi(7 - r);
                let whole: f32 = (0..8).map(|r| (64 << r) as f32 * weight(r)).sum();
                (0..8).map(|r| (64 << r) as f32 * weight(r).powi(2)).sum::<f32>() / (whole * whole)
            }
        };
        let q = row(&guide, key)[0].q;
        println!("{rate:?}: mean of {visits} noisy targets {q:.3} ± {:.3}, their expectation: 7", 7.0 * squares.sqrt());
        // five standard errors: false alarm 6·10⁻⁷ each; the constant rate's error has the exponential's tail, 10⁻⁴
        assert!((q - 7.0).abs() < 5.0 * 7.0 * squares.sqrt(), "{rate:?}: {q}");
        // and no more is claimed than is so: visits are those that still count when learning goes on
        guide.learn(&[]);
        let kept = row(&guide, key)[0].visits;
        let expected = match rate {
            Rate::Forgetting(_) => (0..8).map(|r| (64 << r) as f32 * 0.5f32.powi(8 - r)).sum(),
            _ => visits as f32,
        };
        assert_eq!(kept, expected, "{rate:?}");
    }
}

#[test]
fn an_iteration_keeps_the_share_of_visits_that_is_retained() {
    for retain in [0.0f32, 0.25, 0.5, 1.0] {
        let (mut guide, key) = one_value(Rate::Forgetting(retain));
        find(&mut guide, key, [8.0; 32].into_iter());
        guide.end_iteration(1);
        guide.learn(&[]);
        let kept = row(&guide, key)[0];
        assert_eq!((kept.q, kept.visits), (8.0, 32.0 * retain), "the value stays, its weight fades");
        assert_eq!(guide.field().len(), 1, "the snapshot was taken before");
        find(&mut guide, key, [2.0; 8].into_iter());
        let q = row(&guide, key)[0].q;
        let expected = (8.0 * 32.0 * retain + 2.0 * 8.0) / (32.0 * retain + 8.0);
        assert!((q - expected).abs() < 1e-5, "retain {retain}: {q}, not {expected}");
    }
}

#[test]
fn the_constant_rate_is_a_moving_average() {
    let (mut guide, key) = one_value(Rate::Constant(0.25));
    find(&mut guide, key, [8.0, 4.0, 0.0].into_iter());
    // the first visit has nothing to keep: 8, then 8 − 1, then 7 · 3/4
    assert_eq!(row(&guide, key)[0].q, 5.25);
    guide.end_iteration(1);
    find(&mut guide, key, [5.25, 9.25].into_iter());
    assert_eq!(row(&guide, key)[0].q, 6.25);
}

/// Errors |Q − 5|/5 of a chain that goes on for ever with albedo 0.8: what arrives is 1 + 0.8·Q, Q being the snapshot's
/// (nothing, at first). Iterations double, as the renderer's do.
fn chain(rate: Rate) -> Vec<f32> {
    let (mut guide, key) = one_value(rate);
    (0..12)
        .map(|round| {
            let known = guide.field().summary(key).map_or(0.0, |s| s.irradiance * std::f32::consts::FRAC_1_PI);
            find(&mut guide, key, (0..16 << round).map(|_| 1.0 + 0.8 * known));
            guide.end_iteration(1);
            (row(&guide, key)[0].q - 5.0).abs() / 5.0
        })
        .collect()
}

#[test]
fn early_errors_are_forgotten() {
    let [forgetting, vanishing, constant] = RATES.map(chain);
    println!("{:>8} {:>10} {:>10} {:>10}", "visits", "forgetting", "vanishing", "constant");
    for k in 0..forgetting.len() {
        println!("{:8} {:10.4} {:10.4} {:10.4}", (32 << k) - 16, forgetting[k], vanishing[k], constant[k]);
    }
    // an iteration's own visits have half of the weight at the vanishing rate, three quarters where half is forgotten,
    // and all at a constant rate: errors fall by 1 − 0.2·share in each
    let fall = |errors: &[f32]| errors[11] / errors[10];
    for (errors, share) in [(&vanishing, 0.5), (&forgetting, 0.75), (&constant, 1.0)] {
        assert!((fall(errors) - (1.0 - 0.2 * share)).abs() < 0.003, "{}, not {}", fall(errors), 1.0 - 0.2 * share);
    }
    assert!(forgetting[11] < 0.6 * vanishing[11] && constant[11] < forgetting[11]);
}

/// A target that drifts by one per iteration: how far behind it each rate is.
#[test]
fn a_drifting_target_is_followed() {
    let lag = RATES.map(|rate| {
        let (mut guide, key) = one_value(rate);
        for round in 0..10 {
            find(&mut guide, key, (0..16 << round).map(|_| round as f32));
            guide.end_iteration(1);
        }
        9.0 - row(&guide, key)[0].q
    });
    println!("behind a target that drifts by one per iteration: {lag:?}");
    // rounds weigh 4^r, 2^r and the last alone: the sums over k of k/4^k, of k/2^k
    let expected = [0.75 * (4.0 / 9.0), 1.0, 0.0];
    assert!(lag.iter().zip(expected).all(|(lag, expected)| (lag - expected).abs() < 0.02), "{lag:?}");
}
