use super::cost::{GUIDED_VERTEX_COST, SHADOW_RAY_COST, TRANSITION_COST};
use super::pilot::{MIN_BOUNCED_SHARE, MIN_BUDGET_PATHS, MIN_BUDGET_SAMPLES};
use super::*;
use crate::integrator::Counters;
use crate::io::clock::CpuTime;
use std::time::Duration;

const PIXELS: u64 = 40_000;

/// A grey picture of sixteen samples a pixel, whose samples have the given variance.
fn noise(variance: f64) -> Noise {
    Noise { squares: vec![1.0; PIXELS as usize], relative: vec![variance; PIXELS as usize], mean: 0.0, samples: 16 }
}

/// A million paths of so many rays and seconds of processor time each.
fn counters(rays: u64) -> Counters {
    const PATHS: u64 = 1_000_000;
    let cpu = CpuTime::from_seconds((rays * PATHS) as f64);
    Counters { paths: PATHS, rays: rays * PATHS, cpu, ..Counters::default() }
}

/// Sums over sixteen samples of bounced light, one of them x: their variance is x²/16.
fn bounced(variance: f64) -> Vec<[f32; 2]> {
    let x = (16.0 * variance).sqrt() as f32;
    vec![[x, x * x]; PIXELS as usize]
}

/// After a pilot of sixteen samples of 5 rays and the variance `variance`, of which `bounced_variance` is that of bounced light.
fn begun_of(bounced_variance: f64, variance: f64, budget: f64) -> Auto {
    let mut auto = Auto::new(true, PIXELS);
    assert!(plan(&auto).mode == Mode::Pilot && auto.verdict().is_none());
    auto.pilot.add_passes(auto.meter, &[counters(5)]);
    auto.end_pilot(&noise(variance), &bounced(bounced_variance), budget);
    auto
}

fn begun(bounced: f64, budget: f64) -> Auto {
    begun_of(bounced, 20.0, budget)
}

/// The next iteration after one of four samples, sixteen in all.
fn plan(auto: &Auto) -> Plan {
    auto.next_iteration(&History { samples: 16, planned: Some(4) })
}

/// So many independent samples of these variances.
fn independent(spreads: Vec<f64>, samples: u32) -> Varying {
    Varying { variances: spreads.clone(), spreads, samples }
}

/// The same of one variance everywhere.
fn alike(variance: f64, samples: u32) -> Varying {
    independent(vec![variance; PIXELS as usize], samples)
}

/// What a path of so much work costs.
fn cost(auto: &Auto, counters: &Counters) -> PathCost {
    auto.meter.of_path(counters, CpuTime::default())
}

/// After a first lesson, and trials of 2, 4, 8 … samples of such variances and rays.
fn tried(budget: f64, trials: &[(f64, u64)]) -> Auto {
    let mut auto = begun(10.0, budget);
    assert_eq!(plan(&auto), Plan { mode: Mode::Guided, samples: 1, continues: true, trains: false });
    auto.first_lesson(alike(20.0, 1), 17, cost(&auto, &counters(5)));
    assert_eq!(plan(&auto), Plan { mode: Mode::Guided, samples: 8, continues: false, trains: false });
    for (k, &(variance, rays)) in trials.iter().enumerate() {
        if auto.uses_guide() {
            auto.judge(&noise(20.0), &alike(variance, 2 << k), cost(&auto, &counters(rays)));
        }
    }
    auto
}

#[test]
fn light_that_did_not_bounce_asks_for_no_guide() {
    let reason = |bounced| begun(bounced, 1000.0).verdict().expect("it was measured").reason;
    let least = 20.0 * MIN_BOUNCED_SHARE;
    let calm = begun(0.9 * least, 1000.0);
    let verdict = calm.verdict().expect("it was measured");
    assert!(
        !calm.uses_guide() && !verdict.guided && verdict.trial.is_none() && (verdict.variance - 20.0).abs() < 1e-12
    );
    assert_eq!(plan(&calm), Plan { mode: Mode::Unguided, samples: LONGEST_ITERATION, continues: true, trains: false });
    assert_eq!((reason(0.9 * least), reason(1.1 * least)), (Reason::Calm, Reason::Promising), "of a variance of 20");
    let reason = |bounced| begun_of(bounced, 1.2 * bounced, 1000.0).verdict().expect("it was measured").reason;
    assert_eq!(
        [0.01, 0.7, 10.0].map(reason),
        [Reason::Promising; 3],
        "nearly all of it bounced, however little varies"
    );
}

