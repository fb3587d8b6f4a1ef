//! Where states of an adaptive grid are cut: visits must be many enough to fill the parts, neighbours must differ, and
//! there must be room.

use super::learner::Learner;
use super::recorder::shard_of;
use crate::guiding::directional::hemitree::FAN;
use crate::guiding::spatial::{Adaptive, StateKey};
use crate::guiding::store::{ReturnMoments, Shard, State};
use rayon::prelude::*;

/// What it takes to cut a cell.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Visits in an iteration, for each state of the cell.
    pub visits: f32,
    /// Relative deviation of neighbouring states' irradiance, direction by direction.
    pub difference: f32,
}

/// Sums over the states of a coarse cell.
#[derive(Clone, Copy, Default)]
struct Cell {
    states: f32,
    visits: f32,
    difference: f32,
    pairs: f32,
    bytes: usize,
}

/// Share of the memory up to which cells are cut: the rest is for trees to grow, and for states yet to be met.
const CELLS_SHARE: f64 = 0.5;

/// Cuts coarse cells where it pays; the parts begin with what the whole knew. States that inherited and were not met
/// in the whole iteration since are dropped; those that were once met stay, as another camera's may have been.
pub fn refine(adaptive: &mut Adaptive, learner: &mut Learner, limits: Limits) {
    learner.replace(|state| (!state.met).then(Vec::new));
    let cells = survey(adaptive, learner);
    let pays = |cell: &Cell| {
        let differs = cell.pairs == 0.0 || cell.difference > limits.difference * cell.pairs;
        cell.visits > limits.visits * cell.states && differs
    };
    let mut paying: Vec<(usize, &Cell)> = cells.iter().enumerate().filter(|(_, cell)| pays(cell)).collect();
    // where there is not room for all, the most visited states come first
    paying.sort_by(|(_, a), (_, b)| (b.visits / b.states).total_cmp(&(a.visits / a.states)));
    let mut room = (learner.memory() as f64 * CELLS_SHARE) as usize;
    room = room.saturating_sub(learner.bytes());
    for (coarse, cell) in paying {
        let growth = 7 * cell.bytes;
        if growth <= room && adaptive.refine(coarse) {
            room -= growth;
        }
    }
    let adaptive = &*adaptive;
    learner.replace(|state| (!adaptive.current(state.key)).then(|| parts(state)));
}

fn survey(adaptive: &Adaptive, learner: &Learner) -> Vec<Cell> {
    let mut cells = vec![Cell::default(); adaptive.coarse_cells()];
    for (state, differences) in learner.states().zip(differences(learner)).filter(|(state, _)| state.fresh > 0.0) {
        let cell = &mut cells[adaptive.coarse_of(state.key)];
        cell.states += 1.0;
        cell.visits += state.fresh;
        cell.bytes += state.bytes();
        for difference in differences.into_iter().flatten() {
            cell.difference += difference;
            cell.pairs += 1.0;
        }
    }
    cells
}

/// How much the states beyond the six faces differ from each state, where both are known; in the order of the states.
fn differences(learner: &Learner) -> impl Iterator<Item = [Option<f32>; 6]> {
    let of_shard = |shard: &Shard| shard.states().iter().map(|state| profile(learner, state)).collect();
    let profiles: Vec<Vec<[f32; FAN]>> = learner.shards().par_iter().map(of_shard).collect();
    let known = |key: StateKey| {
        let shard = shard_of(key);
        learner.shards()[shard].row(key).map(|row| &profiles[shard][row as usize])
    };
    let of_state = |state: &State| {
        let mut differences = [None; 6];
        if let Some(own) = known(state.key).filter(|_| state.fresh > 0.0) {
            let others = state.key.neighbours().filter_map(known);
            differences.iter_mut().zip(others).for_each(|(found, other)| *found = difference(own, other));
        }
        differences
    };
    let of_shard = |shard: &Shard| shard.states().iter().map(of_state).collect();
    let all: Vec<Vec<_>> = learner.shards().par_iter().map(of_shard).collect();
    all.into_iter().flatten()
}

/// Relative; `None` where both are dark.
fn difference(a: &[f32; FAN], b: &[f32; FAN]) -> Option<f32> {
    let (difference, sum) = a.iter().zip(b).fold((0.0, 0.0), |(d, s), (a, b)| (d + (a - b).abs(), s + a + b));
    (sum > 0.0).then_some(difference / sum)
}

/// Coarse shares of a state's irradiance.
fn profile(learner: &Learner, state: &State) -> [f32; FAN] {
    learner.table.profile(&state.actions)
}

/// The eight parts of a state, each with its share of the visits.
fn parts(state: &State) -> Vec<State> {
    /// On a surface, a cell's part has about a quarter of its points.
    const SHARE: f32 = 0.25;
    let part = |key: StateKey| {
        let mut part = State { key, visits: state.visits * SHARE, fresh: 0.0, met: false, ..state.clone() };
        part.returns = ReturnMoments { weight: part.returns.weight * SHARE, ..part.returns };
        part.entries_mut().iter_mut().for_each(|entry| entry.visits *= SHARE);
        part
    };
    state.key.parts().map(part).collect()
}
