//! The order of runs, and going through it.

use super::forecast::Forecast;
use super::plan::Plan;
use super::record::Run;
use super::store::Store;
use crate::Result;
use std::time::Instant;

/// A run that is to be made; indices into the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    pub(crate) scene: usize,
    pub(crate) method: usize,
    pub(crate) budget: usize,
    /// From 0.
    pub(crate) run: u32,
    /// No two runs on a scene share one, for what is drawn from equal numbers is not independent.
    pub(crate) seed: u64,
}

/// Makes runs: renders and measures, or pretends to.
pub(crate) trait Executor {
    /// Sees that there is a reference for a scene's runs that is good enough, before any run on any scene; `false` where it was
    /// told to stop.
    fn reference(&mut self, scene: usize, store: &mut Store) -> Result<bool>;

    /// Wall seconds for a sample per pixel, where that was found out before the runs.
    fn pace(&self, scene: usize, method: usize) -> Option<f64>;

    /// Makes ready what a scene's runs are measured against; `false` where it was told to stop.
    fn prepare(&mut self, scene: usize, store: &mut Store) -> Result<bool>;

    /// `None` where it was told to stop before the end.
    fn run(&mut self, slot: &Slot) -> Result<Option<Run>>;
}

/// Watches runs come in.
pub(crate) trait Watcher {
    /// All references are there, and `all` runs are to be made, which take so many seconds, where that can be told.
    fn before(&mut self, all: usize, seconds: Option<f64>);

    /// `done` of `all` runs are over; the last of them is `run`, and what is left takes so many seconds, where that can be
    /// told.
    fn after(&mut self, run: &Run, done: usize, all: usize, seconds: Option<f64>);
}

/// All runs of a plan. On a scene methods take turns, A B C A B C, budget after budget and then seed after seed, so that
/// a machine that grows hot or busy does not favour one of them. Where a plan is given more runs, they follow those it had.
pub(crate) fn order(plan: &Plan) -> Vec<Slot> {
    let mut slots = Vec::new();
    for scene in 0..plan.scenes.len() {
        let mut seed = plan.seed;
        for run in 0..plan.runs {
            for budget in 0..plan.budgets.len() {
                for method in 0..plan.methods.len() {
                    slots.push(Slot { scene, method, budget, run, seed });
                    seed += 1;
                }
            }
        }
    }
    slots
}

/// Makes all runs that `store` does not hold yet and adds each to it when it is done. Returns whether all are there
/// (else it was told to stop).
///
/// # Errors
/// What the studio and the store return; what was done until then is in the store.
pub(crate) fn carry_out(
    plan: &Plan,
    store: &mut Store,
    studio: &mut dyn Executor,
    watcher: &mut dyn Watcher,
) -> Result<bool> {
    let slots = order(plan);
    let mut done = slots.iter().filter(|slot| store.find(plan, slot).is_some()).count();
    let mut forecast = known(plan, store, &slots);
    let missing: Vec<Slot> = slots.iter().copied().filter(|slot| store.find(plan, slot).is_none()).collect();
    for scene in 0..plan.scenes.len() {
        if missing.iter().any(|slot| slot.scene == scene) && !studio.reference(scene, store)? {
            return Ok(false);
        }
        for method in 0..plan.methods.len() {
            studio.pace(scene, method).into_iter().for_each(|pace| forecast.set_pace(scene, method, pace));
        }
    }
    if !missing.is_empty() {
        watcher.before(missing.len(), forecast.of(plan, &missing));
    }
    let mut prepared = None;
    for (k, slot) in missing.iter().enumerate() {
        if prepared != Some(slot.scene) {
            if !studio.prepare(slot.scene, store)? {
                return Ok(false);
            }
            prepared = Some(slot.scene);
        }
        let begun = Instant::now();
        let Some(run) = studio.run(slot)? else { return Ok(false) };
        done += 1;
        forecast.add(slot, &run, Some(begun.elapsed().as_secs_f64()));
        watcher.after(&run, done, slots.len(), forecast.of(plan, &missing[k + 1..]));
        store.add(run)?;
    }
    Ok(true)
}

/// What the runs that are there tell of those that are not.
fn known(plan: &Plan, store: &Store, slots: &[Slot]) -> Forecast {
    let mut forecast = Forecast::default();
    for slot in slots {
        store.find(plan, slot).into_iter().for_each(|run| forecast.add(slot, run, None));
    }
    forecast
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
