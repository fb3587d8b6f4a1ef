//! What looks at a render while it goes on.

use super::limits::Spent;
use super::state::{Record, RenderState};
use crate::film::accumulate::Estimate;
use crate::light::LightUnit;
use rayon::prelude::*;

/// When somebody may look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occasion {
    /// Between two passes.
    Between,
    /// After the last pass, or the last part of one.
    Last,
    /// The same, where somebody waits impatiently for the end.
    AtOnce,
}

/// Looks at a render between its passes, and changes nothing of it.
pub trait Onlooker {
    /// Whether it wants to look now.
    fn is_due(&mut self, occasion: Occasion) -> bool;

    /// Looks; only after it has said that it wants to.
    fn look(&mut self, moment: &Moment);

    /// Whether it may ask for a checkpoint, which takes memory for what is learnt.
    fn keeps_state(&self) -> bool {
        false
    }
}

/// Nobody.
impl Onlooker for () {
    fn is_due(&mut self, _occasion: Occasion) -> bool {
        false
    }

    fn look(&mut self, _moment: &Moment) {}
}

/// A render between two passes, or where it ended in the middle of one. All that was traced is in its film, and learnt.
pub struct Moment<'a> {
    pub(super) state: &'a RenderState,
    pub(super) record: &'a Record,
    pub(super) spent: Spent,
    pub(super) unit: LightUnit,
    pub(super) keeps_guide: bool,
}

impl Moment<'_> {
    /// The picture that there would be if the render ended now, in W/(sr·m²); without what the camera sees first.
    pub(crate) fn picture(&self) -> Estimate {
        in_watts(self.state.film.so_far(), self.unit)
    }

    /// Share of the camera's rays that met something, pixel by pixel.
    pub(crate) fn coverage(&self) -> Vec<f32> {
        self.state.film.coverage()
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
