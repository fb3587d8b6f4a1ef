//! Cells that refine where it pays: the paper's future work 6.4.

use super::grid_keys::{NORMAL_BITS, POSITION_BITS, jittered, origin_and_scale, pack};
use super::normal_bins::normal_bin;
use super::{RegionId, RegionLookup, SpatialPartition};
use crate::simd::{LANES, Mask, Vec3Lanes, truncate};
use glam::{UVec3, Vec3};
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A coarse grid, each cell of which is cut into 1, 2³, 4³ … equal parts. How often is one number per coarse cell, in a
/// dense array that the cache holds, so that a look-up costs one more read than in a uniform grid, however fine.
#[derive(Clone, Debug)]
pub struct TwoLevelGrid {
    origin: Vec3,
    cells_per_unit: f32,
    size: UVec3,
    /// Halvings of each coarse cell.
    levels: Vec<u8>,
    /// Halvings at most.
    max_level: u8,
    /// The longest side of the scene.
    longest: f32,
}

/// Halvings of coarse cells, and how many there may be.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StoredLevels {
    levels: Vec<u8>,
    max_level: u8,
}

/// Vertices that a region is to have at least, where cells are halved before anything is learnt.
const VERTICES_PER_REGION: usize = 4;

/// Share of the vertices, on either side along an axis, that may lie anywhere.
const ASTRAY: f32 = 0.1;

/// One coordinate of a cell.
const COORDINATE: u64 = (1 << POSITION_BITS) - 1;
/// Place of the level in a key.
const LEVEL_SHIFT: u32 = 3 * POSITION_BITS + NORMAL_BITS;

impl TwoLevelGrid {
    /// As [`Self::new`], with fewer cells where so many would take more than `most` bytes.
    pub fn within(low: Vec3, high: Vec3, resolution: u32, max_level: u8, most: usize) -> TwoLevelGrid {
        let fits = |resolution: &u32| {
            TwoLevelGrid::size(low, high, *resolution).2.as_u64vec3().element_product() <= most as u64
        };
        let halved = std::iter::successors(Some(resolution), |resolution| (*resolution > 1).then(|| resolution / 2));
        TwoLevelGrid::new(low, high, halved.into_iter().find(fits).unwrap_or(1), max_level)
    }

    /// Origin, cells per unit of length and cells along each axis.
    fn size(low: Vec3, high: Vec3, resolution: u32) -> (Vec3, f32, UVec3) {
        let (origin, cells_per_unit) = origin_and_scale(low, high, resolution);
        (origin, cells_per_unit, ((high - origin) * cells_per_unit + 2.0).as_uvec3().max(UVec3::ONE))
    }

    /// `resolution` coarse cells along the longest side of the box `(low, high)`, each halved up to `max_level` times.
    pub fn new(low: Vec3, high: Vec3, resolution: u32, max_level: u8) -> TwoLevelGrid {
        let (origin, cells_per_unit, size) = TwoLevelGrid::size(low, high, resolution);
        let cells = size.x as usize * size.y as usize * size.z as usize;
        TwoLevelGrid {
            origin,
            cells_per_unit,
            size,
            levels: vec![0; cells],
            max_level,
            longest: (high - low).max_element(),
        }
    }

    #[inline(always)]
    pub(in crate::guiding) fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> RegionId {
        let p = (p - self.origin) * self.cells_per_unit;
        // moved by the extent of its own part of a cell, a point may come into a cell that is cut otherwise
        let p = moved(p, n, self.levels[self.coarse(p)], jitter);
        part(p, n, self.levels[self.coarse(p)])
    }

    /// [`Self::key`] for a packet.
    #[inline(never)]
    pub(in crate::guiding) fn keys(
        &self,
        points: &Vec3Lanes,
        normals: &Vec3Lanes,
        jitter: [f32; 3],
    ) -> [RegionId; LANES] {
        let (mut at, mut levels, mut p) = ([0; LANES], [0; LANES], Vec3Lanes::ZERO);
        for k in 0..LANES {
            p.set(k, (points.get(k) - self.origin) * self.cells_per_unit);
            at[k] = self.coarse(p.get(k)) as u32;
        }
        for k in 0..LANES {
            levels[k] = self.levels[at[k] as usize];
        }
        for k in 0..LANES {
            p.set(k, moved(p.get(k), normals.get(k), levels[k], jitter));
            at[k] = self.coarse(p.get(k)) as u32;
        }
        for k in 0..LANES {
            levels[k] = self.levels[at[k] as usize];
        }
        let mut keys = [RegionId(0); LANES];
        for k in 0..LANES {
            keys[k] = part(p.get(k), normals.get(k), levels[k]);
        }
        keys
    }

