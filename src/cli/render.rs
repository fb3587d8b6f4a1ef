//! `phototaxis render`: from a scene file or a model to pictures and figures.

use super::choices::Choices;
use super::output::{Outputs, beauty};
use super::progress::{Bar, say};
use super::report::{Context, Report, total};
use super::signals::Signals;
use crate::format;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::image::{Exposure, Tone, ViewTransform};
use crate::inspect::Layers;
use crate::render::guide_file::{self, GuideFingerprint};
use crate::render::{GuideIo, Rendering, Settings, Stop, render_until};
use crate::scene::Scene;
use anyhow::{Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Warnings that are printed; of more only the number is.
const WARNINGS: usize = 20;

const EXAMPLES: &str = "Examples:
  phototaxis render model.obj
  phototaxis render scene.toml --time 60 -o out/scene.exr -o out/scene.png
  phototaxis render scene.toml --guide none --set film.width=640 --json -
  phototaxis render scene.toml --spp 256 --guide-out scene.guide
  phototaxis render scene.toml --spp 64 --guide-in scene.guide --set 'camera.origin=[0, 1, 4]'";

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
    /// Seconds to render for; all that happens after loading counts. Without --spp, time alone decides. All pixels get one
    /// sample at least.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    time: Option<f64>,
    /// Begins with what an earlier render of this scene learnt, whatever its camera.
    #[arg(long, value_name = "FILE")]
    guide_in: Option<PathBuf>,
    /// Writes what was learnt, also when a signal stops the render; the last iteration then learns too.
    #[arg(long, value_name = "FILE")]
    guide_out: Option<PathBuf>,
    /// Adds layers to the EXR: guide.fraction, guide.visits, guide.state.
    #[arg(long)]
    guide_layers: bool,
    /// Stops by which the PNG is brightened, or auto: by its log-average luminance, highlights kept. [default: the scene
    /// file's, else 0; auto for a model]
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true)]
    exposure: Option<Exposure>,
    /// Tone curve of the PNG: srgb (clamped), agx or aces (filmic). [default: the scene file's, else srgb;
    /// agx for a model]
    #[arg(long, value_name = "CURVE")]
    tone: Option<Tone>,
    #[command(flatten)]
    choices: Choices,
    /// Writes the figures as JSON; "-" is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(arguments: &RenderArguments) -> Result<ExitCode> {
    let threads = arguments.choices.machine.start(arguments.quiet)?;
    let (description, warnings) = format::load(&arguments.scene, &overrides(arguments))?;
    let outputs =
        Outputs::new(&arguments.output, arguments.json.as_ref(), arguments.guide_out.as_ref(), &arguments.scene)?;
    check_guide_options(arguments, &description, &outputs)?;
    let load = Instant::now();
    let (scene, more_warnings) = description.load_scene(threads)?;
    let load_seconds = load.elapsed().as_secs_f64();
    if !arguments.quiet {
        warn(&[warnings, more_warnings].concat());
    }
    let keeping = GuideIo {
        from: trained(arguments.guide_in.as_deref(), &scene, &description)?,
        keep: arguments.guide_out.is_some(),
    };
    let signals = Signals::catch(arguments.quiet)?;
    let rendering = watched(&scene, &description, keeping, arguments.quiet, signals.stop());
    let (interrupted, code) = (signals.came(), signals.exit_code());
    if !arguments.quiet {
        warn_of_non_finite(&rendering);
    }
    let film = &description.scene.film;
    let view = ViewTransform::of(film.exposure, film.tone, &beauty(&rendering.estimate));
    let context = Context {
        scene: &scene,
        name: arguments.scene.display().to_string(),
        seed: description.render.seed,
        interrupted,
        load_seconds: load_seconds - scene.build_seconds(),
        build_seconds: scene.build_seconds(),
        view,
        exposure_auto: film.exposure == Exposure::Auto,
        subject: subject(&scene, &description),
        guide_layers: rendering.guide.as_ref().filter(|_| arguments.guide_layers).map(|g| Layers::new(&scene, g)),
    };
    let report = Report::new(&context, &rendering);
    outputs.write(&context, &rendering, &report)?;
    if !arguments.quiet {
        say(&report.summary());
        outputs.paths().for_each(|path| say(&format!("wrote {}", path.display())));
    }
    if let Some(found) = report.non_finite() {
        say(&format!("error: {found}"));
        return Ok(ExitCode::from(super::NOT_FINITE));
    }
    Ok(code)
}

/// The flags that stand for keys of the scene file, then `--set`, which has the last word.
fn overrides(arguments: &RenderArguments) -> Vec<String> {
    let open_ended = arguments.time.is_some() && arguments.spp.is_none();
    let spp = arguments.spp.map(|n| n.to_string()).or(open_ended.then(|| i32::MAX.to_string()));
    let budget = [spp.map(|n| format!("render.spp={n}")), arguments.time.map(|t| format!("render.time={t:?}"))];
    let view = [
        arguments.exposure.map(|exposure| format!("film.exposure={exposure}")),
        arguments.tone.map(|tone| format!("film.tone={}", tone.name())),
    ];
    arguments.choices.overrides(budget.into_iter().chain(view).flatten())
}

/// Refuses options that could do nothing.
fn check_guide_options(arguments: &RenderArguments, scene: &SceneFile, outputs: &Outputs) -> Result<()> {
    let RenderArguments { guide_in, guide_out, guide_layers, .. } = arguments;
    let given =
        [("--guide-in", guide_in.is_some()), ("--guide-out", guide_out.is_some()), ("--guide-layers", *guide_layers)];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given)
        && scene.guiding.method == GuidingMethod::None
    {
        bail!("{option} needs a guide, and guiding.method is none");
    }
    if *guide_layers && !outputs.any_exr() {
        bail!("--guide-layers needs a picture in EXR");
    }
    Ok(())
}

/// What guides of this scene are kept for.
pub(super) fn subject(scene: &Scene, description: &SceneFile) -> GuideFingerprint {
    GuideFingerprint::new(scene.content_hash_text(), &description.guiding, &description.integrator)
}

/// The guide in a file, where one is given.
pub(super) fn trained(
    path: Option<&Path>,
    scene: &Scene,
    description: &SceneFile,
) -> Result<Option<guide_file::LoadedGuide>> {
    let read = |path| guide_file::read(path, &subject(scene, description), &description.guiding, scene.bounds());
    Ok(path.map(read).transpose()?)
}

/// Renders with a progress bar, until done or asked to stop.
pub(super) fn watched(scene: &Scene, description: &SceneFile, keeping: GuideIo, quiet: bool, stop: &Stop) -> Rendering {
    let settings = Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    };
    let bar = Bar::new(quiet);
    let rendering = render_until(scene, &settings, keeping, stop, &mut |progress| {
        bar.update(progress);
        true
    });
    bar.finish();
    rendering
}

pub(super) fn warn(warnings: &[String]) {
    warnings.iter().take(WARNINGS).for_each(|warning| say(&format!("warning: {warning}")));
    if let more @ 1.. = warnings.len().saturating_sub(WARNINGS) {
        say(&format!("warning: and {more} more"));
    }
}

fn warn_of_non_finite(rendering: &Rendering) {
    let total = total(&rendering.iterations);
    if let Some((x, y, sample)) = total.first_non_finite {
        let n = total.non_finite;
        say(&format!(
            "warning: {n} samples were not finite and count as black; the first is pixel ({x}, {y}), sample {sample}"
        ));
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number of seconds".into()),
    }
}
