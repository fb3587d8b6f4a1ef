//! Learning where light comes from, while rendering.
//!
//! A *state* is where a path vertex lies, an *action* the stratum of the hemisphere into which the path goes on,
//! Q(s, a) the radiance (luminance) that arrives at s from a. Tiles record transitions, [`UpdateJob`]s fold them
//! into the [`learner`]'s [`store`], and a [`Field`] is the frozen snapshot that an iteration samples from. An
//! [`sdtree`] does both in a way of its own.
//! Nothing here knows of materials, integrators or Embree.

mod bsdf_fraction;
pub mod directional;
mod guide_stats;
pub mod learner;
mod packed_direction;
mod persist;
mod ppg;
pub mod recorder;
mod refinement;
mod region_index;
pub mod sdtree;
pub mod settings;
mod snapshot;
pub mod spatial;
pub mod store;
mod tables;
mod update_job;
mod view;

pub use directional::distribution::GuidingDistribution;
pub use directional::guide_lanes::GuideLanes;
pub use directional::hemitree::Node;
pub use guide_stats::{GuideStats, HistogramBin};
pub use packed_direction::PackedDirection;
pub use persist::Stored;
pub use recorder::{Recorder, Transition};
pub use snapshot::RegionInfo;
pub use spatial::StateKey;
pub use update_job::UpdateJob;
pub use view::StateView;

use crate::guiding::settings::{GuidingMethod, GuidingSettings};
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;
use ppg::PpgGuide;
use snapshot::Snapshot;
use spatial::voronoi::placement::SitePlacement;
use spatial::{Adaptive, Grid, States};
use tables::Tables;

/// Divisor of the memory budget: the coarse cells of an adaptive grid take at most 1/8 of it.
const CELLS_SHARE: u64 = 8;

/// A guide: what it has learnt so far, and the snapshot that is in use.
pub struct Guide {
    method: GuidingMethod,
    kind: Kind,
}

enum Kind {
    Tables(Box<Tables>),
    PpgGuide(Box<PpgGuide>),
}

impl Guide {
    /// The guide that the settings ask for; `None` renders without one. `bounds` are the scene's, and `triangles` all
    /// of its surfaces, in world space: Voronoi sites are spread over them where the settings say so.
    pub fn new(
        settings: &GuidingSettings,
        bounds: (Vec3, Vec3),
        triangles: impl Iterator<Item = [Vec3; 3]> + Clone,
    ) -> Option<Guide> {
        let (low, high) = bounds;
        let tables = |states| Kind::Tables(Box::new(Tables::new(settings, states, None)));
        let kind = match settings.method {
            GuidingMethod::None => return None,
            GuidingMethod::Grid => tables(States::Grid(Grid::new(low, high, settings.resolution, settings.normals))),
            GuidingMethod::Adaptive | GuidingMethod::Auto => {
                let most = (settings.memory / CELLS_SHARE) as usize;
                tables(States::Adaptive(Adaptive::within(low, high, settings.resolution, settings.levels, most)))
            }
            GuidingMethod::Voronoi => {
                let (states, placing) = SitePlacement::begin(settings, triangles);
                Kind::Tables(Box::new(Tables::new(settings, states, placing)))
            }
            GuidingMethod::SdTree => Kind::PpgGuide(Box::new(PpgGuide::new(settings, bounds))),
        };
        Some(Guide { method: settings.method.model(), kind })
    }

    pub fn method(&self) -> GuidingMethod {
        self.method
    }

    /// The tables, where the guide is made of such.
    fn tables(&self) -> Option<&Tables> {
        match &self.kind {
            Kind::Tables(tables) => Some(tables),
            Kind::PpgGuide(_) => None,
        }
    }

