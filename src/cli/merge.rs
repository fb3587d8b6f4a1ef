//! `phototaxis merge`: one picture of several renders.

use super::render::{Ready, settings};
use super::render_arguments::RenderArguments;
use super::signals::Signals;
use crate::render::checkpoint::open;
use crate::render::merge::Merged;
use crate::render::part;
use anyhow::{Context as _, Result, anyhow, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "Examples:
  phototaxis render scene.toml --seed 1 --spp 256 --checkpoint 1.checkpoint
  phototaxis render scene.toml --seed 2 --spp 256 --checkpoint 2.checkpoint
  phototaxis merge 1.checkpoint 2.checkpoint -o scene.exr -o scene.png

  phototaxis render scene.toml --guide none --spp 1k --part 1/2 --film-out 1.film
  phototaxis render scene.toml --guide none --spp 1k --part 2/2 --film-out 2.film
  phototaxis merge 1.film 2.film -o scene.exr";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MergeArguments {
    /// Checkpoints of renders of one scene by the same settings, each with another seed; or the films of all parts of one
    /// render.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Picture to write, .exr or .png; may be repeated.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
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
    let file = open::<RenderArguments>(first)?;
    let asked = asked(arguments, &file.header.request);
    let ready = Ready::new(&asked)?;
    let settings = settings(&ready.description);
    let signals = Signals::catch(arguments.quiet)?;
    let mut merged = Merged::new(file.read_of_any_seed(&ready.scene, &settings)?);
    for path in &arguments.files[1..] {
        let other = open::<RenderArguments>(path)?.read_of_any_seed(&ready.scene, &settings)?;
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
    let ready = Ready::new(&asked)?;
    let signals = Signals::catch(arguments.quiet)?;
    let rendering = part::join(&ready.scene, &settings(&ready.description), films, arguments.partial)?;
    ready.present(&rendering, &signals)
}

/// What the first render was asked for, but for what is written.
fn asked(arguments: &MergeArguments, first: &RenderArguments) -> RenderArguments {
    let mut asked = first.of_picture_alone();
    asked.output = arguments.output.clone();
    asked.json = arguments.json.clone();
    (asked.denoise, asked.quiet) = (arguments.denoise, arguments.quiet);
    asked
}
