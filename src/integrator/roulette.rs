//! How many paths go on from a vertex: none, one, or several.

use crate::guiding::Summary;

/// Survival of roulette at most, so that no path between mirrors runs for ever.
pub const MAX_SURVIVAL: f32 = 0.95;

/// Paths go on with at least this expectation: light that the guide has not found yet must be able to come.
const MIN_SURVIVAL: f32 = 0.2;

/// What guided roulette weighs a path against, frozen for an iteration.
#[derive(Clone, Debug)]
pub struct Efficiency {
    /// Per pixel, 1 over the luminance that is expected there.
    pub inverse_luminance: Vec<f32>,
    /// √(C/V): C rays a camera path takes on average, V the average variance of its light, relative to the pixel.
    pub scale: f32,
}

impl Efficiency {
    /// Expected number of paths that go on (Rath et al. 2022, "EARS: Efficiency-Aware Russian Roulette and Splitting",
    /// eq. 21): √(V·c²/C') in units of the image's average, where V is the variance of what one of them brings (its
    /// second moment, where that asks for roulette), c what a pixel makes of it, C' the rays it takes.
    ///
    /// `reflected` is the luminance of throughput times albedo, `pixel` an index into `inverse_luminance`.
    #[inline]
    pub fn paths(&self, summary: &Summary, reflected: f32, pixel: usize, max_split: f32) -> f32 {
        let importance = reflected * self.inverse_luminance[pixel] * self.scale;
        let factor = |moment: f32| importance * (moment / summary.rays.max(1.0)).max(0.0).sqrt();
        let survival = factor(summary.square);
        let paths =
            if survival < 1.0 { survival } else { factor(summary.square - summary.mean * summary.mean).max(1.0) };
        paths.clamp(MIN_SURVIVAL, max_split.max(1.0))
    }
}

#[cfg(test)]
#[path = "roulette_tests.rs"]
mod tests;
