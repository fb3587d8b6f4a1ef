//! `phototaxis farm run` and `task`: HyperQueue has the tasks done, and this shows how far they are.

use super::graph::{FIGURES, Graph, Task};
use crate::cli::amounts;
use crate::cli::output::check_pictures;
use crate::cli::progress::say;
use crate::cli::render_arguments::RenderArguments;
use crate::cli::signals::Signals;
use crate::render::lesson;
use anyhow::{Context as _, Result, bail, ensure};
use clap::Args;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "HyperQueue is needed: its program hq (https://github.com/It4innovations/hyperqueue), or pip install hyperqueue.
If a server of it runs, its workers do the tasks; else one is started here for as long as this takes. PHOTOTAXIS_HQ names the
program, PHOTOTAXIS_PYTHON the Python that has the package, HQ_SERVER_DIR the folder of the server. What is done already is not done
again, so that a run that was stopped goes on.";

/// Names the program of HyperQueue, and the Python whose package takes its place.
const HQ: &str = "PHOTOTAXIS_HQ";
const PYTHON: &str = "PHOTOTAXIS_PYTHON";

const DRIVER: &str = include_str!("hyperqueue_driver.py");

/// Between two looks at the files.
const TICK: Duration = Duration::from_millis(250);

/// Seconds between two pictures of what there is, by default.
const EVERY: f64 = 30.0;

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RunArguments {
    /// The folder of phototaxis farm plan.
    folder: PathBuf,
    /// Workers on this machine, where no server of HyperQueue runs yet.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    workers: u32,
    /// Rewrites this picture, .exr or .png, with the samples of all films that are there.
    #[arg(long, value_name = "FILE")]
    preview: Option<PathBuf>,
    /// Time between two of them. [default: 30s]
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds, requires = "preview")]
    every: Option<f64>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Args)]
pub(crate) struct TaskArguments {
    /// The folder of phototaxis farm plan.
    folder: PathBuf,
    /// The task's name in plan.json.
    task: String,
}

/// Becomes the task's command, in the plan's folder. Whoever ends this process ends the task.
pub(super) fn task(arguments: &TaskArguments) -> Result<ExitCode> {
    let TaskArguments { folder, task: name } = arguments;
    let graph = Graph::read(folder)?;
    let task = graph.tasks.iter().find(|task| task.name == *name);
    let task = task.with_context(|| format!("{}: there is no task {name}", Graph::path(folder).display()))?;
    if task.is_done(folder) {
        say(&format!("{name} was done before"));
        return Ok(ExitCode::SUCCESS);
    }
    let (program, rest) = task.command.split_first().context("the task has no command")?;
    let error = Command::new(program).args(rest).current_dir(folder).exec();
    bail!("{program}: {error}")
}

pub(super) fn run(arguments: &RunArguments) -> Result<ExitCode> {
    check_pictures(arguments.preview.as_slice())?;
    let folder = std::path::absolute(&arguments.folder)?;
    let graph = Graph::read(&folder)?;
    ensure!(arguments.preview.is_none() || graph.is_of_picture(), "--preview: a comparison makes no picture of films");
    let mut watch = Watch::new(arguments, &graph, &folder);
    let is_done = || graph.tasks.last().is_none_or(|merge| merge.is_done(&folder));
    if !is_done() {
        let mut engine = Engine::start(&graph, &folder, arguments)?;
        let signals = Signals::catch(true)?;
        while engine.is_busy()? {
            if signals.came() {
                return Ok(signals.exit_code());
            }
            std::thread::sleep(TICK);
            watch.look()?;
        }
    }
    watch.look()?;
    let missing: Vec<&Task> = graph.tasks.iter().filter(|task| !is_done() && !task.is_done(&folder)).collect();
    if let Some(task) = missing.iter().find(|task| task.is_ready(&folder)) {
        bail!("{} tasks are not done; {1} tells of one that failed", missing.len(), log(&folder, task).display());
    }
    ensure!(missing.is_empty(), "{} tasks are not done", missing.len());
    if !arguments.quiet {
        cost(&graph, &folder)?.iter().for_each(|cost| say(cost));
        graph.pictures.iter().for_each(|path| say(&format!("wrote {}", path.display())));
    }
    Ok(ExitCode::SUCCESS)
}

