//! One state, to be looked at.

use super::Guide;
use super::field::estimates;
use super::learner::{Table, in_table};
use super::qtable::{Actions, State};
use super::states::StateKey;
use crate::geometry::Frame;
use glam::Vec3;

/// What a guide knows of one state.
pub struct StateView<'g> {
    state: &'g State,
    table: &'g Table,
    /// Whether the table is held in the frame about the state's own normal.
    oriented: bool,
    /// Q by stratum, as sampling sees it; of a tree nothing.
    strata: Vec<f32>,
}

impl Guide {
    /// Weight of a state's visits, if it was ever met.
    pub fn visits(&self, key: StateKey) -> Option<f32> {
        self.learner.get(key).map(|state| state.visits)
    }

    /// What was learnt of a state, if it was ever met.
    pub fn view(&self, key: StateKey) -> Option<StateView<'_>> {
        let (state, table) = (self.learner.get(key)?, &self.learner.table);
        let strata = match (&state.actions, table) {
            (Actions::Strata(entries), Table::Strata(strata)) => estimates(entries, strata, self.field.smoothing()),
            _ => Vec::new(),
        };
        Some(StateView { state, table, oriented: self.states.oriented(), strata })
    }
}

impl StateView<'_> {
    /// Weight of the visits.
    pub fn visits(&self) -> f32 {
        self.state.visits
    }

    /// Normal of the hemisphere that the table covers, where it is the same for all points of the state.
    pub fn normal(&self) -> Option<Vec3> {
        self.oriented.then_some(self.state.normal)
    }

    /// Q, the radiance (luminance) that arrives from the unit direction `w` (world space, away from the surface), at a
    /// point with the normal `n`; `None` where the table says nothing of it.
    pub fn q(&self, n: Vec3, w: Vec3) -> Option<f32> {
        let n = self.normal().unwrap_or(n);
        match (&self.state.actions, self.table) {
            (Actions::Tree(cells), _) => cells.estimate(Frame::from_normal(n).to_local(w)),
            (Actions::Strata(_), Table::Strata(strata)) => {
                strata.index(in_table(strata.domain(), n, w)).map(|k| self.strata[k])
            }
            _ => None,
        }
    }
}
