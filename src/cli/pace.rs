//! How often a file is written that is written again and again.

use std::time::{Duration, Instant};

/// A writer takes at most one part in so many of a render's time, however short its interval.
const LEAST_PAUSE: u32 = 20;

/// An interval, and when the next one ends.
pub(super) struct Pace {
    every: Duration,
    next: Instant,
}

impl Pace {
    /// Due at once, and then each `every` seconds; never where no clock reaches that.
    pub(super) fn each(every: f64) -> Pace {
        Pace { every: Duration::try_from_secs_f64(every).unwrap_or(Duration::MAX), next: Instant::now() }
    }

    pub(super) fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Begins the next interval, after a writing that held the render up for `took`.
    pub(super) fn written(&mut self, took: Duration) {
        const FAR: Duration = Duration::from_secs(1 << 32);
        let pause = self.every.max(took.saturating_mul(LEAST_PAUSE)).min(FAR);
        self.next = Instant::now() + pause;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_as_long_as_asked_for_and_longer_where_writing_takes_long() {
        let mut far = Pace::each(1e300);
        assert!(far.is_due());
        far.written(Duration::ZERO);
        assert!(!far.is_due(), "beyond all clocks");
        let mut pace = Pace::each(0.0);
        pace.written(Duration::ZERO);
        assert!(pace.is_due());
        pace.written(Duration::from_secs(10));
        let left = pace.next - Instant::now();
        assert!((190..=200).contains(&left.as_secs()), "{left:?}");
    }
}
