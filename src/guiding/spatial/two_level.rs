//! Cells that refine where it pays: the paper's future work 6.4.

use super::normal_bins::normal_bin;
use super::{NORMAL_BITS, POSITION_BITS, StateKey, jittered, lay, pack};
use crate::simd::{LANES, Vec3Lanes, truncate};
use glam::{UVec3, Vec3};

/// A coarse grid, each cell of which is cut into 1, 2³, 4³ … equal parts. How often is one number per coarse cell, in a
/// dense array that the cache holds, so that a look-up costs one more read than in a uniform grid, however fine.
#[derive(Clone, Debug)]
pub struct Adaptive {
    origin: Vec3,
    cells_per_unit: f32,
    size: UVec3,
    /// Halvings of each coarse cell.
    levels: Vec<u8>,
    /// Halvings at most.
    max_level: u8,
}

/// One coordinate of a cell.
const COORDINATE: u64 = (1 << POSITION_BITS) - 1;
/// Place of the level in a key.
const LEVEL_SHIFT: u32 = 3 * POSITION_BITS + NORMAL_BITS;

impl Adaptive {
    /// As [`Self::new`], with fewer cells where so many would take more than `most` bytes.
    pub fn within(low: Vec3, high: Vec3, resolution: u32, max_level: u8, most: usize) -> Adaptive {
        let fits =
            |resolution: &u32| Adaptive::size(low, high, *resolution).2.as_u64vec3().element_product() <= most as u64;
        let halved = std::iter::successors(Some(resolution), |resolution| (*resolution > 1).then(|| resolution / 2));
        Adaptive::new(low, high, halved.into_iter().find(fits).unwrap_or(1), max_level)
    }

    /// Origin, cells per unit of length and cells along each axis.
    fn size(low: Vec3, high: Vec3, resolution: u32) -> (Vec3, f32, UVec3) {
        let (origin, cells_per_unit) = lay(low, high, resolution);
        (origin, cells_per_unit, ((high - origin) * cells_per_unit + 2.0).as_uvec3().max(UVec3::ONE))
    }

    /// `resolution` coarse cells along the longest side of the box `(low, high)`, each halved up to `max_level` times.
    pub fn new(low: Vec3, high: Vec3, resolution: u32, max_level: u8) -> Adaptive {
        let (origin, cells_per_unit, size) = Adaptive::size(low, high, resolution);
        let cells = size.x as usize * size.y as usize * size.z as usize;
        Adaptive { origin, cells_per_unit, size, levels: vec![0; cells], max_level }
    }

    #[inline(always)]
    pub fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> StateKey {
        let p = (p - self.origin) * self.cells_per_unit;
        // moved by the extent of its own part of a cell, a point may come into a cell that is cut otherwise
        let p = moved(p, n, self.levels[self.coarse(p)], jitter);
        part(p, n, self.levels[self.coarse(p)])
    }

    /// [`Self::key`] for a packet.
    #[inline(never)]
    pub fn keys(&self, points: &Vec3Lanes, normals: &Vec3Lanes, jitter: [f32; 2]) -> [StateKey; LANES] {
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
        let mut keys = [StateKey(0); LANES];
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

    /// The coarse cell that a state is part of.
    pub fn coarse_of(&self, key: StateKey) -> usize {
        let level = level(key);
        let at = |axis: u32| ((key.0 >> (axis * POSITION_BITS)) as u32 & ((1 << POSITION_BITS) - 1)) >> level;
        let c = UVec3::new(at(0), at(1), at(2)).min(self.size - 1);
        ((c.z * self.size.y + c.y) * self.size.x + c.x) as usize
    }

    pub fn coarse_cells(&self) -> usize {
        self.levels.len()
    }

    /// Halves the parts of a coarse cell once more, unless they are the smallest there are; returns whether it did.
    pub fn refine(&mut self, coarse: usize) -> bool {
        let refined = self.levels[coarse] < self.max_level;
        self.levels[coarse] += refined as u8;
        refined
    }

    /// Whether a state is of the size that its coarse cell now has.
    pub fn current(&self, key: StateKey) -> bool {
        self.levels[self.coarse_of(key)] == level(key)
    }

    /// Whether a key names a state of a size that there now is.
    pub fn holds(&self, key: StateKey) -> bool {
        level(key) <= self.max_level && self.current(key)
    }

    /// How often each coarse cell was halved.
    pub fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// Takes over how often each coarse cell was halved; `false` where the cells are not these.
    pub fn set_levels(&mut self, levels: Vec<u8>) -> bool {
        let fits = levels.len() == self.levels.len() && levels.iter().all(|&level| level <= self.max_level);
        if fits {
            self.levels = levels;
        }
        fits
    }

    pub fn bytes(&self) -> usize {
        self.levels.len()
    }
}

/// A point, in units of coarse cells, jittered by the extent of a part of a cell that was halved `level` times.
#[inline(always)]
fn moved(p: Vec3, n: Vec3, level: u8, jitter: [f32; 2]) -> Vec3 {
    let scale = (1u32 << level) as f32;
    jittered(p * scale, n, jitter) / scale
}

/// The part of a cell that was halved `level` times.
#[inline(always)]
fn part(p: Vec3, n: Vec3, level: u8) -> StateKey {
    StateKey(pack(p * (1u32 << level) as f32, normal_bin(n)) | (level as u64) << LEVEL_SHIFT)
}

/// How often the coarse cell of a state was halved.
fn level(key: StateKey) -> u8 {
    (key.0 >> LEVEL_SHIFT) as u8
}

impl StateKey {
    /// The eight states of half the size.
    pub fn parts(self) -> impl Iterator<Item = StateKey> {
        let axis = |axis: u32| ((self.0 >> (axis * POSITION_BITS)) & COORDINATE) << 1;
        let corner = axis(0) | axis(1) << POSITION_BITS | axis(2) << (2 * POSITION_BITS);
        let rest = self.0 & !((1u64 << (3 * POSITION_BITS)) - 1);
        (0..8u64).map(move |part| {
            let shift = (part & 1) | (part >> 1 & 1) << POSITION_BITS | (part >> 2) << (2 * POSITION_BITS);
            StateKey((rest + (1u64 << LEVEL_SHIFT)) | (corner + shift))
        })
    }

    /// The states of the same size and normal beyond the six faces.
    pub fn neighbours(self) -> impl Iterator<Item = StateKey> {
        (0..3u32).flat_map(move |axis| {
            let shift = axis * POSITION_BITS;
            let at = (self.0 >> shift) & COORDINATE;
            let rest = self.0 & !(COORDINATE << shift);
            [at.checked_sub(1), Some(at + 1).filter(|&at| at <= COORDINATE)]
                .into_iter()
                .flatten()
                .map(move |at| StateKey(rest | at << shift))
        })
    }
}
