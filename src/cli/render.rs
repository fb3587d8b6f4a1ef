//! `phototaxis render`: from a scene file or a model to pictures and figures.

use super::checkpointer::{self, Checkpointer};
use super::frames::{self, FramesLeft};
use super::layers::layers;
use super::onlookers::{Displays, Onlookers};
use super::output::{Denoised, Outputs, beauty};
use super::preview::{self, Preview};
use super::progress::{self, Bar, Stage, say};
use super::render_arguments::{Budget, OPEN_ENDED, RenderArguments, check_options};
use super::report::{Context, Report};
use super::signals::Signals;
use crate::denoise::{Denoiser, Features};
use crate::embree::Device;
use crate::film::FilmSettings;
use crate::format::SceneFile;
use crate::image::{Exposure, Image, ViewTransform};
use crate::inspect::Layers;
use crate::io::clock::WallClock;
use crate::render::checkpoint::{CheckpointFile, Header};
use crate::render::guide_file::{self, GuideFingerprint};
use crate::render::part::{Part, Wanted, render_part};
use crate::render::{Checkpoint, GuideIo, Onlooker, Progress, Rendering, Settings, Stop, render_shown, resume};
use crate::scene::description::{CameraDescription, Projection};
use crate::scene::{FoundCamera, Scene};
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use glam::{DVec3, Vec3};
use std::path::Path;
use std::process::ExitCode;

/// Warnings that are printed; of more only the number is.
const WARNINGS: usize = 20;

/// How a render was asked for of which there is a checkpoint.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct CheckpointRequest {
    pub(super) arguments: RenderArguments,
    /// Of an animation.
    pub(super) frames: Option<FramesLeft>,
}

/// What a render goes on from.
pub(super) struct Resumption {
    pub(super) file: CheckpointFile<CheckpointRequest>,
    /// Samples per pixel of the whole render, seconds from now on, and relative error, where they are to be others.
    pub(super) spp: Option<u32>,
    pub(super) seconds: Option<f64>,
    pub(super) noise: Option<f64>,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<ExitCode> {
    if let Some(path) = arguments.checkpoint.as_ref().filter(|path| path.is_file() && !arguments.force) {
        bail!(
            "{0}: there is a checkpoint already: go on by phototaxis resume {0}, or replace it by --force",
            path.display()
        );
    }
    if let Some(range) = arguments.animation.range()? {
        return frames::run(arguments, range);
    }
    arguments.part.map_or_else(|| render(arguments, None), |part| shared(arguments, part))
}

/// Renders part of the samples, into a film of their own or for a guide to learn from.
fn shared(arguments: &RenderArguments, (number, parts): (u32, u32)) -> Result<ExitCode> {
    let ready = Ready::new(arguments)?;
    let Ready { description, scene, bar, .. } = &ready;
    let spp = description.render.spp;
    let part = Part::of(number, parts, spp)
        .with_context(|| format!("--part: {spp} samples per pixel have no {parts} parts"))?;
    let guide = trained(arguments.guide_in.as_deref(), scene, description)?;
    let signals = Signals::catch(arguments.quiet)?;
    bar.stage(Stage::Rendering);
    let settings = settings(description);
    let mut observer = |progress: &Progress| {
        bar.update(progress);
        !signals.stop().is_asked()
    };
    let (film, lesson) = (arguments.film_out.as_deref(), arguments.learn_out.as_deref());
    let paths = || film.into_iter().chain(lesson).map(Path::display);
    let wanted = Wanted { film: film.is_some(), lesson: lesson.is_some() };
    let done = render_part(scene, &settings, guide.as_ref(), (part, wanted), signals.stop(), &mut observer);
    let Some(done) = done else {
        paths().for_each(|path| say(&format!("error: {path}: not written, since the part was stopped")));
        return Ok(signals.exit_code());
    };
    bar.stage(Stage::Writing);
    let request = arguments.settled(&ready.outputs, &description.render)?;
    done.write(&Header::new(scene, &settings, request), film, lesson)?;
    ready.bar.finish();
    if !arguments.quiet {
        paths().for_each(|path| say(&format!("wrote {path}")));
    }
    Ok(ExitCode::SUCCESS)
}

/// Renders, or goes on with a render that was asked for by the same arguments.
pub(super) fn render(arguments: &RenderArguments, from: Option<Resumption>) -> Result<ExitCode> {
    let mut ready = Ready::new(arguments)?;
    let start = start(arguments, from, &ready.scene, &mut ready.description)?;
    let signals = Signals::catch(arguments.quiet)?;
    let mut onlookers = onlookers(&ready, None)?;
    let rendering = watched_by(&ready.bar, &ready.scene, &ready.description, start, signals.stop(), &mut onlookers);
    let go_on = onlookers.finish(signals.stop());
    let code = ready.present(&rendering, &signals);
    ready.end(&signals);
    ready.say_how_to_go_on(go_on.as_deref());
    code
}

/// All that is there before a picture is.
pub(super) struct Ready<'a> {
    arguments: &'a RenderArguments,
    pub(super) description: SceneFile,
    pub(super) scene: Scene,
    pub(super) outputs: Outputs,
    denoiser: Option<Denoiser>,
    displays: Displays,
    pub(super) bar: Bar,
    load_seconds: f64,
}

