//! The uniform grid.
//!
//! A region is a cell together with a quantised normal. The normal is the *facing* one, flipped to the side the path
//! came from, so corners and the two sides of a thin sheet never share a table.

use super::grid_keys::{NORMAL_BITS, POSITION_BITS, jittered, origin_and_scale, pack};
use super::normal_bins::normal_bin;
use super::{RegionId, RegionLookup, SpatialPartition};
use crate::simd::{LANES, Mask, Vec3Lanes};
use glam::Vec3;

/// Cells of one size, hashed: none is stored before it is met.
#[derive(Clone, Debug)]
pub struct Grid {
    origin: Vec3,
    cells_per_unit: f32,
    normals: bool,
}

impl Grid {
    /// `resolution` cells along the longest side of the box `(low, high)`; without `normals` all of a cell is one region
    /// (the paper's grid).
    pub fn new(low: Vec3, high: Vec3, resolution: u32, normals: bool) -> Grid {
        let (origin, cells_per_unit) = origin_and_scale(low, high, resolution);
        Grid { origin, cells_per_unit, normals }
    }

    #[inline(always)]
    pub(in crate::guiding) fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> RegionId {
        let bin = if self.normals { normal_bin(n) } else { 0 };
        RegionId(pack(jittered((p - self.origin) * self.cells_per_unit, n, jitter), bin))
    }

    #[inline(never)]
    pub(in crate::guiding) fn keys(
        &self,
        points: &Vec3Lanes,
        normals: &Vec3Lanes,
        jitter: [f32; 3],
    ) -> [RegionId; LANES] {
        let mut keys = [RegionId(0); LANES];
        for k in 0..LANES {
            keys[k] = self.key(points.get(k), normals.get(k), jitter);
        }
        keys
    }
}

impl SpatialPartition for Grid {
    /// There is nothing that the settings do not say.
    type Stored = ();

    #[inline(always)]
    fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
        Some(RegionLookup::one(self.key(p, n, jitter)))
    }

    #[inline(always)]
    fn locate_lanes(&self, _: Mask, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 3]) -> Option<[RegionId; LANES]> {
        Some(self.keys(p, n, jitter))
    }

    fn is_oriented(&self) -> bool {
        self.normals
    }

    fn holds(&self, key: RegionId) -> bool {
        key.0 >> (3 * POSITION_BITS + NORMAL_BITS) == 0
    }

    fn bytes(&self) -> usize {
        0
    }

    fn stored(&self) {}

    fn restore(&mut self, (): (), _memory: usize) -> Result<(), String> {
        Ok(())
    }
}
