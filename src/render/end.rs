//! When a pass is cut: by those who wait for it, or by the clock.

use crate::integrator::Stop;
use std::time::{Duration, Instant};

/// Share of a time limit by which a pass may go beyond it. A pass that is longer is cut at the limit itself.
const LEEWAY: f64 = 0.01;

/// What tells threads to begin no further task.
#[derive(Clone, Copy)]
pub(super) struct End<'a> {
    pub stop: &'a Stop,
    /// When the pass under way is cut, if ever.
    pub deadline: Option<Instant>,
}

impl End<'_> {
    /// Whether no further task is to begin. Threads ask between tasks, which take milliseconds.
    pub fn is_due(&self) -> bool {
        self.stop.is_due() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Whether what is under way is to be given up.
    pub fn is_urgent(&self) -> bool {
        self.stop.is_urgent()
    }
}

/// A budget of time for a render.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeLimit {
    pub start: Instant,
    pub seconds: f64,
}

impl TimeLimit {
    /// Seconds that are left.
    pub fn left(&self) -> f64 {
        self.seconds - self.start.elapsed().as_secs_f64()
    }

    /// Whether no other pass is to begin that takes as long as the last: where it can end near enough to the limit, if it
    /// would go beyond that by more than half of itself; where it will be cut, if nothing is left.
    pub fn is_over(&self, pass: Duration) -> bool {
        let half = 0.5 * pass.as_secs_f64();
        self.left() <= if half <= self.leeway() { half } else { 0.0 }
    }

    /// When such a pass is cut.
    pub fn deadline(&self, pass: Duration) -> Option<Instant> {
        let leeway = if 0.5 * pass.as_secs_f64() <= self.leeway() { self.leeway() } else { 0.0 };
        Duration::try_from_secs_f64(self.seconds + leeway).ok().and_then(|limit| self.start.checked_add(limit))
    }

    fn leeway(&self) -> f64 {
        LEEWAY * self.seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit of 100 seconds, of which so many are gone.
    fn limit(gone: f64) -> TimeLimit {
        TimeLimit { start: Instant::now() - Duration::from_secs_f64(gone), seconds: 100.0 }
    }

    #[test]
    fn short_passes_end_nearest_to_the_limit() {
        let pass = Duration::from_secs_f64(1.0);
        assert!(!limit(99.4).is_over(pass) && limit(99.6).is_over(pass));
        let limit = limit(0.0);
        let cut = limit.deadline(pass).unwrap() - limit.start;
        assert_eq!(cut, Duration::from_secs(101), "one that takes longer than expected is cut all the same");
    }

    #[test]
    fn long_passes_are_cut_at_the_limit() {
        let pass = Duration::from_secs_f64(30.0);
        assert!(!limit(99.0).is_over(pass) && limit(100.1).is_over(pass));
        let limit = limit(0.0);
        assert_eq!(limit.deadline(pass).unwrap() - limit.start, Duration::from_secs(100));
    }

    #[test]
    fn a_limit_beyond_all_clocks_never_comes() {
        assert_eq!(TimeLimit { start: Instant::now(), seconds: 1e300 }.deadline(Duration::ZERO), None);
    }
}
