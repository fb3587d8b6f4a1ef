//! How long a comparison takes: said before it begins, and again after each run.

use super::plan::{Budget, Plan};
use super::record::Run;
use super::schedule::Slot;
use rustc_hash::FxHashMap;

/// What runs have taken so far, by scene, method and budget.
#[derive(Default)]
pub(crate) struct Forecast {
    known: FxHashMap<(usize, usize, usize), Total>,
    /// By pilot runs: wall seconds for a sample per pixel.
    pace: FxHashMap<(usize, usize), f64>,
    /// Seconds on the clock over those of the renders alone: pictures are measured and written too.
    elapsed: Total,
    rendered: f64,
}

#[derive(Clone, Copy, Default)]
struct Total {
    seconds: f64,
    runs: f64,
}

impl Forecast {
    /// Takes down a run, and where it was made just now, what it took on the clock.
    pub(crate) fn add(&mut self, slot: &Slot, run: &Run, elapsed: Option<f64>) {
        let total = self.known.entry((slot.scene, slot.method, slot.budget)).or_default();
        (total.seconds, total.runs) = (total.seconds + run.wall_seconds, total.runs + 1.0);
        if let Some(elapsed) = elapsed {
            self.elapsed.seconds += elapsed;
            self.rendered += run.wall_seconds;
        }
    }

    /// Takes down how fast a method is on a scene.
    pub(crate) fn set_pace(&mut self, scene: usize, method: usize, seconds: f64) {
        self.pace.insert((scene, method), seconds);
    }

    /// Seconds that these runs will take; `None` where nothing is known of one of them.
    pub(crate) fn of(&self, plan: &Plan, slots: &[Slot]) -> Option<f64> {
        let more = if self.rendered > 0.0 { self.elapsed.seconds / self.rendered } else { 1.0 };
        slots.iter().map(|slot| self.expected(plan, slot)).sum::<Option<f64>>().map(|seconds| more * seconds)
    }

    fn expected(&self, plan: &Plan, slot: &Slot) -> Option<f64> {
        if let Some(total) = self.known.get(&(slot.scene, slot.method, slot.budget)) {
            return Some(total.seconds / total.runs);
        }
        match plan.budgets[slot.budget] {
            Budget::Seconds(seconds) => Some(seconds),
            Budget::Samples(spp) => self.pace.get(&(slot.scene, slot.method)).map(|pace| pace * f64::from(spp)),
        }
    }
}

/// A length of time as people say it.
pub(crate) fn said(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::compare::fixtures;
    use crate::lab::compare::schedule::order;

    #[test]
    fn seconds_are_as_planned_until_runs_tell() {
        let plan = fixtures::plan();
        let (slots, mut forecast) = (order(&plan), Forecast::default());
        // two scenes, two methods, three runs of 2 s and of 4 s
        assert_eq!(forecast.of(&plan, &slots), Some(72.0));
        // measured and written, a run takes a quarter longer
        let run = fixtures::run(&plan, &slots[0]);
        forecast.add(&slots[0], &run, Some(1.25 * run.wall_seconds));
        assert_eq!(forecast.of(&plan, &slots), Some(90.0));
    }

    #[test]
    fn samples_need_a_pilot() {
        let mut plan = fixtures::plan();
        plan.budgets = vec![Budget::Samples(16)];
        let (slots, mut forecast) = (order(&plan), Forecast::default());
        assert_eq!(forecast.of(&plan, &slots), None);
        for (scene, method) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            forecast.set_pace(scene, method, 0.5);
        }
        assert_eq!(forecast.of(&plan, &slots), Some(12.0 * 8.0));
        assert_eq!([20.4, 600.0, 7200.0].map(said), ["20 s", "10 min", "2.0 h"]);
    }
}
