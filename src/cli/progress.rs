//! What standard error shows meanwhile: lines, and how far it is. Where somebody is looking that is a bar, elsewhere a line each
//! ten seconds, and for programs an object of JSON each second.

use crate::render::Progress;
use crate::scene::LoadStage;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Steps of the bar.
const STEPS: u64 = 1000;

/// How progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
pub(crate) enum Show {
    /// A bar in a terminal, elsewhere a line each ten seconds
    #[default]
    Auto,
    /// An object of JSON a line, each second; all else on standard error is JSON too
    Json,
    /// Nothing
    None,
}

/// What a command is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Stage {
    Loading,
    Textures,
    Building,
    Training,
    Rendering,
    Denoising,
    Writing,
}

impl Stage {
    fn text(self) -> &'static str {
        match self {
            Stage::Loading => "loading the scene",
            Stage::Textures => "loading textures",
            Stage::Building => "preparing the scene for rays",
            Stage::Training => "training the guide",
            Stage::Rendering => "rendering",
            Stage::Denoising => "denoising",
            Stage::Writing => "writing pictures",
        }
    }
}

impl From<LoadStage> for Stage {
    fn from(stage: LoadStage) -> Stage {
        match stage {
            LoadStage::Models => Stage::Loading,
            LoadStage::Textures => Stage::Textures,
            LoadStage::Building => Stage::Building,
        }
    }
}

/// What is shown now.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);
/// Whether lines are objects of JSON.
static JSON: AtomicBool = AtomicBool::new(false);
/// Whether a signal has asked for the end.
static FINISHING: AtomicBool = AtomicBool::new(false);

/// What the user is told of the time between a signal and the end of rendering.
pub(crate) const FINISHING_TEXT: &str = "finishing this pass";

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Chooses the form of all that is said, for as long as the program runs.
pub(crate) fn choose(show: Show) {
    JSON.store(show == Show::Json, Ordering::Relaxed);
}

/// Shows from now on that rendering is about to end.
pub(crate) fn finishing() {
    FINISHING.store(true, Ordering::Relaxed);
}

