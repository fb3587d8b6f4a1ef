//! Learning where light comes from, while rendering.
//!
//! A *state* is where a path vertex lies, an *action* the stratum of the hemisphere into which the path goes on,
//! Q(s, a) the radiance (luminance) that arrives at s from a. Tiles record transitions, the [`learner`] folds them
//! into the [`qtable`] between rounds, and a [`Field`] is the frozen snapshot that an iteration samples from.
//! Nothing here knows of materials, integrators or Embree.

pub mod action;
mod field;
pub mod learner;
pub mod qtable;
pub mod recorder;
pub mod state;
#[cfg(test)]
mod tests;
pub mod voronoi;

pub use field::{Field, GuidingDistribution};
pub use recorder::{Recorder, Transition};
pub use state::StateKey;

use crate::scene::description::{GuidingMethod, GuidingSettings};
use action::Strata;
use glam::Vec3;
use learner::Learner;
use qtable::Shard;
use state::Grid;

/// A guide: what it has learnt so far, and the snapshot that is in use.
pub struct Guide {
    field: Field,
    learner: Learner,
    retain: f32,
}

impl Guide {
    /// The guide that the settings ask for; `None` renders without one. `bounds` are the scene's.
    pub fn new(settings: &GuidingSettings, bounds: (Vec3, Vec3)) -> Option<Guide> {
        if settings.method == GuidingMethod::None {
            return None;
        }
        let strata = Strata::new(settings.strata);
        let actions = strata.count();
        let per_state = Shard::bytes_per_state(actions) + Field::bytes_per_state(&strata);
        let states = (settings.memory / per_state as u64).min(u32::MAX as u64) as usize;
        let grid = Grid::new(bounds.0, bounds.1, settings.resolution, settings.normals);
        Some(Guide {
            field: Field::empty(grid, strata),
            learner: Learner::new(actions, states),
            retain: settings.retain,
        })
    }

    /// The snapshot of this iteration.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Learns from what tiles recorded, in their order. The snapshot stays as it is.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        self.learner.fold(recorders);
    }

    /// Ends an iteration: what was learnt becomes the next snapshot.
    pub fn end_iteration(&mut self) {
        self.field.freeze(&self.learner);
        self.learner.forget(self.retain);
    }

    /// States that were ever met.
    pub fn states(&self) -> usize {
        self.learner.states()
    }

    /// Bytes of table and snapshot.
    pub fn bytes(&self) -> usize {
        self.learner.states() * Shard::bytes_per_state(self.field.strata_count()) + self.field.bytes()
    }
}
