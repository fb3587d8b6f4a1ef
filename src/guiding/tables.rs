//! The guide of tables: states, each with the values of its directions.

use super::learner::{Learner, Table};
use super::recorder::Recorder;
use super::refinement;
use super::snapshot::{SamplingOptions, Snapshot};
use super::update_job::UpdateJob;
use crate::guiding::settings::GuidingSettings;
use crate::guiding::spatial::States;
use crate::guiding::spatial::voronoi::Voronoi;
use crate::guiding::spatial::voronoi::placement::SitePlacement;
use rayon::prelude::*;
use std::sync::Arc;

/// Visits of an iteration, on average over the states, after which adaptive states stop to learn until the next one
/// begins. With four times fewer, rooms lit through a gap got a tenth noisier; without end, tables grow and gain nothing.
const VISITS_PER_STATE: u64 = 1024;

/// What was learnt so far, and the snapshot of it that is in use.
pub struct Tables {
    pub(super) states: States,
    pub(super) field: Snapshot,
    pub(super) learner: Learner,
    /// An iteration ended, and the next one has not begun to learn: only then do earlier visits fade.
    pub(super) ended: bool,
    refinement: refinement::Limits,
    /// While there are no sites.
    placing: Option<SitePlacement>,
    /// Bytes for states and tables.
    pub(super) memory: usize,
}

impl Tables {
    /// Nothing known yet.
    pub fn new(settings: &GuidingSettings, states: States, placing: Option<SitePlacement>) -> Tables {
        let table = Table::new(settings);
        let usage = SamplingOptions {
            sampling: settings.sampling,
            bsdf_fraction: settings.bsdf_fraction,
            learnt_fraction: settings.learns_fraction(),
            compensation: settings.mis_compensation,
            smoothing: settings.smoothing,
        };
        let memory = usize::try_from(settings.memory).unwrap_or(usize::MAX);
        let left = memory.saturating_sub(states.bytes());
        let learner = Learner::new(table.clone(), states.oriented(), settings.rate, left);
        let field = Snapshot::empty(states.clone(), table, usage);
        let refinement = refinement::Limits { visits: settings.refine_visits, difference: settings.refine_difference };
        Tables { states, field, learner, ended: false, refinement, placing, memory }
    }

    pub fn field(&self) -> &Snapshot {
        &self.field
    }

    pub fn learn(&mut self, recorders: &[&Recorder]) {
        self.lessons(recorders).1.into_par_iter().for_each(UpdateJob::learn);
    }

    /// What is to be learnt of what tiles recorded, in parts; and the snapshot, which knows nothing of that.
    pub fn lessons<'a>(&'a mut self, recorders: &'a [&'a Recorder]) -> (&'a Snapshot, Vec<UpdateJob<'a>>) {
        if let Some(placing) = &mut self.placing {
            recorders.iter().for_each(|recorder| placing.visit(recorder.points()));
        }
        if std::mem::take(&mut self.ended) {
            self.learner.fade();
        }
        (&self.field, self.learner.lessons(recorders, &self.states))
    }

    /// Whether more visits in one iteration would teach adaptive states little. Others learn from all: their memory is
    /// laid out beforehand, or what they are compared with does so too.
    pub fn has_enough(&self, transitions: u64) -> bool {
        matches!(self.states, States::Adaptive(_)) && transitions > VISITS_PER_STATE * self.states().max(1) as u64
    }

    /// What was learnt so far becomes the snapshot, in the middle of an iteration.
    pub fn refresh(&mut self) {
        self.field.freeze(&self.states, &self.learner);
    }

    /// Ends an iteration: states and tables are refined, and what was learnt becomes the next snapshot.
    pub fn end_iteration(&mut self) {
        if let Some(voronoi) = self.placing.as_ref().and_then(SitePlacement::sites) {
            self.place(voronoi);
        }
        if let States::Adaptive(adaptive) = &mut self.states {
            refinement::refine(adaptive, &mut self.learner, self.refinement);
        }
        self.learner.refine_actions();
        self.refresh();
        self.ended = true;
    }

    /// Begins to tell states apart by sites.
    pub(super) fn place(&mut self, voronoi: Arc<Voronoi>) {
        self.states = States::Voronoi(Some(voronoi));
        self.placing = None;
        self.learner.keep_within(self.memory.saturating_sub(self.states.bytes()));
    }

    /// States that were ever met.
    pub fn states(&self) -> usize {
        self.learner.states().count()
    }

    /// Bytes of table and snapshot.
    pub fn bytes(&self) -> usize {
        self.learner.bytes() + self.states.bytes() + self.placing.as_ref().map_or(0, SitePlacement::bytes)
    }
}
