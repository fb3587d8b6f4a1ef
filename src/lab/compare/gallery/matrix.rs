//! All cells of a gallery at its largest budget.

use super::checks::{Evidence, Finding, findings, largest_guide, worst_pixels};
use super::{Bounds, Colour, Gallery};
use crate::lab::compare::cell::{Cell, Ratio};
use crate::lab::compare::plan::Plan;
use crate::lab::compare::record::Run;
use crate::lab::compare::scene_cache::SceneCache;
use crate::lab::compare::schedule::order;
use crate::lab::compare::store::Store;
use crate::stats::sidak;
use serde::Serialize;

/// Scenes × methods.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Matrix {
    pub(crate) bounds: Bounds,
    pub(crate) budget: String,
    /// Cells that were tested for bias, and the p below which each is called biased.
    pub(crate) tested: usize,
    pub(crate) level: f64,
    pub(crate) cells: Vec<MatrixCell>,
}

/// A method on a scene.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MatrixCell {
    pub(crate) scene: String,
    pub(crate) method: String,
    /// The worst of all findings.
    pub(crate) colour: Colour,
    pub(crate) runs: usize,
    pub(crate) ratio: Ratio,
    pub(crate) relmse_median: Option<f64>,
    pub(crate) relmse_worst: Option<f64>,
    /// Share of the error in the worst 0.1 % of the pixels.
    pub(crate) firefly_share: Option<f64>,
    pub(crate) p: Option<f64>,
    /// Bytes of the largest guide of all runs, and what it may take.
    pub(crate) guide_bytes: u64,
    pub(crate) memory: u64,
    pub(crate) repeatable: Option<bool>,
    pub(crate) findings: Vec<Finding>,
    /// Of the worst run, beside the reference; within the comparison's folder.
    pub(crate) picture: Option<String>,
}

impl MatrixCell {
    /// What is red of it.
    pub(crate) fn failures(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.colour == Colour::Red)
    }
}

impl Matrix {
    /// Judges all cells that have runs.
    pub(crate) fn new(
        plan: &Plan,
        gallery: &Gallery,
        scene_cache: &SceneCache,
        store: &Store,
        cells: &[Cell],
    ) -> Matrix {
        let memory = |scene, method| scene_cache.with_method(scene, method).1.guiding.memory;
        Matrix::judged(plan, gallery, store, cells, &memory)
    }

    /// As [`Matrix::new`]; `memory` is what the guide of a scene's method may take.
    pub(super) fn judged(
        plan: &Plan,
        gallery: &Gallery,
        store: &Store,
        cells: &[Cell],
        memory: &dyn Fn(usize, usize) -> u64,
    ) -> Matrix {
        let budget = plan.budgets.last().map_or(String::new(), |budget| budget.name());
        let here: Vec<&Cell> = cells.iter().filter(|cell| cell.budget == budget).collect();
        let tested = here.iter().filter(|cell| cell.bias.p.is_some()).count();
        let bounds = gallery.bounds;
        let mut matrix = Matrix { bounds, budget, tested, level: sidak(bounds.alarm, tested), cells: Vec::new() };
        for (scene, runs) in by_cell(plan, store).iter().enumerate() {
            let name = plan.scenes[scene].name();
            let find = |method: usize| here.iter().find(|c| c.scene == name && c.method == plan.methods[method].name);
            let base = find(plan.baseline).map(|cell| (&runs[plan.baseline][..], *cell));
            for (method, own) in runs.iter().enumerate() {
                let Some(cell) = find(method) else { continue };
                let evidence = Evidence {
                    runs: own,
                    cell,
                    baseline: base.filter(|_| method != plan.baseline),
                    planned: plan.runs as usize,
                    memory: memory(scene, method),
                    repeatable: store.repeatable(&name, &cell.method, bounds.repeat),
                    level: matrix.level,
                    bounds: &bounds,
                };
                matrix.cells.push(judge(&evidence, gallery));
            }
        }
        matrix
    }

    pub(crate) fn find(&self, scene: &str, method: &str) -> Option<&MatrixCell> {
        self.cells.iter().find(|cell| cell.scene == scene && cell.method == method)
    }
}

/// The runs at the largest budget by scene and method.
fn by_cell<'a>(plan: &Plan, store: &'a Store) -> Vec<Vec<Vec<&'a Run>>> {
    let mut all = vec![vec![Vec::new(); plan.methods.len()]; plan.scenes.len()];
    for slot in order(plan).iter().filter(|slot| slot.budget + 1 == plan.budgets.len()) {
        all[slot.scene][slot.method].extend(store.find(plan, slot));
    }
    all
}

fn judge(e: &Evidence, gallery: &Gallery) -> MatrixCell {
    let (scene, method) = (e.cell.scene.clone(), e.cell.method.clone());
    let mut findings = findings(e);
    for finding in findings.iter_mut().filter(|f| f.colour == Colour::Red) {
        finding.why = gallery.why(&scene, &method, finding.check).map(str::to_owned);
    }
    MatrixCell {
        colour: findings.iter().map(|f| f.colour).max().unwrap_or(Colour::Amber),
        runs: e.runs.len(),
        ratio: e.cell.ratio,
        relmse_median: e.cell.relmse_median,
        relmse_worst: e.cell.relmse_worst,
        firefly_share: worst_pixels(e.runs).mean,
        p: e.cell.bias.p,
        guide_bytes: largest_guide(e.runs),
        memory: e.memory,
        repeatable: e.repeatable,
        findings,
        picture: None,
        scene,
        method,
    }
}