fn log(folder: &Path, task: &Task) -> PathBuf {
    folder.join(format!("logs/{}.log", task.name))
}

/// What of HyperQueue runs for us.
struct Engine {
    /// Ends when all tasks have ended.
    waits: Child,
    /// The server and its workers, where we have started them.
    own: Vec<Child>,
    hq: Option<PathBuf>,
}

impl Engine {
    fn start(graph: &Graph, folder: &Path, arguments: &RunArguments) -> Result<Engine> {
        if let Some(hq) = program_of_hyperqueue() {
            return Engine::by_program(hq, folder, arguments.workers);
        }
        let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
        let has = Command::new(&python).args(["-c", "import hyperqueue"]).stderr(Stdio::null()).status();
        ensure!(
            has.is_ok_and(|status| status.success()),
            "HyperQueue is not here: neither its program hq, nor the Python package ({} -m pip install hyperqueue)",
            python.display()
        );
        let program = graph.tasks.first().and_then(|task| task.command.first()).context("the plan has no tasks")?;
        let mut command = Command::new(python);
        command.args(["-c", DRIVER, program]).arg(folder).arg(arguments.workers.to_string()).stdout(Stdio::null());
        Ok(Engine { waits: command.spawn()?, own: Vec::new(), hq: None })
    }

    fn by_program(hq: PathBuf, folder: &Path, workers: u32) -> Result<Engine> {
        let quiet = |words: &[&str]| {
            let mut command = Command::new(&hq);
            command.args(words).stdout(Stdio::null());
            command
        };
        let is_up = || quiet(&["server", "info"]).stderr(Stdio::null()).status().map(|status| status.success());
        let mut own = Vec::new();
        if !is_up().with_context(|| hq.display().to_string())? {
            own.push(quiet(&["server", "start"]).spawn()?);
            let start = Instant::now();
            while !is_up()? {
                ensure!(start.elapsed() < Duration::from_secs(60), "hq server start: no server came up");
                std::thread::sleep(TICK);
            }
            for _ in 0..workers {
                own.push(quiet(&["worker", "start"]).spawn()?);
            }
        }
        let job = folder.join("hyperqueue.toml");
        let submitted = Command::new(&hq).args(["--output-mode=quiet", "job", "submit-file"]).arg(job).output()?;
        let id = String::from_utf8_lossy(&submitted.stdout).trim().to_string();
        let said = String::from_utf8_lossy(&submitted.stderr);
        ensure!(submitted.status.success() && !id.is_empty(), "hq job submit-file: {}", said.trim());
        let waits = quiet(&["job", "wait", &id]).spawn()?;
        Ok(Engine { waits, own, hq: Some(hq) })
    }

    fn is_busy(&mut self) -> Result<bool> {
        Ok(self.waits.try_wait()?.is_none())
    }
}

/// Ends what was started for this run. What was submitted to a server of others goes on.
impl Drop for Engine {
    fn drop(&mut self) {
        _ = self.waits.kill();
        _ = self.waits.wait();
        if let Some(hq) = self.hq.as_ref().filter(|_| !self.own.is_empty()) {
            _ = Command::new(hq).args(["server", "stop"]).stdout(Stdio::null()).status();
        }
        self.own.iter_mut().for_each(|child| _ = child.wait());
    }
}

/// The program hq, where it is named or among those that a shell finds.
fn program_of_hyperqueue() -> Option<PathBuf> {
    let named = std::env::var_os(HQ).map(PathBuf::from);
    let found = || {
        let all = std::env::var_os("PATH")?;
        std::env::split_paths(&all).map(|folder| folder.join("hq")).find(|path| path.is_file())
    };
    named.or_else(found)
}

