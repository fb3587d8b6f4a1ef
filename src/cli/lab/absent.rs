//! In the place of the laboratory's subcommands where the program is built without it: they say how to have them.

use anyhow::bail;
use clap::{Args, Subcommand};
use std::process::ExitCode;

#[derive(Subcommand)]
pub(crate) enum LabCommand {
    /// Measure, compare and chart: in programs built with the feature `lab`.
    #[command(hide = true, aliases = ["bench", "generate", "paper", "rates"])]
    Compare(Anything),
}

#[derive(Args)]
#[command(disable_help_flag = true)]
pub(crate) struct Anything {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<std::ffi::OsString>,
}

impl LabCommand {
    /// # Errors
    /// Always.
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        bail!(
            "bench, compare, generate, paper and rates are the laboratory, which this program was built without: \
             `make lab`, or `cargo build --release --features lab`"
        )
    }
}
