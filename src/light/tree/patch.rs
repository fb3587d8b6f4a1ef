//! What a leaf of the tree is: a light, or two triangles that are one flat patch.

use super::LightBounds;
use super::draw::rest;
use crate::simd::pick;

/// A light by its index, or two of them that follow each other and are chosen as one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub light: u32,
    /// Share that the first of two has of their area; 1 where there is one light.
    pub share: f32,
    pub bounds: LightBounds,
}

impl Patch {
    pub fn is_pair(&self) -> bool {
        self.share < 1.0
    }

    /// The triangle `self` and the next, whose areas are in the ratio of `areas`.
    pub fn with(&self, next: &LightBounds, areas: [f64; 2]) -> Patch {
        let share = areas[0] / (areas[0] + areas[1]);
        let (a, b) = (&self.bounds, next);
        let centre = a.centre + (b.centre - a.centre) * (1.0 - share) as f32;
        let radius = (a.centre.distance(centre) + a.radius).max(b.centre.distance(centre) + b.radius);
        let off = |light: &LightBounds| light.thickness + (light.centre - centre).dot(a.axis).abs();
        // the axis of the second is that of the first but for rounding
        let thickness = off(a).max(off(b) + a.axis.distance(b.axis) * 2.0 * radius);
        let (lo, hi, intensity) = (a.lo.min(b.lo), a.hi.max(b.hi), a.intensity + b.intensity);
        let share = (share as f32).clamp(f32::EPSILON, 1.0 - f32::EPSILON);
        Patch { share, bounds: LightBounds { lo, hi, centre, radius, thickness, intensity, ..*a }, ..*self }
    }
}

/// Of the two triangles of a patch, the one to which a number points: whether it is the second, its probability, and what is
/// left of the number. `share` is 1 where there is but one.
#[inline(always)]
pub(super) fn part(share: f32, u: f64) -> (u32, f32, f64) {
    let first = f64::from(share);
    let second = u >= first;
    let (into, of) = pick(second, (u - first, 1.0 - first), (u, first));
    (u32::from(second), pick(second, 1.0 - share, share), rest(into, of))
}
