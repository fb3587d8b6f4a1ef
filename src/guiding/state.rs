//! States: which of the scene's surface points share a table.
//!
//! A state is a cell of a uniform grid together with a quantised normal. The normal is the *facing* one, flipped
//! to the side the path came from, so corners and the two sides of a thin sheet never share a table.

use crate::geometry::Frame;
use glam::{IVec3, Vec3};

/// Names a state; it is the same whoever asks, so a state needs no table to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StateKey(pub u64);

/// Bits for each coordinate of a cell.
const POSITION_BITS: u32 = 17;
/// Each face of the normals' cube is cut into `FACE`² bins; an odd number keeps an axis at a bin's centre.
pub(super) const FACE: i32 = 3;
pub(super) const NORMALS: usize = 6 * (FACE * FACE) as usize;

/// The uniform grid.
#[derive(Clone, Debug)]
pub struct Grid {
    origin: Vec3,
    cells_per_unit: f32,
    normals: bool,
    /// One frame per normal bin; without normals a single one, about +y.
    frames: Vec<Frame>,
}

impl Grid {
    /// `resolution` cells along the longest side of the box `(low, high)`.
    pub fn new(low: Vec3, high: Vec3, resolution: u32, normals: bool) -> Grid {
        let side = (high - low).max_element();
        let frames = match normals {
            true => (0..NORMALS).map(|bin| Frame::from_normal(bin_normal(bin))).collect(),
            false => vec![Frame::from_normal(Vec3::Y)],
        };
        // A single point has no extent; any cell size does.
        let cells_per_unit = if side > 0.0 { resolution as f32 / side } else { 1.0 };
        // Walls love round coordinates, and the box's own: an odd share of a cell keeps them off the cells' faces,
        // where rounding would split a wall between two layers of states.
        let origin = low - Vec3::new(1.37, 1.41, 1.33) / cells_per_unit;
        Grid { origin, cells_per_unit, normals, frames }
    }

    /// The state of point `p` with unit normal `n` on the side of the path. `jitter`, in [0, 1)², moves the point by
    /// up to half a cell along the surface: neighbouring tables blend over many queries, as in the stochastic
    /// filter of Müller (2019), and no query costs more than one look-up.
    #[inline]
    pub fn key(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> StateKey {
        let bin = if self.normals { normal_bin(n) } else { 0 };
        let frame = &self.frames[bin];
        let along = frame.s * (jitter[0] - 0.5) + frame.t * (jitter[1] - 0.5);
        let cell = (p - self.origin) * self.cells_per_unit + along;
        // Casts saturate and the border is kept: far outside of the grid everything is one border cell.
        let limit = (1 << POSITION_BITS) - 1;
        let c = IVec3::new(cell.x as i32, cell.y as i32, cell.z as i32).clamp(IVec3::ZERO, IVec3::splat(limit));
        let position = c.x as u64 | (c.y as u64) << POSITION_BITS | (c.z as u64) << (2 * POSITION_BITS);
        StateKey(position | (bin as u64) << (3 * POSITION_BITS))
    }

    /// The frame in which the state's table is held; `n` points into the hemisphere it covers.
    #[inline]
    pub fn frame(&self, key: StateKey) -> &Frame {
        &self.frames[(key.0 >> (3 * POSITION_BITS)) as usize]
    }
}

/// The face of the cube that `n` points through, and the part of that face.
#[inline]
pub(super) fn normal_bin(n: Vec3) -> usize {
    let a = n.abs();
    let (face, major, x, y) = if a.x >= a.y && a.x >= a.z {
        (if n.x < 0.0 { 1 } else { 0 }, a.x, n.y, n.z)
    } else if a.y >= a.z {
        (if n.y < 0.0 { 3 } else { 2 }, a.y, n.x, n.z)
    } else {
        (if n.z < 0.0 { 5 } else { 4 }, a.z, n.x, n.y)
    };
    let part = |v: f32| (((v / major + 1.0) * (0.5 * FACE as f32)) as i32).clamp(0, FACE - 1);
    ((face * FACE + part(x)) * FACE + part(y)) as usize
}

/// Unit vector through the centre of a bin.
pub(super) fn bin_normal(bin: usize) -> Vec3 {
    let (face, x, y) = (bin as i32 / (FACE * FACE), bin as i32 / FACE % FACE, bin as i32 % FACE);
    let centre = |i: i32| (2 * i + 1) as f32 / FACE as f32 - 1.0;
    let (x, y, sign) = (centre(x), centre(y), if face % 2 == 0 { 1.0 } else { -1.0 });
    match face / 2 {
        0 => Vec3::new(sign, x, y),
        1 => Vec3::new(x, sign, y),
        _ => Vec3::new(x, y, sign),
    }
    .normalize()
}
