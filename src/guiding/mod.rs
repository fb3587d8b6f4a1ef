//! Learning where light comes from, while rendering.
//!
//! A *state* is where a path vertex lies, an *action* the stratum of the hemisphere into which the path goes on,
//! Q(s, a) the radiance (luminance) that arrives at s from a. Tiles record transitions, the [`learner`] folds them
//! into the [`qtable`] between rounds, and a [`Field`] is the frozen snapshot that an iteration samples from.
//! Nothing here knows of materials, integrators or Embree.

mod direction;
mod distribution;
mod field;
pub mod learner;
pub mod qtable;
pub mod recorder;
mod refine;
pub mod sdtree;
pub mod states;
pub mod strata;
pub mod tree;

pub use direction::PackedDirection;
pub use distribution::GuidingDistribution;
pub use field::{Field, Summary};
pub use recorder::{Recorder, Transition};
pub use states::StateKey;

use crate::scene::description::{DirectionTable, GuidingMethod, GuidingSettings};
use field::Use;
use glam::Vec3;
use learner::{Learner, Table};
use states::{Adaptive, Grid, States};
use strata::{Domain, Strata};
use tree::TreeShape;

/// A guide: what it has learnt so far, and the snapshot that is in use.
pub struct Guide {
    states: States,
    field: Field,
    learner: Learner,
    refinement: refine::Limits,
}

impl Guide {
    /// The guide that the settings ask for; `None` renders without one. `bounds` are the scene's.
    pub fn new(settings: &GuidingSettings, (low, high): (Vec3, Vec3)) -> Option<Guide> {
        let states = match settings.method {
            GuidingMethod::None => return None,
            GuidingMethod::Grid => States::Grid(Grid::new(low, high, settings.resolution, settings.normals)),
            GuidingMethod::Adaptive => {
                States::Adaptive(Adaptive::new(low, high, settings.resolution, settings.levels))
            }
        };
        let table = match settings.table {
            DirectionTable::Hemisphere => Table::Strata(Strata::new(Domain::Hemisphere, settings.strata)),
            DirectionTable::Sphere => Table::Strata(Strata::new(Domain::Sphere, settings.strata)),
            DirectionTable::Tree => Table::Tree(TreeShape::new(settings.split_share, settings.split_visits)),
        };
        let usage = Use {
            sampling: settings.sampling,
            bsdf_fraction: settings.bsdf_fraction,
            learnt_fraction: settings.learned_fraction,
            compensation: settings.mis_compensation,
            smoothing: settings.smoothing,
        };
        let memory = usize::try_from(settings.memory).unwrap_or(usize::MAX).saturating_sub(states.bytes());
        let learner = Learner::new(table.clone(), states.oriented(), settings.rate, memory);
        let field = Field::empty(states.clone(), table, usage);
        let refinement = refine::Limits { visits: settings.refine_visits, difference: settings.refine_difference };
        Some(Guide { states, field, learner, refinement })
    }

    /// The snapshot of this iteration.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Learns from what tiles recorded, in their order. The snapshot stays as it is.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        self.learner.fold(recorders);
    }

    /// What was learnt so far becomes the snapshot, in the middle of an iteration: the paper's on-line updates.
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

#[cfg(test)]
mod tests;
