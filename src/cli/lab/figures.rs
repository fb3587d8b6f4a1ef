//! `phototaxis figures`: every picture, chart and table of the documentation anew, from one build.
//!
//! Each step is a command line that a reader may type too, carried out by this program as a process of its own; what it writes is kept
//! in a folder for work, and what the documentation shows is copied or written from there. Comparisons go on where they stopped.

mod blocks;
mod crops;
mod page;
mod scenes;
mod steps;
mod validation;

use crate::cli::progress::say;
use crate::lab::compare::forecast::said;
use crate::platform::{Platform, busy};
use anyhow::{Context as _, Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;
use steps::STEPS;

const NOTES: &str = "Steps:
  pictures   the door, and crops of it at equal time
  results    all scenes by all methods, at each budget: results.md, its charts
  sdtree     the SD-tree with other thresholds on the door
  gallery    the verdicts of stability.md, and its pictures
  paper      the pictures and the table of paper.md
  rates      its chart of learning rates
  inspect    what a guide has learnt, as guide.md shows it
  bench      the tables of benchmarks.md
  validation what fitted settings are worth on scenes that had no say: validation.md
Run it from the project's folder. Pictures of Blender are made with it, and not here.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct FiguresArguments {
    /// Folder that takes pictures, charts and pages; pages with marked parts that are there already are kept but for these parts.
    #[arg(short, long, value_name = "DIR", default_value = "docs")]
    output: PathBuf,
    /// Folder for renders, references and comparisons; what is there is gone on with.
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    work: PathBuf,
    /// Carries out these steps alone.
    #[arg(long, value_name = "STEPS", value_delimiter = ',')]
    only: Vec<String>,
    /// Budgets of a second or less all over: to see that it works, not for figures.
    #[arg(long)]
    quick: bool,
    /// Seconds of a run; several are several budgets. [default: 0.25,2,8; quick: 0.05]
    #[arg(long, value_name = "SECONDS", value_delimiter = ',')]
    time: Vec<f64>,
    /// Runs of a cell of the results. [default: 5; quick: 2]
    #[arg(long, value_name = "N")]
    runs: Option<u32>,
    /// Runs of a cell of the gallery. [default: 20; quick: 2]
    #[arg(long, value_name = "N")]
    gallery_runs: Option<u32>,
    /// Seconds that the reference of a scene may take. [default: 600; quick: 0.2]
    #[arg(long, value_name = "SECONDS")]
    reference_time: Option<f64>,
    /// Pixels of a scene's width in the results. [default: 256; quick: 32]
    #[arg(long, value_name = "N")]
    width: Option<u32>,
    /// Seconds of each of the crops at equal time. [default: 10; quick: 0.02]
    #[arg(long, value_name = "SECONDS")]
    crop_time: Option<f64>,
    /// Seconds of the long render beside them. [default: 600; quick: 1]
    #[arg(long, value_name = "SECONDS")]
    long_time: Option<f64>,
    /// Samples per pixel of the pictures of the paper; their references have four times as many. [default: 1024; quick: 2]
    #[arg(long, value_name = "N")]
    paper_spp: Option<u32>,
    /// Runs of each benchmark, in turns. [default: 7; quick: 1]
    #[arg(long, value_name = "N")]
    turns: Option<u32>,
    /// Methods of the results. [default: none, auto, adaptive, grid, voronoi, sdtree, paper, paper-full]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Vec<String>,
    /// Scenes of the results, by name; all without it.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Folder of real scenes that are not part of this repository; without them they are left out, and the page says so.
    #[arg(long, value_name = "DIR", env = "PHOTOTAXIS_SCENES", default_value = "../shared/scenes")]
    real: PathBuf,
}

/// How much is rendered.
struct Budgets {
    methods: Vec<String>,
    time: Vec<f64>,
    runs: u32,
    gallery_runs: u32,
    gallery_time: f64,
    reference_time: f64,
    width: u32,
    crop_time: f64,
    long_time: f64,
    /// Of door.png, of the pictures of the paper, of the charts of rates, of a guide that is looked into.
    spp: u32,
    paper_spp: u32,
    paper_scale: f64,
    rates_spp: u32,
    truth_samples: u32,
    turns: u32,
    /// Triangles of the city.
    triangles: u32,
}

impl Budgets {
    fn of(a: &FiguresArguments) -> Budgets {
        let defaults = if a.quick { quick() } else { full() };
        Budgets {
            methods: if a.methods.is_empty() { defaults.methods } else { a.methods.clone() },
            time: if a.time.is_empty() { defaults.time } else { a.time.clone() },
            runs: a.runs.unwrap_or(defaults.runs),
            gallery_runs: a.gallery_runs.unwrap_or(defaults.gallery_runs),
            reference_time: a.reference_time.unwrap_or(defaults.reference_time),
            width: a.width.unwrap_or(defaults.width),
            crop_time: a.crop_time.unwrap_or(defaults.crop_time),
            long_time: a.long_time.unwrap_or(defaults.long_time),
            paper_spp: a.paper_spp.unwrap_or(defaults.paper_spp),
            turns: a.turns.unwrap_or(defaults.turns),
            ..defaults
        }
    }
}

fn full() -> Budgets {
    Budgets {
        methods: scenes::METHODS.map(String::from).to_vec(),
        time: vec![0.25, 2.0, 8.0],
        runs: 5,
        gallery_runs: 20,
        gallery_time: 0.25,
        reference_time: 600.0,
        width: 256,
        crop_time: 10.0,
        long_time: 600.0,
        spp: 128,
        paper_spp: 1024,
        paper_scale: 0.5,
        rates_spp: 1023,
        truth_samples: 512,
        turns: 7,
        triangles: 1_000_000,
    }
}

