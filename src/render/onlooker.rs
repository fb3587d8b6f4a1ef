//! What looks at a render while it goes on.

use crate::film::accumulate::{Estimate, Film};
use crate::light::LightUnit;
use rayon::prelude::*;

/// Looks at a render between its passes, and changes nothing of it.
pub trait Onlooker {
    /// Whether it wants to look now; where the render `ends`, for the last time.
    fn is_due(&mut self, ends: bool) -> bool;

    /// Looks; only after it has said that it wants to.
    fn look(&mut self, moment: &Moment);
}

/// Nobody.
impl Onlooker for () {
    fn is_due(&mut self, _ends: bool) -> bool {
        false
    }

    fn look(&mut self, _moment: &Moment) {}
}

/// A render between two passes. All that was traced is in its film.
pub struct Moment<'a> {
    pub(super) film: &'a Film,
    pub(super) unit: LightUnit,
}

impl Moment<'_> {
    /// The picture that there would be if the render ended now, in W/(sr·m²); without what the camera sees first.
    pub(crate) fn picture(&self) -> Estimate {
        in_watts(self.film.so_far(), self.unit)
    }

    /// Share of the camera's rays that met something, pixel by pixel.
    pub(crate) fn coverage(&self) -> Vec<f32> {
        self.film.coverage()
    }
}

/// A picture in `unit`, as one in W/(sr·m²).
pub(super) fn in_watts(mut estimate: Estimate, unit: LightUnit) -> Estimate {
    estimate.mean.par_iter_mut().for_each(|mean| *mean = unit.radiance(*mean));
    estimate.layers.par_iter_mut().flat_map(|(_, means)| means).for_each(|mean| *mean = unit.radiance(*mean));
    estimate.variance.par_iter_mut().for_each(|variance| *variance = unit.squared_radiance(*variance));
    estimate
}

#[cfg(test)]
#[path = "onlooker_tests.rs"]
mod tests;
