use super::super::cost::{GUIDE_COST, LEARNING_COST, SHADOW_COST};
use super::*;
use std::time::Duration;

const PIXELS: u64 = 40_000;

/// A grey picture of sixteen samples a pixel, whose samples have the given variance.
fn noise(variance: f64) -> Noise {
    Noise { squares: vec![1.0; PIXELS as usize], relative: vec![variance; PIXELS as usize], floor: 0.0, samples: 16 }
}

/// A million paths of so many rays and seconds each.
fn counters(rays: u64) -> Counters {
    const PATHS: u64 = 1_000_000;
    Counters { paths: PATHS, rays: rays * PATHS, total: Duration::from_secs(rays * PATHS), ..Counters::default() }
}

/// After a yardstick of sixteen samples of 5 rays and the variance 20, of which `bounced` is that of bounced light.
fn begun_of(bounced: f64, variance: f64, budget: f64) -> Worth {
    let mut worth = Worth::new(true, PIXELS);
    assert!(worth.measures() && !worth.pays() && worth.verdict().is_none());
    // sixteen samples, one of them x: their variance is x²/16
    let x = (16.0 * bounced).sqrt() as f32;
    (0..PIXELS as usize).for_each(|pixel| worth.add_bounced(pixel, [x, x * x]));
    worth.add_pass(&Counters::default(), &counters(5));
    worth.begin(&noise(variance), budget);
    worth
}

fn begun(bounced: f64, budget: f64) -> Worth {
    begun_of(bounced, 20.0, budget)
}

fn rendered(counters: &Counters, samples: u32) -> Rendered<'_> {
    Rendered { samples, counters, learning: 0.0 }
}

/// After a first lesson, and trials of 2, 4, 8 … samples of such variances and rays.
fn tried(budget: f64, trials: &[(f64, u64)]) -> Worth {
    let mut worth = begun(10.0, budget);
    assert!(worth.pays() && worth.unguided());
    worth.learnt(vec![20.0; PIXELS as usize], 17, &rendered(&counters(5), 1));
    assert!(!worth.unguided());
    for (k, &(variance, rays)) in trials.iter().enumerate() {
        if worth.pays() {
            worth.judge(&noise(20.0), &vec![variance; PIXELS as usize], &rendered(&counters(rays), 2 << k));
        }
    }
    worth
}

#[test]
fn light_that_did_not_bounce_asks_for_no_guide() {
    let reason = |bounced| begun(bounced, 1000.0).verdict().expect("it was measured").reason;
    let least = 20.0 * LEAST_SHARE;
    let calm = begun(0.9 * least, 1000.0);
    let verdict = calm.verdict().expect("it was measured");
    assert!(!calm.pays() && !verdict.guided && verdict.trial.is_none() && (verdict.variance - 20.0).abs() < 1e-12);
    assert_eq!((reason(0.9 * least), reason(1.1 * least)), (Reason::Calm, Reason::Promising), "of a variance of 20");
    let reason = |bounced| begun_of(bounced, 1.2 * bounced, 1000.0).verdict().expect("it was measured").reason;
    assert_eq!((reason(0.9 * CALM), reason(1.1 * CALM)), (Reason::Calm, Reason::Promising), "nearly all of it bounced");
}

#[test]
fn a_short_budget_is_not_spent_on_learning() {
    let pays = |budget| begun(10.0, budget).pays();
    let least = LEAST_SAMPLES.max(LEAST_PATHS / PIXELS as f64);
    assert!(!pays(0.9 * least) && pays(1.1 * least));
}

#[test]
fn a_longer_budget_has_a_longer_yardstick() {
    let taken = |samples, budget| {
        let mut worth = Worth::new(true, PIXELS);
        worth.add_pass(&Counters::default(), &counters(5));
        assert_eq!((worth.more_samples(samples), worth.unlearnt()), (None, u32::MAX), "nothing is known of the budget");
        worth.begin(&Noise { samples, ..noise(20.0) }, budget);
        (worth.measures(), worth.more_samples(samples), worth.unlearnt())
    };
    assert_eq!(taken(2, 60.0), (false, None, 2));
    assert_eq!(taken(2, 600.0), (true, Some(10), u32::MAX), "2 % of the budget");
    assert_eq!(taken(2, 1e6), (true, Some(14), u32::MAX), "as many as there can be use for");
    assert_eq!(taken(12, 600.0), (false, None, 12));
}