    #[inline(always)]
    fn coarse(&self, p: Vec3) -> usize {
        let c = UVec3::new(truncate(p.x), truncate(p.y), truncate(p.z)).min(self.size - 1);
        ((c.z * self.size.y + c.y) * self.size.x + c.x) as usize
    }

    /// The most halvings of which a key can tell.
    fn deepest(&self) -> u8 {
        (1u64 << POSITION_BITS).div_ceil(u64::from(self.size.max_element())).ilog2() as u8
    }

    /// The halvings of a coarse cell, `most` at most, that leave each of its regions enough of these vertices.
    fn halvings(&self, vertices: &[(Vec3, Vec3)], most: u8) -> u8 {
        let cells = |p: Vec3| (p - self.origin) * self.cells_per_unit;
        let enough = |level: &u8| {
            let regions: FxHashSet<RegionId> = vertices.iter().map(|(p, n)| part(cells(*p), *n, *level)).collect();
            vertices.len() >= VERTICES_PER_REGION * regions.len()
        };
        (1..=most).take_while(enough).last().unwrap_or(0)
    }

    /// The coarse cell that a region is part of.
    fn coarse_of(&self, key: RegionId) -> usize {
        let level = level(key);
        let at = |axis: u32| ((key.0 >> (axis * POSITION_BITS)) as u32 & ((1 << POSITION_BITS) - 1)) >> level;
        let c = UVec3::new(at(0), at(1), at(2)).min(self.size - 1);
        ((c.z * self.size.y + c.y) * self.size.x + c.x) as usize
    }

    /// Whether a region is of the size that its coarse cell now has.
    fn is_current(&self, key: RegionId) -> bool {
        self.levels[self.coarse_of(key)] == level(key)
    }
}

/// On a surface, a cell's part has about a quarter of its points.
const PART_SHARE: f32 = 0.25;

impl SpatialPartition for TwoLevelGrid {
    type Stored = StoredLevels;

    #[inline(always)]
    fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
        Some(RegionLookup::one(self.key(p, n, jitter)))
    }

    #[inline(always)]
    fn locate_lanes(&self, _: Mask, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 3]) -> Option<[RegionId; LANES]> {
        Some(self.keys(p, n, jitter))
    }

    fn is_oriented(&self) -> bool {
        true
    }

    fn holds(&self, key: RegionId) -> bool {
        level(key) <= self.max_level && self.is_current(key)
    }

    fn bytes(&self) -> usize {
        self.levels.len()
    }

    fn cells(&self) -> usize {
        self.levels.len()
    }

    fn cell_of(&self, key: RegionId) -> usize {
        self.coarse_of(key)
    }

    fn parts_per_region(&self) -> usize {
        8
    }

    /// Halves the parts of a coarse cell once more.
    fn divide(&mut self, coarse: usize) -> Option<Range<usize>> {
        let divided = self.levels[coarse] < self.max_level;
        self.levels[coarse] += divided as u8;
        divided.then_some(coarse..coarse + 1)
    }

    fn parts(&self, key: RegionId) -> Vec<(RegionId, f32)> {
        if self.is_current(key) {
            return Vec::new();
        }
        let (mut parts, mut share) = (vec![key], 1.0);
        for _ in level(key)..self.levels[self.coarse_of(key)] {
            parts = parts.iter().flat_map(|part| part.parts()).collect();
            share *= PART_SHARE;
        }
        parts.into_iter().map(|part| (part, share)).collect()
    }

    fn neighbours(&self, key: RegionId) -> Vec<RegionId> {
        key.neighbours().collect()
    }

    fn adapts_to_vertices(&self) -> bool {
        true
    }

    /// Where most paths stay within a small part of the scene, such as a room in a landscape, cells there begin as fine as they
    /// would if that part were all of the scene. Elsewhere nothing changes.
    fn expect_vertices(&mut self, vertices: &[(Vec3, Vec3)]) {
        let side = extent(vertices);
        let finer = if side > 0.0 { (self.longest / side).log2().floor().max(0.0) as u8 } else { 0 };
        let finer = finer.min(self.deepest().saturating_sub(1));
        let mut by_cell: Vec<(usize, (Vec3, Vec3))> = vertices
            .iter()
            .map(|vertex| (self.coarse((vertex.0 - self.origin) * self.cells_per_unit), *vertex))
            .collect();
        by_cell.sort_by_key(|(cell, _)| *cell);
        for cell in by_cell.chunk_by(|a, b| a.0 == b.0) {
            let vertices: Vec<(Vec3, Vec3)> = cell.iter().map(|(_, vertex)| *vertex).collect();
            self.levels[cell[0].0] = self.halvings(&vertices, finer);
        }
        self.max_level = (self.max_level + finer).min(self.deepest()).max(self.max_level);
    }

    fn stored(&self) -> StoredLevels {
        StoredLevels { levels: self.levels.clone(), max_level: self.max_level }
    }

    fn restore(&mut self, stored: StoredLevels, _memory: usize) -> Result<(), String> {
        let StoredLevels { levels, max_level } = stored;
        let fits = levels.len() == self.levels.len() && levels.iter().all(|&level| level <= max_level);
        if !fits || max_level < self.max_level || max_level > self.deepest() {
            return Err("its cells are not those of this grid".into());
        }
        (self.levels, self.max_level) = (levels, max_level);
        Ok(())
    }
}