#[test]
fn a_short_budget_is_not_spent_on_learning() {
    let pays = |budget| begun(10.0, budget).uses_guide();
    let least = MIN_BUDGET_SAMPLES.max(MIN_BUDGET_PATHS / PIXELS as f64);
    assert!(!pays(0.9 * least) && pays(1.1 * least));
}

#[test]
fn a_longer_budget_has_a_longer_pilot() {
    let taken = |samples, budget| {
        let mut auto = Auto::new(true, PIXELS);
        assert_eq!(auto.next_iteration(&History { samples: 0, planned: None }).samples, 2, "nothing is known yet");
        auto.pilot.add_passes(auto.meter, &[counters(5)]);
        auto.end_pilot(&Noise { samples, ..noise(20.0) }, &bounced(10.0), budget);
        let next = auto.next_iteration(&History { samples, planned: Some(samples) });
        (next.mode == Mode::Pilot).then_some(next.samples)
    };
    assert_eq!(taken(2, 60.0), None);
    assert_eq!(taken(2, 600.0), Some(10), "2 % of the budget");
    assert_eq!(taken(2, 1e6), Some(14), "as many as there can be use for");
    assert_eq!(taken(12, 600.0), None);
}

#[test]
fn a_picture_that_says_nothing_has_a_pilot_of_twice_the_length() {
    let auto = Auto::new(true, PIXELS);
    assert_eq!(plan(&auto), Plan { mode: Mode::Pilot, samples: 8, continues: true, trains: false });
}

#[test]
fn a_trial_that_loses_ends_before_it_has_cost_much_of_the_budget() {
    // a quarter of the efficiency: of 2 and 4 samples, 12 − 3 are lost at twice the cost and variance
    let auto = tried(100.0, &[(40.0, 10); 2]);
    let verdict = auto.verdict().expect("it was tried");
    assert_eq!((verdict.reason, verdict.guided), (Reason::Losing, false));
    assert!((verdict.lost - 9.0).abs() < 1e-9, "{} lost", verdict.lost);
    let trial = verdict.trial.expect("it was tried");
    assert!((trial.variance_ratio - 2.0).abs() < 1e-12 && trial.cost_ratio == 2.0);
    assert!((trial.gain() - 0.25).abs() < 1e-12);
    assert_eq!(plan(&auto), Plan { mode: Mode::Unguided, samples: LONGEST_ITERATION, continues: false, trains: false });
    // where the budget is long the same is a small part of it; but a larger part is never lost
    let losing = [(40.0, 10); 24];
    assert!(tried(1e6, &losing[..2]).uses_guide());
    let lost = tried(1e6, &losing).verdict().filter(|verdict| !verdict.guided).map(|verdict| verdict.lost);
    let most = LOSS_SHARE * 1e6;
    assert!(lost.is_some_and(|lost| (most / 4.0..most).contains(&lost)), "{lost:?}");
    // what costs as much and gets better stays
    assert!(tried(1e6, &[(40.0, 10), (30.0, 10), (22.0, 10), (16.0, 10), (11.0, 10), (8.0, 10)]).uses_guide());
}

#[test]
fn a_guide_that_wins_or_is_about_to_stays() {
    for budget in [50.0, 1e3, 1e6] {
        assert!(tried(budget, &[(12.0, 10), (4.0, 10), (4.0, 10), (4.0, 10), (4.0, 10)]).uses_guide(), "{budget}");
    }
    assert!(tried(100.0, &[(60.0, 10)]).uses_guide(), "a first trial says little, where there is time for another");
    // before the last, one at little less than the unguided efficiency may lose a little, and a bad one may not
    assert!(tried(60.0, &[(12.4, 10); 2]).uses_guide() && !tried(60.0, &[(30.0, 10); 2]).uses_guide());
}

#[test]
fn the_last_and_longest_iteration_is_for_a_guide_that_wins() {
    // three quarters of the efficiency in the end: cheap as a trial, but not for the 60 samples that then are left
    let trials = |last| [(14.0, 10), (12.4, 10), (11.1, 10), (last, 10)];
    assert!(!tried(200.0, &trials(13.0)).uses_guide() && tried(200.0, &trials(9.5)).uses_guide());
    assert!(tried(1e4, &trials(13.0)).uses_guide(), "there is time to learn more");
}

