//! Lanes: one number for each ray of a packet. A loop over all lanes becomes vector instructions if its body is arithmetic and
//! [`pick`] alone, without branches and table look-ups.

use super::{Packing, instructions};
use glam::Vec3;
use std::ops::{BitAnd, BitOr, Not};

/// Rays of a packet, and vertices that are worked on at once.
pub(crate) const LANES: usize = 16;

/// One number for each ray of a packet.
pub(crate) type Lanes = [f32; LANES];

/// A mask of lanes, one bit per lane. (A byte per lane, written one by one and read at once, would stall on store forwarding.)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mask(u16);

/// The mask of the lanes for which `is(lane)` holds.
#[inline(always)]
pub(crate) fn mask(is: impl Fn(usize) -> bool) -> Mask {
    let mut lanes = [0; LANES];
    for k in 0..LANES {
        lanes[k] = if is(k) { u32::MAX } else { 0 };
    }
    Mask(instructions::bits(&lanes))
}

impl Mask {
    pub(crate) const NONE: Mask = Mask(0);

    /// Lanes by their bits, that of lane 0 being the lowest.
    #[inline(always)]
    pub(crate) fn from_bits(bits: u16) -> Mask {
        Mask(bits)
    }

    #[inline(always)]
    pub(crate) fn bits(self) -> u16 {
        self.0
    }

    /// Whether lane `k` is set. Loops over all lanes should test [`Self::lanes`] instead, which vectorises.
    #[inline(always)]
    pub(crate) fn has(self, k: usize) -> bool {
        self.0 >> k & 1 != 0
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.0 != 0
    }

    /// How many there are.
    #[inline(always)]
    pub(crate) fn count(self) -> u64 {
        self.0.count_ones().into()
    }

    /// Sets or clears lane `k`.
    #[inline(always)]
    pub(crate) fn set(&mut self, k: usize, is: bool) {
        self.0 = self.0 & !(1 << k) | (is as u16) << k;
    }

    /// The mask as one word per lane, for loops over all lanes.
    #[inline(always)]
    pub(crate) fn lanes(self) -> MaskLanes {
        MaskLanes(instructions::spread(self.0))
    }
}

impl BitAnd for Mask {
    type Output = Mask;

    #[inline(always)]
    fn bitand(self, other: Mask) -> Mask {
        Mask(self.0 & other.0)
    }
}

impl BitOr for Mask {
    type Output = Mask;

    #[inline(always)]
    fn bitor(self, other: Mask) -> Mask {
        Mask(self.0 | other.0)
    }
}

impl Not for Mask {
    type Output = Mask;

    #[inline(always)]
    fn not(self) -> Mask {
        Mask(!self.0)
    }
}

/// See [`Mask::lanes`].
#[derive(Clone, Copy)]
pub(crate) struct MaskLanes([u32; LANES]);

impl MaskLanes {
    #[inline(always)]
    pub(crate) fn has(&self, k: usize) -> bool {
        self.0[k] != 0
    }
}

/// Branch-free select: `a` where `is` holds, else `b`. Both operands are evaluated, so that the compiler can use a vector blend.
#[inline(always)]
pub(crate) fn pick<T>(is: bool, a: T, b: T) -> T {
    if is { a } else { b }
}

/// Iterates over the lanes that are set, from the lowest, without a branch per lane: only the end of the loop may be
/// mispredicted.
#[inline(always)]
pub(crate) fn each(mask: Mask) -> Each {
    Each(mask.0 as u32)
}

/// See [`each`].
pub(crate) struct Each(u32);

impl Iterator for Each {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        // says to the compiler that there are no more
        Some(lane % LANES)
    }
}

/// One vector for each, by component.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Vec3Lanes {
    x: Lanes,
    y: Lanes,
    z: Lanes,
}

impl Vec3Lanes {
    pub(crate) const ZERO: Vec3Lanes = Vec3Lanes { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    /// Components, row by row.
    #[inline(always)]
    pub(crate) fn rows(&self) -> [&Lanes; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// Puts the lanes that were chosen behind those which are there; see [`Packing::put`].
    #[inline(always)]
    pub(crate) fn pack(&self, packing: &Packing, [first, second]: [&mut Vec3Lanes; 2]) {
        packing.put(&self.x, [&mut first.x, &mut second.x]);
        packing.put(&self.y, [&mut first.y, &mut second.y]);
        packing.put(&self.z, [&mut first.z, &mut second.z]);
    }

    /// Takes over whole rows of components.
    #[inline(always)]
    pub(crate) fn set_rows(&mut self, [x, y, z]: [&Lanes; 3]) {
        (self.x, self.y, self.z) = (*x, *y, *z);
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}

/// `v` at unit length; `None`'s place is taken by `otherwise` where it has no direction. As glam's `try_normalize`, but a
/// choice and no jump.
#[inline(always)]
pub(crate) fn normalize_or(v: Vec3, otherwise: Vec3) -> Vec3 {
    let scale = v.length_recip();
    if scale.is_finite() && scale > 0.0 { v * scale } else { otherwise }
}

/// Branch-free truncation of `v` to an integer, clamped to [0, 2²³). (An `as` cast saturates, which takes branches.)
#[inline(always)]
#[allow(clippy::manual_clamp, reason = "NaN must become 0, as in a cast; `clamp` would keep it")]
pub(crate) fn truncate(v: f32) -> u32 {
    /// From here on numbers have no fraction, and are counted by their last bits.
    const UNIT: f32 = (1 << 23) as f32;
    (v.max(0.0).min(UNIT - 1.0).floor() + UNIT).to_bits() - UNIT.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lane_of_a_mask_comes_once_and_in_order() {
        for some in [0, 1, 0x8000, 0xffff, 0b1010_0110u16] {
            let is = |k: usize| some >> k & 1 == 1;
            let lanes = mask(is);
            assert_eq!(lanes.bits(), some);
            assert_eq!(each(lanes).collect::<Vec<_>>(), (0..LANES).filter(|&k| is(k)).collect::<Vec<_>>());
            assert!((0..LANES).all(|k| lanes.has(k) == is(k) && lanes.lanes().has(k) == is(k)));
        }
    }

    #[test]
    fn truncation_is_that_of_a_cast_that_saturates() {
        const MOST: u32 = (1 << 23) - 1;
        let some =
            [-1e9, -1.0, -0.0, 0.0, 0.999_999_94, 1.0, 2.5, 8_388_606.5, 8_388_607.0, 1e9, f32::INFINITY, f32::NAN];
        for v in some.into_iter().chain((0..100_000).map(|k| k as f32 * 0.7)) {
            assert_eq!(truncate(v), (v as u32).min(MOST), "{v}");
        }
    }
}
