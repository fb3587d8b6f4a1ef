//! `phototaxis render --frames`: pictures of a camera that moves.
//!
//! The scene is loaded and built once. What the guide has learnt in a frame goes on to the next, as through a file: it is frozen
//! while it is drawn from, and no frame draws the random numbers of another, so that each is unbiased by itself.

mod pattern;
mod range;

pub(crate) use range::FrameRange;

use super::names;
use super::output::Outputs;
use super::progress::say;
use super::render::{CheckpointRequest, Ready, Start, onlookers, settings, trained, watched_by};
use super::render_arguments::RenderArguments;
use super::signals::Signals;
use crate::guiding::settings::GuidingMethod;
use crate::image::Exposure;
use crate::render::checkpoint::CheckpointFile;
use crate::render::guide_file::LoadedGuide;
use crate::render::{GuideIo, Rendering};
use crate::scene::description::CameraDescription;
use anyhow::{Context as _, Result, bail, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Which frames, and what becomes of those that are there.
#[derive(Args, Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct FrameArguments {
    /// Renders frames of an animation: A..B (both too), A..B:STEP or one. The camera moves as its keys say ([[camera.key]]), or
    /// by --turntable. Names of files have #### or %04d for the number. [default with --turntable: 1..N]
    #[arg(long, value_name = "A..B", conflicts_with = "part")]
    pub(super) frames: Option<FrameRange>,
    /// Turns the camera around its target, once in N frames; frame 1 is the view itself.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with = "part")]
    pub(super) turntable: Option<u32>,
    /// Leaves out frames whose files are all there and whole. Without it, or --force, such files are an error.
    #[arg(long, conflicts_with = "force")]
    pub(super) skip_existing: bool,
}

impl FrameArguments {
    /// Those that are asked for, if any are.
    pub(super) fn range(&self) -> Result<Option<FrameRange>> {
        let whole_turn = |n: u32| format!("1..{n}").parse().map_err(anyhow::Error::msg);
        let range = self.frames.map(Ok).or(self.turntable.map(whole_turn)).transpose()?;
        ensure!(range.is_some() || !self.skip_existing, "--skip-existing needs --frames");
        Ok(range)
    }
}

/// A frame to render.
struct Frame {
    number: u32,
    camera: CameraDescription,
}

/// What a checkpoint of an animation keeps beside the frame under way.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct FramesLeft {
    pub(super) asked: FrameArguments,
    /// Numbers of the frame under way and of those after it, and how many frames were to be rendered in all.
    numbers: Vec<u32>,
    all: usize,
    /// As in [`Carried`].
    salt: u64,
    /// By which the frame is shown.
    exposure: Exposure,
}

/// The files of a frame. The guide is written with the last.
pub(super) fn outputs(arguments: &RenderArguments, number: u32, is_last: bool) -> Result<Outputs> {
    let range = arguments.animation.range()?;
    let alone = range.is_some_and(|range| range.numbers().len() == 1);
    let named = |path: &PathBuf| match pattern::numbered(path, number) {
        Some(path) => Ok(path),
        None if alone || path.as_os_str() == "-" => Ok(path.clone()),
        None => bail!("{}: several frames need a name with #### or %04d for their numbers", path.display()),
    };
    let pictures = patterns(arguments)?.iter().map(named).collect::<Result<Vec<_>>>()?;
    let json = arguments.json.as_ref().map(named).transpose()?;
    let guide = arguments.guide_out.as_ref().filter(|_| is_last);
    Outputs::new(&pictures, json.as_ref(), guide, &arguments.scene, true)
}

/// The names of their pictures, with the place of the number.
pub(super) fn patterns(arguments: &RenderArguments) -> Result<Vec<PathBuf>> {
    match &arguments.output[..] {
        [] => Ok(names::of_frames(&arguments.scene)?.to_vec()),
        given => Ok(given.to_vec()),
    }
}