/// The longest side of the box in which most of the vertices lie: along each axis some may lie anywhere on either side, and the rest
/// is taken for as much less than the whole.
fn extent(vertices: &[(Vec3, Vec3)]) -> f32 {
    if vertices.is_empty() {
        return 0.0;
    }
    let along = |axis: usize| {
        let mut at: Vec<f32> = vertices.iter().map(|(p, _)| p[axis]).collect();
        let astray = (ASTRAY * at.len() as f32) as usize;
        let last = at.len() - 1 - astray;
        let low = *at.select_nth_unstable_by(astray, f32::total_cmp).1;
        let high = *at.select_nth_unstable_by(last, f32::total_cmp).1;
        (high - low) / (1.0 - 2.0 * ASTRAY)
    };
    (0..3).map(along).fold(0.0, f32::max)
}

/// A point, in units of coarse cells, jittered by the extent of a part of a cell that was halved `level` times.
#[inline(always)]
fn moved(p: Vec3, n: Vec3, level: u8, jitter: [f32; 3]) -> Vec3 {
    let scale = (1u32 << level) as f32;
    jittered(p * scale, n, jitter) / scale
}

/// The part of a cell that was halved `level` times.
#[inline(always)]
fn part(p: Vec3, n: Vec3, level: u8) -> RegionId {
    RegionId(pack(p * (1u32 << level) as f32, normal_bin(n)) | (level as u64) << LEVEL_SHIFT)
}

/// How often the coarse cell of a region was halved.
fn level(key: RegionId) -> u8 {
    (key.0 >> LEVEL_SHIFT) as u8
}

impl RegionId {
    /// The eight regions of half the size.
    pub(in crate::guiding) fn parts(self) -> impl Iterator<Item = RegionId> {
        let axis = |axis: u32| ((self.0 >> (axis * POSITION_BITS)) & COORDINATE) << 1;
        let corner = axis(0) | axis(1) << POSITION_BITS | axis(2) << (2 * POSITION_BITS);
        let rest = self.0 & !((1u64 << (3 * POSITION_BITS)) - 1);
        (0..8u64).map(move |part| {
            let shift = (part & 1) | (part >> 1 & 1) << POSITION_BITS | (part >> 2) << (2 * POSITION_BITS);
            RegionId((rest + (1u64 << LEVEL_SHIFT)) | (corner + shift))
        })
    }

    /// The regions of the same size and normal beyond the six faces.
    pub(in crate::guiding) fn neighbours(self) -> impl Iterator<Item = RegionId> {
        (0..3u32).flat_map(move |axis| {
            let shift = axis * POSITION_BITS;
            let at = (self.0 >> shift) & COORDINATE;
            let rest = self.0 & !(COORDINATE << shift);
            [at.checked_sub(1), Some(at + 1).filter(|&at| at <= COORDINATE)]
                .into_iter()
                .flatten()
                .map(move |at| RegionId(rest | at << shift))
        })
    }
}
