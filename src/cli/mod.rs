//! The command line: one file per subcommand. All printing and all exit codes live here.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong usage, 3 pixels that are not finite (with the picture written), 128 + n stopped by
//! signal n (with what there was written).

mod address;
mod amounts;
mod beside;
mod checkpointer;
mod choices;
mod convert;
mod error;
mod farm;
mod frames;
mod guide;
mod hints;
mod image;
mod info;
mod inspect;
mod keys;
#[cfg(feature = "lab")]
mod lab;
#[cfg(not(feature = "lab"))]
#[path = "lab/absent.rs"]
mod lab;
mod layers;
mod manual;
mod merge;
mod names;
mod onlookers;
mod output;
mod pace;
mod page;
mod preview;
mod progress;
mod render;
mod render_arguments;
mod report;
mod resume;
mod signals;
mod tev;

use crate::io::contain;
use crate::platform::Platform;
use anyhow::Context as _;
use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

const EXIT_CODES: &str = "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 pixels of a picture are infinite or undefined (it is \
    written all the same); 130, 143 and 129 stopped by SIGINT (Ctrl-C), SIGTERM and SIGHUP, with what there was written. A \
    second signal hurries that, a third leaves it out.\nThe scene file is described in docs/scene-file.md.";

/// Exit code where pixels of a picture are not finite.
const NOT_FINITE: u8 = 3;

/// A path tracer on Embree that learns where the light is while it renders.
#[derive(Parser)]
#[command(name = "phototaxis", version, about, after_help = EXIT_CODES, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or a bare model (.obj, .ply).
    Render(Box<render_arguments::RenderArguments>),
    /// Go on with a render from its checkpoint, to the end of its budget or beyond.
    Resume(resume::ResumeArguments),
    /// Make one picture of several renders of a scene that have other seeds.
    Merge(merge::MergeArguments),
    /// Make one picture by many machines.
    #[command(subcommand)]
    Farm(farm::FarmCommand),
    /// Have a guide learn what machines that share a render have found.
    #[command(subcommand)]
    Guide(guide::GuideCommand),
    /// Print what a scene consists of, as it is understood: triangles, materials, textures, lights, cameras.
    Info(info::InfoArguments),
    /// Write a scene of any form as a scene file (.toml) or for Mitsuba (.xml), with its meshes beside it.
    Convert(convert::ConvertArguments),
    /// Make another picture of a rendered EXR: other exposure, tone curve, part, size or layer.
    Image(image::ImageArguments),
    /// Print how far a picture is from a reference, as JSON: MSE, relMSE (all and trimmed), MAPE, SMAPE.
    Error(error::ErrorArguments),
    /// Show what the guide knows of the place behind a pixel, and how large it is.
    Inspect(inspect::InspectArguments),
    /// List the keys of a scene file: values, default, range, unit and meaning.
    Keys(keys::KeysArguments),
    /// Print the manual page of a command, or write those of all commands.
    Man(manual::ManArguments),
    /// Print what a shell reads to complete commands and options.
    Completions(manual::CompletionsArguments),
    #[command(flatten)]
    Lab(lab::LabCommand),
}

/// Runs the command that `argv` names.
pub fn run() -> ExitCode {
    contain::silence();
    let result = match Arguments::try_parse().unwrap_or_else(|error| leave(error)).command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Resume(arguments) => resume::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Farm(command) => command.run(),
        Command::Guide(command) => command.run(),
        Command::Info(arguments) => info::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Image(arguments) => image::run(&arguments),
        Command::Error(arguments) => error::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Keys(arguments) => keys::run(&arguments),
        Command::Man(arguments) => manual::run(&arguments, Arguments::command()),
        Command::Completions(arguments) => manual::completions(&arguments, Arguments::command()),
        Command::Lab(command) => command.run(),
    };
    result.unwrap_or_else(|error| {
        progress::say(&format!("error: {error:#}"));
        ExitCode::from(1)
    })
}

/// Where there is nothing to run: help, the version, or wrong usage.
fn leave(mut error: clap::Error) -> ! {
    hints::add(&mut error);
    if error.kind() == ErrorKind::DisplayVersion {
        let printed = version();
        printed.iter().for_each(|lines| _ = print(lines));
        if let Err(error) = &printed {
            eprintln!("error: {error:#}");
        }
        std::process::exit(printed.is_err().into())
    }
    error.exit()
}

/// The program and what it runs on.
fn version() -> crate::Result<String> {
    let platform = Platform::here()?;
    let advice = platform.advice().map_or(String::new(), |advice| format!("\n{advice}"));
    Ok(format!("phototaxis {}{advice}", platform.summary()))
}

/// Writes a line to standard output. Where that is closed (a pipe into `head`), it is an error and no panic.
fn print(line: &str) -> anyhow::Result<()> {
    writeln!(std::io::stdout(), "{line}").context("standard output")
}