/// Renders them.
pub(super) fn run(arguments: &RenderArguments, range: FrameRange) -> Result<ExitCode> {
    let numbers = to_render(arguments, range)?;
    if numbers.is_empty() {
        if !arguments.quiet {
            say("all frames are there already");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let mut ready = Ready::new(arguments)?;
    if arguments.animation.skip_existing {
        share_exposure(arguments, &mut ready, range.first())?;
    }
    let guide = Carried::new(arguments, &ready)?;
    let (asked, exposure) = (arguments.animation.clone(), ready.description.scene.film.exposure);
    let left = FramesLeft { asked, all: numbers.len(), numbers, salt: guide.salt, exposure };
    render(arguments, ready, guide, (left, None))
}

/// Goes on with the frame that a checkpoint is of, and renders those that are left.
pub(super) fn resume(
    arguments: &RenderArguments,
    left: FramesLeft,
    from: CheckpointFile<CheckpointRequest>,
) -> Result<ExitCode> {
    let mut ready = Ready::new(arguments)?;
    ready.description.scene.film.exposure = left.exposure;
    let guide = Carried::nothing(arguments, &ready, left.salt);
    render(arguments, ready, guide, (left, Some(from)))
}

/// Renders what is left, one frame after the other, until the last or a signal; `from` where the first was left.
fn render(
    arguments: &RenderArguments,
    mut ready: Ready,
    mut guide: Carried,
    (mut left, mut from): (FramesLeft, Option<CheckpointFile<CheckpointRequest>>),
) -> Result<ExitCode> {
    let frames = frames(arguments, &ready, &left.numbers)?;
    let signals = Signals::catch(arguments.quiet)?;
    let (seed, mut code, mut go_on) = (ready.description.render.seed, ExitCode::SUCCESS, None);
    for (k, frame) in (left.all - frames.len() + 1..).zip(&frames) {
        let is_last = k == left.all;
        ready.description.render.seed = seed.wrapping_add(frame.number.into());
        ready.scene.look_through(&frame.camera, &ready.description.scene.film)?;
        ready.bar.begin_frame([frame.number as usize, k, left.all]);
        left.exposure = ready.description.scene.film.exposure;
        let start = match from.take() {
            Some(file) => Start::From(Box::new(file.read(&ready.scene, &settings(&ready.description))?), false),
            None => Start::New(Box::new(guide.io(is_last))),
        };
        let mut onlookers = onlookers(&ready, Some(&left))?;
        let rendering = watched_by(&ready.bar, &ready.scene, &ready.description, start, signals.stop(), &mut onlookers);
        go_on = onlookers.finish(signals.stop());
        ready.outputs = outputs(arguments, frame.number, is_last || signals.stop().is_asked())?;
        if !arguments.quiet {
            say(&format!("frame {} ({k} of {}):", frame.number, left.all));
        }
        code = worse(code, ready.present(&rendering, &signals)?);
        share_exposure(arguments, &mut ready, frame.number)?;
        if signals.stop().is_asked() {
            break;
        }
        guide.take(rendering, &ready)?;
        left.numbers.remove(0);
    }
    ready.end(&signals);
    ready.say_how_to_go_on(go_on.as_deref());
    Ok(code)
}

/// Where the exposure is automatic, shows the frames that follow as frame `number` is shown, if that is there: else they would flicker.
fn share_exposure(arguments: &RenderArguments, ready: &mut Ready, number: u32) -> Result<()> {
    let exposure = &mut ready.description.scene.film.exposure;
    if *exposure == Exposure::Auto {
        let files = outputs(arguments, number, false)?;
        let shown = files.pictures().iter().find_map(|path| names::exposure(path));
        *exposure = shown.map_or(Exposure::Auto, Exposure::Stops);
    }
    Ok(())
}

/// The first that is no success.
fn worse(before: ExitCode, after: ExitCode) -> ExitCode {
    if before == ExitCode::SUCCESS { after } else { before }
}

/// The frames that are not there. Those that are, are refused unless they are to be skipped or replaced.
fn to_render(arguments: &RenderArguments, range: FrameRange) -> Result<Vec<u32>> {
    let (mut left, mut there) = (Vec::new(), Vec::<PathBuf>::new());
    for number in range.numbers() {
        let outputs = outputs(arguments, number, false)?;
        let files = outputs.pictures();
        if arguments.animation.skip_existing && files.iter().all(|path| names::is_whole(path)) {
            continue;
        }
        there.extend(files.iter().filter(|path| path.is_file()).cloned());
        left.push(number);
    }
    let may_replace = arguments.force || arguments.animation.skip_existing;
    if let Some(first) = there.first().filter(|_| !may_replace) {
        let more =
            if there.len() > 1 { format!(", and {} more are there too", there.len() - 1) } else { String::new() };
        bail!(
            "{}: is there already{more}: --skip-existing leaves such frames out, --force replaces them",
            first.display()
        );
    }
    Ok(left)
}

/// Where the camera is in each of them.
fn frames(arguments: &RenderArguments, ready: &Ready, numbers: &[u32]) -> Result<Vec<Frame>> {
    let (scene, said) = (&ready.scene, ready.description.scene.camera.as_ref());
    let found = scene.found_camera().map(|found| &found.camera);
    let base = found.or(said).context("--frames: the scene has no camera")?;
    let keys = said.map_or(&[][..], |camera| &camera.keys);
    let turntable = arguments.animation.turntable.map(f64::from);
    ensure!(
        turntable.is_some() || !keys.is_empty(),
        "--frames: nothing moves. The camera has no keys ([[camera.key]]); --turntable N turns it around its target"
    );
    ensure!(
        turntable.is_none() || keys.is_empty(),
        "--turntable: the camera moves already, by its keys ([[camera.key]])"
    );
    if turntable.is_some() && !arguments.quiet {
        let [x, y, z] = base.target.to_array();
        say(&format!("note: the camera turns around its target, ({x}, {y}, {z})"));
    }
    let film = &ready.description.scene.film;
    let frame = |&number: &u32| {
        let at = f64::from(number);
        let camera = turntable.map_or_else(|| base.at(at), |n| base.turned((at - 1.0) / n));
        scene.check_camera(&camera, film).with_context(|| format!("frame {number}"))?;
        Ok(Frame { number, camera })
    };
    numbers.iter().map(frame).collect()
}

/// The guide from frame to frame.
struct Carried {
    guide: Option<LoadedGuide>,
    /// Of the guide that there was before the first frame, else 0; see [`LoadedGuide::salt`]. Frames differ in their seeds, so that it
    /// need not change from one to the next.
    salt: u64,
    is_written: bool,
    /// The guide is in use only where it pays.
    is_auto: bool,
}

impl Carried {
    fn new(arguments: &RenderArguments, ready: &Ready) -> Result<Carried> {
        let path: Option<&Path> = arguments.guide_in.as_deref();
        let guide = trained(path, &ready.scene, &ready.description)?;
        let salt = guide.as_ref().map_or(0, |guide| guide.salt);
        Ok(Carried { guide, ..Carried::nothing(arguments, ready, salt) })
    }

    /// Before a frame has left one.
    fn nothing(arguments: &RenderArguments, ready: &Ready, salt: u64) -> Carried {
        let is_auto = ready.description.guiding.method == GuidingMethod::Auto;
        Carried { guide: None, salt, is_written: arguments.guide_out.is_some(), is_auto }
    }

    /// What the next frame begins with. It is learnt from to its end if the guide is of use after it; where it is not yet known whether
    /// the guide pays, that is found out first.
    fn io(&mut self, is_last: bool) -> GuideIo {
        let is_known = !self.is_auto || self.guide.is_some();
        GuideIo { from: self.guide.take(), keep: self.is_written || (!is_last && is_known) }
    }

    /// Takes what a frame leaves, if that is of use.
    fn take(&mut self, rendering: Rendering, ready: &Ready) -> Result<()> {
        let pays = rendering.verdict.is_none_or(|verdict| verdict.guided);
        if let Some(guide) = rendering.guide.filter(|guide| pays && guide.states() > 0) {
            let settings = &ready.description.guiding;
            let carried = LoadedGuide::carried(&guide, rendering.learnt_paths, settings, ready.scene.bounds());
            self.guide = Some(LoadedGuide { salt: self.salt, ..carried? });
        }
        Ok(())
    }
}
