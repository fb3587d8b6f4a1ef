//! `phototaxis render`: from a scene file or a model to pictures and figures.

use super::amounts;
use super::choices::Choices;
use super::output::{Denoised, Outputs, beauty, check_pictures};
use super::preview::{self, Preview};
use super::progress::{self, Bar, Show, Stage, say};
use super::report::{Context, Report, total};
use super::signals::Signals;
use crate::denoise::{Denoiser, Features};
use crate::embree::Device;
use crate::film::{FilmSettings, MAX_SIDE};
use crate::format;
use crate::format::SceneFile;
use crate::format::reference::help;
use crate::guiding::settings::GuidingMethod;
use crate::image::Rectangle;
use crate::image::{Exposure, Image, Tone, ViewTransform};
use crate::inspect::Layers;
use crate::io::clock::WallClock;
use crate::render::guide_file::{self, GuideFingerprint};
use crate::render::{GuideIo, Onlooker, Progress, Rendering, Settings, Stop, render_shown};
use crate::scene::description::{CameraDescription, Projection};
use crate::scene::{FoundCamera, Scene};
use anyhow::{Result, anyhow, bail, ensure};
use clap::Args;
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Warnings that are printed; of more only the number is.
const WARNINGS: usize = 20;

const EXAMPLES: &str = "Examples:
  phototaxis render model.obj
  phototaxis render scene.toml --size 1920x1080 --time 1m30s -o out/scene.exr -o out/scene.png
  phototaxis render scene.toml --guide none --scale 50% --json -
  phototaxis render scene.toml --spp 256 --guide-out scene.guide
  phototaxis render scene.toml --spp 64 --guide-in scene.guide --set 'camera.origin=[0, 1, 4]'";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderArguments {
    /// Scene (.toml, .json, .xml, .gltf, .glb) or model (.obj, .ply).
    scene: PathBuf,
    /// Picture to write, .exr (linear, all layers) or .png (sRGB); may be repeated. [default: both, named like the
    /// scene, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Replaces the pictures of another scene that has the same name; without --output only.
    #[arg(long, conflicts_with = "output")]
    force: bool,
    /// Size of the picture in pixels, for example 1920x1080. [default: the scene file's, else 1280x720]
    #[arg(long, value_name = "WxH", value_parser = amounts::size)]
    size: Option<(u32, u32)>,
    /// Scales the picture's size, for example 50%.
    #[arg(long, value_name = "PERCENT", value_parser = amounts::scale)]
    scale: Option<f64>,
    /// Renders a part of the picture alone, in pixels from the upper left of the whole as --size and --scale leave it.
    #[arg(long, value_name = "X,Y,W,H", value_parser = amounts::rectangle)]
    crop: Option<Rectangle>,
    #[arg(long, value_name = "N|1k", value_parser = amounts::count_u32, help = help("render.spp"))]
    spp: Option<u32>,
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds, help = help("render.time"))]
    time: Option<f64>,
    /// Begins with what an earlier render of this scene learnt, whatever its camera.
    #[arg(long, value_name = "FILE")]
    guide_in: Option<PathBuf>,
    /// Writes what was learnt, also when a signal stops the render; the last iteration then learns too.
    #[arg(long, value_name = "FILE")]
    guide_out: Option<PathBuf>,
    /// Rewrites this picture, .png or .exr (colours, alpha, numbers of samples), again and again while it renders.
    #[arg(long, value_name = "FILE")]
    preview: Option<PathBuf>,
    /// Time between two previews; more where writing one takes more than a twentieth of it. [default: 10s]
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds, requires = "preview")]
    every: Option<f64>,
    /// Adds layers to the EXR: guide.fraction, guide.visits, guide.state.
    #[arg(long)]
    guide_layers: bool,
    #[arg(long, value_name = "LAYERS", value_delimiter = ',', help = help("render.layers"))]
    layers: Vec<String>,
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true, help = help("film.exposure"))]
    exposure: Option<Exposure>,
    /// Tone curve of the PNG: srgb (clamped), agx or aces (filmic). [default: the scene file's, else srgb;
    /// agx for a model]
    #[arg(long, value_name = "CURVE")]
    tone: Option<Tone>,
    #[command(flatten)]
    choices: Choices,
    /// Removes the noise by Intel Open Image Denoise, which must be installed: the PNG shows the result, the EXR has it as
    /// denoised.{R,G,B} beside the picture as it was rendered.
    #[arg(long)]
    denoise: bool,
    /// Makes errors of pictures of a material library that are missing or cannot be read, which else are warnings.
    #[arg(long)]
    strict: bool,
    /// How progress is shown on standard error.
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    progress: Show,
    /// Writes the figures as JSON; "-" is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<ExitCode> {
    let show = if arguments.quiet { Show::None } else { arguments.progress };
    progress::choose(show);
    let threads = arguments.choices.machine.start(arguments.quiet)?;
    let (mut description, warnings) =
        format::load_seen_by(&arguments.scene, arguments.choices.camera.as_deref(), &overrides(arguments))?;
    let film = &mut description.scene.film;
    arguments.scale.map_or(Ok(()), |scale| rescale(film, scale))?;
    arguments.crop.map_or(Ok(()), |part| crop(film, &part))?;
    let outputs = outputs(arguments)?;
    check_options(arguments, &description, &outputs)?;
    // Whoever lacks the library learns it now and not when hours are gone.
    let denoiser = arguments.denoise.then(|| Denoiser::new(rayon::current_num_threads())).transpose()?;
    let bar = Bar::of(show, Stage::Loading);
    let load = WallClock::start();
    let (scene, more_warnings) =
        description.load_scene_watched(Device::new(threads)?, &|stage| bar.stage(stage.into()))?;
    let load_seconds = load.elapsed().as_secs_f64();
    if !arguments.quiet {
        warn(&[warnings, more_warnings].concat());
        outputs.note().iter().for_each(|note| say(note));
        scene.found_camera().iter().for_each(|found| say(&camera_note(found)));
    }
    let keeping = GuideIo {
        from: trained(arguments.guide_in.as_deref(), &scene, &description)?,
        keep: arguments.guide_out.is_some(),
    };
    let signals = Signals::catch(arguments.quiet)?;
    let mut preview = preview(arguments, &scene, &description);
    let rendering = watched_by(&bar, &scene, &description, keeping, signals.stop(), preview.as_mut());
    // the newest is in its file before the picture is
    drop(preview);
    if !arguments.quiet {
        warn_of_non_finite(&rendering);
    }
    let denoised = match denoiser {
        Some(_) if signals.stop().is_urgent() => {
            Err(anyhow!("not denoised, since a second signal asked for what there is"))
        }
        denoiser => denoiser.map(|denoiser| denoised(&denoiser, &rendering, &bar)).transpose(),
    };
    // A picture with its noise is better than none.
    let (denoised, failure) = denoised.map_or_else(|error| (None, Some(error)), |denoised| (denoised, None));
    let film = &description.scene.film;
    let context = Context {
        scene: &scene,
        name: arguments.scene.display().to_string(),
        seed: description.render.seed,
        interrupted: signals.came(),
        load_seconds: load_seconds - scene.build_seconds(),
        build_seconds: scene.build_seconds(),
        view: view(film, &rendering, denoised.as_ref()),
        exposure_auto: film.exposure == Exposure::Auto,
        subject: subject(&scene, &description),
        whole: [film.width, film.height],
        extra_layers: description.render.layers.clone(),
        guide_layers: rendering.guide.as_ref().filter(|_| arguments.guide_layers).map(|g| Layers::new(&scene, g)),
        denoised,
    };
    let finite = conclude(&outputs, &context, &rendering, bar, arguments.quiet)?;
    failure.map_or(Ok(()), Err)?;
    Ok(if finite { signals.exit_code() } else { ExitCode::from(super::NOT_FINITE) })
}

