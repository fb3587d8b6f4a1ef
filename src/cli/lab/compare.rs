//! `phototaxis compare`: methods on the same scenes and budgets, in runs that take turns.

mod screen;
mod table;
mod tasks;

use crate::cli::choices::Machine;
use crate::cli::progress::say;
use crate::cli::render::warn;
use crate::cli::signals::Signals;
use crate::draw::png;
use crate::draw::svg::Svg;
use crate::io::atomic::write_atomically;
use crate::lab::compare::cell::{Cell, cells};
use crate::lab::compare::chart::charts;
use crate::lab::compare::chart::pdf::pdf;
use crate::lab::compare::executor::{RenderExecutor, reference_blocks};
use crate::lab::compare::gallery::matrix::Matrix;
use crate::lab::compare::gallery::{output, pictures};
use crate::lab::compare::plan::{Budget, Draft, Plan, parse_set, plain_scene};
use crate::lab::compare::results::{Results, chart_file, csv};
use crate::lab::compare::scene_cache::SceneCache;
use crate::lab::compare::schedule::{carry_out, order};
use crate::lab::compare::store::Store;
use crate::lab::compare::{file, forecast, overall, report, sweep, tables};
use crate::platform::busy;
use crate::render::Stop;
use anyhow::{Context as _, Result, bail};
use clap::Args;
use screen::Screen;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const NOTES: &str = "Examples:
  phototaxis compare scenes/door.toml --methods none,grid,adaptive --time 5,10,20
  phototaxis compare scene.toml --methods none --spp 64 --methods 'sweep:guiding.method=grid;guiding.resolution=8,16,32'
  phototaxis compare --plan comparison.toml --runs 10 -o out
  phototaxis compare --gallery --runs 3 -o gallery-out
A comparison that was interrupted goes on where it stopped when it is started again. What the figures mean, and the
form of --plan's file: docs/compare.md.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct CompareArguments {
    /// Scenes, of any kind that render takes.
    scenes: Vec<PathBuf>,
    /// File that says what is compared; what is said here too has precedence.
    #[arg(long, value_name = "TOML")]
    plan: Option<PathBuf>,
    /// Carries out the stability gallery, the comparison in scenes/gallery: docs/stability.md.
    #[arg(long, conflicts_with_all = ["plan", "scenes"])]
    gallery: bool,
    /// Only these scenes of the plan or the gallery, by their names.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
    /// Methods, separated by commas: none, auto, adaptive, grid, voronoi, sdtree, or those of the plan; or
    /// sweep:KEY=VALUE,VALUE;KEY=VALUE,VALUE for all combinations. May be repeated. [default: none,auto]
    #[arg(long, value_name = "NAMES")]
    methods: Vec<String>,
    /// Seconds that a run may take, learning included; several are several budgets.
    #[arg(long, value_name = "SECONDS", value_delimiter = ',', value_parser = positive, conflicts_with = "spp")]
    time: Vec<f64>,
    /// Samples per pixel of a run.
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    spp: Vec<u32>,
    /// Runs of each cell, with seeds of their own. [default: 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: Option<u32>,
    /// The first seed. [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1 << 53))]
    seed: Option<u64>,
    /// Method that the others are measured against. [default: none, else the first]
    #[arg(long, value_name = "NAME")]
    baseline: Option<String>,
    /// Picture (.exr) to compare with, of the one scene there is. [default: made, by a long unguided render]
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Share of the smallest error expected that a reference's own noise may have. [default: 0.05]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    reference_noise: Option<f64>,
    /// Seconds that a reference may take. [default: 600]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    reference_time: Option<f64>,
    /// Folder for the references that are made, which several comparisons may share: one that is there already is taken, and rendered
    /// further where it is too noisy. [default: references, in the folder of the results]
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Compares with a reference that is noisier than --reference-noise.
    #[arg(long)]
    allow_noisy_reference: bool,
    /// Overrides a key of all scene files, for all methods; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Title of the results.
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Folder for results, references and pictures; made if it is missing.
    #[arg(short, long, value_name = "DIR", default_value = "compare-out")]
    output: PathBuf,
    /// Deletes the runs that the folder holds, and begins anew. References are kept.
    #[arg(long)]
    restart: bool,
    /// Renders nothing: writes down all runs as tasks for many machines, into the same folder. phototaxis farm run does them, or
    /// HyperQueue or Slurm. See docs/farm.md.
    #[arg(long, conflicts_with_all = ["gallery", "restart"])]
    tasks: bool,
    /// Does this task of --tasks alone: what machines call.
    #[arg(long, value_name = "NAME", hide = true, conflicts_with_all = ["tasks", "restart"])]
    task: Option<String>,
    /// Leaves the pictures out of results.json.
    #[arg(long)]
    no_images: bool,
    #[command(flatten)]
    machine: Machine,
    /// Prints the table and errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &CompareArguments) -> Result<ExitCode> {
    let plan = draft(arguments)?.finish()?;
    let threads = arguments.machine.start(arguments.quiet)?;
    let (scene_cache, warnings) = SceneCache::load(&plan, threads)?;
    if !arguments.quiet {
        warn(&warnings);
    }
    if arguments.tasks {
        // by now all settings are known to be right
        tasks::write(arguments, &plan)?;
        return Ok(ExitCode::SUCCESS);
    }
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let log = folder.join("runs.jsonl");
    if arguments.restart && log.exists() {
        std::fs::remove_file(&log).with_context(|| log.display().to_string())?;
    }
    if arguments.restart {
        tasks::forget(folder)?;
    }
    let signals = Signals::catch(arguments.quiet)?;
    if let Some(name) = &arguments.task {
        let whole = tasks::carry_out(arguments, &plan, &scene_cache, name, signals.stop())?;
        return Ok(if whole { ExitCode::SUCCESS } else { signals.exit_code() });
    }
    let hash = scene_cache.plan_hash(&plan);
    let mut store = Store::open(&log, &hash, &plan.title)?;
    tasks::take_in(folder, &mut store, &hash)?;
    if !arguments.quiet {
        busy().iter().for_each(|why| say(&format!("warning: {why}")));
        say(&estimate(&plan, &store));
    }
    let outcome = carry_on(arguments, &plan, &scene_cache, &mut store, signals.stop());
    // Whatever ended it: what was measured is not lost.
    let finished = finish(arguments, &plan, &scene_cache, &store);
    let whole = outcome?;
    finished?;
    Ok(if whole { ExitCode::SUCCESS } else { signals.exit_code() })
}

