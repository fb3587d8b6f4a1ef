//! `phototaxis guide`: what is done with guides in files.

use super::output::check_writable;
use super::progress::say;
use super::render::{Ready, settings, subject, trained};
use super::render_arguments::RenderArguments;
use crate::render::{guide_file, lesson};
use anyhow::{Context as _, Result};
use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis render scene.toml --guide adaptive --spp 4 --part 1/2 --learn-out 1.lesson
  phototaxis render scene.toml --guide adaptive --spp 4 --part 2/2 --learn-out 2.lesson
  phototaxis guide merge 1.lesson 2.lesson -o first.guide
  phototaxis render scene.toml --guide adaptive --spp 8 --part 1/1 --guide-in first.guide --learn-out all.lesson
  phototaxis guide merge all.lesson --guide-in first.guide -o second.guide

phototaxis farm plan writes down all of it for as many machines as there are. See docs/farm.md.";

#[derive(Subcommand)]
pub(crate) enum GuideCommand {
    /// Have a guide learn what all parts of an iteration taught (render --part --learn-out).
    Merge(MergeArguments),
}

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MergeArguments {
    /// The lessons of all parts of an iteration.
    #[arg(required = true)]
    lessons: Vec<PathBuf>,
    /// The guide that the parts began with; where they began with none, without it.
    #[arg(long, value_name = "FILE")]
    guide_in: Option<PathBuf>,
    /// Where the guide goes that has learnt.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

impl GuideCommand {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let GuideCommand::Merge(arguments) = self;
        merge(arguments)
    }
}

fn merge(arguments: &MergeArguments) -> Result<ExitCode> {
    let MergeArguments { lessons, guide_in, output, quiet } = arguments;
    check_writable(output)?;
    let files = lessons.iter().map(|path| lesson::open::<RenderArguments>(path)).collect::<crate::Result<Vec<_>>>()?;
    let mut asked = files.first().context("there are no lessons")?.header.request.of_picture_alone();
    asked.quiet = true;
    let ready = Ready::without_outputs(&asked)?;
    let guide = trained(guide_in.as_deref(), &ready.scene, &ready.description)?;
    let taught = lesson::teach(&ready.scene, &settings(&ready.description), guide, files)?;
    let subject = subject(&ready.scene, &ready.description);
    guide_file::write_with_view(output, &taught.guide, &subject, taught.paths, taught.view.as_ref())?;
    if !quiet {
        let (states, usable) = (taught.guide.states(), taught.guide.field().len());
        say(&format!("wrote {}: {states} states, of which {usable} guide", output.display()));
    }
    Ok(ExitCode::SUCCESS)
}
