//! The uniform grid.
//!
//! A state is a cell together with a quantised normal. The normal is the *facing* one, flipped to the side the path
//! came from, so corners and the two sides of a thin sheet never share a table.

use super::normal_bins::normal_bin;
use super::{StateKey, jittered, lay, pack};
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;

/// Cells of one size, hashed: none is stored before it is met.
#[derive(Clone, Debug)]
pub struct Grid {
    origin: Vec3,
    cells_per_unit: f32,
    normals: bool,
}

impl Grid {
    /// `resolution` cells along the longest side of the box `(low, high)`; without `normals` all of a cell is one state
    /// (the paper's grid).
    pub fn new(low: Vec3, high: Vec3, resolution: u32, normals: bool) -> Grid {
        let (origin, cells_per_unit) = lay(low, high, resolution);
        Grid { origin, cells_per_unit, normals }
    }

    #[inline(always)]
    pub fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> StateKey {
        let bin = if self.normals { normal_bin(n) } else { 0 };
        StateKey(pack(jittered((p - self.origin) * self.cells_per_unit, n, jitter), bin))
    }

    /// [`Self::key`] for a packet.
    #[inline(never)]
    pub fn keys(&self, points: &Vec3Lanes, normals: &Vec3Lanes, jitter: [f32; 2]) -> [StateKey; LANES] {
        let mut keys = [StateKey(0); LANES];
        for k in 0..LANES {
            keys[k] = self.key(points.get(k), normals.get(k), jitter);
        }
        keys
    }

    pub fn oriented(&self) -> bool {
        self.normals
    }
}
