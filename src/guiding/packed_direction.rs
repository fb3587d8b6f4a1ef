//! Unit vectors in 32 bits, so that a transition stays small.

use crate::simd::{LANES, Vec3Lanes, truncate};
use glam::{Vec2, Vec3};

/// A unit vector by the octahedral map (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
/// Unit Vectors"), 16 bits for each coordinate: wrong by less than 10⁻⁴ radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackedDirection(u32);

/// Bits of each coordinate by which cells of the sphere are told apart.
const CELL_BITS: u32 = 5;

const STEPS: f32 = u16::MAX as f32;

impl PackedDirection {
    #[inline(always)]
    pub fn new(w: Vec3) -> PackedDirection {
        let scale = w.x.abs() + w.y.abs() + w.z.abs();
        let p = Vec2::new(w.x / scale, w.y / scale);
        let (folded, below) = (fold(p), w.z < 0.0);
        let quantised = |flat: f32, folded: f32| {
            let coordinate = if below { folded } else { flat };
            truncate(((coordinate * 0.5 + 0.5) * STEPS).round())
        };
        PackedDirection(quantised(p.x, folded.x) | quantised(p.y, folded.y) << 16)
    }

    /// The [`Self::bits`] of a packet's directions.
    #[inline(never)]
    pub fn of_lanes(w: &Vec3Lanes) -> [u32; LANES] {
        let mut packed = [0; LANES];
        for k in 0..LANES {
            packed[k] = PackedDirection::new(w.get(k)).0;
        }
        packed
    }

    /// The 32 bits, for [`Self::from_bits`].
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub fn from_bits(bits: u32) -> PackedDirection {
        PackedDirection(bits)
    }

    /// Cells of [`Self::cell`].
    pub(crate) const CELLS: u32 = 1 << (2 * CELL_BITS);

    /// Which of [`Self::CELLS`] cells of the sphere it lies in, squares of the octahedral map.
    #[inline]
    pub(crate) fn cell(self) -> u32 {
        let coordinate = |v: u32| v >> (16 - CELL_BITS);
        coordinate(self.0 & 0xffff) | coordinate(self.0 >> 16) << CELL_BITS
    }

    /// The middle of such a cell.
    pub(crate) fn of_cell(cell: u32) -> PackedDirection {
        let (side, half) = ((1 << CELL_BITS) - 1, 1 << (15 - CELL_BITS));
        let coordinate = |v: u32| (v & side) << (16 - CELL_BITS) | half;
        PackedDirection(coordinate(cell) | coordinate(cell >> CELL_BITS) << 16)
    }

    #[inline(always)]
    pub fn unpack(self) -> Vec3 {
        let p = Vec2::new((self.0 & 0xffff) as f32, (self.0 >> 16) as f32) * (2.0 / STEPS) - 1.0;
        let z = 1.0 - p.x.abs() - p.y.abs();
        let (folded, below) = (fold(p), z < 0.0);
        // choices of single numbers, which run in vectors
        let (x, y) = (if below { folded.x } else { p.x }, if below { folded.y } else { p.y });
        Vec3::new(x, y, z).normalize()
    }

    /// The same for a packet.
    #[inline(never)]
    pub fn unpack_lanes(packed: &[PackedDirection; LANES], w: &mut Vec3Lanes) {
        for k in 0..LANES {
            w.set(k, packed[k].unpack());
        }
    }
}

/// The lower half of the octahedron folds over the edges of the upper.
#[inline(always)]
fn fold(p: Vec2) -> Vec2 {
    Vec2::new((1.0 - p.y.abs()).copysign(p.x), (1.0 - p.x.abs()).copysign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{rng::Rng, warp};

    #[test]
    fn what_is_packed_comes_back() {
        let mut rng = Rng::new(1);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|a| [a, -a]);
        let random = (0..100_000).map(|_| warp::square_to_uniform_sphere(rng.f32x2()));
        for w in axes.chain(random) {
            let back = PackedDirection::new(w).unpack();
            assert!((back - w).length() < 1e-4, "{w} became {back}");
            let mut lanes = Vec3Lanes::ZERO;
            lanes.set(3, w);
            assert_eq!(PackedDirection::of_lanes(&lanes)[3], PackedDirection::new(w).bits());
            PackedDirection::unpack_lanes(&[PackedDirection::new(w); LANES], &mut lanes);
            assert_eq!(lanes.get(3), back);
        }
    }
}
