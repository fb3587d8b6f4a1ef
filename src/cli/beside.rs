//! Work on the picture so far, in a thread beside the render.

use super::pace::Pace;
use crate::io::clock::WallClock;
use crate::render::Occasion;
use std::thread::JoinHandle;

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

    /// Begins with the next, which the render has waited for since `clock` was started. Where there can be no thread, it is not
    /// done.
    pub(super) fn begin(&mut self, clock: WallClock, work: impl FnOnce() -> T + Send + 'static) {
        self.worker = std::thread::Builder::new().name(self.name.into()).spawn(work).ok();
        self.pace.written(clock.elapsed());
    }
}