/// What is to be done and how long that takes, as far as it can be told before anything is rendered.
fn estimate(plan: &Plan, store: &Store) -> String {
    let missing: Vec<_> = order(plan).into_iter().filter(|slot| store.find(plan, slot).is_none()).collect();
    let scenes = plan.scenes.iter().filter(|scene| store.reference(&scene.name()).is_none());
    let made = scenes.filter(|scene| scene.reference.is_none()).count();
    let runs = forecast::Forecast::default()
        .of(plan, &missing)
        .map_or(", whose time pilot runs will tell".into(), |seconds| format!(" in {}", forecast::said(seconds)));
    let references = match made {
        0 => String::new(),
        1 => format!(", and a reference in at most {}", forecast::said(plan.reference_time)),
        n => format!(", and {n} references in at most {}", forecast::said(plan.reference_time * n as f64)),
    };
    format!("to do: {} runs{runs}{references}", missing.len())
}

/// What file and flags say; flags have the last word.
fn draft(arguments: &CompareArguments) -> Result<Draft> {
    let a = arguments;
    let mut draft = match (&a.plan, a.gallery) {
        (Some(path), _) => file::read(path)?,
        (None, true) => file::read(&write_gallery(&a.output)?)?,
        (None, false) => Draft::default(),
    };
    draft.keep_scenes(&a.only)?;
    if !a.scenes.is_empty() {
        draft.scenes = a.scenes.iter().map(|path| plain_scene(path)).collect();
    }
    if let Some(path) = &a.reference {
        let [scene] = &mut draft.scenes[..] else { bail!("--reference is for one scene: say them in --plan's file") };
        scene.reference = Some(path.clone());
    }
    if !a.methods.is_empty() {
        draft.methods = a.methods.iter().flat_map(|text| names(text)).collect();
    } else if draft.methods.is_empty() {
        draft.methods = ["none", "auto"].map(String::from).to_vec();
    }
    let seconds = a.time.iter().map(|s| Budget::Seconds(*s));
    let budgets: Vec<Budget> = seconds.chain(a.spp.iter().map(|n| Budget::Samples(*n))).collect();
    if !budgets.is_empty() {
        draft.budgets = budgets;
    }
    draft.overrides.extend(a.set.iter().map(|text| parse_set(text)).collect::<crate::Result<Vec<_>>>()?);
    draft.title = a.title.clone().or(draft.title);
    draft.baseline = a.baseline.clone().or(draft.baseline);
    draft.runs = a.runs.or(draft.runs);
    draft.seed = a.seed.or(draft.seed);
    draft.reference_noise = a.reference_noise.or(draft.reference_noise);
    draft.reference_time = a.reference_time.or(draft.reference_time);
    draft.references = a.references.as_deref().map(std::path::absolute).transpose().context("--references")?;
    Ok(draft)
}

