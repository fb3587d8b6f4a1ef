//! One state, to be looked at.

use super::Guide;
use super::Kind;
use super::learner::{Table, in_table};
use super::sdtree::Quadtree;
use super::tables::Tables;
use crate::guiding::directional::bins::rows::estimates;
use crate::guiding::spatial::StateKey;
use crate::guiding::store::{Actions, State};
use crate::math::Frame;
use glam::Vec3;
use std::f32::consts::PI;

/// What a guide knows of one state.
pub enum StateView<'g> {
    Table(TableView<'g>),
    /// A leaf of an SD-tree: its directions, the mean radiance over the sphere, and its visits.
    Leaf {
        directions: Quadtree<'g>,
        mean: f32,
        visits: f32,
    },
}

/// A state of a table.
pub struct TableView<'g> {
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
        match &self.kind {
            Kind::Tables(tables) => tables.learner.get(key).map(|state| state.visits),
            Kind::PpgGuide(leaves) => leaves.summary(key).map(|summary| summary.visits),
        }
    }

    /// What was learnt of a state, if it was ever met.
    pub fn view(&self, key: StateKey) -> Option<StateView<'_>> {
        match &self.kind {
            Kind::Tables(tables) => tables.view(key).map(StateView::Table),
            Kind::PpgGuide(leaves) => {
                let summary = leaves.summary(key)?;
                let directions = leaves.tree().distribution(summary.leaf())?;
                let mean = leaves.tree().mean_radiance(summary.leaf());
                Some(StateView::Leaf { directions, mean, visits: summary.visits })
            }
        }
    }
}

impl Tables {
    fn view(&self, key: StateKey) -> Option<TableView<'_>> {
        let (state, table) = (self.learner.get(key)?, &self.learner.table);
        let strata = match (&state.actions, table) {
            (Actions::Strata(entries), Table::Strata(strata)) => estimates(entries, strata, self.field.smoothing()),
            _ => Vec::new(),
        };
        Some(TableView { state, table, oriented: self.states.oriented(), strata })
    }
}

impl StateView<'_> {
    /// Weight of the visits.
    pub fn visits(&self) -> f32 {
        match self {
            StateView::Table(view) => view.state.visits,
            StateView::Leaf { visits, .. } => *visits,
        }
    }

    /// Normal of the hemisphere that the table covers, where it is the same for all points of the state.
    pub fn normal(&self) -> Option<Vec3> {
        match self {
            StateView::Table(view) => view.oriented.then_some(view.state.normal),
            StateView::Leaf { .. } => None,
        }
    }

    /// Q, the radiance (luminance) that arrives from the unit direction `w` (world space, away from the surface), at a
    /// point with the normal `n`; `None` where the table says nothing of it.
    pub fn q(&self, n: Vec3, w: Vec3) -> Option<f32> {
        match self {
            StateView::Table(view) => view.q(self.normal().unwrap_or(n), w),
            // the density is in proportion to the radiance, the mean of which is over the sphere
            StateView::Leaf { directions, mean, .. } => Some(4.0 * PI * mean * directions.pdf(w)),
        }
    }
}

impl TableView<'_> {
    fn q(&self, n: Vec3, w: Vec3) -> Option<f32> {
        match (&self.state.actions, self.table) {
            (Actions::Tree(cells), _) => cells.estimate(Frame::from_normal(n).to_local(w)),
            (Actions::Strata(_), Table::Strata(strata)) => {
                strata.index(in_table(strata.domain(), n, w)).map(|k| self.strata[k])
            }
            _ => None,
        }
    }
}
