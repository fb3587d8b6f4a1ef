//! Learning where light comes from, while rendering.
//!
//! A guide has two axes. A partition of space ([`spatial`]) says which points share what is learnt: a *region*, or state.
//! A model of directions ([`directional`]) says how what arrives at a region is learnt, frozen and drawn from; its cells
//! are the actions. Q(s, a) is the radiance (luminance) that arrives at s from a. Any partition and any model make a
//! [`Guide`]; the SD-tree is a binary tree over space with quadtrees of directions, and a schedule of its own.
//!
//! Tiles record transitions, [`UpdateJob`]s fold them into the regions (or [`Lesson`]s sum them up, for machines that share an
//! iteration), and a [`Snapshot`] is what an iteration samples
//! from. Nothing here knows of materials, integrators or Embree.

mod bsdf_fraction;
mod diagnostics;
mod directional;
mod guide;
mod hue;
mod lesson;
mod memory;
mod packed_direction;
mod persist;
mod ppg;
pub(crate) mod recorder;
mod refinement;
mod region;
mod region_index;
mod schedule;
pub mod settings;
mod snapshot;
pub mod spatial;
mod state;
mod store;
mod update_job;
mod visibility;

pub(crate) use diagnostics::{GuideStats, HistogramBin, StateView};
pub(crate) use directional::hemitree::Node;
pub(crate) use directional::{GlossyLobe, GuideLanes, GuidingDistribution};
pub use guide::Guide;
pub use hue::Hue;
pub(crate) use lesson::{Lesson, RegionSums};
pub use packed_direction::PackedDirection;
pub(crate) use persist::Stored;
pub use recorder::{Recorder, Transition};
pub(crate) use snapshot::{RegionInfo, Snapshot};
pub use spatial::{RegionId, RegionLookup};
pub(crate) use state::GuideState;
pub(crate) use update_job::UpdateJob;
pub use visibility::ShadowOutcome;

/// The frozen guide of an iteration.
pub type Field<'a> = &'a Snapshot;

#[cfg(test)]
mod tests;
