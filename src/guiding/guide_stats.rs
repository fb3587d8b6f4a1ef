//! How large a guide is, and how well known.

use super::sdtree::LeafInfo;
use super::{Guide, Kind};
use crate::guiding::store::{Actions, State};
use serde::Serialize;

/// Figures over all states of a guide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuideStats {
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
    pub visits: Vec<HistogramBin>,
}

/// States with at least `from` visits and fewer than `to`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistogramBin {
    pub from: f64,
    pub to: f64,
    pub states: usize,
}

/// A state's figures.
struct Figures {
    bytes: usize,
    nodes: usize,
    met: bool,
    usable: bool,
    visits: f32,
}

impl Guide {
    pub fn survey(&self) -> GuideStats {
        let states = self.figures();
        let count = |holds: &dyn Fn(&Figures) -> bool| states.iter().filter(|state| holds(state)).count();
        let share = |n: usize| if states.is_empty() { 0.0 } else { n as f64 / states.len() as f64 };
        let sizes = || states.iter().map(|state| state.bytes);
        GuideStats {
            states: states.len(),
            mean_bytes: if states.is_empty() { 0.0 } else { sizes().sum::<usize>() as f64 / states.len() as f64 },
            min_bytes: sizes().min().unwrap_or(0),
            max_bytes: sizes().max().unwrap_or(0),
            bytes: self.bytes(),
            tree_nodes: states.iter().map(|state| state.nodes).sum(),
            not_met_share: share(count(&|state| !state.met)),
            unusable_share: share(count(&|state| !state.usable)),
            visits: decades(states.iter().map(|state| state.visits)),
        }
    }

    fn figures(&self) -> Vec<Figures> {
        match &self.kind {
            Kind::Tables(tables) => {
                let figures = |state: &State| Figures {
                    bytes: state.bytes(),
                    nodes: nodes(state),
                    met: state.fresh > 0.0,
                    usable: tables.field().summary(state.key).is_some(),
                    visits: state.visits,
                };
                tables.learner.states().map(figures).collect()
            }
            Kind::PpgGuide(leaves) => {
                let all: Vec<LeafInfo> = leaves.tree().inspect().collect();
                let whole = all.iter().map(|leaf| leaf.nodes).sum::<usize>().max(1);
                let figures = |leaf: &LeafInfo| Figures {
                    // its part of the whole tree, by its nodes
                    bytes: leaves.bytes() * leaf.nodes / whole,
                    nodes: leaf.nodes,
                    met: leaf.visits > 0.0,
                    usable: leaves.tree().distribution(leaf.leaf).is_some(),
                    visits: leaf.visits as f32,
                };
                all.iter().map(figures).collect()
            }
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
fn decades(visits: impl Iterator<Item = f32>) -> Vec<HistogramBin> {
    let mut counts: Vec<usize> = Vec::new();
    for visits in visits {
        let decade = if visits < 1.0 { 0 } else { visits.log10().floor() as usize + 1 };
        counts.resize(counts.len().max(decade + 1), 0);
        counts[decade] += 1;
    }
    let bound = |k: i32| if k < 0 { 0.0 } else { 10f64.powi(k) };
    let decade =
        |(k, &states): (usize, &usize)| HistogramBin { from: bound(k as i32 - 1), to: bound(k as i32), states };
    counts.iter().enumerate().map(decade).collect()
}
