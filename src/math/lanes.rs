//! Numbers side by side, as many as a packet has rays. A loop over them whose body is plain arithmetic, with choices but
//! without jumps or look-ups, becomes vector instructions.

use glam::Vec3;

/// Rays of a packet, and vertices that are worked on at once.
pub const LANES: usize = 16;

/// One number for each.
pub type Lanes = [f32; LANES];

/// Some of them.
pub type Mask = [bool; LANES];

/// Those of which it is so. In place of `array::from_fn`, which compilers leave as a call a lane.
#[inline(always)]
pub fn mask(is: impl Fn(usize) -> bool) -> Mask {
    let mut mask = [false; LANES];
    for k in 0..LANES {
        mask[k] = is(k);
    }
    mask
}

/// The lanes of a mask, one after the other. Where loops test each lane, every test of lanes that come as they like is a
/// guess that processors often lose; this loses one at its end.
#[inline(always)]
pub fn each(mask: &Mask) -> Each {
    let mut lanes = 0;
    for k in 0..LANES {
        lanes |= (mask[k] as u32) << k;
    }
    Each(lanes)
}

/// See [`each`].
pub struct Each(u32);

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
    pub const ZERO: Vec3Lanes = Vec3Lanes { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    /// Takes over whole rows of components.
    #[inline(always)]
    pub fn set_rows(&mut self, [x, y, z]: [&Lanes; 3]) {
        (self.x, self.y, self.z) = (*x, *y, *z);
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}

/// `v` at unit length; `None`'s place is taken by `otherwise` where it has no direction. As glam's `try_normalize`, but a
/// choice and no jump.
#[inline(always)]
pub fn normalize_or(v: Vec3, otherwise: Vec3) -> Vec3 {
    let scale = v.length_recip();
    if scale.is_finite() && scale > 0.0 { v * scale } else { otherwise }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lane_of_a_mask_comes_once_and_in_order() {
        for some in [0, 1, 0x8000, 0xffff, 0b1010_0110] {
            let is = |k: usize| some >> k & 1 == 1;
            assert_eq!(each(&mask(is)).collect::<Vec<_>>(), (0..LANES).filter(|&k| is(k)).collect::<Vec<_>>());
        }
    }
}
