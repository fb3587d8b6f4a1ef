//! What shadow rays from a region find: how often lights are in sight.

use serde::{Deserialize, Serialize};

/// What the shadow ray of a path's vertex found, and how many rays it stands for: 1 over the probability with which it was cast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowOutcome {
    /// Negative where something lay on the ray; 0 where no ray was cast.
    weight: f32,
}

impl ShadowOutcome {
    /// No ray was cast.
    pub const NONE: ShadowOutcome = ShadowOutcome { weight: 0.0 };

    /// One that stands for `rays`, and is open or not.
    #[inline(always)]
    pub fn new(rays: f32, open: bool) -> ShadowOutcome {
        ShadowOutcome { weight: if open { rays } else { -rays } }
    }

    /// How many rays it stands for, and how many open ones.
    #[inline(always)]
    pub(super) fn rays(self) -> [f32; 2] {
        [self.weight.abs(), self.weight.max(0.0)]
    }
}

/// Shadow rays from a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Visibility {
    /// Weight of all rays, and of those that were open.
    pub rays: f32,
    pub open: f32,
}

impl Visibility {
    #[inline(always)]
    pub(super) fn add(&mut self, outcome: ShadowOutcome) {
        let [rays, open] = outcome.rays();
        self.rays += rays;
        self.open += open;
    }

    /// Leaves earlier rays a share of their weight.
    pub(super) fn decay(&mut self, share: f32) {
        self.rays *= share;
        self.open *= share;
    }

    /// The share of rays that are open, as far as it is known: never 0 or 1, however few or many were seen (half a ray of each
    /// kind is added, after Jeffreys).
    pub(super) fn share(&self) -> f32 {
        // for more rays than an `f32` counts by halves, the sum of both kinds stays above each
        let (open, blocked) = (self.open + 0.5, (self.rays - self.open).max(0.0) + 0.5);
        open / (open + blocked)
    }

    /// Whether these can be sums over rays.
    pub(super) fn is_sound(&self) -> bool {
        self.rays.is_finite() && self.open >= 0.0 && self.open <= self.rays
    }
}
