//! Space: which of the scene's surface points share what is learnt.
//!
//! A [`SpatialPartition`] names the *region* of a point. What is learnt of a region is no business of it.

mod grid;
mod grid_keys;
mod kd_tree;
pub mod normal_bins;
mod partition;
mod two_level;
pub mod voronoi;

pub(crate) use voronoi::Gathered;

pub(crate) use grid::Grid;
pub(crate) use kd_tree::KdTree;
#[cfg(test)]
pub(super) use kd_tree::LeafBox;
pub(crate) use partition::Partition;
pub(crate) use two_level::TwoLevelGrid;

use crate::simd::{LANES, Mask, Vec3Lanes};
use glam::Vec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Names a region; it is the same whoever asks, so a region needs no table to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct RegionId(pub u64);

/// The regions of a path vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionLookup {
    /// What to draw from.
    pub drawn: RegionId,
    /// Where to record what was found; another one where a partition filters its records, and not its look-ups.
    pub recorded: RegionId,
}

impl RegionLookup {
    /// The same region for both.
    #[inline(always)]
    pub(crate) fn one(key: RegionId) -> RegionLookup {
        RegionLookup { drawn: key, recorded: key }
    }
}

/// A way of telling regions apart.
///
/// Look-ups read a copy that is frozen during an iteration. Between iterations, *cells* may be divided: a cell is what
/// one decision divides, and holds one region or several (one for each normal's bin, for example).
pub trait SpatialPartition: Clone + Send + Sync {
    /// What of it outlives a render.
    type Stored: Clone + Serialize + DeserializeOwned;

    /// The regions of the point `p` (world space) with unit normal `n` on the side of the path. `jitter`, in [0, 1)³,
    /// blends neighbouring regions: it moves the point by up to half a region's extent, so that no query costs more than
    /// one look-up (the stochastic filter of Müller 2019). 0.5 everywhere leaves the point where it is. `None` while
    /// there are no regions.
    fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup>;

    /// [`Self::locate`] for the points of a packet that are asked for, where both regions are the same and are found side by side,
    /// with any regions for the others; `None` where points are to be asked for one by one.
    fn locate_lanes(
        &self,
        _asked: Mask,
        _p: &Vec3Lanes,
        _n: &Vec3Lanes,
        _jitter: [f32; 3],
    ) -> Option<[RegionId; LANES]> {
        None
    }

    /// Whether all points of a region face the same way, more or less: its directions can be held in one frame.
    fn is_oriented(&self) -> bool;

    /// The normal of that frame, where it is not the one of the region's first visit.
    fn normal(&self, _key: RegionId) -> Option<Vec3> {
        None
    }

    /// Whether a key, perhaps from a file, names a region.
    fn holds(&self, key: RegionId) -> bool;

    /// Where keys are numbers below a bound that is near the number of regions: that bound.
    fn dense(&self) -> Option<usize> {
        None
    }

    /// Bytes that are held.
    fn bytes(&self) -> usize;

    /// What look-ups need, to be frozen.
    fn frozen(&self) -> Self {
        self.clone()
    }

    /// Whether [`Self::expect_vertices`] does anything.
    fn adapts_to_vertices(&self) -> bool {
        false
    }

    /// Takes some vertices of the paths that are to be expected, before anything is learnt.
    fn expect_vertices(&mut self, _vertices: &[(Vec3, Vec3)]) {}

    /// Takes path vertices with their normals, while there are no regions.
    fn observe(&mut self, _points: &[(Vec3, Vec3)]) {}

    /// Makes regions of what was observed, between iterations; returns whether that changed anything.
    fn settle(&mut self) -> bool {
        false
    }

    /// A bound on the numbers of cells; 0 where none can ever be divided.
    fn cells(&self) -> usize {
        0
    }

    /// The cell that a current region is in.
    fn cell_of(&self, _key: RegionId) -> usize {
        0
    }

    /// Regions that a region of a cell becomes when that is divided once.
    fn parts_per_region(&self) -> usize {
        1
    }

    /// Divides a cell once, unless it is the smallest there is. Returns the cells that its parts are in.
    fn divide(&mut self, _cell: usize) -> Option<Range<usize>> {
        None
    }

    /// The regions that a region was divided into, each with its share of the visits; none where it is current.
    fn parts(&self, _key: RegionId) -> Vec<(RegionId, f32)> {
        Vec::new()
    }

    /// Regions of the same size and normal beyond the faces of this one, where that is known.
    fn neighbours(&self, _key: RegionId) -> Vec<RegionId> {
        Vec::new()
    }

    fn stored(&self) -> Self::Stored;

    /// What [`Self::observe`] has gathered and [`Self::settle`] has not used yet.
    fn gathered(&self) -> Option<Gathered> {
        None
    }

    /// Goes on with what another partition of the same settings has gathered.
    fn restore_gathered(&mut self, _gathered: Gathered) {}

    /// Takes over what a partition of the same settings has stored, where this one is new.
    ///
    /// # Errors
    /// Where that is not what such a partition can hold, or is more than `memory` bytes.
    fn restore(&mut self, stored: Self::Stored, memory: usize) -> Result<(), String>;
}
