//! What is shown while a comparison goes on.

use crate::cli::progress::{Bar, say};
use crate::lab::compare::executor::Event;
use crate::lab::compare::forecast::said;
use crate::lab::compare::record::Run;
use crate::lab::compare::schedule::Watcher;
use std::cell::RefCell;

/// Lines on standard error, with a bar for what is being rendered.
pub(crate) struct Screen {
    quiet: bool,
    now: RefCell<Option<(String, Bar)>>,
}

impl Screen {
    pub(crate) fn new(quiet: bool) -> Screen {
        Screen { quiet, now: RefCell::new(None) }
    }

    pub(crate) fn show(&self, event: &Event) {
        let (label, announced, progress) = match event {
            Event::Pilot { scene, method, progress } => (format!("{scene}: a pilot run of {method}"), true, progress),
            Event::Reference { scene, wanted, progress } => {
                (format!("{scene}: the reference, to a relMSE of its own of {wanted:.1e}"), true, progress)
            }
            Event::Run { scene, method, budget, progress } => (format!("{scene}: {method}, {budget}"), false, progress),
        };
        let mut now = self.now.borrow_mut();
        if now.as_ref().is_none_or(|(shown, _)| *shown != label) {
            if let Some((_, bar)) = now.take() {
                bar.finish();
            }
            if announced && !self.quiet {
                say(&label);
            }
            *now = Some((label, Bar::new(self.quiet)));
        }
        if let Some((_, bar)) = &*now {
            bar.update(progress);
        }
    }
}

impl Watcher for &Screen {
    fn before(&mut self, all: usize, seconds: Option<f64>) {
        if !self.quiet {
            let takes = seconds.map_or("a time that the first of them will tell".into(), said);
            say(&format!("the references are there; {all} runs take {takes}"));
        }
    }

    fn after(&mut self, run: &Run, done: usize, all: usize, seconds: Option<f64>) {
        if let Some((_, bar)) = self.now.borrow_mut().take() {
            bar.finish();
        }
        if !self.quiet {
            let Run { scene, method, budget, seed, samples, wall_seconds, errors, .. } = run;
            let relmse = errors.relmse;
            let left = seconds.filter(|_| done < all).map_or(String::new(), |s| format!("; {} left", said(s)));
            say(&format!(
                "[{done}/{all}] {scene}: {method}, {budget}, seed {seed}: {samples} spp in {wall_seconds:.2} s, relMSE \
                 {relmse:.3e}{left}"
            ));
        }
    }
}
