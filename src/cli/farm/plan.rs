//! `phototaxis farm plan`: how samples and iterations are dealt among machines.

use super::graph::{Graph, Work};
use super::pace::Pace;
use super::scripts;
use crate::cli::amounts;
use crate::cli::output::{Outputs, check_pictures};
use crate::cli::progress::say;
use crate::cli::render_arguments::{RenderArguments, check_options};
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::io::atomic::write_atomically;
use anyhow::{Context as _, Result, bail, ensure};
use clap::{Args, Parser};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis farm plan scene.toml --machines 16 --spp 4k -o farm
  phototaxis farm plan scene.toml --machines 4 --time 2h -o farm -- --size 1920x1080 --set integrator.max_depth=12

and then one of these:
  phototaxis farm run farm
  farm/slurm.sh --partition=long --cpus-per-task=32

All machines need the program and the folder, by the same paths. See docs/farm.md.";

/// Films for each machine: so many tasks that one machine more or less, or a slow one, costs little.
const FILMS: u32 = 2;

/// Share of the samples of the picture that the guide learns from beforehand, and which are no part of the picture.
const LEARNING: f64 = 1.0 / 3.0;

/// Bytes of a state that directs paths, as the default guide's are on average; each wants to be visited so often in an iteration, and
/// a camera path visits so many states at least. An iteration longer than what that makes teaches a full memory nothing new.
const STATE_BYTES: u64 = 2 << 10;
const STATE_VISITS: u64 = 1024;
const PATH_VISITS: u64 = 4;

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PlanArguments {
    /// Scene or model, as for phototaxis render.
    scene: PathBuf,
    /// Machines, or workers, that there will be about: the picture does not depend on it but by how long the guide learns.
    #[arg(long, value_name = "N", value_parser = amounts::count_u32)]
    machines: u32,
    /// Samples per pixel of the picture.
    #[arg(long, value_name = "N|1k", value_parser = amounts::count_u32, required_unless_present = "time")]
    spp: Option<u32>,
    /// Time that all of it takes on so many machines as this one, about: a few samples are timed here to tell how many there may be.
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds, conflicts_with_all = ["spp", "learn"])]
    time: Option<f64>,
    /// Samples per pixel that the guide learns from before, in iterations of doubling length. They are no part of the picture.
    /// [default: a third of --spp, or as many as fill the guide's memory]
    #[arg(long, value_name = "N", value_parser = amounts::count_u32)]
    learn: Option<u32>,
    /// Folder for the plan and all files of the render; it is made where it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Picture to write, .exr or .png; may be repeated. [default: picture.exr and picture.png in the folder]
    #[arg(long, value_name = "FILE")]
    picture: Vec<PathBuf>,
    /// Films that share the samples of the picture. [default: 2 for each machine]
    #[arg(long, value_name = "N", value_parser = amounts::count_u32)]
    films: Option<u32>,
    /// The program on all machines. [default: this one, by its path]
    #[arg(long, value_name = "FILE")]
    program: Option<String>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
    /// Options of phototaxis render that each part is rendered with.
    #[arg(last = true, value_name = "OPTION")]
    options: Vec<String>,
}

/// What a part would be rendered with.
#[derive(Parser)]
#[command(name = "phototaxis render")]
struct PartCommand {
    #[command(flatten)]
    render: RenderArguments,
}

pub(super) fn run(arguments: &PlanArguments) -> Result<ExitCode> {
    let PlanArguments { machines, output, .. } = arguments;
    let machines = *machines;
    let folder = std::path::absolute(output)?;
    let plan = Graph::path(&folder);
    ensure!(!plan.exists(), "{}: there is a plan already: run it, or remove the folder", plan.display());
    let (asked, description) = asked(arguments)?;
    let guided = description.guiding.method != GuidingMethod::None;
    let spp = match arguments.time {
        Some(time) => Pace::measure(&asked)?.samples(time, machines, if guided { LEARNING } else { 0.0 })?,
        None => arguments.spp.context("--spp or --time is needed")?,
    };
    let learning = learning(arguments, &description, spp)?;
    let default = || vec![folder.join("picture.exr"), folder.join("picture.png")];
    let pictures = if arguments.picture.is_empty() { default() } else { absolute(&arguments.picture)? };
    check_pictures(&arguments.picture)?;
    let films = arguments.films.unwrap_or(machines.saturating_mul(FILMS));
    let graph = Graph::of(Work {
        program: program(arguments)?,
        scene: text(&std::path::absolute(&arguments.scene)?)?,
        options: arguments.options.clone(),
        machines,
        samples: spp,
        learning,
        pictures,
        films: films.min(spp),
    });
    write(&graph, &program(arguments)?, &folder)?;
    if !arguments.quiet {
        say(&summary(&graph, output));
    }
    Ok(ExitCode::SUCCESS)
}

