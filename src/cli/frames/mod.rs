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
use super::render::{Ready, Start, onlookers, trained, watched_by};
use super::render_arguments::RenderArguments;
use super::signals::Signals;
use crate::guiding::settings::GuidingMethod;
use crate::image::Exposure;
use crate::render::guide_file::LoadedGuide;
use crate::render::{GuideIo, Rendering};
use crate::scene::description::CameraDescription;
use anyhow::{Context as _, Result, bail, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Which frames, and what becomes of those that are there.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct FrameArguments {
    /// Renders frames of an animation: A..B (both too), A..B:STEP or one. The camera moves as its keys say ([[camera.key]]), or
    /// by --turntable. Names of files have #### or %04d for the number. [default with --turntable: 1..N]
    #[arg(long, value_name = "A..B", conflicts_with_all = ["part", "checkpoint"])]
    pub(super) frames: Option<FrameRange>,
    /// Turns the camera around its target, once in N frames; frame 1 is the view itself.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000),
          conflicts_with_all = ["part", "checkpoint"])]
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

/// The files of a frame. The guide is written with the last.
pub(super) fn outputs(arguments: &RenderArguments, number: u32, is_last: bool) -> Result<Outputs> {
    let range = arguments.animation.range()?;
    let alone = range.is_some_and(|range| range.numbers().len() == 1);
    let named = |path: &PathBuf| match pattern::numbered(path, number) {
        Some(path) => Ok(path),
        None if alone || path.as_os_str() == "-" => Ok(path.clone()),
        None => bail!("{}: several frames need a name with #### or %04d for their numbers", path.display()),
    };
    let pictures = match &arguments.output[..] {
        [] => names::of_frame(&arguments.scene, number)?.to_vec(),
        given => given.iter().map(named).collect::<Result<_>>()?,
    };
    let json = arguments.json.as_ref().map(named).transpose()?;
    let guide = arguments.guide_out.as_ref().filter(|_| is_last);
    Outputs::new(&pictures, json.as_ref(), guide, &arguments.scene, true)
}

/// Renders them one after the other, until the last or a signal.
pub(super) fn run(arguments: &RenderArguments, range: FrameRange) -> Result<ExitCode> {
    let numbers = to_render(arguments, range)?;
    if numbers.is_empty() {
        if !arguments.quiet {
            say("all frames are there already");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let mut ready = Ready::new(arguments)?;
    let frames = frames(arguments, &ready, &numbers)?;
    let mut guide = Carried::new(arguments, &ready)?;
    let signals = Signals::catch(arguments.quiet)?;
    let (seed, mut code) = (ready.description.render.seed, ExitCode::SUCCESS);
    if arguments.animation.skip_existing {
        share_exposure(arguments, &mut ready, range.first())?;
    }
    for (k, frame) in (1..).zip(&frames) {
        let is_last = k == frames.len();
        ready.description.render.seed = seed.wrapping_add(frame.number.into());
        ready.scene.look_through(&frame.camera, &ready.description.scene.film)?;
        ready.bar.begin_frame([frame.number as usize, k, frames.len()]);
        let mut onlookers = onlookers(&ready)?;
        let start = Start::New(Box::new(guide.io(is_last)));
        let rendering = watched_by(&ready.bar, &ready.scene, &ready.description, start, signals.stop(), &mut onlookers);
        onlookers.finish();
        ready.outputs = outputs(arguments, frame.number, is_last || signals.stop().is_asked())?;
        if !arguments.quiet {
            say(&format!("frame {} ({k} of {}):", frame.number, frames.len()));
        }
        code = worse(code, ready.present(&rendering, &signals)?);
        share_exposure(arguments, &mut ready, frame.number)?;
        if signals.stop().is_asked() {
            break;
        }
        guide.take(rendering, &ready)?;
    }
    ready.end(&signals);
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
        let is_auto = ready.description.guiding.method == GuidingMethod::Auto;
        let salt = guide.as_ref().map_or(0, |guide| guide.salt);
        Ok(Carried { guide, salt, is_written: arguments.guide_out.is_some(), is_auto })
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
