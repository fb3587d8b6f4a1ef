//! The wish that a render should end before its budget is used.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long the pass under way may still take after [`Stop::ask`]. A pass that is over by then leaves all pixels with equally
/// many samples; a longer one is cut, so that nobody waits for it.
pub(crate) const GRACE: Duration = Duration::from_secs(1);

/// How long what is not the picture itself may still be written after [`Stop::insist`]. With packing the picture it is to be over
/// within a second.
const HASTE: Duration = Duration::from_millis(300);

/// A wish to end a render, which any thread may state while the render runs: once, or a second time with more force.
///
/// It decides which samples are taken by their place in the order of tasks and not by their values, so that a picture of fewer
/// samples is as unbiased. The exception are tasks that are given up, at most one for each thread, and more likely a long one.
#[derive(Debug, Default)]
pub struct Stop {
    asked: OnceLock<Instant>,
    urgent: AtomicBool,
    insisted: OnceLock<Instant>,
}

impl Stop {
    /// One that nobody has stated yet.
    pub const fn new() -> Stop {
        Stop { asked: OnceLock::new(), urgent: AtomicBool::new(false), insisted: OnceLock::new() }
    }

    /// Asks the render to end: with the pass under way if that ends within [`GRACE`], else in the middle of it. Tasks that
    /// have begun by then are finished, if that takes no longer than another [`GRACE`].
    pub fn ask(&self) {
        self.asked.get_or_init(Instant::now);
    }

    /// Asks for what there is, at once: tasks under way are given up at their next wave, and nothing more is learnt.
    pub fn insist(&self) {
        self.ask();
        self.insisted.get_or_init(Instant::now);
        self.urgent.store(true, Ordering::Relaxed);
    }

    /// Whether the render is to end.
    pub(crate) fn is_asked(&self) -> bool {
        self.asked.get().is_some()
    }

    /// Whether it is to end at once.
    #[inline]
    pub(crate) fn is_urgent(&self) -> bool {
        self.urgent.load(Ordering::Relaxed)
    }

    /// Whether files are to be given up that are not the picture itself, though they are half written.
    pub(crate) fn gives_up_files(&self) -> bool {
        self.insisted.get().is_some_and(|insisted| insisted.elapsed() >= HASTE)
    }

    /// Whether tasks under way are to be given up.
    #[inline]
    pub(crate) fn gives_up_tasks(&self) -> bool {
        self.is_urgent() || self.asked.get().is_some_and(|asked| asked.elapsed() >= 2 * GRACE)
    }

    /// Whether no further task is to begin.
    pub(crate) fn is_due(&self) -> bool {
        self.is_urgent() || self.asked.get().is_some_and(|asked| asked.elapsed() >= GRACE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_wish_is_more_urgent_than_the_first() {
        let stop = Stop::new();
        assert!(!stop.is_asked() && !stop.is_due() && !stop.is_urgent());
        stop.ask();
        assert!(stop.is_asked() && !stop.is_urgent());
        stop.insist();
        assert!(stop.is_asked() && stop.is_due() && stop.is_urgent() && stop.gives_up_tasks());
    }

    #[test]
    fn what_was_asked_for_is_due_after_the_grace_however_often_it_is_asked_for() {
        let stop = Stop { asked: OnceLock::from(Instant::now() - GRACE), ..Stop::new() };
        stop.ask();
        assert!(stop.is_due() && !stop.is_urgent() && !stop.gives_up_tasks());
    }

    #[test]
    fn files_are_given_up_some_time_after_the_second_wish_and_never_after_the_first() {
        let long_ago = || OnceLock::from(Instant::now() - 10 * GRACE);
        let stop = Stop { asked: long_ago(), ..Stop::new() };
        assert!(!stop.gives_up_files());
        stop.insist();
        assert!(!stop.gives_up_files(), "what is nearly done may end");
        assert!(Stop { insisted: long_ago(), ..stop }.gives_up_files());
    }

    #[test]
    fn a_task_that_goes_on_and_on_is_given_up() {
        let stop = Stop { asked: OnceLock::from(Instant::now() - 2 * GRACE), ..Stop::new() };
        assert!(stop.gives_up_tasks() && !stop.is_urgent());
    }
}
