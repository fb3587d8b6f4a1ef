//! The order of runs, and going through it.

use super::plan::Plan;
use super::record::Run;
use super::store::Store;
use crate::Result;

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
    /// Makes ready what a scene's runs are measured against; `false` where it was told to stop.
    fn prepare(&mut self, scene: usize, store: &mut Store) -> Result<bool>;

    /// `None` where it was told to stop before the end.
    fn run(&mut self, slot: &Slot) -> Result<Option<Run>>;
}

/// Watches runs come in.
pub(crate) trait Watcher {
    /// `done` of `all` runs are over; the last of them is `run`.
    fn after(&mut self, run: &Run, done: usize, all: usize);
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
    let mut prepared = None;
    for slot in &slots {
        if store.find(plan, slot).is_some() {
            continue;
        }
        if prepared != Some(slot.scene) {
            if !studio.prepare(slot.scene, store)? {
                return Ok(false);
            }
            prepared = Some(slot.scene);
        }
        let Some(run) = studio.run(slot)? else { return Ok(false) };
        done += 1;
        watcher.after(&run, done, slots.len());
        store.add(run)?;
    }
    Ok(true)
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
