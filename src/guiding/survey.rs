//! How large a guide is, and how well known.

use super::Guide;
use super::qtable::{Actions, State};
use serde::Serialize;

/// Figures over all states of a guide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Survey {
    pub states: usize,
    /// Of a state, its part of the snapshot included.
    pub mean_bytes: f64,
    pub min_bytes: usize,
    pub max_bytes: usize,
    /// Bytes of the whole guide.
    pub bytes: usize,
    /// Nodes of all trees of directions; 0 where there are none.
    pub tree_nodes: usize,
    /// Share of the states without a visit in the last iteration that learnt, those included that its end cut from larger
    /// ones.
    pub not_met_share: f64,
    /// Share of the states of which too little is known to draw from.
    pub unusable_share: f64,
    /// States by the weight of their visits.
    pub visits: Vec<Decade>,
}

/// States with at least `from` visits and fewer than `to`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decade {
    pub from: f64,
    pub to: f64,
    pub states: usize,
}

impl Guide {
    pub fn survey(&self) -> Survey {
        let states: Vec<&State> = self.learner.states().collect();
        let count = |holds: &dyn Fn(&State) -> bool| states.iter().filter(|state| holds(state)).count();
        let share = |n: usize| if states.is_empty() { 0.0 } else { n as f64 / states.len() as f64 };
        let sizes = || states.iter().map(|state| state.bytes());
        Survey {
            states: states.len(),
            mean_bytes: if states.is_empty() { 0.0 } else { sizes().sum::<usize>() as f64 / states.len() as f64 },
            min_bytes: sizes().min().unwrap_or(0),
            max_bytes: sizes().max().unwrap_or(0),
            bytes: self.bytes(),
            tree_nodes: states.iter().map(|state| nodes(state)).sum(),
            not_met_share: share(count(&|state| state.fresh == 0.0)),
            unusable_share: share(count(&|state| self.field.summary(state.key).is_none())),
            visits: decades(states.iter().map(|state| state.visits)),
        }
    }
}

fn nodes(state: &State) -> usize {
    match &state.actions {
        Actions::Strata(_) => 0,
        Actions::Tree(cells) => cells.nodes(),
    }
}

/// From 0 to 1, to 10, to 100 … as far as there are any.
fn decades(visits: impl Iterator<Item = f32>) -> Vec<Decade> {
    let mut counts: Vec<usize> = Vec::new();
    for visits in visits {
        let decade = if visits < 1.0 { 0 } else { visits.log10().floor() as usize + 1 };
        counts.resize(counts.len().max(decade + 1), 0);
        counts[decade] += 1;
    }
    let bound = |k: i32| if k < 0 { 0.0 } else { 10f64.powi(k) };
    let decade = |(k, &states): (usize, &usize)| Decade { from: bound(k as i32 - 1), to: bound(k as i32), states };
    counts.iter().enumerate().map(decade).collect()
}