/// A place as one would write it, in single precision where that is all it has.
fn written(v: DVec3) -> String {
    if v.as_vec3().as_dvec3() == v { v.as_vec3().to_string() } else { v.to_string() }
}

/// Where the camera stands that was found, as one would write it.
fn camera_note(found: &FoundCamera) -> String {
    let CameraDescription { origin, target, up, vfov, view_height, .. } = &found.camera;
    let place = if found.outside { "outside, where all of the model is in the picture" } else { "where most is seen" };
    let [origin, target] = [origin, target].map(|v| written(*v));
    let up = if *up == Vec3::Y { String::new() } else { format!(" --set 'camera.up={up}'") };
    let field = match found.camera.projection {
        Projection::Perspective => format!(" --set camera.vfov={vfov}"),
        Projection::Orthographic => format!(" --set camera.view_height={view_height}"),
        Projection::Panorama => String::new(),
    };
    format!("note: the camera stands {place}: --set 'camera.origin={origin}' --set 'camera.target={target}'{up}{field}")
}

/// Writes all that was asked for and says so; `false` where pixels are not finite.
fn conclude(outputs: &Outputs, context: &Context, rendering: &Rendering, bar: Bar, quiet: bool) -> Result<bool> {
    bar.stage(Stage::Writing);
    let report = Report::new(context, rendering);
    outputs.write(context, rendering, &report)?;
    bar.finish();
    if !quiet {
        report.blackness().iter().for_each(|black| say(&format!("warning: {black}")));
        say(&report.summary());
        outputs.paths().for_each(|path| say(&format!("wrote {}", path.display())));
    }
    report.non_finite().iter().for_each(|found| say(&format!("error: {found}")));
    Ok(report.non_finite().is_none())
}

fn outputs(arguments: &RenderArguments) -> Result<Outputs> {
    let (json, guide) = (arguments.json.as_ref(), arguments.guide_out.as_ref());
    Outputs::new(&arguments.output, json, guide, &arguments.scene, arguments.force)
}

/// What rewrites the picture so far, where that is asked for.
fn preview(arguments: &RenderArguments, scene: &Scene, description: &SceneFile) -> Option<Preview> {
    let path = arguments.preview.as_ref()?;
    let (every, name) = (arguments.every.unwrap_or(preview::EVERY), arguments.scene.display().to_string());
    Some(Preview::new(path, every, &name, scene, description).quietly(arguments.quiet))
}

