//! Signals that ask a command to end.
//!
//! The first ends what is being rendered, and what there is gets written; a second does so at once; a third ends the program.
//! SIGINT, SIGTERM and SIGHUP are alike, since whoever closes a terminal or shuts a machine down wants their picture too.

use super::progress::{self, FINISHING_TEXT, say};
use crate::render::Stop;
use anyhow::{Context as _, Result};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals as Incoming;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Signals that follow each other within this time are one wish: timeout(1) signals a program and then its whole group, and a
/// terminal that closes sends SIGHUP more than once.
const ONE_WISH: Duration = Duration::from_millis(250);

/// What came so far.
#[derive(Default)]
struct State {
    stop: Stop,
    first: OnceLock<i32>,
    /// Whether the next signal ends the program.
    last_warning: Arc<AtomicBool>,
}

/// Catches signals for as long as the program runs.
pub(crate) struct Signals(Arc<State>);

impl Signals {
    /// Begins to catch them; with `quiet` nothing is said about them. Those that the program was started to ignore, as by
    /// nohup(1), stay ignored.
    pub(crate) fn catch(quiet: bool) -> Result<Signals> {
        let state = Arc::new(State::default());
        let caught: Vec<i32> = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal)).collect();
        for &signal in &caught {
            let armed = state.last_warning.clone();
            signal_hook::flag::register_conditional_shutdown(signal, status(signal).into(), armed)
                .context("catching signals")?;
        }
        let incoming = Incoming::new(&caught).context("catching signals")?;
        let listener = state.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || listener.listen(incoming, quiet))
            .context("catching signals")?;
        Ok(Signals(state))
    }

    /// What signals ask of a render.
    pub(crate) fn stop(&self) -> &Stop {
        &self.0.stop
    }

    /// Whether any came.
    pub(crate) fn came(&self) -> bool {
        self.0.first.get().is_some()
    }

    /// The program's exit code: as shells have it, 128 and the number of the first signal that came.
    pub(crate) fn exit_code(&self) -> ExitCode {
        self.0.first.get().map_or(ExitCode::SUCCESS, |&signal| ExitCode::from(status(signal)))
    }
}

impl State {
    fn listen(&self, mut incoming: Incoming, quiet: bool) {
        let tell = |text: String| {
            if !quiet {
                say(&text)
            }
        };
        loop {
            let Some(signal) = incoming.wait().next() else { continue };
            if self.first.set(signal).is_ok() {
                self.stop.ask();
                progress::finishing();
                let then = "then the picture is written (once more: at once, a third time: without writing)";
                tell(format!("{}: stopping now, {FINISHING_TEXT} for a second at most, {then}", name(signal)));
            } else {
                self.stop.insist();
                tell(format!("{}: writing what there is", name(signal)));
            }
            std::thread::sleep(ONE_WISH);
            incoming.pending().for_each(drop);
            self.last_warning.store(self.stop.is_urgent(), Ordering::Relaxed);
        }
    }
}

/// Exit status of a program that a signal ended, as shells tell it.
fn status(signal: i32) -> u8 {
    128 + signal as u8
}

fn name(signal: i32) -> &'static str {
    signal_hook::low_level::signal_name(signal).unwrap_or("a signal")
}

/// Whether the program was started with the signal ignored, as the kernel tells.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
