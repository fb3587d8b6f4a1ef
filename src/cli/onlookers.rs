//! All that looks at a render while it goes on.

use super::checkpointer::Checkpointer;
use super::preview::Preview;
use crate::render::{Moment, Occasion, Onlooker};
use std::path::PathBuf;

/// Previews and checkpoints, where they are asked for.
pub(super) struct Onlookers {
    preview: Option<Preview>,
    checkpointer: Option<Checkpointer>,
    /// Which of them wants to look.
    due: [bool; 2],
}

impl Onlookers {
    pub(super) fn new(preview: Option<Preview>, checkpointer: Option<Checkpointer>) -> Onlookers {
        Onlookers { preview, checkpointer, due: [false; 2] }
    }

    /// Waits until all is in its file; the checkpoint, where it holds the end of the render.
    pub(super) fn finish(self) -> Option<PathBuf> {
        self.checkpointer.as_ref().and_then(Checkpointer::written).map(PathBuf::from)
    }
}

impl Onlooker for Onlookers {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        let preview = self.preview.as_mut().is_some_and(|preview| preview.is_due(occasion));
        let checkpoint = self.checkpointer.as_mut().is_some_and(|checkpointer| checkpointer.is_due(occasion));
        self.due = [preview, checkpoint];
        preview || checkpoint
    }

    fn look(&mut self, moment: &Moment) {
        let [preview, checkpoint] = self.due;
        // a signal that comes again ends the program: what cannot be made again comes first
        self.checkpointer.iter_mut().filter(|_| checkpoint).for_each(|checkpointer| checkpointer.look(moment));
        self.preview.iter_mut().filter(|_| preview).for_each(|preview| preview.look(moment));
    }

    fn keeps_state(&self) -> bool {
        self.checkpointer.is_some()
    }
}
