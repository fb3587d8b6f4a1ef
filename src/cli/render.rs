//! `phototaxis render`: from a scene file or a model to pictures and figures.

use super::output::Outputs;
use super::progress::Bar;
use super::report::{Context, Report, total};
use crate::render::{Rendering, Settings, render};
use crate::scene::description::SceneDescription;
use crate::scene::{Scene, file};
use anyhow::{Context as _, Result};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Warnings that are printed; of more only the number is.
const WARNINGS: usize = 20;

const EXAMPLES: &str = "Examples:
  phototaxis render model.obj
  phototaxis render scene.toml --time 60 -o out/scene.exr -o out/scene.png
  phototaxis render scene.toml --guide none --set film.width=640 --json -";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct RenderArguments {
    /// Scene file (.toml), interchange scene (.json) or model (.obj).
    scene: PathBuf,
    /// Picture to write, .exr (linear, all layers) or .png (sRGB); may be repeated. [default: both, named like the
    /// scene, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Samples per pixel, over all iterations. [default: the scene file's, else 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Seconds to render for; all that happens after loading counts. Without --spp, time alone decides.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    time: Option<f64>,
    /// The guide: what learns where light comes from. [default: the scene file's, else adaptive]
    #[arg(long, value_name = "METHOD")]
    guide: Option<Method>,
    /// Seed of the random numbers. [default: the scene file's, else 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Threads; 0 takes all of the machine's. The picture does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Overrides a key of the scene file, for example guiding.resolution=32; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Writes the figures as JSON; "-" is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// No guide: directions from the material, and next-event estimation
    None,
    /// Learns in cells that refine where it pays, by position and facing normal
    Adaptive,
    /// Learns in the cells of a uniform grid
    Grid,
}

pub fn run(arguments: &RenderArguments) -> Result<ExitCode> {
    super::set_threads(arguments.threads)?;
    let (description, warnings) = file::load(&arguments.scene, &overrides(arguments))?;
    let outputs = Outputs::new(&arguments.output, arguments.json.as_ref(), &arguments.scene)?;
    let load = Instant::now();
    let (scene, more_warnings) = Scene::load(&description, arguments.threads)?;
    let load_seconds = load.elapsed().as_secs_f64();
    if !arguments.quiet {
        warn(&[warnings, more_warnings].concat());
    }
    let stop = stop_flag()?;
    let rendering = watched(&scene, &description, arguments.quiet, &stop);
    let interrupted = stop.load(Ordering::Relaxed);
    if !arguments.quiet {
        warn_of_non_finite(&rendering);
    }
    let context = Context {
        scene: &scene,
        name: arguments.scene.display().to_string(),
        seed: description.render.seed,
        interrupted,
        load_seconds: load_seconds - scene.build_seconds(),
        build_seconds: scene.build_seconds(),
    };
    let report = Report::new(&context, &rendering);
    outputs.write(&context, &description, &rendering, &report)?;
    if !arguments.quiet {
        eprintln!("{}", report.summary());
        outputs.pictures().iter().for_each(|path| eprintln!("wrote {}", path.display()));
    }
    Ok(if interrupted { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

/// The flags that stand for keys of the scene file, then `--set`, which has the last word.
fn overrides(arguments: &RenderArguments) -> Vec<String> {
    let mut all = Vec::new();
    let mut add = |key: &str, value: Option<String>| all.extend(value.map(|v| format!("{key}={v}")));
    let open_ended = arguments.time.is_some() && arguments.spp.is_none();
    add("render.spp", arguments.spp.map(|n| n.to_string()).or(open_ended.then(|| i32::MAX.to_string())));
    add("render.time", arguments.time.map(|t| format!("{t:?}")));
    add("render.seed", arguments.seed.map(|s| s.to_string()));
    add("guiding.method", arguments.guide.map(|m| m.to_possible_value().expect("none is hidden").get_name().into()));
    all.extend(arguments.set.iter().cloned());
    all
}

/// Renders with a progress bar, until done or asked to stop.
pub(super) fn watched(scene: &Scene, description: &SceneDescription, quiet: bool, stop: &AtomicBool) -> Rendering {
    let settings = Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    };
    let bar = Bar::new(quiet);
    let rendering = render(scene, &settings, &mut |progress| {
        bar.update(progress);
        !stop.load(Ordering::Relaxed)
    });
    bar.finish();
    rendering
}

/// Set by the first Ctrl-C or SIGTERM, which end the render after its pass; the second ends the program at once.
pub(super) fn stop_flag() -> Result<Arc<AtomicBool>> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register_conditional_shutdown(signal, 130, stop.clone()).context("catching Ctrl-C")?;
        signal_hook::flag::register(signal, stop.clone()).context("catching Ctrl-C")?;
    }
    Ok(stop)
}

fn warn(warnings: &[String]) {
    warnings.iter().take(WARNINGS).for_each(|warning| eprintln!("warning: {warning}"));
    if let more @ 1.. = warnings.len().saturating_sub(WARNINGS) {
        eprintln!("warning: and {more} more");
    }
}

fn warn_of_non_finite(rendering: &Rendering) {
    let total = total(&rendering.iterations);
    if let Some((x, y, sample)) = total.first_non_finite {
        let n = total.non_finite;
        eprintln!(
            "warning: {n} samples were not finite and count as black; the first is pixel ({x}, {y}), sample {sample}"
        );
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number of seconds".into()),
    }
}