/// Looks at the files that tasks have made.
struct Watch<'a> {
    arguments: &'a RunArguments,
    graph: &'a Graph,
    folder: &'a Path,
    said: String,
    /// When the newest preview was begun, how long it took, and of how many films it was.
    preview: Option<(Instant, Duration)>,
    films: usize,
}

impl<'a> Watch<'a> {
    fn new(arguments: &'a RunArguments, graph: &'a Graph, folder: &'a Path) -> Watch<'a> {
        Watch { arguments, graph, folder, said: String::new(), preview: None, films: 0 }
    }

    /// Says what has changed, and makes the picture so far where it is time to.
    fn look(&mut self) -> Result<()> {
        let done: Vec<&Task> = self.graph.tasks.iter().filter(|task| task.is_done(self.folder)).collect();
        let text = progress(self.graph, &done);
        if text != self.said && !self.arguments.quiet {
            say(&text);
            self.said = text;
        }
        let films: Vec<&Path> = done.iter().filter(|task| task.stage == "film").map(|task| &*task.outputs[0]).collect();
        let every = Duration::from_secs_f64(self.arguments.every.unwrap_or(EVERY).min(1e9));
        // looking takes a twentieth of the time at most
        let is_due = self.preview.is_none_or(|(begun, took)| begun.elapsed() >= every.max(20 * took));
        if let Some(picture) = self.arguments.preview.as_deref().filter(|_| is_due && films.len() > self.films) {
            let begun = Instant::now();
            self.films = films.len();
            self.merge(&films, picture)?;
            self.preview = Some((begun, begun.elapsed()));
        }
        Ok(())
    }

    fn merge(&self, films: &[&Path], picture: &Path) -> Result<()> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["merge", "--partial", "--quiet", "-o"]).arg(std::path::absolute(picture)?).args(films);
        let status = command.current_dir(self.folder).status()?;
        if !status.success() {
            say(&format!("warning: {}: the picture so far was not written", picture.display()));
        }
        Ok(())
    }
}

/// How far it is.
fn progress(graph: &Graph, done: &[&Task]) -> String {
    let iterations = done.iter().filter(|task| task.stage.starts_with("guide")).count();
    let count = |tasks: &mut dyn Iterator<Item = &Task>| tasks.filter(|task| task.stage == "film").count();
    let (films, all) = (count(&mut done.iter().copied()), count(&mut graph.tasks.iter()));
    let learning = match graph.learning.len() {
        0 => String::new(),
        n => format!("{iterations} of {n} iterations learnt, "),
    };
    let films = if graph.is_of_picture() { format!("{films} of {all} films, ") } else { String::new() };
    format!("{learning}{films}{} of {} tasks", done.len(), graph.tasks.len())
}

/// What a picture took, by what the parts say of themselves; `None` where lessons were removed after the guide had learnt from them.
fn cost(graph: &Graph, folder: &Path) -> Result<Option<String>> {
    let lessons: Vec<&Task> = graph.tasks.iter().filter(|task| task.stage.starts_with("learn")).collect();
    if !graph.is_of_picture() || !lessons.iter().all(|task| task.is_done(folder)) {
        return Ok(None);
    }
    let spent = |task: &&Task| Ok(lesson::open::<RenderArguments>(&folder.join(&task.outputs[0]))?.cpu_seconds());
    let learning: f64 = lessons.iter().map(spent).collect::<Result<Vec<_>>>()?.into_iter().sum();
    let path = folder.join(FIGURES);
    let figures = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let figures: serde_json::Value = serde_json::from_str(&figures).with_context(|| path.display().to_string())?;
    let rendering = figures["render_cpu_seconds"].as_f64().unwrap_or_default();
    Ok(Some(format!("{rendering:.0} s of processor time for the picture, {learning:.0} s to learn for it")))
}
