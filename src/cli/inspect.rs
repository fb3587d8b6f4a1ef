//! `phototaxis inspect`: what the guide knows of the place behind a pixel, and how large it is.

pub(super) mod pictures;

use super::choices::Choices;
use super::output::{check_writable, write_json};
use super::render::{trained, warn, watched};
use super::signals::Signals;
use crate::format;
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::guiding::{Guide, GuideStats};
use crate::inspect::{Comparison, Layers, PixelVertex, Radiance};
use crate::platform::Platform;
use crate::render::GuideIo;
use crate::render::guide_file::LoadedGuide;
use crate::scene::Scene;
use anyhow::{Context as _, Result, bail};
use clap::Args;
use pictures::Pictures;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Version of the JSON's shape; a change that breaks readers raises it.
const SCHEMA: u32 = 1;

#[derive(Args)]
pub(crate) struct InspectArguments {
    /// Scene (.toml, .json, .xml, .gltf, .glb, .pbrt) or model (.obj, .ply).
    scene: PathBuf,
    /// Pixel, counted from the upper left, from 0.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: (u32, u32),
    /// Folder for the pictures; it is made if it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Guide to look at, of `render --guide-out`. Without it, one is trained by rendering.
    #[arg(long, value_name = "FILE")]
    guide_in: Option<PathBuf>,
    /// Samples per pixel to train with. [default: the scene file's, else 64]
    #[arg(long, value_name = "N", conflicts_with = "guide_in", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Paths that are traced for each of the 64 × 64 directions of the truth.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=65536))]
    truth_samples: u32,
    #[command(flatten)]
    choices: Choices,
    /// Writes the figures as JSON; "-" is standard output, in place of the table.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Prints neither progress nor warnings.
    #[arg(short, long)]
    quiet: bool,
}

/// What `--json` writes.
#[derive(Serialize)]
struct Report {
    schema: u32,
    phototaxis: &'static str,
    platform: Platform,
    scene: String,
    scene_hash: String,
    pixel: (u32, u32),
    /// Where the pixel's centre meets a surface, and its normal on the side of the viewer.
    point: [f32; 3],
    normal: [f32; 3],
    state: State,
    /// Learnt against traced.
    radiance: Comparison,
    guide: GuideStats,
}

#[derive(Serialize)]
struct State {
    /// In hexadecimal.
    key: String,
    /// Weight of the visits; 0 for a state that was never met.
    visits: f32,
    /// Whether it is known well enough to draw from.
    usable: bool,
}

pub(crate) fn run(arguments: &InspectArguments) -> Result<ExitCode> {
    let threads = arguments.choices.machine.start(arguments.quiet)?;
    let overrides = arguments.choices.overrides(arguments.spp.map(|n| format!("render.spp={n}")));
    let camera = arguments.choices.camera.as_deref();
    let (description, warnings) = format::load_seen_by(&arguments.scene, camera, &overrides)?;
    if description.guiding.method == GuidingMethod::None {
        bail!("there is no guide to look at: guiding.method is none");
    }
    let (scene, more_warnings) = description.load_scene(threads)?;
    if !arguments.quiet {
        warn(&[warnings, more_warnings].concat());
    }
    let seen = seen(&scene, arguments.pixel)?;
    prepare(arguments)?;
    let (guide, code) = guide(arguments, &scene, &description)?;
    let (samples, seed) = (arguments.truth_samples, description.render.seed);
    let radiance = Radiance::new(&scene, &description.integrator, &guide, &seen, samples, seed);
    let pictures = Pictures { folder: &arguments.output, prefix: "", scene: &scene, seed, samples };
    pictures.radiance(&guide, &seen, &radiance)?;
    pictures.states(&Layers::new(&scene, &guide))?;
    let report = report(arguments, &scene, &guide, &seen, radiance.compare());
    arguments.json.iter().try_for_each(|path| write_json(path, &report))?;
    match &arguments.json {
        Some(path) if path.as_os_str() == "-" => {}
        _ => report.table().iter().try_for_each(|line| super::print(line))?,
    }
    Ok(code)
}

