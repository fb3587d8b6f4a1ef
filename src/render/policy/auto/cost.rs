//! What samples cost: processor time or, where no clock may decide, a count of what was done.

use crate::integrator::Counters;
use crate::io::clock::CpuTime;

/// Counted costs, in rays: of a shadow ray with the choice of its light; of a vertex at which the guide was asked and
/// drawn from; of a transition that is recorded and learnt from. The last two are geometric means of the processor time on eleven
/// scenes of 36 to a million triangles, where they were 0.32 to 1.7 and 0.18 to 0.94: the dearer, the cheaper the scene's own rays.
pub const SHADOW_RAY_COST: f64 = 0.5;
pub const GUIDED_VERTEX_COST: f64 = 0.93;
pub const TRANSITION_COST: f64 = 0.43;

/// Seconds, or rays: the least that anything costs, as costs are divided by each other. It is the resolution of the clock.
pub const LEAST_COST: f64 = 1e-9;

/// Tells costs, in seconds or in rays.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct CostMeter {
    /// Costs are processor time; else they are counted, so that the same seed always gives the same picture.
    pub by_clock: bool,
}

/// What one camera path costs.
#[derive(Clone, Copy, Debug)]
pub struct PathCost {
    /// To trace it.
    pub tracing: f64,
    /// To trace it and to learn from it.
    pub whole: f64,
}

impl CostMeter {
    /// Of tracing the camera paths of `counters`.
    pub fn tracing(self, c: &Counters) -> f64 {
        let counted =
            || c.rays as f64 + SHADOW_RAY_COST * c.shadow_rays as f64 + GUIDED_VERTEX_COST * c.guide_hits as f64;
        if self.by_clock { c.cpu.without(c.recording_cpu).seconds() } else { counted() }.max(LEAST_COST)
    }

    /// Of a camera path among those of `counters`.
    pub fn tracing_path(self, counters: &Counters) -> f64 {
        self.tracing(counters) / counters.paths.max(1) as f64
    }

    /// Of a camera path among those of `counters`, where learning between tasks took `learning`.
    pub fn of_path(self, c: &Counters, learning: CpuTime) -> PathCost {
        let counted = TRANSITION_COST * c.transitions as f64;
        let learning = if self.by_clock { (c.recording_cpu + learning).seconds() } else { counted };
        let (paths, tracing) = (c.paths.max(1) as f64, self.tracing(c));
        PathCost { tracing: tracing / paths, whole: (tracing + learning) / paths }
    }
}
