//! How many paths go on from a vertex: none, one, or several; and whether it looks at a light.

use crate::guiding::{Hue, RegionInfo};
use crate::simd::pick;

/// Survival of roulette at most, so that no path between mirrors runs for ever.
pub(crate) const MAX_SURVIVAL: f32 = 0.95;

/// Paths go on with at least this expectation: light that the guide has not found yet must be able to come.
const MIN_SURVIVAL: f32 = 0.2;

/// Shadow rays are cast with at least this probability: what a region has learnt may not hold everywhere in it.
const MIN_CAST: f32 = 0.1;

/// What a shadow ray costs, in rays that ask for their closest hit.
const SHADOW_COST: f32 = 0.5;

/// What guided roulette weighs a path against, frozen for an iteration.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct RouletteNormalisation {
    /// Per pixel, 1 over the luminance that is expected there.
    pub(crate) inverse_luminance: Vec<f32>,
    /// √(C/V): C rays a camera path takes on average, V the average variance of its light, relative to the pixel.
    pub(crate) scale: f32,
}

impl RouletteNormalisation {
    /// Expected number of paths that go on (Rath et al. 2022, "EARS: Efficiency-Aware Russian Roulette and Splitting",
    /// eq. 21): √(V·c²/C') in units of the image's average, where V is the variance of what one of them brings (its
    /// second moment, where that asks for roulette), c what a pixel makes of it, C' the rays it takes.
    ///
    /// `reflected` is the luminance of throughput times albedo, `inverse_luminance` that of the pixel. Without a jump, so
    /// that a loop over many runs in vectors.
    #[inline(always)]
    pub(crate) fn paths(&self, moments: Moments, reflected: f32, inverse_luminance: f32, max_split: f32) -> f32 {
        let Moments { square, variance, .. } = moments;
        let importance = reflected * inverse_luminance * self.scale;
        let factor = |moment: f32| importance * moment.max(0.0).sqrt();
        let (survival, split) = (factor(square), factor(variance).max(1.0));
        pick(survival < 1.0, survival, split).max(MIN_SURVIVAL).min(max_split.max(1.0))
    }

    /// Probability with which a shadow ray is cast, by the same equation. `brought` is the luminance that the ray would bring to a pixel
    /// of this `inverse_luminance`, were it open, and `open` the probability that it is. That much of it is expected without the ray:
    /// what is at stake is the square of what is found less what was expected, brought²·open·(1 − open). Without a jump.
    #[inline(always)]
    pub(crate) fn cast(&self, brought: f32, inverse_luminance: f32, open: f32) -> f32 {
        let cast = brought * inverse_luminance * self.scale * (open * (1.0 - open) / SHADOW_COST).max(0.0).sqrt();
        pick(cast < 1.0, cast.max(MIN_CAST), 1.0)
    }
}

/// What a state knows of the one-sample estimate of irradiance/π: its second moment and its variance, each over the rays that it takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub(crate) square: f32,
    pub(crate) variance: f32,
    /// What is expected of it: luminance and colour.
    pub(crate) expected: f32,
    pub(crate) hue: Hue,
}

impl Moments {
    #[inline(always)]
    pub(crate) fn of(&RegionInfo { square, variance, expected, hue, .. }: &RegionInfo) -> Moments {
        Moments { square, variance, expected, hue }
    }
}

#[cfg(test)]
#[path = "roulette_tests.rs"]
mod tests;