/// Prints a line on standard error, above the bar. Where nobody takes it, because the terminal was closed or a pipe has no
/// reader, it is lost: that is no reason to lose a picture as well.
pub(crate) fn say(line: &str) {
    let json = || serde_json::json!({ "message": line }).to_string();
    let line = if JSON.load(Ordering::Relaxed) { json() } else { line.to_string() };
    let print = || _ = writeln!(std::io::stderr(), "{line}");
    match &*lock(&SHOWN) {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Shows on standard error what a command is busy with and how far it is, until it is dropped or finished.
pub(crate) struct Bar {
    shared: Arc<Shared>,
    ticker: Option<JoinHandle<()>>,
}

/// Tells how far a command is.
pub(super) struct Status(Arc<Shared>);

impl Status {
    /// The object of JSON that programs are shown.
    pub(super) fn json(&self) -> serde_json::Value {
        lock(&self.0.state).json()
    }
}

struct Shared {
    state: Mutex<State>,
    /// Whether each stage is told at once, by the thread that begins it: a ticker would miss the short ones.
    tells_stages: bool,
    /// Wakes the ticker for the end.
    changed: Condvar,
}

struct State {
    stage: Stage,
    since: Instant,
    progress: Option<Progress>,
    /// Number of the frame under way, which one that is, and of how many; where there are frames.
    frame: Option<[usize; 3]>,
    finished: bool,
}

/// How the ticker shows it.
enum Form {
    Bar(ProgressBar),
    Lines,
    Json,
}

impl Form {
    fn interval(&self) -> Duration {
        match self {
            Form::Bar(_) => Duration::from_millis(125),
            Form::Lines => Duration::from_secs(10),
            Form::Json => Duration::from_secs(1),
        }
    }
}

impl Bar {
    /// Of a render; silent when asked to be.
    pub(crate) fn new(quiet: bool) -> Bar {
        Bar::of(if quiet { Show::None } else { Show::Auto }, Stage::Rendering)
    }

    /// As asked for, beginning with this stage.
    pub(crate) fn of(show: Show, stage: Stage) -> Bar {
        let state = State { stage, since: Instant::now(), progress: None, frame: None, finished: false };
        let tells_stages = show == Show::Json;
        if tells_stages {
            state.print_json();
        }
        let shared = Arc::new(Shared { state: Mutex::new(state), tells_stages, changed: Condvar::new() });
        let form = match show {
            Show::None => None,
            Show::Json => Some(Form::Json),
            Show::Auto if std::io::stderr().is_terminal() => Some(Form::Bar(bar())),
            Show::Auto => Some(Form::Lines),
        };
        // Where there can be no thread, nothing is shown.
        let ticker = form.and_then(|form| {
            let shared = shared.clone();
            std::thread::Builder::new().name("progress".into()).spawn(move || shared.tick(&form)).ok()
        });
        Bar { shared, ticker }
    }

    /// Something else begins.
    pub(crate) fn stage(&self, stage: Stage) {
        let mut state = lock(&self.shared.state);
        if state.stage != stage {
            (state.stage, state.since, state.progress) = (stage, Instant::now(), None);
            if self.shared.tells_stages {
                state.print_json();
            }
        }
    }

    /// The next frame begins: its number, which one it is, and of how many.
    pub(super) fn begin_frame(&self, frame: [usize; 3]) {
        lock(&self.shared.state).frame = Some(frame);
    }

    /// What tells how far it is, for as long as anybody asks.
    pub(super) fn status(&self) -> Status {
        Status(self.shared.clone())
    }

    pub(crate) fn update(&self, progress: &Progress) {
        if progress.training {
            return self.stage(Stage::Training);
        }
        self.stage(Stage::Rendering);
        lock(&self.shared.state).progress = Some(*progress);
    }

    pub(crate) fn finish(mut self) {
        self.end();
    }

    fn end(&mut self) {
        lock(&self.shared.state).finished = true;
        self.shared.changed.notify_all();
        // A ticker that panicked has shown what it could.
        self.ticker.take().map(JoinHandle::join);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.end();
    }
}

impl Shared {
    /// Shows the state again and again until it is finished.
    fn tick(&self, form: &Form) {
        let (mut state, mut begins) = (lock(&self.state), true);
        while !state.finished {
            match form {
                Form::Bar(bar) => state.draw(bar),
                // At the beginning there is nothing that a line could add.
                _ if begins => {}
                Form::Json => state.print_json(),
                Form::Lines => say(&state.line()),
            }
            begins = false;
            let waited = self.changed.wait_timeout_while(state, form.interval(), |state| !state.finished);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        if let Form::Bar(bar) = form {
            *lock(&SHOWN) = None;
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(8));
    *lock(&SHOWN) = Some(bar.clone());
    bar
}

impl State {
    fn left(&self) -> Option<f64> {
        let p = self.progress.filter(|p| p.share > 0.0)?;
        Some(p.wall_seconds * (1.0 / p.share - 1.0))
    }

    fn draw(&self, bar: &ProgressBar) {
        let template = match self.progress {
            Some(_) => "{bar:30} {percent:>3} %  {prefix}  {msg}",
            None => "{spinner} {msg}",
        };
        bar.set_style(ProgressStyle::with_template(template).expect("the template is well-formed"));
        let (share, gone) = (self.progress.map_or(0.0, |p| p.share), time_text(self.since.elapsed().as_secs_f64()));
        bar.set_position((share * STEPS as f64) as u64);
        match self.progress {
            Some(_) => {
                let left = self.left().map_or(String::new(), |left| format!(", {} left", time_text(left)));
                bar.set_prefix(format!("{gone} gone{left}"));
                bar.set_message(self.detail());
            }
            None => bar.set_message(format!("{}, {gone}", self.what())),
        }
        bar.tick();
    }

    /// Samples and speed, or that it is about to end.
    fn detail(&self) -> String {
        let Some(p) = self.progress else { return String::new() };
        if FINISHING.load(Ordering::Relaxed) {
            return FINISHING_TEXT.into();
        }
        let rate = p.paths as f64 / p.wall_seconds.max(1e-9) * 1e-6;
        let frame = self.frame.map_or(String::new(), |[number, k, of]| format!("frame {number} ({k} of {of}), "));
        format!("{frame}{} spp, {rate:.2} Msamples/s", p.samples)
    }

    /// What it is busy with.
    fn what(&self) -> String {
        let frame = self.frame.filter(|_| self.progress.is_none());
        let frame = frame.map_or(String::new(), |[number, k, of]| format!(" frame {number} ({k} of {of})"));
        format!("{}{frame}", self.stage.text())
    }

    fn line(&self) -> String {
        let (what, gone) = (self.what(), time_text(self.since.elapsed().as_secs_f64()));
        let Some(p) = self.progress else { return format!("{what}: {gone} so far") };
        let left = self.left().map_or(String::new(), |left| format!(", {} left", time_text(left)));
        format!("{what}: {:.0} % after {gone}{left}; {}", 100.0 * p.share, self.detail())
    }

    fn print_json(&self) {
        _ = writeln!(std::io::stderr(), "{}", self.json());
    }

    fn json(&self) -> serde_json::Value {
        let (share, samples) = (self.progress.map(|p| p.share), self.progress.map(|p| p.samples));
        let mut object = serde_json::json!({
            "stage": self.stage,
            "seconds": self.since.elapsed().as_secs_f64(),
            "share": share,
            "samples": samples,
            "left_seconds": self.left(),
            "finishing": FINISHING.load(Ordering::Relaxed),
        });
        if let Some([number, k, of]) = self.frame {
            object["frame"] = serde_json::json!({ "number": number, "k": k, "of": of });
        }
        object
    }
}

/// Whole seconds as people say them.
fn time_text(seconds: f64) -> String {
    let s = seconds.round() as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        _ => format!("{} h {} min", s / 3600, s / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(share: f64) -> State {
        let progress = Some(Progress { samples: 12, share, wall_seconds: 30.0, paths: 60_000_000, training: false });
        State { stage: Stage::Rendering, since: Instant::now(), progress, frame: None, finished: false }
    }

    #[test]
    fn a_line_says_how_far_it_is_and_how_long_it_will_take() {
        assert_eq!(state(0.25).line(), "rendering: 25 % after 0 s, 1 min 30 s left; 12 spp, 2.00 Msamples/s");
        assert_eq!(state(0.0).line(), "rendering: 0 % after 0 s; 12 spp, 2.00 Msamples/s");
        let loading = State { stage: Stage::Building, progress: None, ..state(0.0) };
        assert_eq!(loading.line(), "preparing the scene for rays: 0 s so far");
        let frame = State { frame: Some([12, 2, 120]), ..state(0.25) };
        let line = "rendering: 25 % after 0 s, 1 min 30 s left; frame 12 (2 of 120), 12 spp, 2.00 Msamples/s";
        assert_eq!(frame.line(), line);
        assert_eq!(frame.json()["frame"], serde_json::json!({ "number": 12, "k": 2, "of": 120 }));
    }

    #[test]
    fn times_are_said_in_two_units_at_most() {
        let cases = [(0.4, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (3599.0, "59 min 59 s"), (7260.0, "2 h 1 min")];
        for (seconds, text) in cases {
            assert_eq!(time_text(seconds), text);
        }
    }

    #[test]
    fn what_is_finished_ends_at_once() {
        let start = Instant::now();
        for show in [Show::None, Show::Auto] {
            let bar = Bar::of(show, Stage::Loading);
            bar.stage(Stage::Rendering);
            bar.update(&state(0.5).progress.unwrap());
            bar.finish();
        }
        assert!(start.elapsed() < Duration::from_secs(5), "nobody waits for the next line");
    }
}