fn seen(scene: &Scene, (x, y): (u32, u32)) -> Result<PixelVertex<'_>> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    if x >= width || y >= height {
        bail!("pixel {x},{y} is not in the picture: it has {width} × {height} pixels, counted from 0");
    }
    PixelVertex::through(scene, x, y)
        .with_context(|| format!("behind pixel {x},{y} there is no surface that a guide could help"))
}

/// Refuses, before anything is trained, what could not be written.
fn prepare(arguments: &InspectArguments) -> Result<()> {
    std::fs::create_dir_all(&arguments.output).with_context(|| arguments.output.display().to_string())?;
    check_writable(&arguments.output.join("states.exr"))?;
    arguments.json.iter().filter(|path| path.as_os_str() != "-").try_for_each(|path| check_writable(path))
}

/// The guide, and the program's exit code, which tells whether its training was interrupted.
fn guide(arguments: &InspectArguments, scene: &Scene, description: &SceneFile) -> Result<(Guide, ExitCode)> {
    if let Some(LoadedGuide { guide, .. }) = trained(arguments.guide_in.as_deref(), scene, description)? {
        return Ok((guide, ExitCode::SUCCESS));
    }
    let signals = Signals::catch(arguments.quiet)?;
    let keeping = GuideIo { from: None, keep: true };
    let rendering = watched(scene, description, keeping, arguments.quiet, signals.stop());
    let guide = rendering.guide.context("there is no guide to look at")?;
    Ok((guide, signals.exit_code()))
}

fn report(
    arguments: &InspectArguments,
    scene: &Scene,
    guide: &Guide,
    seen: &PixelVertex,
    radiance: Comparison,
) -> Report {
    let key = seen.state(guide);
    Report {
        schema: SCHEMA,
        phototaxis: env!("CARGO_PKG_VERSION"),
        platform: Platform::of(scene.geometry().device()),
        scene: arguments.scene.display().to_string(),
        scene_hash: scene.content_hash_text(),
        pixel: arguments.pixel,
        point: seen.si.p.into(),
        normal: seen.normal().into(),
        state: State {
            key: key.map_or("none".into(), |key| format!("{:016x}", key.0)),
            visits: key.and_then(|key| guide.visits(key)).unwrap_or(0.0),
            usable: key.is_some_and(|key| guide.field().summary(key).is_some()),
        },
        radiance,
        guide: guide.stats(),
    }
}

impl Report {
    fn table(&self) -> Vec<String> {
        let [x, y, z] = self.point;
        let State { key, visits, usable } = &self.state;
        let usable = if *usable { "drawn from" } else { "not drawn from" };
        let number = |value: Option<f64>| value.map_or("-".to_string(), |value| format!("{value:.3}"));
        let (r, g) = (&self.radiance, &self.guide);
        let line = |name: &str, value: String| format!("{name:28} {value}");
        let mut lines = vec![
            line("point", format!("{x:.4} {y:.4} {z:.4}")),
            line("state", format!("{key}, {visits:.0} visits, {usable}")),
            line("correlation with the truth", number(r.correlation)),
            line(
                "relative error",
                format!("{} (noise of the truth: {})", number(r.relative_error), number(r.truth_noise)),
            ),
            line("irradiance, learnt", format!("{:.4e}", r.learnt_irradiance)),
            line("irradiance, traced", format!("{:.4e}", r.traced_irradiance)),
            line("states", g.states.to_string()),
            line("bytes per state", format!("{:.0} ({} to {})", g.mean_bytes, g.min_bytes, g.max_bytes)),
            line("nodes of trees", g.tree_nodes.to_string()),
            line("bytes in all", format!("{} ({:.1} MiB)", g.bytes, g.bytes as f64 / (1 << 20) as f64)),
            line("not met in last iteration", format!("{:.1} %", 100.0 * g.not_met_share)),
            line("too little known to use", format!("{:.1} %", 100.0 * g.unusable_share)),
        ];
        let decade =
            |d: &crate::guiding::HistogramBin| line(&format!("visits {} to {}", d.from, d.to), d.states.to_string());
        lines.extend(g.visits.iter().map(decade));
        lines
    }
}

fn pixel(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    parsed.ok_or_else(|| "expected X,Y, for example 320,180".into())
}
