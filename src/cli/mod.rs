//! The command line: one file per subcommand. All printing and all exit codes live here.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong usage, 128 + n stopped by signal n (with what there was written).

mod bench;
mod choices;
mod compare;
mod error;
mod generate;
mod inspect;
mod output;
mod paper;
mod progress;
mod rates;
mod render;
mod report;
mod signals;

use anyhow::Context as _;
use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

const EXIT_CODES: &str = "Exit codes: 0 done, 1 failed, 2 wrong usage; 130, 143 and 129 stopped by SIGINT (Ctrl-C), SIGTERM \
    and SIGHUP, with what there was written. A second signal hurries that, a third leaves it out.\nThe scene file is described in docs/scene-file.md.";

/// A path tracer on Embree that learns where the light is while it renders.
#[derive(Parser)]
#[command(name = "phototaxis", version, about, after_help = EXIT_CODES, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene file (.toml, .json) or a bare model (.obj).
    Render(render::RenderArguments),
    /// Print how far a picture is from a reference, as JSON: MSE, relMSE (all and trimmed), MAPE, SMAPE.
    Error(error::ErrorArguments),
    /// Measure this program here: its rays against Embree alone, what its time goes into, loading, a rival.
    Bench(bench::BenchArguments),
    /// Show what the guide knows of the place behind a pixel, and how large it is.
    Inspect(inspect::InspectArguments),
    /// Compare methods: error against time, with intervals, over several runs.
    Compare(Box<compare::CompareArguments>),
    /// Render the pictures of Tan's paper on the project's own scenes, with a table of what they cost.
    Paper(paper::PaperArguments),
    /// Chart how near each learning rule and rate comes to a light field that is known, by visits.
    Rates(rates::RatesArguments),
    /// Write the project's own scenes.
    Generate(generate::GenerateArguments),
}

/// Runs the command that `argv` names.
pub fn run() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Error(arguments) => error::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Rates(arguments) => rates::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
    };
    result.unwrap_or_else(|error| {
        progress::say(&format!("error: {error:#}"));
        ExitCode::from(1)
    })
}

/// Writes a line to standard output. Where that is closed (a pipe into `head`), it is an error and no panic.
fn print(line: &str) -> anyhow::Result<()> {
    writeln!(std::io::stdout(), "{line}").context("standard output")
}

/// Sets the number of worker threads, 0 for all of the machine's.
fn set_threads(threads: usize) -> anyhow::Result<()> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?)
}