    /// The snapshot of this iteration.
    pub fn field(&self) -> Field<'_> {
        match &self.kind {
            Kind::Tables(tables) => Field::Tables(tables.field()),
            Kind::PpgGuide(leaves) => Field::PpgGuide(leaves),
        }
    }

    /// Learns from what tiles recorded, in their order. The snapshot stays as it is.
    pub fn learn(&mut self, recorders: &[&Recorder]) {
        match &mut self.kind {
            Kind::Tables(tables) => tables.learn(recorders),
            Kind::PpgGuide(leaves) => leaves.learn(recorders),
        }
    }

    /// The same in parts, for any threads in any order, and the snapshot, which may be in use meanwhile. An SD-tree
    /// learns at once.
    pub fn lessons<'a>(&'a mut self, recorders: &'a [&'a Recorder]) -> (Field<'a>, Vec<UpdateJob<'a>>) {
        match &mut self.kind {
            Kind::Tables(tables) => {
                let (field, lessons) = tables.lessons(recorders);
                (Field::Tables(field), lessons)
            }
            Kind::PpgGuide(leaves) => {
                leaves.learn(recorders);
                (Field::PpgGuide(leaves), Vec::new())
            }
        }
    }

    /// What was learnt so far becomes the snapshot, in the middle of an iteration: the paper's on-line updates.
    ///
    /// Of tables only: an SD-tree takes its snapshots of whole iterations, and stays as it is.
    pub fn refresh(&mut self) {
        match &mut self.kind {
            Kind::Tables(tables) => tables.refresh(),
            Kind::PpgGuide(_) => (),
        }
    }

    /// Ends an iteration of `spp` samples per pixel: states and tables are refined, and what was learnt becomes the
    /// next snapshot.
    pub fn end_iteration(&mut self, spp: u32) {
        match &mut self.kind {
            Kind::Tables(tables) => tables.end_iteration(),
            Kind::PpgGuide(leaves) => leaves.end_iteration(spp),
        }
    }

    /// Whether an iteration that recorded so many transitions has taught enough.
    pub fn has_enough(&self, transitions: u64) -> bool {
        self.tables().is_some_and(|tables| tables.has_enough(transitions))
    }

    /// States that were ever met; of an SD-tree, all leaves.
    pub fn states(&self) -> usize {
        match &self.kind {
            Kind::Tables(tables) => tables.states(),
            Kind::PpgGuide(leaves) => leaves.tree().leaves(),
        }
    }

    /// Bytes of table and snapshot.
    pub fn bytes(&self) -> usize {
        match &self.kind {
            Kind::Tables(tables) => tables.bytes(),
            Kind::PpgGuide(leaves) => leaves.bytes(),
        }
    }
}

/// The frozen guide: what sampling and pdf read during an iteration.
#[derive(Clone, Copy)]
pub enum Field<'a> {
    Tables(&'a Snapshot),
    PpgGuide(&'a PpgGuide),
}

/// The states of a path vertex. Of tables both are the same; an SD-tree's filter moves only what is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// What to draw from.
    pub drawn: StateKey,
    /// Where to record what was found.
    pub recorded: StateKey,
}

impl<'a> Field<'a> {
    /// The states of the point `p` with unit normal `n` on the side of the path. `jitter`, in [0, 1)³, blends
    /// neighbouring states; 0.5 everywhere leaves the point where it is. Tables use two of its numbers. `None` while
    /// there are no states: sites are still to be placed, at points that [`Recorder::push_point`] takes.
    #[inline(always)]
    pub fn place(self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<Place> {
        match self {
            Field::Tables(tables) => {
                let key = tables.state(p, n, [jitter[0], jitter[1]])?;
                Some(Place { drawn: key, recorded: key })
            }
            Field::PpgGuide(leaves) => Some(Place { drawn: leaves.drawn(p), recorded: leaves.recorded(p, jitter) }),
        }
    }

    /// [`Self::place`] for all points of a packet, where that is done side by side; `None` where points are to be asked
    /// for one by one.
    #[inline(always)]
    pub fn places(self, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 3]) -> Option<[StateKey; LANES]> {
        match self {
            Field::Tables(tables) => tables.keys(p, n, [jitter[0], jitter[1]]),
            Field::PpgGuide(_) => None,
        }
    }

    /// What is known of a state, where that is enough.
    #[inline(always)]
    pub fn summary(self, key: StateKey) -> Option<&'a RegionInfo> {
        match self {
            Field::Tables(tables) => tables.summary(key),
            Field::PpgGuide(leaves) => leaves.summary(key),
        }
    }

    /// Where to go on at a point with the normal `n`, on the side of the path, of a state of which `summary` is known.
    #[inline(always)]
    pub fn distribution(self, summary: &RegionInfo, n: Vec3) -> GuidingDistribution<'a> {
        match self {
            Field::Tables(tables) => tables.distribution(summary, n),
            Field::PpgGuide(leaves) => leaves.distribution(summary),
        }
    }

    /// The same where it is a tree: the normal of its hemisphere, and its nodes.
    #[inline(always)]
    pub fn tree(self, summary: &RegionInfo, n: Vec3) -> Option<(Vec3, &'a [Node])> {
        match self {
            Field::Tables(tables) => tables.tree(summary, n),
            Field::PpgGuide(_) => None,
        }
    }

    /// States that can be drawn from.
    pub fn len(self) -> usize {
        match self {
            Field::Tables(tables) => tables.len(),
            Field::PpgGuide(leaves) => leaves.known(),
        }
    }

    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Bytes of the snapshot; of an SD-tree, which learns in place, of all of it.
    pub fn bytes(self) -> usize {
        match self {
            Field::Tables(tables) => tables.bytes(),
            Field::PpgGuide(leaves) => leaves.bytes(),
        }
    }
}

#[cfg(test)]
mod tests;
