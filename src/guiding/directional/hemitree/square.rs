//! Where the cells of a tree lie in the hemisphere's square.

use super::{DEPTH, SIDE};
use crate::math::Frame;
use crate::math::warp;
use crate::simd::{LANES, Mask, Vec3Lanes, mask, truncate};
use glam::Vec3;
use std::f32::consts::TAU;

/// Where a cell is: the size, by how many nodes lead to it, and its place among those of its size.
#[derive(Clone, Copy, Debug)]
pub struct SquareCell {
    pub depth: usize,
    pub x: u32,
    pub y: u32,
}

impl SquareCell {
    pub const ROOT: SquareCell = SquareCell { depth: 0, x: 0, y: 0 };

    #[inline]
    pub fn cell(self, k: usize) -> SquareCell {
        SquareCell { depth: self.depth + 1, x: self.x * SIDE + k as u32 % SIDE, y: self.y * SIDE + k as u32 / SIDE }
    }

    /// LearntTree of its size along the square's side.
    #[inline]
    pub fn side(self) -> u32 {
        1 << (SIDE.trailing_zeros() * self.depth as u32)
    }

    /// Uniform direction in the cell, in the region's frame.
    #[inline(always)]
    pub fn direction(self, inside: [f32; 2]) -> Vec3 {
        warp::square_to_uniform_hemisphere(self.point(inside))
    }

    /// The point of the hemisphere's square that it comes from.
    #[inline(always)]
    pub fn point(self, inside: [f32; 2]) -> [f32; 2] {
        let scale = 1.0 / self.side() as f32;
        [(self.x as f32 + inside[0]) * scale, (self.y as f32 + inside[1]) * scale]
    }

    #[inline]
    pub fn solid_angle(self) -> f32 {
        TAU / (self.side() * self.side()) as f32
    }
}

/// A direction in the region's frame, in units of the smallest cells; `None` below the horizon.
#[inline(always)]
pub fn coordinates(local: Vec3) -> Option<[u32; 2]> {
    (local.z >= 0.0).then(|| cells_of(warp::uniform_hemisphere_to_square(local)))
}

/// A point of the hemisphere's square in these units.
#[inline(always)]
pub fn cells_of(square: [f32; 2]) -> [u32; 2] {
    const SMALLEST: f32 = (SIDE * SIDE * SIDE) as f32;
    square.map(|v| truncate(v * SMALLEST))
}

/// The [`coordinates`] of directions, side by side.
pub struct CellCoords {
    x: [u32; LANES],
    y: [u32; LANES],
    above: Mask,
}

impl CellCoords {
    #[inline(always)]
    pub fn get(&self, k: usize) -> Option<[u32; 2]> {
        self.above.has(k).then(|| [self.x[k], self.y[k]])
    }
}

/// Those of directions in world space, in the frames about normals.
#[inline(never)]
pub fn coordinates_of(normals: &Vec3Lanes, w: &Vec3Lanes) -> CellCoords {
    let mut found = CellCoords { x: [0; LANES], y: [0; LANES], above: Mask::NONE };
    let mut z = [0.0; LANES];
    for k in 0..LANES {
        let local = Frame::from_normal(normals.get(k)).to_local(w.get(k));
        [found.x[k], found.y[k]] = cells_of(warp::uniform_hemisphere_to_square(local));
        z[k] = local.z;
    }
    found.above = mask(|k| z[k] >= 0.0);
    found
}

/// The cell at `depth` that holds the coordinates.
#[inline]
pub fn cell_at(x: u32, y: u32, depth: usize) -> usize {
    let shift = 2 * (DEPTH - depth);
    (((y >> shift) % SIDE) * SIDE + (x >> shift) % SIDE) as usize
}
