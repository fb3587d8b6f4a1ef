//! What looks at a render while it goes on.

use super::limits::Spent;
use super::policy::{GuidePolicy, Mode, Verdict};
use super::state::{FIRST_ESTIMATE, Record, RenderState};
use crate::film::accumulate::Estimate;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::{Counters, Stop};
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

    /// Whether it wants to know the error of the picture.
    fn wants_error(&self) -> bool {
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
    pub(super) stop: &'a Stop,
}

impl Moment<'_> {
    /// What asks the render to end, also while somebody looks.
    pub(crate) fn stop(&self) -> &Stop {
        self.stop
    }

    /// The picture that there would be if the render ended now, in W/(sr·m²); without what the camera sees first.
    pub(crate) fn picture(&self) -> Estimate {
        in_watts(self.state.film.so_far(), self.unit)
    }

    /// Share of the camera's rays that met something, pixel by pixel.
    pub(crate) fn coverage(&self) -> Vec<f32> {
        self.state.film.coverage()
    }
}

/// Figures of a render so far.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Figures {
    /// Samples per pixel; on average, rounded down, where a pass was cut.
    pub(crate) samples: u32,
    /// Wall time of the render, with what it took before it was resumed.
    pub(crate) wall_seconds: f64,
    /// Camera paths, and all rays, shadow rays too.
    pub(crate) paths: u64,
    pub(crate) rays: u64,
    /// Estimated of the picture; `None` where too little is known.
    pub(crate) relative_error: Option<f64>,
    pub(crate) mode: Mode,
    /// What `auto` has found of the guide, if it was asked and knows something.
    pub(crate) verdict: Option<Verdict>,
    /// `None` where there is none to be learnt.
    pub(crate) guide: Option<GuideFigures>,
}

/// What is to be said of a guide.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct GuideFigures {
    pub(crate) method: &'static str,
    /// Places that it has learnt something of.
    pub(crate) states: usize,
    pub(crate) bytes: usize,
    /// Share of the directions drawn at surfaces with smooth lobes that the guide drew, in the iteration under way.
    pub(crate) drawn_share: f64,
}

impl Moment<'_> {
    pub(crate) fn figures(&self) -> Figures {
        let Moment { state, record, spent, .. } = *self;
        let newest = &record.report.counters;
        let rays = |of: &Counters| of.rays + of.shadow_rays;
        Figures {
            samples: state.samples(),
            wall_seconds: spent.wall.elapsed().as_secs_f64(),
            paths: state.paths,
            rays: state.iterations.iter().map(|i| rays(&i.counters)).sum::<u64>() + rays(newest),
            relative_error: state.error_so_far().filter(|_| state.samples() >= FIRST_ESTIMATE),
            mode: state.plan.mode,
            verdict: state.policy.verdict(),
            guide: state.guide.as_ref().filter(|guide| guide.method() != GuidingMethod::None).map(|guide| {
                GuideFigures {
                    method: guide.method().name(),
                    states: guide.states(),
                    bytes: guide.bytes(),
                    drawn_share: newest.guided_directions as f64 / newest.directions.max(1) as f64,
                }
            }),
        }
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
