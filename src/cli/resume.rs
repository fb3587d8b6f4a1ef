//! `phototaxis resume`: goes on with a render from its checkpoint.

use super::amounts;
use super::choices::Machine;
use super::frames;
use super::progress::Show;
use super::render::{CheckpointRequest, Resumption, render};
use super::render_arguments::{DisplayArguments, RenderArguments};
use crate::render::checkpoint::open;
use anyhow::{Result, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis resume scene.checkpoint
  phototaxis resume scene.checkpoint --spp 4096 -o better.exr
  phototaxis resume scene.checkpoint --time 2h --preview now.png

All other options of the render hold that it was begun with. See docs/long-renders.md.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ResumeArguments {
    /// What `render --checkpoint` wrote; it is rewritten on the way.
    file: PathBuf,
    /// Samples per pixel of the whole render. [default: its old budget]
    #[arg(long, value_name = "N|1k", value_parser = amounts::count_u32)]
    spp: Option<u32>,
    /// Time from now on. [default: what is left of its old budget]
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds)]
    time: Option<f64>,
    /// Relative error of the picture at which it ends. [default: its old budget]
    #[arg(long, value_name = "ERROR", value_parser = amounts::error)]
    noise: Option<f64>,
    /// Picture to write in place of those that the render was to write; may be repeated.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Rewrites this picture again and again while it renders. [default: as it was begun]
    #[arg(long, value_name = "FILE")]
    preview: Option<PathBuf>,
    #[command(flatten)]
    displays: DisplayArguments,
    /// Time between two previews and between two checkpoints. [default: as it was begun]
    #[arg(long, value_name = "SECONDS|1m30s", value_parser = amounts::seconds)]
    every: Option<f64>,
    #[command(flatten)]
    machine: Machine,
    /// How progress is shown on standard error.
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    progress: Show,
    /// Writes the figures as JSON; "-" is standard output. [default: as it was begun]
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &ResumeArguments) -> Result<ExitCode> {
    let file = open::<CheckpointRequest>(&arguments.file)?;
    let asked = asked(arguments, &file.header.request);
    let ResumeArguments { spp, time: seconds, noise, .. } = *arguments;
    if let Some(frames) = file.header.request.frames.clone() {
        let new_budget = spp.is_some() || seconds.is_some() || noise.is_some();
        ensure!(!new_budget, "{}: an animation goes on with the budget that it had", arguments.file.display());
        return frames::resume(&asked, frames, file);
    }
    render(&asked, Some(Resumption { file, spp, seconds, noise }))
}

/// What the render was asked for, and is now.
fn asked(arguments: &ResumeArguments, before: &CheckpointRequest) -> RenderArguments {
    let ResumeArguments { file, output, preview, displays, every, machine, progress, json, quiet, .. } = arguments;
    let mut asked = before.arguments.clone();
    asked.animation = before.frames.as_ref().map_or_else(Default::default, |left| left.asked.clone());
    if !output.is_empty() {
        asked.output = output.clone();
    }
    asked.preview = preview.clone().or(asked.preview);
    asked.displays = displays.clone();
    asked.every = every.or(asked.every);
    asked.json = json.clone().or(asked.json);
    asked.checkpoint = Some(Path::to_path_buf(file));
    asked.choices.machine = machine.or_isa_of(&asked.choices.machine);
    (asked.progress, asked.quiet) = (*progress, *quiet);
    asked
}
