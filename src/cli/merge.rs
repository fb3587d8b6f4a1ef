//! `phototaxis merge`: one picture of several renders.

use super::output::check_writable;
use super::progress::say;
use super::render::{CheckpointRequest, Ready, settings};
use super::render_arguments::RenderArguments;
use super::signals::Signals;
use crate::render::checkpoint::open;
use crate::render::merge::Merged;
use crate::render::part;
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis render scene.toml --seed 1 --spp 256 --checkpoint 1.checkpoint
  phototaxis render scene.toml --seed 2 --spp 256 --checkpoint 2.checkpoint
  phototaxis merge 1.checkpoint 2.checkpoint -o scene.exr -o scene.png

  phototaxis render scene.toml --guide none --spp 1k --part 1/2 --film-out 1.film
  phototaxis render scene.toml --guide none --spp 1k --part 2/2 --film-out 2.film
  phototaxis merge 1.film 2.film -o scene.exr
  phototaxis merge 1.film 2.film --film-out half.film";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MergeArguments {
    /// Checkpoints of renders of one scene by the same settings, each with another seed; or the films of all parts of one
    /// render.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Picture to write, .exr or .png; may be repeated.
    #[arg(short, long, value_name = "FILE", required_unless_present = "film_out")]
    output: Vec<PathBuf>,
    /// Writes one film of those of neighbouring parts, in place of a picture: merge takes it with those that are left. So films can
    /// be joined by several machines.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "partial", "denoise", "json"])]
    film_out: Option<PathBuf>,
    /// Makes a picture of the films that there are, each of which has as many samples of one pixel as of another, where others
    /// are missing.
    #[arg(long)]
    partial: bool,
    /// Removes the noise by Intel Open Image Denoise, as render does.
    #[arg(long)]
    denoise: bool,
    /// Writes the figures as JSON, of all renders together; "-" is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints errors only.
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &MergeArguments) -> Result<ExitCode> {
    let first = arguments.files.first().context("there is nothing to merge")?;
    match part::is_film(first) {
        true => films(arguments),
        false if arguments.film_out.is_some() => bail!("{}: --film-out joins films, and it is none", first.display()),
        false => checkpoints(arguments, first),
    }
}

/// One picture of renders with other seeds.
fn checkpoints(arguments: &MergeArguments, first: &Path) -> Result<ExitCode> {
    if first.extension().is_some_and(|extension| extension == "exr" || extension == "png") {
        bail!(
            "{}: a picture does not say how its iterations and their halves differ, by which renders are weighed: merge takes \
             what render --checkpoint or --film-out wrote",
            first.display()
        );
    }
    if arguments.partial {
        bail!("{}: --partial is for films", first.display());
    }
    let file = open::<CheckpointRequest>(first)?;
    ensure!(
        file.header.request.frames.is_none(),
        "{}: this is of an animation: merge joins single pictures",
        first.display()
    );
    let asked = asked(arguments, &file.header.request.arguments);
    let ready = Ready::new(&asked)?;
    let settings = settings(&ready.description);
    let signals = Signals::catch(arguments.quiet)?;
    let mut merged = Merged::new(file.read_of_any_seed(&ready.scene, &settings)?);
    for path in &arguments.files[1..] {
        let other = open::<CheckpointRequest>(path)?.read_of_any_seed(&ready.scene, &settings)?;
        merged.add(other).map_err(|why| anyhow!("{}: {why}", path.display()))?;
    }
    let rendering = merged.finish(&ready.scene);
    ready.present(&rendering, &signals)
}

/// One picture of all parts of a render.
fn films(arguments: &MergeArguments) -> Result<ExitCode> {
    let films = arguments.files.iter().map(|path| part::open::<RenderArguments>(path));
    let films = films.collect::<crate::Result<Vec<_>>>()?;
    let asked = asked(arguments, &films[0].header.request);
    if let Some(path) = &arguments.film_out {
        return one_film(&asked, films, path);
    }
    let ready = Ready::new(&asked)?;
    let signals = Signals::catch(arguments.quiet)?;
    let rendering = part::join(&ready.scene, &settings(&ready.description), films, arguments.partial)?;
    ready.present(&rendering, &signals)
}

/// One film of neighbouring parts.
fn one_film(asked: &RenderArguments, films: Vec<part::PartFile<RenderArguments>>, path: &Path) -> Result<ExitCode> {
    check_writable(path)?;
    let ready = Ready::without_outputs(asked)?;
    let (header, joined) = part::join_films(&ready.scene, &settings(&ready.description), films)?;
    joined.write(&header, Some(path), None)?;
    ready.bar.finish();
    if !asked.quiet {
        say(&format!("wrote {}", path.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// What the first render was asked for, but for what is written.
fn asked(arguments: &MergeArguments, first: &RenderArguments) -> RenderArguments {
    let mut asked = first.of_picture_alone();
    asked.output = arguments.output.clone();
    asked.json = arguments.json.clone();
    (asked.denoise, asked.quiet) = (arguments.denoise, arguments.quiet);
    asked
}
