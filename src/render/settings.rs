//! How a render is asked for.

use crate::film::Combine;

/// How long, from which numbers, and what becomes of the iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples per pixel over all iterations.
    pub spp: u32,
    /// Seconds after loading; rendering stops at whichever of `spp` and `time` comes first, but not before every pixel has a
    /// sample.
    pub time: Option<f64>,
    pub seed: u64,
    pub combine: Combine,
    pub order: Order,
    /// Watertight ray queries: no ray slips between two triangles that share an edge, for about a quarter of the speed.
    pub robust: bool,
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            spp: 64,
            time: None,
            seed: 0,
            combine: Combine::InverseVariance,
            order: Order::Progressive,
            robust: false,
        }
    }
}

/// Which samples come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Passes over the whole picture, in iterations of doubling length.
    Progressive,
    /// One block after the other, each with all of its samples, from the middle outwards: a single iteration.
    Blocks,
}
