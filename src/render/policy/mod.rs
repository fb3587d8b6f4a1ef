//! Whether the guide is used. A policy plans each iteration and sees what came of it; the driver carries the plans out and
//! knows nothing of their reasons.

mod auto;

pub(crate) use auto::{Reason, Trial, Verdict};

use super::noise::Noise;
use super::schedule::doubled;
use super::{IterationReport, Settings, training};
use crate::film::accumulate::Film;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::Counters;
use crate::io::clock::CpuTime;
use auto::Auto;

/// Samples per pixel of the first iteration with a guide that was learnt before: enough for a picture by which guided roulette
/// can go.
const FIRST_WITH_A_GUIDE: u32 = 2;

/// How the samples of an iteration are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Mode {
    /// Directions come from BSDFs and lights alone, and nothing is learnt.
    Unguided,
    /// As [`Mode::Unguided`]; the light that bounced is measured beside it, pixel by pixel.
    Pilot,
    /// The guide learns, and directions come from it wherever it has learnt before.
    Guided,
}

/// What the next iteration is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Plan {
    pub mode: Mode,
    /// Samples per pixel. The driver takes others where the budget ends.
    pub samples: u32,
    /// Its samples are distributed as those of the iteration before, and the film weighs both as one.
    pub continues: bool,
    /// The guide is [trained](super::training) before it.
    pub trains: bool,
}

impl Plan {
    /// Whether both draw their samples alike, as all do without a guide.
    pub fn is_drawn_as(&self, other: &Plan) -> bool {
        self.mode != Mode::Guided && other.mode != Mode::Guided
    }
}

/// What has been rendered so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    /// Samples per pixel.
    pub samples: u32,
    /// Samples per pixel that were planned for the newest iteration; `None` before the first.
    pub planned: Option<u32>,
}

/// What a render may take: whichever ends first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    /// Samples per pixel.
    pub samples: u32,
    /// Seconds of processor time, of all threads together.
    pub cpu_seconds: Option<f64>,
}

/// A finished iteration.
pub(super) struct Iteration<'a> {
    pub mode: Mode,
    /// Samples per pixel: of it alone, and of all so far.
    pub samples: u32,
    pub all_samples: u32,
    pub counters: &'a Counters,
    /// The same of its passes over the picture, one by one.
    pub passes: &'a [Counters],
    /// Processor time of the learning between tasks.
    pub learning: CpuTime,
    /// What was done to train the guide before all guided iterations.
    pub training: &'a [IterationReport],
    /// With the iteration's samples, of which it is the end.
    pub film: &'a Film,
    /// Of that film; `None` for a picture that says nothing of its noise.
    pub noise: Option<&'a Noise>,
    /// Σ x and Σ x² of the luminance of light that bounced, pixel by pixel, over all pilot samples so far.
    pub bounced: &'a [[f32; 2]],
    pub budget: Budget,
}

/// Decides iteration by iteration. A policy owns what it knows, so that a render can go on elsewhere.
pub(super) trait GuidePolicy {
    fn next_iteration(&self, history: &History) -> Plan;

    /// Takes an iteration after which another may follow.
    fn observe(&mut self, _iteration: &Iteration) {}

    /// Why the guide is in use, or is not; `None` where that is no question.
    fn verdict(&self) -> Option<Verdict> {
        None
    }
}

/// The guide is always used.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Always {
    /// Samples per pixel of the first iteration.
    pub first: u32,
    /// The guide is trained before that.
    pub trains: bool,
}

impl GuidePolicy for Always {
    fn next_iteration(&self, history: &History) -> Plan {
        let samples = history.planned.map_or(self.first, doubled);
        let trains = self.trains && history.planned.is_none();
        Plan { mode: Mode::Guided, samples, continues: false, trains }
    }
}

/// There is no guide.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Never;

impl GuidePolicy for Never {
    fn next_iteration(&self, history: &History) -> Plan {
        Plan { mode: Mode::Unguided, samples: history.planned.map_or(1, doubled), continues: false, trains: false }
    }
}

/// One of the policies, with what it knows.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) enum Policy {
    Always(Always),
    Never(Never),
    Auto(Box<Auto>),
}

impl Policy {
    /// What the settings ask for, for a picture of `pixels` pixels. A guide that was given or is to be kept is `wanted`, and
    /// used whatever it pays. With one that was given, whose iterations go on with `given` samples per pixel, the first is short,
    /// so that there is a picture by which roulette can go; a new one is trained. A render that is timed judges by processor
    /// time, and then no two are alike.
    pub fn asked_for(settings: &Settings, wanted: bool, given: Option<u32>, pixels: u64) -> Policy {
        let (method, timed) = (settings.guiding.method, settings.render.time.is_some());
        let trains = given.is_none() && training::samples(pixels, f64::from(settings.render.spp)) > 0;
        let first = if trains { FIRST_WITH_A_GUIDE } else { given.unwrap_or(1) };
        match method {
            GuidingMethod::None => Policy::Never(Never),
            GuidingMethod::Auto if !wanted => Policy::Auto(Box::new(Auto::new(timed, pixels))),
            // it learns from each iteration alone, so that a short one would be all that it knows
            GuidingMethod::SdTree => Policy::Always(Always { first, trains }),
            _ => Policy::Always(Always { first: first.min(FIRST_WITH_A_GUIDE), trains }),
        }
    }

    /// Whether all samples are identically distributed, whatever is found out.
    pub fn never_guides(&self) -> bool {
        matches!(self, Policy::Never(_))
    }

    fn inner(&self) -> &dyn GuidePolicy {
        match self {
            Policy::Always(policy) => policy,
            Policy::Never(policy) => policy,
            Policy::Auto(policy) => policy.as_ref(),
        }
    }
}

impl GuidePolicy for Policy {
    fn next_iteration(&self, history: &History) -> Plan {
        self.inner().next_iteration(history)
    }

    fn observe(&mut self, iteration: &Iteration) {
        match self {
            Policy::Always(policy) => policy.observe(iteration),
            Policy::Never(policy) => policy.observe(iteration),
            Policy::Auto(policy) => policy.observe(iteration),
        }
    }

    fn verdict(&self) -> Option<Verdict> {
        self.inner().verdict()
    }
}
