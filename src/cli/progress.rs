//! What standard error shows meanwhile: lines, and a bar with what is left to wait, where somebody is looking.

use crate::render::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Steps of the bar.
const STEPS: u64 = 1000;

/// The bar that is shown now.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

fn shown() -> MutexGuard<'static, Option<ProgressBar>> {
    SHOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Prints a line on standard error, above the bar. Where nobody takes it, because the terminal was closed or a pipe has no
/// reader, it is lost: that is no reason to lose a picture as well.
pub fn say(line: &str) {
    let print = || _ = writeln!(std::io::stderr(), "{line}");
    match &*shown() {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// A progress bar on standard error; silent when asked to be, or when that is no terminal.
pub struct Bar(ProgressBar);

impl Bar {
    pub fn new(quiet: bool) -> Bar {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed} gone, {prefix} left  {msg}")
            .expect("the template is well-formed");
        let bar = ProgressBar::with_draw_target(Some(STEPS), target).with_style(style);
        *shown() = Some(bar.clone());
        Bar(bar)
    }

    pub fn update(&self, p: &Progress) {
        self.0.set_position((p.share * STEPS as f64) as u64);
        let left = if p.share > 0.0 { p.wall_seconds * (1.0 / p.share - 1.0) } else { 0.0 };
        self.0.set_prefix(format!("{:.0?}", Duration::from_secs(left.round() as u64)));
        let rate = p.paths as f64 / p.wall_seconds.max(1e-9) * 1e-6;
        self.0.set_message(format!("{} spp, {rate:.2} Msamples/s", p.samples));
    }

    pub fn finish(&self) {
        *shown() = None;
        self.0.finish_and_clear();
    }
}
