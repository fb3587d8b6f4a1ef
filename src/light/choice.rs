//! Which light is sampled. This is the one place that a choice which knows the lit point (a light hierarchy) replaces.

use crate::math::alias::AliasTable;
use crate::simd::LANES;

/// Chooses a light with probability proportional to its power.
#[derive(Clone, Debug)]
pub(super) struct PowerLightSampler {
    /// `None` where no light has power.
    table: Option<AliasTable>,
}

impl PowerLightSampler {
    /// Powers in W, finite and not negative.
    pub fn new(powers: &[f64]) -> PowerLightSampler {
        PowerLightSampler { table: AliasTable::new(powers) }
    }

    /// Index of a light and what is left of `u` as a fresh uniform number.
    #[inline]
    pub fn choose(&self, u: f64) -> Option<(usize, f64)> {
        self.table.as_ref().map(|table| table.sample_wide(u))
    }

    /// The lights alone for a packet; `None` where there is none.
    #[inline(always)]
    pub fn choose_lanes(&self, u: &[f64; LANES]) -> Option<[u32; LANES]> {
        self.table.as_ref().map(|table| table.sample_lanes(u))
    }

    /// Probability of a light.
    #[inline]
    pub fn pmf(&self, light: usize) -> f32 {
        self.table.as_ref().map_or(0.0, |table| table.pmf(light))
    }

    /// Whether no light has power.
    pub fn is_empty(&self) -> bool {
        self.table.is_none()
    }
}
