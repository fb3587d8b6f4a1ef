//! States: which of the scene's surface points share a table.

mod grid;
pub mod kd_tree;
pub mod normal_bins;
mod two_level;
pub mod voronoi;

pub use grid::Grid;
pub use two_level::Adaptive;

use crate::guiding::spatial::voronoi::Voronoi;
use crate::math::Frame;
use crate::simd::truncate;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Names a state; it is the same whoever asks, so a state needs no table to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct StateKey(pub u64);

/// The ways of telling states apart.
#[derive(Clone, Debug)]
pub enum States {
    Grid(Grid),
    Adaptive(Adaptive),
    /// `None` until there are sites.
    Voronoi(Option<Arc<Voronoi>>),
}

impl States {
    /// The state of point `p` with unit normal `n` on the side of the path. `jitter`, in [0, 1)², moves the point by up
    /// to half a state's extent along the surface: neighbouring tables blend over many queries, as in the stochastic
    /// filter of Müller (2019), and no query costs more than one look-up. `None` while there are no sites.
    #[inline(always)]
    pub fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> Option<StateKey> {
        match self {
            States::Grid(grid) => Some(grid.key(p, n, jitter)),
            States::Adaptive(adaptive) => Some(adaptive.key(p, n, jitter)),
            States::Voronoi(voronoi) => Some(StateKey(voronoi.as_ref()?.state(p, n, jitter) as u64)),
        }
    }

    /// Whether all points of a state face the same way, more or less: its table can be held in the frame of one of them.
    pub fn oriented(&self) -> bool {
        match self {
            States::Grid(grid) => grid.oriented(),
            States::Adaptive(_) | States::Voronoi(_) => true,
        }
    }

    /// Whether a key, perhaps from a file, can name a state.
    pub fn holds(&self, key: StateKey) -> bool {
        match self {
            States::Grid(_) => key.0 >> (3 * POSITION_BITS + NORMAL_BITS) == 0,
            States::Adaptive(adaptive) => adaptive.holds(key),
            States::Voronoi(voronoi) => voronoi.as_ref().is_some_and(|voronoi| key.0 < voronoi.len() as u64),
        }
    }

    pub fn bytes(&self) -> usize {
        match self {
            States::Grid(_) => 0,
            States::Adaptive(adaptive) => adaptive.bytes(),
            States::Voronoi(voronoi) => voronoi.as_ref().map_or(0, |voronoi| voronoi.bytes()),
        }
    }

    /// The normal about which a state's table is held, where that is not the one of its first visit.
    pub fn normal(&self, key: StateKey) -> Option<Vec3> {
        match self {
            States::Voronoi(Some(voronoi)) => Some(voronoi.frame(key.0 as u32).n),
            _ => None,
        }
    }
}

/// Moves `p`, in units of cells, by up to half a cell along the surface with normal `n`.
#[inline(always)]
fn jittered(p: Vec3, n: Vec3, jitter: [f32; 2]) -> Vec3 {
    let frame = Frame::from_normal(n);
    p + frame.s * (jitter[0] - 0.5) + frame.t * (jitter[1] - 0.5)
}

/// Bits for each coordinate of a cell.
const POSITION_BITS: u32 = 17;
const NORMAL_BITS: u32 = 6;

/// A key from the cell that holds `cell`, and a normal's bin. The border is kept: far outside of the grid everything is one
/// border cell.
#[inline(always)]
fn pack(cell: Vec3, bin: usize) -> u64 {
    let limit = (1 << POSITION_BITS) - 1;
    let coordinate = |v: f32| truncate(v).min(limit) as u64;
    let (x, y, z) = (coordinate(cell.x), coordinate(cell.y), coordinate(cell.z));
    let position = x | y << POSITION_BITS | z << (2 * POSITION_BITS);
    position | (bin as u64) << (3 * POSITION_BITS)
}

/// Where a grid over the box `(low, high)` starts, and its cells per unit of length.
fn lay(low: Vec3, high: Vec3, resolution: u32) -> (Vec3, f32) {
    let side = (high - low).max_element();
    // A single point has no extent; any cell size does.
    let cells_per_unit = if side > 0.0 { resolution as f32 / side } else { 1.0 };
    // Walls love round coordinates, and the box's own: an odd share of a cell keeps them off the cells' faces,
    // where rounding would split a wall between two layers of states.
    (low - Vec3::new(1.37, 1.41, 1.33) / cells_per_unit, cells_per_unit)
}