/// What each part will be asked for, and the scene as it will see it, if parts can be rendered with these options.
fn asked(arguments: &PlanArguments) -> Result<(RenderArguments, SceneFile)> {
    let (scene, spp) = (text(&arguments.scene)?, arguments.spp.unwrap_or(1).to_string());
    let own = ["--spp", &spp, "--part", "1/1", "--film-out", "a"].map(str::to_string);
    let words = ["render".to_string(), scene].into_iter().chain(arguments.options.iter().cloned()).chain(own);
    let mut asked = PartCommand::try_parse_from(words).unwrap_or_else(|error| error.exit()).render;
    if asked.guide_in.is_some() || asked.learn_out.is_some() {
        bail!("--guide-in and --learn-out are what the plan is to say");
    }
    let (description, _) = asked.load()?;
    if description.guiding.method != GuidingMethod::None {
        (asked.film_out, asked.learn_out) = (None, Some(PathBuf::from("a")));
    }
    check_options(&asked, &description, &Outputs::default())?;
    Ok((asked, description))
}

/// Samples per pixel of each iteration: 1, 2, 4 …
fn learning(arguments: &PlanArguments, description: &SceneFile, spp: u32) -> Result<Vec<u32>> {
    let (guiding, film) = (&description.guiding, &description.scene.film);
    if guiding.method == GuidingMethod::None {
        ensure!(arguments.learn.is_none(), "--learn needs a guide, and guiding.method is none");
        return Ok(Vec::new());
    }
    let budget = arguments.learn.unwrap_or((f64::from(spp) * LEARNING) as u32);
    ensure!(budget > 0, "{spp} samples per pixel are too few for a guide to learn from: take --guide none");
    let enough = guiding.memory / STATE_BYTES * STATE_VISITS / PATH_VISITS;
    let pixels = u64::from(film.width) * u64::from(film.height);
    let most = if arguments.learn.is_some() { u32::MAX } else { (enough / pixels).clamp(1, u32::MAX.into()) as u32 };
    Ok(doubling(budget, most))
}

/// Iterations of 1, 2, 4 … samples until one has `most` or more, `budget` in all at most. The last takes what is left.
fn doubling(budget: u32, most: u32) -> Vec<u32> {
    let short = |samples: &u32| samples.saturating_mul(2) - 1 <= budget && samples / 2 < most;
    let mut all: Vec<u32> = (0..31).map(|k| 1 << k).take_while(short).collect();
    let left = budget - all.iter().sum::<u32>();
    all.last_mut().filter(|last| **last < most).into_iter().for_each(|last| *last += left);
    all
}

fn program(arguments: &PlanArguments) -> Result<String> {
    arguments.program.clone().map_or_else(|| text(&std::env::current_exe()?), Ok)
}

fn absolute(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    paths.iter().map(|path| Ok(std::path::absolute(path)?)).collect()
}

fn text(path: &Path) -> Result<String> {
    path.to_str().map(str::to_string).with_context(|| format!("{}: a plan takes names in UTF-8", path.display()))
}

/// Writes the graph and its scripts, and makes the folders that its tasks write into.
pub(in crate::cli) fn write(graph: &Graph, program: &str, folder: &Path) -> Result<()> {
    let outputs = graph.tasks.iter().flat_map(|task| &task.outputs).filter_map(|output| output.parent());
    for part in outputs.chain([Path::new("logs")]) {
        let part = folder.join(part);
        std::fs::create_dir_all(&part).with_context(|| part.display().to_string())?;
    }
    let script = folder.join("slurm.sh");
    let put = |path: &Path, text: &str| write_atomically(path, |file| file.write_all(text.as_bytes()));
    put(&folder.join("hyperqueue.toml"), &scripts::hyperqueue(graph, program, folder))?;
    put(&script, &scripts::slurm(graph, program, folder))?;
    make_executable(&script).with_context(|| script.display().to_string())?;
    Ok(put(&Graph::path(folder), &serde_json::to_string_pretty(graph)?)?)
}

/// Whoever may read it may run it.
fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    let mode = path.metadata()?.permissions().mode();
    std::fs::set_permissions(path, PermissionsExt::from_mode(mode | (mode & 0o444) >> 2))
}

fn summary(graph: &Graph, folder: &Path) -> String {
    let (learning, films) =
        (&graph.learning, graph.stages().iter().find(|(stage, _)| *stage == "film").map_or(0, |s| s.1));
    let learnt: u32 = learning.iter().sum();
    let guide = match learning.len() {
        0 => String::new(),
        n => format!("the guide learns from {learnt} samples per pixel in {n} iterations; then "),
    };
    let (samples, tasks, folder) = (graph.samples, graph.tasks.len(), folder.display());
    format!(
        "{tasks} tasks: {guide}{films} films share {samples} samples per pixel\nphototaxis farm run {folder}, or {folder}/slurm.sh"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_double_and_use_all_there_is() {
        assert_eq!(doubling(1, u32::MAX), [1]);
        assert_eq!(doubling(20, u32::MAX), [1, 2, 4, 13]);
        assert_eq!(doubling(15, u32::MAX), [1, 2, 4, 8]);
        assert_eq!(doubling(u32::MAX, u32::MAX).iter().sum::<u32>(), u32::MAX);
        assert_eq!(doubling(1000, 5), [1, 2, 4, 8], "a memory that is full learns nothing new");
        assert_eq!(doubling(1000, 1), [1]);
    }
}
