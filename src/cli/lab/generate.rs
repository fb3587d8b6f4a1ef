//! `phototaxis generate`: the project's own scenes.

use crate::lab::generate::{self, large};
use anyhow::{Result, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct GenerateArguments {
    /// Scene to write; without it, the scenes are listed.
    name: Option<String>,
    /// How many triangles a large scene (city, forest, terrain) is to have, about: 10 thousand to 30 million [default: 1
    /// million].
    #[arg(long, value_name = "N", requires = "name", value_parser = crate::cli::amounts::count)]
    triangles: Option<u64>,
    /// Writes the scenes of the stability gallery and the comparison of them, all at once.
    #[arg(long, conflicts_with = "name")]
    gallery: bool,
    /// Folder to write to; it is made if it is missing.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &GenerateArguments) -> Result<ExitCode> {
    match &arguments.name {
        None if arguments.gallery => {
            for path in generate::gallery::generate(&arguments.out)? {
                crate::cli::print(&path.display().to_string())?;
            }
        }
        None => {
            for (name, about) in generate::scenes().iter().chain(&large::SCENES) {
                crate::cli::print(&format!("{name:10} {about}"))?;
            }
        }
        Some(name) => {
            for path in write(name, arguments.triangles, &arguments.out)? {
                crate::cli::print(&path.display().to_string())?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn write(name: &str, triangles: Option<u64>, out: &Path) -> Result<Vec<PathBuf>> {
    let names = large::SCENES.map(|scene| scene.0);
    if names.contains(&name) {
        return Ok(large::generate(name, triangles.unwrap_or(large::DEFAULT_TRIANGLES), out)?);
    }
    let known = generate::scenes().iter().any(|scene| scene.0 == name);
    let only = names.join(", ");
    ensure!(triangles.is_none() || !known, "{name} is of one size: --triangles is for {only}");
    Ok(generate::generate(name, out)?)
}
