//! `phototaxis man` and `phototaxis completions`: what a package installs beside the program, made from the command line's own
//! description, so that neither can differ from it.

use crate::io::atomic::write_atomically;
use anyhow::{Context as _, Result, bail};
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct ManArguments {
    /// Command that the page is about, for example: bench rays. [default: all of phototaxis]
    command: Vec<String>,
    /// Writes the pages of all commands into this folder, which is made if it is missing.
    #[arg(short, long, value_name = "DIR", conflicts_with = "command")]
    output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct CompletionsArguments {
    /// Shell whose completions are printed.
    shell: Shell,
}

/// Prints one manual page, or writes all of them. `program` describes the whole command line.
pub(crate) fn run(arguments: &ManArguments, program: Command) -> Result<ExitCode> {
    let mut program = program.disable_help_subcommand(true);
    // gives each command its full name and the options that all have
    program.build();
    match &arguments.output {
        None => std::io::stdout().write_all(&page(find(&program, &arguments.command)?)?).context("standard output")?,
        Some(folder) => {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            for command in all(&program) {
                let bytes = page(command)?;
                let path = folder.join(Man::new(command.clone()).get_filename());
                write_atomically(&path, |file| file.write_all(&bytes))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints what a shell reads to complete this command line.
pub(crate) fn completions(arguments: &CompletionsArguments, mut program: Command) -> Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "phototaxis", &mut script);
    std::io::stdout().write_all(&script).context("standard output")?;
    Ok(ExitCode::SUCCESS)
}

/// The command that is named by its own name and those of the commands above it.
fn find<'a>(program: &'a Command, names: &[String]) -> Result<&'a Command> {
    names.iter().try_fold(program, |above, name| match above.find_subcommand(name) {
        Some(command) => Ok(command),
        None => bail!("there is no command `{name}` in `{}`", above.get_display_name().unwrap_or("phototaxis")),
    })
}

/// A command and all below it.
fn all(command: &Command) -> Vec<&Command> {
    std::iter::once(command).chain(command.get_subcommands().flat_map(all)).collect()
}

/// A page of section 1 in roff.
fn page(command: &Command) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    Man::new(command.clone()).render(&mut bytes)?;
    Ok(bytes)
}
