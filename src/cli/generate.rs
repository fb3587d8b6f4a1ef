//! `phototaxis generate`: the project's own scenes.

use crate::generate;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct GenerateArguments {
    /// Scene to write; without it, the scenes are listed.
    name: Option<String>,
    /// Writes the scenes of the stability gallery and the comparison of them, all at once.
    #[arg(long, conflicts_with = "name")]
    gallery: bool,
    /// Folder to write to; it is made if it is missing.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

pub fn run(arguments: &GenerateArguments) -> Result<ExitCode> {
    match &arguments.name {
        None if arguments.gallery => {
            for path in generate::gallery::generate(&arguments.out)? {
                super::print(&path.display().to_string())?;
            }
        }
        None => {
            for (name, about) in generate::scenes() {
                super::print(&format!("{name:10} {about}"))?;
            }
        }
        Some(name) => {
            for path in generate::generate(name, &arguments.out)? {
                super::print(&path.display().to_string())?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
