//! `phototaxis rates`: learning rules and rates against a light field that is known in closed form.

use crate::cli::choices::Machine;
use crate::draw::png;
use crate::draw::svg::Svg;
use crate::io::atomic::write_atomically;
use crate::io::clock;
use crate::lab::compare::chart::{Labels, Point, Series, Size, plot, style};
use crate::lab::convergence::{Furnace, Learnt, WAYS};
use crate::lab::generate;
use crate::platform::Platform;
use anyhow::{Context as _, Result};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

const NOTES: &str = "Renders the scene furnace, a closed sphere that glows with 1 and reflects a share of what it receives, \
    without next-event estimation; writes rates.svg, rates.png, rates.json and the scene. The error is the root mean \
    square, over points of the sphere, of the relative error of the irradiance that the guide has learnt.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct RatesArguments {
    /// Folder to write to; it is made if it is missing.
    #[arg(long, value_name = "DIR", default_value = "rates")]
    out: PathBuf,
    /// Samples per pixel at most, of 32 × 32 pixels.
    #[arg(long, value_name = "N", default_value_t = 1023, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Share of light that the sphere reflects.
    #[arg(long, value_name = "A", default_value_t = 0.8, value_parser = albedo)]
    albedo: f32,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    machine: Machine,
}

/// What rates.json holds.
#[derive(Serialize)]
struct Rates<'a> {
    platform: Platform,
    date: String,
    curves: &'a [Curve],
}

#[derive(Serialize)]
struct Curve {
    way: &'static str,
    learnt: Vec<Learnt>,
}

pub(crate) fn run(arguments: &RatesArguments) -> Result<ExitCode> {
    arguments.machine.start(false)?;
    std::fs::create_dir_all(&arguments.out).with_context(|| arguments.out.display().to_string())?;
    let files = generate::generate("furnace", &arguments.out)?;
    let furnace = Furnace::load(&files[0], arguments.albedo, 32)?;
    crate::cli::print(&format!(
        "{:24} {:>6} {:>16} {:>10} {:>8}",
        "way", "spp", "visits per state", "of truth", "rms"
    ))?;
    let mut curves = Vec::new();
    for way in &WAYS {
        let learnt = furnace.curve(way, arguments.seed, arguments.spp);
        for Learnt { samples, visits_per_state, reported } in &learnt {
            let (name, mean, rms) = (way.name, reported.mean, reported.rms);
            crate::cli::print(&format!("{name:24} {samples:>6} {visits_per_state:>16.0} {mean:>10.4} {rms:>8.4}"))?;
        }
        curves.push(Curve { way: way.name, learnt });
    }
    write(arguments, &curves)?;
    Ok(ExitCode::SUCCESS)
}

fn write(arguments: &RatesArguments, curves: &[Curve]) -> Result<()> {
    let chart = chart(curves, arguments.albedo).context("too few samples: no state is known well enough yet")?;
    let platform = Platform::here()?;
    let stamp = platform.stamp();
    let svg = Svg::with_metadata(&chart, &stamp);
    let json = serde_json::to_string_pretty(&Rates { platform, date: clock::utc_now(), curves })? + "\n";
    let files = [("rates.svg", svg.as_bytes()), ("rates.png", &png(&chart, &stamp)?), ("rates.json", json.as_bytes())];
    for (name, bytes) in files {
        write_atomically(&arguments.out.join(name), |file| file.write_all(bytes))?;
    }
    Ok(())
}

fn chart(curves: &[Curve], albedo: f32) -> Option<String> {
    let series = |(k, curve): (usize, &Curve)| Series {
        name: curve.way.into(),
        style: style(k),
        points: curve.learnt.iter().map(|l| Point::new(l.visits_per_state, l.reported.rms, None)).collect(),
        joined: true,
        level: None,
    };
    let labels = Labels {
        title: "What each rate has learnt of a known light field",
        note: &format!("Furnace of albedo {albedo}; expected SARSA where no rule is named; 6 × 6 strata"),
        x: "Visits of a state",
        y: "Relative error of irradiance (rms)",
    };
    plot(Size::Wide, &labels, &curves.iter().enumerate().map(series).collect::<Vec<_>>(), true)
}

fn albedo(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if (0.0..1.0).contains(&value) => Ok(value),
        _ => Err("expected a number from 0 up to, but not including, 1".into()),
    }
}