#[test]
fn a_trial_that_loses_ends_before_it_has_cost_much_of_the_budget() {
    // a quarter of the efficiency: of 2 and 4 samples, 12 − 3 are lost at twice the cost and variance
    let worth = tried(100.0, &[(40.0, 10); 2]);
    let verdict = worth.verdict().expect("it was tried");
    assert_eq!((verdict.reason, verdict.guided), (Reason::Losing, false));
    assert!((verdict.lost - 9.0).abs() < 1e-9, "{} lost", verdict.lost);
    let trial = verdict.trial.expect("it was tried");
    assert!((trial.variance_ratio - 2.0).abs() < 1e-12 && trial.cost_ratio == 2.0);
    assert!((trial.gain() - 0.25).abs() < 1e-12);
    // where the budget is long the same is a small part of it; but patience has an end
    let losing = [(40.0, 10); 8];
    assert!(tried(1e6, &losing[..2]).pays());
    assert!(!tried(1e6, &losing[..=PATIENCE as usize]).pays());
    // what costs as much and gets better stays
    assert!(tried(1e6, &[(40.0, 10), (30.0, 10), (22.0, 10), (16.0, 10), (11.0, 10), (8.0, 10)]).pays());
}

#[test]
fn a_guide_that_wins_or_is_about_to_stays() {
    for budget in [50.0, 1e3, 1e6] {
        assert!(tried(budget, &[(12.0, 10), (4.0, 10), (4.0, 10), (4.0, 10), (4.0, 10)]).pays(), "{budget}");
    }
    assert!(tried(100.0, &[(60.0, 10)]).pays(), "a first trial says little, where there is time for another");
    // before the last, one at little less than the unguided efficiency has roulette still to gain, and a bad one not enough
    assert!(tried(40.0, &[(14.0, 10)]).pays() && !tried(40.0, &[(30.0, 10)]).pays());
}

#[test]
fn the_last_and_longest_iteration_is_for_a_guide_that_wins() {
    // five sixths of the efficiency in the end: cheap as a trial, but not for the 60 samples that then are left
    let trials = |last| [(14.0, 10), (12.4, 10), (11.1, 10), (last, 10)];
    assert!(!tried(200.0, &trials(12.0)).pays() && tried(200.0, &trials(9.5)).pays());
    assert!(tried(1e4, &trials(12.0)).pays(), "there is time to learn more");
}

#[test]
fn wild_light_may_cost_more_to_try() {
    let lost = |variance: f64| {
        let mut worth = begun(10.0, 60.0);
        worth.learnt(vec![variance; PIXELS as usize], 5, &rendered(&counters(5), 2));
        worth.judge(&noise(variance), &vec![1.1 * variance; PIXELS as usize], &rendered(&counters(10), 4));
        worth.pays()
    };
    assert!(!lost(20.0) && lost(400.0), "the same trial, of a variance that turned out to be so much larger");
}

#[test]
fn cost_is_counted_or_what_the_clock_says_without_what_was_recorded() {
    let cost = |clock, guided: &Counters| {
        let mut worth = Worth::new(clock, PIXELS);
        (0..PIXELS as usize).for_each(|pixel| worth.add_bounced(pixel, [12.0, 144.0]));
        // the first of several passes only warms caches
        let passes = [Counters::default(), counters(9), Counters::default(), counters(2)];
        worth.add_pass(&passes[0], &passes[1]);
        worth.add_pass(&passes[2], &passes[3]);
        worth.begin(&noise(20.0), 1e3);
        worth.learnt(vec![20.0; PIXELS as usize], 5, &rendered(&passes[3], 2));
        worth.judge(&noise(20.0), &vec![20.0; PIXELS as usize], &rendered(guided, 4));
        let verdict = worth.verdict().expect("it was tried");
        (verdict.trial.expect("it was tried").cost_ratio, verdict.lost)
    };
    let paths = counters(0).paths;
    let guided = Counters {
        shadow_rays: 2 * paths,
        guide_hits: paths,
        transitions: paths,
        recording: Duration::from_secs(paths),
        ..counters(3)
    };
    let (counted, lost) = cost(false, &guided);
    assert!((counted - (3.0 + 2.0 * SHADOW_COST + GUIDE_COST) / 2.0).abs() < 1e-12);
    assert!((lost - 4.0 * (counted + LEARNING_COST / 2.0 - 1.0)).abs() < 1e-9, "learning is part of the loss");
    let (clocked, lost) = cost(true, &guided);
    assert!((clocked - 1.0).abs() < 1e-12 && (lost - 2.0).abs() < 1e-9, "{clocked}, {lost}");
}

#[test]
fn a_guide_has_the_benefit_of_the_doubt_where_few_pixels_say_how_samples_vary() {
    let lost = |bright: usize| {
        let mut worth = begun(10.0, 60.0);
        // 20 on average, all of it in one of so many pixels
        let variances: Vec<f64> =
            (0..PIXELS as usize).map(|i| if i % bright == 0 { 20.0 * bright as f64 } else { 0.0 }).collect();
        worth.learnt(variances, 1, &rendered(&counters(5), 2));
        worth.judge(&noise(20.0), &vec![22.0; PIXELS as usize], &rendered(&counters(10), 4));
        worth.pays()
    };
    assert!(!lost(1) && !lost(5) && lost(1000), "the same trial, with a standard error of 0, 1 and 16 %");
}
