//! A plan and runs for tests.

use super::plan::{Budget, Draft, Plan, plain_scene};
use super::record::{Iteration, Run, RunErrors};
use super::schedule::Slot;
use std::path::Path;

/// Two scenes, two methods, two budgets, three runs.
pub(crate) fn plan() -> Plan {
    let draft = Draft {
        scenes: ["s0.toml", "s1.toml"].map(|path| plain_scene(Path::new(path))).to_vec(),
        methods: vec!["none".into(), "grid".into()],
        budgets: vec![Budget::Seconds(2.0), Budget::Seconds(4.0)],
        runs: Some(3),
        ..Draft::default()
    };
    draft.finish().unwrap()
}

/// A run with plausible figures: errors fall with the budget and with the method's index.
pub(crate) fn run(plan: &Plan, slot: &Slot) -> Run {
    let seconds = plan.budgets[slot.budget].amount();
    let relmse = (1.0 + 0.25 * f64::from(slot.run)) / (seconds * (1.0 + slot.method as f64));
    let guided = slot.method > 0;
    let iteration = |k: u32| Iteration {
        samples: 1 << k,
        wall_seconds: 0.25 * f64::from(k + 1),
        learn_wall_seconds: if guided { 0.125 } else { 0.0 },
        mean_path_length: 4.0 + f64::from(slot.run) + 0.5 * f64::from(k),
        zero_share: 0.5,
        guide_hit_share: if guided && k > 0 { 0.75 } else { 0.0 },
    };
    Run {
        scene: plan.scenes[slot.scene].name(),
        method: plan.methods[slot.method].name.clone(),
        budget: plan.budgets[slot.budget].name(),
        seed: slot.seed,
        samples: 64 * seconds as u32,
        wall_seconds: seconds,
        cpu_seconds: 2.0 * seconds,
        learn_wall_seconds: if guided { 0.25 } else { 0.0 },
        film_wall_seconds: 0.125,
        errors: RunErrors {
            mse: 0.5 * relmse,
            relmse,
            relmse_trimmed: 0.75 * relmse,
            mape: 0.25,
            smape: 0.25,
            flip: 0.125,
            worst_permille: 8.0,
        },
        mean: [0.5, 0.25, 0.125],
        non_finite: 0,
        broken_pixels: 0,
        negative_pixels: 0,
        rays: 4_000_000,
        shadow_rays: 2_000_000,
        paths: 1_000_000,
        mean_path_length: 4.0,
        zero_share: 0.5,
        guide_bytes: if guided { 1 << 20 } else { 0 },
        guide_states: if guided { 500 } else { 0 },
        peak_bytes: Some(1 << 28),
        iterations: (0..5).map(iteration).collect(),
        blocks: (0..64).map(|k| 1.0 + 0.015625 * ((k + slot.seed as usize) % 5) as f64).collect(),
    }
}
