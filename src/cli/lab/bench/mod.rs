//! `phototaxis bench`: measurements of this program on this machine, one file per subcommand.

mod embree;
mod load;
mod mitsuba;
mod output;
mod rays;
mod render;

use crate::cli::choices::Machine;
use crate::cli::render::warn;
use crate::format;
use crate::format::SceneFile;
use crate::platform::busy;
use crate::scene::Scene;
use anyhow::Result;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub(crate) struct BenchArguments {
    #[command(subcommand)]
    command: Bench,
}

#[derive(Subcommand)]
enum Bench {
    /// Replay the rays of an unguided render through Embree alone, and compare with the whole renderer.
    Rays(rays::RaysArguments),
    /// Time whole renders by several methods, and what their time goes into.
    Render(render::RenderArguments),
    /// Time the loading of a model: reading, building, first pixel, memory; and tobj on the same file.
    Load(load::LoadArguments),
    /// Compare with the path tracer of Embree's own tutorials (Debian's package embree-tools) on the same work.
    Embree(embree::EmbreeArguments),
    /// Compare with the path tracer of Mitsuba 3 (Python's package mitsuba) on the same scene.
    Mitsuba(mitsuba::MitsubaArguments),
}

pub(crate) fn run(arguments: &BenchArguments) -> Result<ExitCode> {
    busy().iter().for_each(|why| eprintln!("warning: {why}"));
    match &arguments.command {
        Bench::Rays(arguments) => rays::run(arguments)?,
        Bench::Render(arguments) => render::run(arguments)?,
        Bench::Load(arguments) => load::run(arguments)?,
        Bench::Embree(arguments) => embree::run(arguments)?,
        Bench::Mitsuba(arguments) => mitsuba::run(arguments)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Options of those that take a scene.
#[derive(Args)]
struct Subject {
    /// Scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or model (.obj, .ply).
    scene: PathBuf,
    #[command(flatten)]
    machine: Machine,
    /// Overrides a key of the scene file, for example film.width=512; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Subject {
    /// The scene, after `first` and what `--set` says; prints its warnings.
    fn load(&self, first: &[String]) -> Result<(SceneFile, Scene)> {
        let threads = self.machine.start(false)?;
        let (description, warnings) = format::load(&self.scene, &[first, &self.set].concat())?;
        let (scene, more) = description.load_scene(threads)?;
        warn(&[warnings, more].concat());
        Ok((description, scene))
    }
}

/// A scene's name in tables and charts: its file's, without folders and extension.
fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
