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
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

pub fn run(arguments: &GenerateArguments) -> Result<ExitCode> {
    match &arguments.name {
        None => generate::scenes().iter().for_each(|(name, about)| println!("{name:10} {about}")),
        Some(name) => {
            for path in generate::generate(name, &arguments.out)? {
                println!("{}", path.display());
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