#[test]
fn a_guide_has_the_benefit_of_the_doubt_where_few_pixels_say_how_samples_vary() {
    let stays = |every: usize| {
        // 20 on average without outliers, all of it in one of so many pixels
        let kept = PIXELS as f64 * 0.999;
        let bright = 20.0 * kept / (PIXELS as f64 / every as f64 - (PIXELS as f64 - kept));
        let unguided = (0..PIXELS as usize).map(|i| if i % every == 0 { bright } else { 0.0 }).collect();
        let mut auto = begun(10.0, 60.0);
        auto.first_lesson(independent(unguided, 2), 1, cost(&auto, &counters(5)));
        for samples in [2, 4] {
            auto.judge(&noise(20.0), &alike(13.0, samples), cost(&auto, &counters(10)));
        }
        auto.uses_guide()
    };
    assert!(!stays(1) && !stays(5) && stays(100), "the same trials, with a standard error of 0, 1 and 5 %");
}

#[test]
fn a_few_pixels_have_no_say() {
    // one pixel in a thousand varies so much that it would be all that is seen; of two, one is
    let gain = |every: usize| {
        let mut auto = begun(10.0, 1e4);
        let guided = (0..PIXELS as usize).map(|i| if i % every == 0 { 1e9 } else { 20.0 }).collect::<Vec<_>>();
        auto.first_lesson(alike(20.0, 1), 17, cost(&auto, &counters(5)));
        auto.judge(&noise(20.0), &independent(guided, 2), cost(&auto, &counters(5)));
        auto.verdict().and_then(|verdict| verdict.trial).expect("it was tried").gain()
    };
    assert!((gain(1000) - 1.0).abs() < 1e-9 && gain(500) < 1e-3, "{} and {}", gain(1000), gain(500));
}

#[test]
fn cost_is_counted_or_processor_time_without_that_of_recording() {
    let judged = |by_clock, guided: &Counters| {
        let mut auto = Auto::new(by_clock, PIXELS);
        // the first of several passes only warms caches
        auto.pilot.add_passes(auto.meter, &[counters(9), counters(2)]);
        auto.end_pilot(&noise(20.0), &vec![[12.0, 144.0]; PIXELS as usize], 1e3);
        auto.first_lesson(alike(20.0, 2), 5, cost(&auto, &counters(2)));
        auto.judge(&noise(20.0), &alike(20.0, 4), cost(&auto, guided));
        let verdict = auto.verdict().expect("it was tried");
        (verdict.trial.expect("it was tried").cost_ratio, verdict.lost)
    };
    let paths = counters(0).paths;
    let guided = Counters {
        shadow_rays: 2 * paths,
        guide_hits: paths,
        transitions: paths,
        recording_cpu: CpuTime::from_seconds(paths as f64),
        // three threads shared a processor with other programs
        wall: Duration::from_secs(9 * paths),
        ..counters(3)
    };
    let (counted, lost) = judged(false, &guided);
    assert!((counted - (3.0 + 2.0 * SHADOW_RAY_COST + GUIDED_VERTEX_COST) / 2.0).abs() < 1e-12);
    assert!((lost - 4.0 * (counted + TRANSITION_COST / 2.0 - 1.0)).abs() < 1e-9, "learning is part of the loss");
    let (clocked, lost) = judged(true, &guided);
    assert!((clocked - 1.0).abs() < 1e-12 && (lost - 2.0).abs() < 1e-9, "{clocked}, {lost}");
}

#[test]
fn fewer_samples_that_are_spread_evenly_are_worth_less() {
    // a third of the variance at twice the cost: 1.5 times the samples where they are independent
    let gain = |evenness: f64| {
        let samples = 16;
        let mut auto = begun(10.0, 1e4);
        auto.first_lesson(alike(20.0, 1), 17, cost(&auto, &counters(5)));
        let told = ((1.0 + evenness).exp2() - 1.0) * f64::from(samples).powf(-evenness);
        let variances = vec![20.0 / 3.0 * told; PIXELS as usize];
        let guided = Varying { variances, ..alike(20.0 / 3.0, samples) };
        auto.judge(&noise(20.0), &guided, cost(&auto, &counters(10)));
        let verdict = auto.verdict().expect("it was measured");
        // as many as 48 independent ones, for the cost of 32; in so small a group they are less even than ten thousand
        let worth = 48.0 * (16.0 / 1e4f64).powf(evenness);
        assert!((verdict.lost - (32.0 - worth)).abs() < 1e-6, "{} lost", verdict.lost);
        verdict.trial.expect("it was tried").gain()
    };
    assert!((gain(0.0) - 1.5).abs() < 1e-6);
    // n unguided and n/2 guided samples have means of the same variance, 3 · 2^−(1 + e) = 1, where e = log₂ 3 − 1
    assert!((gain(3f64.log2() - 1.0) - 1.0).abs() < 1e-6);
    assert!(gain(0.9) < 1.0);
}