/// How the picture is shown: the denoised one, where there is one.
pub(super) fn view(film: &FilmSettings, rendering: &Rendering, denoised: Option<&Denoised>) -> ViewTransform {
    let shown = |image: &Image| ViewTransform::of(film.exposure, film.tone, image);
    denoised.map_or_else(|| shown(&beauty(&rendering.estimate)), |denoised| shown(&denoised.image))
}

/// The picture without its noise.
fn denoised(denoiser: &Denoiser, rendering: &Rendering, bar: &Bar) -> Result<Denoised> {
    bar.stage(Stage::Denoising);
    let (start, e) = (WallClock::start(), &rendering.estimate);
    let (albedo, normal): (Vec<_>, Vec<_>) = e.features.iter().map(|f| (f.albedo, f.normal)).unzip();
    let image = denoiser.denoise(&beauty(e), &Features { albedo: &albedo, normal: &normal })?;
    Ok(Denoised { image, seconds: start.elapsed().as_secs_f64(), by: denoiser.version().to_string() })
}

/// The flags that stand for keys of the scene file, then `--set`, which has the last word.
fn overrides(arguments: &RenderArguments) -> Vec<String> {
    let open_ended = arguments.time.is_some() && arguments.spp.is_none();
    let spp = arguments.spp.map(|n| n.to_string()).or(open_ended.then(|| i32::MAX.to_string()));
    let budget = [spp.map(|n| format!("render.spp={n}")), arguments.time.map(|t| format!("render.time={t:?}"))];
    let layers = (!arguments.layers.is_empty()).then(|| format!("render.layers={:?}", arguments.layers));
    let strict = arguments.strict.then(|| "render.strict=true".to_string());
    let size = arguments.size.map(|(width, height)| [format!("film.width={width}"), format!("film.height={height}")]);
    let view = [
        arguments.exposure.map(|exposure| format!("film.exposure={exposure}")),
        arguments.tone.map(|tone| format!("film.tone={}", tone.name())),
    ];
    arguments.choices.overrides(
        budget.into_iter().chain(view).flatten().chain(layers).chain(strict).chain(size.into_iter().flatten()),
    )
}

/// The film in another size, of the same shape as far as whole pixels allow.
fn rescale(film: &mut FilmSettings, scale: f64) -> Result<()> {
    ensure!(film.crop.is_none(), "--scale and film.crop: give the part of the smaller picture by --crop");
    for side in [&mut film.width, &mut film.height] {
        let scaled = amounts::scaled(u64::from(*side), scale);
        ensure!(scaled <= MAX_SIDE.into(), "--scale makes a side of {scaled} pixels, and {MAX_SIDE} are the most");
        *side = scaled as u32;
    }
    Ok(())
}

fn crop(film: &mut FilmSettings, part: &Rectangle) -> Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(|_| anyhow!("--crop: {n} pixels are more than a picture has"));
    film.crop = Some([side(part.x)?, side(part.y)?, side(part.width)?, side(part.height)?]);
    film.check_crop().map_err(|error| anyhow!("--crop: {error}"))
}

/// Refuses options that could do nothing.
fn check_options(arguments: &RenderArguments, scene: &SceneFile, outputs: &Outputs) -> Result<()> {
    let RenderArguments { guide_in, guide_out, guide_layers, preview, .. } = arguments;
    check_pictures(preview.as_slice())?;
    let given =
        [("--guide-in", guide_in.is_some()), ("--guide-out", guide_out.is_some()), ("--guide-layers", *guide_layers)];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given)
        && scene.guiding.method == GuidingMethod::None
    {
        bail!("{option} needs a guide, and guiding.method is none");
    }
    for (option, given) in [("--guide-layers", *guide_layers), ("--layers", !arguments.layers.is_empty())] {
        ensure!(!given || outputs.any("exr"), "{option} needs a picture in EXR");
    }
    let shown =
        outputs.any("png") || arguments.preview.as_ref().is_some_and(|p| p.extension().is_some_and(|e| e == "png"));
    for (option, given) in [("--exposure", arguments.exposure.is_some()), ("--tone", arguments.tone.is_some())] {
        ensure!(!given || shown, "{option} needs a picture in PNG: an EXR stays linear and unexposed");
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
    watched_by(&Bar::new(quiet), scene, description, keeping, stop, None)
}

/// The same with a bar of the caller's.
fn watched_by(
    bar: &Bar,
    scene: &Scene,
    description: &SceneFile,
    keeping: GuideIo,
    stop: &Stop,
    onlooker: Option<&mut Preview>,
) -> Rendering {
    let settings = Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    };
    bar.stage(Stage::Rendering);
    let mut nobody = ();
    let onlooker = onlooker.map_or(&mut nobody as &mut dyn Onlooker, |preview| preview);
    let mut observer = |progress: &Progress| {
        bar.update(progress);
        true
    };
    render_shown(scene, &settings, keeping, &(), stop, (&mut observer, onlooker))
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