/// Writes the gallery's scenes and its comparison, whose path is returned.
fn write_gallery(folder: &Path) -> Result<PathBuf> {
    let written = crate::lab::generate::gallery::generate(&folder.join("scenes"))?;
    written.into_iter().next().context("the gallery is empty")
}

/// A sweep has commas of its own.
fn names(text: &str) -> Vec<String> {
    match text.starts_with(sweep::PREFIX) {
        true => vec![text.to_string()],
        false => text.split(',').map(|name| name.trim().to_string()).collect(),
    }
}

/// Makes the runs that are missing; `false` where a signal came before all were there.
fn carry_on(
    a: &CompareArguments,
    plan: &Plan,
    scene_cache: &SceneCache,
    store: &mut Store,
    stop: &Stop,
) -> Result<bool> {
    let screen = Screen::new(a.quiet);
    let mut listener = |event: crate::lab::compare::executor::Event| {
        screen.show(&event);
    };
    // A gallery goes on where a reference cannot be made good enough, and its verdicts say what is then not known.
    let allow_noisy = a.allow_noisy_reference || plan.gallery.is_some();
    let mut executor = RenderExecutor::new(plan, scene_cache, &a.output, allow_noisy, stop, &mut listener);
    Ok(carry_out(plan, store, &mut executor, &mut &screen)?)
}

/// Writes and prints what there is.
fn finish(arguments: &CompareArguments, plan: &Plan, scene_cache: &SceneCache, store: &Store) -> Result<()> {
    let folder = &arguments.output;
    let cells = cells(plan, store, &reference_blocks(plan, scene_cache, store, folder)?);
    if cells.is_empty() {
        return Ok(());
    }
    let overall = overall::overall(plan, &cells);
    let charts = charts(plan, store, &cells, &overall);
    let stamp = scene_cache.platform().stamp();
    std::fs::create_dir_all(folder.join("charts")).with_context(|| folder.display().to_string())?;
    for chart in &charts {
        let path = |extension: &str| folder.join("charts").join(format!("{}.{extension}", chart_file(chart)));
        write(&path("svg"), Svg::with_metadata(&chart.svg, &stamp).as_bytes())?;
        write(&path("png"), &png(&chart.svg, &stamp)?)?;
        write(&path("pdf"), &pdf(&chart.svg, &chart.title, &stamp)?)?;
    }
    write(&folder.join("cells.csv"), tables::cells_csv(&cells).as_bytes())?;
    write(&folder.join("overall.csv"), tables::overall_csv(&overall).as_bytes())?;
    write(&folder.join("table.tex"), tables::latex(plan, &cells, &overall, &stamp).as_bytes())?;
    write(&folder.join("results.csv"), csv(plan, store).as_bytes())?;
    let matrix = matrix(plan, scene_cache, store, &cells, folder)?;
    let table = table::lines(plan, store, &cells, &overall);
    let mut results = Results::new(plan, scene_cache, store, &command_line(), cells, overall, charts);
    if let Some(matrix) = matrix {
        results.add_gallery(matrix);
    }
    if !arguments.no_images {
        results.add_pictures(plan, store, folder)?;
    }
    let json = results.to_json()?;
    write(&folder.join("results.json"), json.as_bytes())?;
    write(&folder.join("report.html"), report::page(&json).as_bytes())?;
    if !arguments.quiet {
        say(&format!("wrote {0}/report.html, results.json, tables (.csv, table.tex) and {0}/charts", folder.display()));
    }
    table.iter().try_for_each(|line| crate::cli::print(line))
}

/// The verdicts, where the plan asks for them, written as tables and pictures.
fn matrix(
    plan: &Plan,
    scene_cache: &SceneCache,
    store: &Store,
    cells: &[Cell],
    folder: &Path,
) -> Result<Option<Matrix>> {
    let Some(gallery) = &plan.gallery else { return Ok(None) };
    let mut matrix = Matrix::new(plan, gallery, scene_cache, store, cells);
    pictures::write(&mut matrix, plan, scene_cache, store, folder)?;
    write(&folder.join("matrix.csv"), output::csv(&matrix).as_bytes())?;
    write(&folder.join("stability.md"), output::markdown(plan, &matrix).as_bytes())?;
    Ok(Some(matrix))
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(write_atomically(path, |file| file.write_all(bytes))?)
}

/// The command as it may be typed again.
fn command_line() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_=./,:+".contains(c);
    let quoted = |text: String| match !text.is_empty() && text.chars().all(plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', "'\\''")),
    };
    let arguments = std::env::args_os().skip(1).map(|a| quoted(a.to_string_lossy().into_owned()));
    std::iter::once("phototaxis".to_string()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number of seconds".into()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("expected a number greater than 0 and at most 1".into()),
    }
}
