//! Numbers side by side, as many as a packet has rays. A loop over them whose body is plain arithmetic, with choices but
//! without jumps or look-ups, becomes vector instructions.

use glam::Vec3;

/// Rays of a packet, and vertices that are worked on at once.
pub const LANES: usize = 16;

/// One number for each.
pub type Lanes = [f32; LANES];

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
