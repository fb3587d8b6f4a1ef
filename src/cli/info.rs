//! `phototaxis info`: what a scene consists of, as it is understood. Nothing is rendered.

mod material;
mod report;
mod text;

use super::choices::{Definitions, Machine};
use super::output::write_json;
use super::progress::{Bar, Show, Stage};
use crate::embree::Device;
use crate::format;
use anyhow::Result;
use clap::Args;
use report::{Loaded, Report};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(Args)]
pub(crate) struct InfoArguments {
    /// Scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or model (.obj, .ply).
    scene: PathBuf,
    /// Prints JSON, described in docs/info.md.
    #[arg(long)]
    json: bool,
    /// The camera of this name, of a scene file with several. [default: that of [camera], else the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Overrides a key of the scene file, for example material.Floor.alpha=0.2; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    definitions: Definitions,
    #[command(flatten)]
    machine: Machine,
}

pub(crate) fn run(arguments: &InfoArguments) -> Result<ExitCode> {
    let threads = arguments.machine.start(false)?;
    let start = Instant::now();
    let overrides: Vec<String> = arguments.set.iter().cloned().chain(arguments.definitions.overrides()).collect();
    let (file, mut warnings) = format::load_seen_by(&arguments.scene, arguments.camera.as_deref(), &overrides)?;
    let bar = Bar::of(Show::Auto, Stage::Loading);
    let (scene, more) = file.load_scene_watched(Device::new(threads)?, &|stage| bar.stage(stage.into()))?;
    bar.finish();
    warnings.extend(more);
    let loaded = Loaded { name: &arguments.scene, file: &file, scene: &scene, warnings, seconds: start.elapsed() };
    let report = Report::new(loaded);
    match arguments.json {
        true => write_json(Path::new("-"), &report)?,
        false => super::print(&text::lines(&report).join("\n"))?,
    }
    Ok(ExitCode::SUCCESS)
}
