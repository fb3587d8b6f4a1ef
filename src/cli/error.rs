//! `phototaxis error`: how far a picture is from a reference.

use crate::film::compare::compare;
use crate::film::exr::read_rgb;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct ErrorArguments {
    /// Picture (.exr).
    image: PathBuf,
    /// Reference of the same size (.exr).
    reference: PathBuf,
}

pub fn run(arguments: &ErrorArguments) -> Result<ExitCode> {
    let errors = compare(&read_rgb(&arguments.image)?, &read_rgb(&arguments.reference)?)?;
    super::print(&serde_json::to_string_pretty(&errors)?)?;
    Ok(ExitCode::SUCCESS)
}
