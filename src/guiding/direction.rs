//! Unit vectors in 32 bits, so that a transition stays small.

use glam::{Vec2, Vec3};

/// A unit vector by the octahedral map (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
/// Unit Vectors"), 16 bits for each coordinate: wrong by less than 10⁻⁴ radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackedDirection(u32);

const STEPS: f32 = u16::MAX as f32;

impl PackedDirection {
    #[inline]
    pub fn new(w: Vec3) -> PackedDirection {
        let p = w.truncate() / (w.x.abs() + w.y.abs() + w.z.abs());
        let p = if w.z < 0.0 { fold(p) } else { p };
        let quantised = ((p * 0.5 + 0.5) * STEPS).round();
        PackedDirection(quantised.x as u32 | (quantised.y as u32) << 16)
    }

    #[inline]
    pub fn unpack(self) -> Vec3 {
        let p = Vec2::new((self.0 & 0xffff) as f32, (self.0 >> 16) as f32) * (2.0 / STEPS) - 1.0;
        let z = 1.0 - p.x.abs() - p.y.abs();
        let p = if z < 0.0 { fold(p) } else { p };
        p.extend(z).normalize()
    }
}

/// The lower half of the octahedron folds over the edges of the upper.
#[inline]
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
        }
    }
}
