//! `phototaxis bench`: how rays are best traced here.

use crate::bench;
use crate::scene::{Scene, file};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct BenchArguments {
    /// Scene file (.toml), interchange scene (.json) or model (.obj).
    scene: PathBuf,
    /// How often every variant takes its turn; medians are printed.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    turns: u16,
    /// Prints JSON instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &BenchArguments) -> Result<ExitCode> {
    let (description, _) = file::load(&arguments.scene, &[])?;
    let (scene, _) = Scene::load(&description, 0)?;
    let figures = bench::measure(&scene, arguments.turns as usize);
    if arguments.json {
        super::print(&serde_json::to_string_pretty(&figures)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let [set, order, width, coherent, rate, ratio] = ["rays", "order", "width", "coherent", "Mrays/s", "ratio"];
    super::print(&format!("{set:8} {order:8} {width:>5} {coherent:>8} {rate:>8} {ratio:>6}"))?;
    for f in &figures {
        let set = format!("{:?}", f.set).to_lowercase();
        let coherent = if f.coherent { "yes" } else { "no" };
        let (order, width, rate, ratio) = (f.order, f.width, f.mrays_per_second, f.ratio);
        super::print(&format!("{set:8} {order:8} {width:>5} {coherent:>8} {rate:>8.2} {ratio:>6.2}"))?;
    }
    Ok(ExitCode::SUCCESS)
}
