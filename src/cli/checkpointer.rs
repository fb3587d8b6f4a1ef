//! Checkpoints of a render while it goes on.

use super::pace::Pace;
use super::progress::say;
use super::render::CheckpointRequest;
use crate::io::clock::WallClock;
use crate::render::checkpoint::Header;
use crate::render::{Moment, Occasion, Onlooker, Stop};
use std::path::{Path, PathBuf};

/// Seconds between two checkpoints, where nothing else is asked for.
pub(super) const EVERY: f64 = 300.0;

/// Writes checkpoints, each in place of the one before.
pub(super) struct Checkpointer {
    path: PathBuf,
    header: Header<CheckpointRequest>,
    pace: Pace,
    /// Whether one that could not be written has been told of, or nothing is to be told.
    told: bool,
    /// Whether the newest moment of which one was asked for is in the file.
    is_newest: bool,
}

impl Checkpointer {
    /// In the file `path`, each `every` seconds. `quiet`, it says nothing.
    pub(super) fn new(path: &Path, every: f64, header: Header<CheckpointRequest>, quiet: bool) -> Checkpointer {
        let path = path.to_path_buf();
        Checkpointer { path, header, pace: Pace::after(every), told: quiet, is_newest: false }
    }

    /// The file, where it holds the end of the render.
    pub(super) fn written(&self) -> Option<&Path> {
        self.is_newest.then_some(&self.path)
    }

    /// Tells once why there is no new checkpoint. That is no reason to end the render.
    fn tell(&mut self, why: &str, stop: &Stop) {
        let then = if stop.is_asked() { "" } else { ", and the render goes on" };
        if !std::mem::replace(&mut self.told, true) {
            say(&format!("warning: {why}; there is no new checkpoint, an older one stays{then}"));
        }
    }

    /// Writes one, or says why there is none.
    fn write(&self, moment: &Moment) -> Result<(), String> {
        let path = self.path.display();
        if !moment.can_go_on() {
            return Err(format!("{path}: the render was stopped in the middle of a round of its guide"));
        }
        moment.write_checkpoint(&self.path, &self.header).map_err(|error| match moment.stop().gives_up_files() {
            true => format!("{path}: given up, since a second signal asked for what there is"),
            false => error.to_string(),
        })
    }
}

impl Onlooker for Checkpointer {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        occasion != Occasion::Between || self.pace.is_due()
    }

    fn look(&mut self, moment: &Moment) {
        let clock = WallClock::start();
        let written = self.write(moment);
        self.is_newest = written.is_ok();
        written.unwrap_or_else(|why| self.tell(&why, moment.stop()));
        self.pace.written(clock.elapsed());
    }

    fn keeps_state(&self) -> bool {
        true
    }
}
