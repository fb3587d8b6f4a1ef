//! Keys of grids: the quantised position and the bin of the facing normal.

use crate::math::Frame;
use crate::simd::truncate;
use glam::Vec3;

/// Bits for each coordinate of a cell.
pub const POSITION_BITS: u32 = 17;
pub const NORMAL_BITS: u32 = 6;

/// Moves `p`, in units of cells, by up to half a cell along the surface with normal `n`.
#[inline(always)]
pub fn jittered(p: Vec3, n: Vec3, jitter: [f32; 3]) -> Vec3 {
    let frame = Frame::from_normal(n);
    p + frame.s * (jitter[0] - 0.5) + frame.t * (jitter[1] - 0.5)
}

/// A key from the cell that holds `cell`, and a normal's bin. The border is kept: far outside of the grid everything is
/// one border cell.
#[inline(always)]
pub fn pack(cell: Vec3, bin: usize) -> u64 {
    let limit = (1 << POSITION_BITS) - 1;
    let coordinate = |v: f32| truncate(v).min(limit) as u64;
    let (x, y, z) = (coordinate(cell.x), coordinate(cell.y), coordinate(cell.z));
    let position = x | y << POSITION_BITS | z << (2 * POSITION_BITS);
    position | (bin as u64) << (3 * POSITION_BITS)
}

/// Where a grid over the box `(low, high)` starts, and its cells per unit of length.
pub fn origin_and_scale(low: Vec3, high: Vec3, resolution: u32) -> (Vec3, f32) {
    let side = (high - low).max_element();
    // A single point has no extent; any cell size does.
    let cells_per_unit = if side > 0.0 { resolution as f32 / side } else { 1.0 };
    // Walls love round coordinates, and the box's own: an odd share of a cell keeps them off the cells' faces,
    // where rounding would split a wall between two layers of regions.
    (low - Vec3::new(1.37, 1.41, 1.33) / cells_per_unit, cells_per_unit)
}
