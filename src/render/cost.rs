//! What samples cost: processor time by the clock, or, where a clock must not decide, a count of what was done.

use crate::integrator::Counters;

/// What cost is counted in: rays; a shadow ray with the choice of its light; a vertex at which the guide was asked and drawn
/// from. Fitted to a box of 36 triangles and a room of 143,000, whose guided samples took 1.4 to 1.7 and 1.3 times as long as
/// others by the clock.
pub(super) const SHADOW_COST: f64 = 0.5;
pub(super) const GUIDE_COST: f64 = 0.6;

/// The same of a transition, recorded and learnt from.
pub(super) const LEARNING_COST: f64 = 0.5;

/// Seconds in which durations are counted, and the least that anything costs: costs are divided by each other.
pub(super) const CLOCK_STEP: f64 = 1e-9;

/// An iteration that was just rendered.
pub struct Rendered<'a> {
    /// Samples per pixel.
    pub samples: u32,
    pub counters: &'a Counters,
    /// Processor time of all threads that went into learning between rounds.
    pub learning: f64,
}

/// Tells costs, in seconds or in rays.
#[derive(Clone, Copy, Debug)]
pub struct Meter {
    /// Cost is what the clock says; else it is counted, so that the same seed always gives the same picture.
    pub clock: bool,
}

impl Meter {
    /// What tracing camera paths costs.
    pub fn drawing(self, c: &Counters) -> f64 {
        let counted = || c.rays as f64 + SHADOW_COST * c.shadow_rays as f64 + GUIDE_COST * c.guide_hits as f64;
        if self.clock { c.total.saturating_sub(c.recording).as_secs_f64() } else { counted() }
    }

    /// Of one camera path of an iteration: to trace it, and to trace it and learn from it.
    pub fn of_path(self, rendered: &Rendered) -> (f64, f64) {
        let c = rendered.counters;
        let counted = LEARNING_COST * c.transitions as f64;
        let learning = if self.clock { c.recording.as_secs_f64() + rendered.learning } else { counted };
        let (paths, drawing) = (c.paths.max(1) as f64, self.drawing(c).max(CLOCK_STEP));
        (drawing / paths, (drawing + learning) / paths)
    }
}
