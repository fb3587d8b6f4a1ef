//! Work on the picture so far, in a thread beside the render.

use super::pace::Pace;
use crate::io::clock::WallClock;
use crate::render::{Occasion, Stop};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time between two looks at whether work is done that is waited for.
const POLL: Duration = Duration::from_millis(5);

/// One piece of work after the other, never two at once: what is slow has fewer pictures, and does not hold the render up.
pub(super) struct Beside<T> {
    /// Of its thread.
    name: &'static str,
    pace: Pace,
    /// The newest work, which is under way or has been done.
    worker: Option<JoinHandle<T>>,
}

impl<T: Send + 'static> Beside<T> {
    /// Each `every` seconds, and for the first time at the end of the first pass.
    pub(super) fn new(name: &'static str, every: f64) -> Beside<T> {
        Beside { name, pace: Pace::each(every), worker: None }
    }

    pub(super) fn is_due(&self, occasion: Occasion) -> bool {
        let busy = self.worker.as_ref().is_some_and(|worker| !worker.is_finished());
        match occasion {
            Occasion::Between => self.pace.is_due() && !busy,
            Occasion::Last => true,
            Occasion::AtOnce => false,
        }
    }

    /// Waits for the newest work; what came of it, where that was not asked before.
    pub(super) fn settle(&mut self) -> Option<T> {
        self.worker.take().and_then(|worker| worker.join().ok())
    }

    /// As [`Self::settle`]. Once `stop` is urgent, the work is left to itself and ends with the program.
    pub(super) fn settle_unless(&mut self, stop: &Stop) -> Option<T> {
        while self.worker.as_ref().is_some_and(|worker| !worker.is_finished()) {
            if stop.is_urgent() {
                self.worker = None;
                return None;
            }
            std::thread::sleep(POLL);
        }
        self.settle()
    }

    /// Begins with the next, which the render has waited for since `clock` was started. Where there can be no thread, it is not
    /// done.
    pub(super) fn begin(&mut self, clock: WallClock, work: impl FnOnce() -> T + Send + 'static) {
        self.worker = std::thread::Builder::new().name(self.name.into()).spawn(work).ok();
        self.pace.written(clock.elapsed());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn work_is_waited_for_unless_somebody_is_impatient() {
        let (stop, (end, ended)) = (Stop::new(), channel::<()>());
        let mut beside = Beside::new("test", 0.0);
        stop.ask();
        beside.begin(WallClock::start(), || 7);
        assert_eq!(beside.settle_unless(&stop), Some(7));
        beside.begin(WallClock::start(), move || ended.recv().map_or(8, |()| 9));
        stop.insist();
        // waiting for what never ends would never end
        assert_eq!((beside.settle_unless(&stop), beside.settle()), (None, None));
        drop(end);
    }
}
