//! The program as its users meet it: arguments, exit codes, what is printed where, and the files that are left.

mod bench;
mod commands;
mod compare;
mod convert;
mod extremes;
mod farm;
mod faults;
mod figures;
mod frames;
mod gallery;
mod guides;
mod info;
mod installing;
mod paper;
mod pictures;
mod previews;
mod processors;
mod readme;
mod render;
mod resuming;
mod sharing;
mod stopping;
mod transforms;
mod views;
mod watching;

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::process::Output;

/// Arguments that keep a render of one of the project's scenes tiny.
const TINY: [&str; 4] = ["--set", "film.width=16", "--set", "film.height=12"];

/// The program under test: another build of it where the environment names one, for example the portable program.
fn program() -> PathBuf {
    std::env::var_os("PHOTOTAXIS_PROGRAM")
        .map_or_else(|| assert_cmd::cargo::cargo_bin!("phototaxis").to_path_buf(), PathBuf::from)
}

/// The program, in a folder of its own.
fn phototaxis(folder: &Path) -> Command {
    let mut command = Command::new(program());
    command.current_dir(folder);
    command
}

/// Path of one of the project's own scenes.
fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("the system's temporary folder takes files")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("all that is printed is UTF-8")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("all that is printed is UTF-8")
}

/// Names of the files in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
