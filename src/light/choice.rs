//! Which light is sampled where the lit point plays no part.

use super::tree::{Choice, ChoiceLanes};
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

    #[inline]
    pub fn choose(&self, u: f64) -> Option<Choice> {
        let (light, rest) = self.table.as_ref()?.sample_wide(u);
        Some(Choice { light: light as u32, pmf: self.pmf(light), rest })
    }

    /// The same for a packet; `None` where there is no light.
    #[inline(always)]
    pub fn choose_lanes(&self, u: &[f64; LANES]) -> Option<ChoiceLanes> {
        let (light, rest) = self.table.as_ref()?.sample_lanes(u);
        Some(ChoiceLanes { light, pmf: light.map(|light| self.pmf(light as usize)), rest })
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