impl<'a> Ready<'a> {
    /// Starts the threads, checks what can be checked, and loads the scene.
    pub(super) fn new(arguments: &'a RenderArguments) -> Result<Ready<'a>> {
        Ready::writing(arguments, RenderArguments::outputs)
    }

    /// The same where no picture will be written.
    pub(super) fn without_outputs(arguments: &'a RenderArguments) -> Result<Ready<'a>> {
        Ready::writing(arguments, |_| Ok(Outputs::default()))
    }

    fn writing(
        arguments: &'a RenderArguments,
        outputs: impl FnOnce(&RenderArguments) -> Result<Outputs>,
    ) -> Result<Ready<'a>> {
        progress::choose(arguments.show());
        let threads = arguments.choices.machine.start(arguments.quiet)?;
        let (description, warnings) = arguments.load()?;
        let outputs = outputs(arguments)?;
        check_options(arguments, &description, &outputs)?;
        // Whoever lacks the library learns it now and not when hours are gone.
        let denoiser = arguments.denoise.then(|| Denoiser::new(rayon::current_num_threads())).transpose()?;
        let displays = Displays::open(&arguments.displays, &arguments.name(), &description, arguments.quiet)?;
        let bar = Bar::of(arguments.show(), Stage::Loading);
        displays.follow(|| bar.status());
        let load = WallClock::start();
        let (scene, more_warnings) =
            description.load_scene_watched(Device::new(threads)?, &|stage| bar.stage(stage.into()))?;
        let load_seconds = load.elapsed().as_secs_f64();
        if !arguments.quiet {
            warn(&[warnings, more_warnings].concat());
            outputs.note().iter().for_each(|note| say(note));
            scene.found_camera().iter().for_each(|found| say(&camera_note(found)));
        }
        Ok(Ready { arguments, description, scene, outputs, denoiser, displays, bar, load_seconds })
    }

    /// Writes all that was asked for.
    pub(super) fn present(&self, rendering: &Rendering, signals: &Signals) -> Result<ExitCode> {
        let Ready { arguments, description, scene, outputs, denoiser, displays, bar, load_seconds } = self;
        if !arguments.quiet {
            warn_of_non_finite(rendering);
        }
        let denoised = match denoiser {
            Some(_) if signals.stop().is_urgent() => {
                Err(anyhow!("not denoised, since a second signal asked for what there is"))
            }
            denoiser => denoiser.as_ref().map(|denoiser| denoised(denoiser, rendering, bar)).transpose(),
        };
        // A picture with its noise is better than none.
        let (denoised, failure) = denoised.map_or_else(|error| (None, Some(error)), |denoised| (denoised, None));
        let film = &description.scene.film;
        let context = Context {
            scene,
            stop: signals.stop(),
            name: arguments.name(),
            seed: description.render.seed,
            interrupted: signals.came(),
            load_seconds: load_seconds - scene.build_seconds(),
            build_seconds: scene.build_seconds(),
            view: view(film, rendering, denoised.as_ref()),
            exposure_auto: film.exposure == Exposure::Auto,
            subject: subject(scene, description),
            whole: [film.width, film.height],
            extra_layers: description.render.layers.clone(),
            guide_layers: rendering.guide.as_ref().filter(|_| arguments.guide_layers).map(|g| Layers::new(scene, g)),
            denoised,
        };
        let finite = conclude(outputs, &context, rendering, bar, arguments.quiet)?;
        let size = [rendering.estimate.width, rendering.estimate.height];
        displays.show(|| layers(rendering, &context), size, signals.stop());
        failure.map_or(Ok(()), Err)?;
        Ok(if finite { signals.exit_code() } else { ExitCode::from(super::NOT_FINITE) })
    }

    /// Names the checkpoint that is of the end of the render, where there is one.
    pub(super) fn say_how_to_go_on(&self, checkpoint: Option<&Path>) {
        if let Some(path) = checkpoint.filter(|_| !self.arguments.quiet) {
            say(&format!("wrote {0}: phototaxis resume {0} goes on", path.display()));
        }
    }

    /// Tells all who watch that nothing more comes.
    pub(super) fn end(&self, signals: &Signals) {
        self.displays.end(if signals.came() { "stopped by a signal" } else { "done" }, signals.stop());
    }
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
fn conclude(outputs: &Outputs, context: &Context, rendering: &Rendering, bar: &Bar, quiet: bool) -> Result<bool> {
    bar.stage(Stage::Writing);
    let report = Report::new(context, rendering);
    outputs.write(context, rendering, &report)?;
    if !quiet {
        report.blackness().iter().for_each(|black| say(&format!("warning: {black}")));
        say(&report.summary());
        outputs.paths().for_each(|path| say(&format!("wrote {}", path.display())));
    }
    report.non_finite().iter().for_each(|found| say(&format!("error: {found}")));
    Ok(report.non_finite().is_none())
}

/// What rewrites the picture so far and what it takes to go on, where that is asked for; `frames` are left of an animation.
pub(super) fn onlookers(ready: &Ready, frames: Option<&FramesLeft>) -> Result<Onlookers> {
    let Ready { arguments, description, scene, outputs, .. } = ready;
    let quiet = arguments.quiet;
    let preview = arguments.preview.as_ref().map(|path| {
        let every = arguments.every.unwrap_or(preview::EVERY);
        Preview::new(path, every, &arguments.name(), scene, description).quietly(quiet)
    });
    let checkpointer = arguments.checkpoint.as_ref().map(|path| {
        let every = arguments.every.unwrap_or(checkpointer::EVERY);
        let arguments = arguments.settled(outputs, &description.render)?;
        let request = CheckpointRequest { arguments, frames: frames.cloned() };
        let header = Header::new(scene, &settings(description), request);
        anyhow::Ok(Checkpointer::new(path, every, header, quiet))
    });
    Ok(Onlookers::new(preview, &ready.displays, description, checkpointer.transpose()?))
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
    watched_by(&Bar::new(quiet), scene, description, Start::New(Box::new(keeping)), stop, &mut ())
}

/// The same with a bar of the caller's.
pub(super) fn watched_by(
    bar: &Bar,
    scene: &Scene,
    description: &SceneFile,
    start: Start,
    stop: &Stop,
    onlooker: &mut dyn Onlooker,
) -> Rendering {
    let settings = settings(description);
    bar.stage(Stage::Rendering);
    let mut observer = |progress: &Progress| {
        bar.update(progress);
        true
    };
    match start {
        Start::New(keeping) => render_shown(scene, &settings, *keeping, &(), stop, (&mut observer, onlooker)),
        Start::From(from, new_budget) => {
            resume(scene, &settings, (*from, new_budget), &(), stop, (&mut observer, onlooker))
        }
    }
}

/// What a render begins with.
pub(super) enum Start {
    New(Box<GuideIo>),
    /// Where another one was, with its budget or another.
    From(Box<Checkpoint>, bool),
}

/// What to begin with. Of a render that goes on, the budget is set.
fn start(
    arguments: &RenderArguments,
    from: Option<Resumption>,
    scene: &Scene,
    description: &mut SceneFile,
) -> Result<Start> {
    let Some(Resumption { file, spp, seconds, noise }) = from else {
        let from = trained(arguments.guide_in.as_deref(), scene, description)?;
        return Ok(Start::New(Box::new(GuideIo { from, keep: arguments.guide_out.is_some() })));
    };
    let from = file.read(scene, &settings(description))?;
    let (new_budget, render) = (spp.is_some() || seconds.is_some() || noise.is_some(), &mut description.render);
    if new_budget {
        let time = seconds.map(|more| from.seconds() + more);
        Budget { spp: spp.unwrap_or(OPEN_ENDED), time, noise }.set(render);
    }
    let (has, wanted) = (from.samples(), render.spp);
    ensure!(wanted >= has, "--spp {wanted}: the render has {has} samples per pixel already");
    Ok(Start::From(Box::new(from), new_budget))
}

pub(super) fn settings(description: &SceneFile) -> Settings {
    Settings {
        integrator: description.integrator.clone(),
        guiding: description.guiding.clone(),
        render: description.render.clone(),
    }
}

pub(super) fn warn(warnings: &[String]) {
    warnings.iter().take(WARNINGS).for_each(|warning| say(&format!("warning: {warning}")));
    if let more @ 1.. = warnings.len().saturating_sub(WARNINGS) {
        say(&format!("warning: and {more} more"));
    }
}

fn warn_of_non_finite(rendering: &Rendering) {
    let total = rendering.total();
    if let Some((x, y, sample)) = total.first_non_finite {
        let n = total.non_finite;
        say(&format!(
            "warning: {n} samples were not finite and count as black; the first is pixel ({x}, {y}), sample {sample}"
        ));
    }
}