fn quick() -> Budgets {
    Budgets {
        methods: scenes::METHODS.map(String::from).to_vec(),
        time: vec![0.05],
        runs: 2,
        gallery_runs: 2,
        gallery_time: 0.02,
        reference_time: 0.2,
        width: 32,
        crop_time: 0.02,
        long_time: 1.0,
        spp: 1,
        paper_spp: 2,
        paper_scale: 0.125,
        rates_spp: 63,
        truth_samples: 2,
        turns: 1,
        triangles: 10_000,
    }
}

/// What a step works with.
struct Desk<'a> {
    arguments: &'a FiguresArguments,
    budgets: Budgets,
    /// What everything is made with, in one line.
    stamp: String,
    /// The commands that ran, for the pages.
    commands: Vec<String>,
}

pub(crate) fn run(arguments: &FiguresArguments) -> Result<ExitCode> {
    let names: Vec<&str> = STEPS.iter().map(|(name, _)| *name).collect();
    if let Some(unknown) = arguments.only.iter().find(|name| !names.contains(&name.as_str())) {
        bail!("there is no step `{unknown}`: there are {}", names.join(", "));
    }
    if !Path::new("scenes/door.toml").exists() {
        bail!("scenes/door.toml is missing: this command is run from the project's folder");
    }
    busy().iter().for_each(|why| say(&format!("warning: {why}")));
    for folder in [&arguments.output, &arguments.work] {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let (stamp, budgets) = (Platform::here()?.stamp(), Budgets::of(arguments));
    let mut desk = Desk { arguments, budgets, stamp, commands: Vec::new() };
    let begun = Instant::now();
    for (name, step) in STEPS {
        if arguments.only.is_empty() || arguments.only.iter().any(|only| only == name) {
            let here = Instant::now();
            say(&format!("== {name}"));
            desk.commands.clear();
            step(&mut desk).with_context(|| format!("step {name}"))?;
            say(&format!("== {name}: done in {}", said(here.elapsed().as_secs_f64())));
        }
    }
    say(&format!("all done in {}", said(begun.elapsed().as_secs_f64())));
    Ok(ExitCode::SUCCESS)
}

impl Desk<'_> {
    /// Runs this program with arguments; what it prints. Its messages go where this one's go.
    fn run(&mut self, arguments: &[String]) -> Result<String> {
        let shown = arguments.iter().map(|a| quoted(a)).collect::<Vec<_>>().join(" ");
        say(&format!("phototaxis {shown}"));
        // pages show the folders that are usual, and none of this machine
        let usual =
            |text: String, folder: &Path, usual: &str| text.replace(&quoted(&folder.display().to_string()), usual);
        let told = usual(shown.clone(), &self.arguments.work, "out/figures");
        self.commands.push(format!("phototaxis {}", usual(told, &self.arguments.output, "docs")));
        let program = std::env::current_exe().context("this program's file")?;
        let output = Command::new(program).args(arguments).stderr(Stdio::inherit()).output()?;
        if !output.status.success() {
            bail!("`phototaxis {shown}` failed: {}", output.status);
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn work(&self, name: &str) -> PathBuf {
        self.arguments.work.join(name)
    }

    fn output(&self, name: &str) -> PathBuf {
        self.arguments.output.join(name)
    }

    /// Copies a file into the documentation; a PNG that does not say what it was made with says it there.
    fn publish(&self, from: &Path, name: &str) -> Result<()> {
        let mut bytes = std::fs::read(from).with_context(|| from.display().to_string())?;
        if name.ends_with(".png") && crate::image::png::text(from, "Comment").is_none() {
            bytes = commented(&bytes, &self.stamp);
        }
        Ok(crate::io::atomic::write_atomically(&self.output(name), |file| file.write_all(&bytes))?)
    }
}

/// Bytes of a PNG's signature and its first chunk, the header.
const PNG_HEADER: usize = 33;

/// A PNG with one more chunk of text, after its header (PNG, third edition, 11.3.3.4).
fn commented(png: &[u8], text: &str) -> Vec<u8> {
    let (before, end) = png.split_at(png.len().min(PNG_HEADER));
    // keyword, no compression, no language, no translated keyword
    let chunk = [b"iTXtComment\0\0\0\0\0", text.as_bytes()].concat();
    let length = (chunk.len() - 4) as u32;
    let sum = crc32fast::hash(&chunk);
    [before, &length.to_be_bytes(), &chunk, &sum.to_be_bytes(), end].concat()
}

/// An argument as it may be typed.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_=./,:+".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, ViewTransform, png};
    use crate::math::Rgb;

    #[test]
    fn a_png_keeps_its_picture_and_says_more() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image = Image { width: 3, height: 2, data: vec![Rgb::splat(0.5); 6] };
        png::write(&path, &image, &ViewTransform::default(), &[("Scene", "s")]).unwrap();
        let before = image::open(&path).unwrap().into_rgb8();
        let bytes = commented(&std::fs::read(&path).unwrap(), "made – here");
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(image::open(&path).unwrap().into_rgb8(), before);
        assert_eq!(png::text(&path, "Comment").as_deref(), Some("made – here"));
        assert_eq!(png::text(&path, "Scene").as_deref(), Some("s"));
    }
}
