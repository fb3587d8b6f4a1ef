//! The guide of tables: states, each with the values of its directions.

use super::field::{TableField, Use};
use super::learner::{Learner, Table};
use super::recorder::Recorder;
use super::refine;
use super::states::States;
use super::strata::{Domain, Strata};
use super::tree::TreeShape;
use crate::scene::description::{DirectionTable, GuidingSettings};

/// What was learnt so far, and the snapshot of it that is in use.
pub struct Tables {
    states: States,
    field: TableField,
    learner: Learner,
    refinement: refine::Limits,
}

impl Tables {
    /// Nothing known yet.
    pub fn new(settings: &GuidingSettings, states: States) -> Tables {
        let table = match settings.table {
            DirectionTable::Hemisphere => Table::Strata(Strata::new(Domain::Hemisphere, settings.strata)),
            DirectionTable::Sphere => Table::Strata(Strata::new(Domain::Sphere, settings.strata)),
            DirectionTable::Tree => Table::Tree(TreeShape::new(settings.split_share, settings.split_visits)),
        };
        let usage = Use {
            sampling: settings.sampling,
            bsdf_fraction: settings.bsdf_fraction,
            learnt_fraction: settings.learns_fraction(),
            compensation: settings.mis_compensation,
            smoothing: settings.smoothing,
        };
        let memory = usize::try_from(settings.memory).unwrap_or(usize::MAX).saturating_sub(states.bytes());
        let learner = Learner::new(table.clone(), states.oriented(), settings.rate, memory);
        let field = TableField::empty(states.clone(), table, usage);
        let refinement = refine::Limits { visits: settings.refine_visits, difference: settings.refine_difference };
        Tables { states, field, learner, refinement }
    }

    pub fn field(&self) -> &TableField {
        &self.field
    }

    pub fn learn(&mut self, recorders: &[&Recorder]) {
        self.learner.fold(recorders);
    }

    /// What was learnt so far becomes the snapshot, in the middle of an iteration.
    pub fn refresh(&mut self) {
        self.field.freeze(&self.states, &self.learner);
    }

    /// Ends an iteration: states and tables are refined, and what was learnt becomes the next snapshot.
    pub fn end_iteration(&mut self) {
        if let States::Adaptive(adaptive) = &mut self.states {
            refine::refine(adaptive, &mut self.learner, self.refinement);
        }
        self.learner.refine_actions();
        self.refresh();
        self.learner.fade();
    }

    /// States that were ever met.
    pub fn states(&self) -> usize {
        self.learner.states().count()
    }

    /// Bytes of table and snapshot.
    pub fn bytes(&self) -> usize {
        self.learner.bytes() + self.states.bytes()
    }
}
