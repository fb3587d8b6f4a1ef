//! The table of figures: one row a preset.

use crate::image::Image;
use crate::image::metrics::{Errors, compare};
use crate::inspect::Comparison;
use crate::integrator::Counters;
use crate::io::atomic::write_atomically;
use crate::lab::paper::{Preset, View};
use crate::platform::Platform;
use crate::render::{IterationReport, Rendering};
use anyhow::Result;
use serde::Serialize;
use std::path::Path;

/// What paper.json holds.
#[derive(Serialize)]
struct File<'a> {
    platform: Platform,
    presets: &'a [Row],
}

/// What a preset cost and how far it is from the reference.
#[derive(Serialize)]
pub(crate) struct Row {
    preset: &'static str,
    compared_with: &'static str,
    about: &'static str,
    spp: u32,
    spp_kept: u32,
    wall_seconds: f64,
    /// Of it, in which the guide learnt; on average over all threads.
    learn_wall_seconds: f64,
    /// Rays of a path, those to lights included.
    rays_per_path: f64,
    /// Mean segments of a path and share of paths that found no light, iteration by iteration.
    path_lengths: Vec<f64>,
    zero_contribution_shares: Vec<f64>,
    /// For a sample per pixel, iteration by iteration.
    wall_seconds_per_spp: Vec<f64>,
    guide_states: usize,
    guide_bytes: usize,
    #[serde(flatten)]
    errors: Errors,
    parts: [&'static str; 2],
    relmse_trimmed_of_parts: [f64; 2],
    smape_of_parts: [f64; 2],
    /// Learnt against traced, where Q is shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    q: Option<Comparison>,
}

impl Row {
    pub(crate) fn new(preset: &Preset, rendering: &Rendering, reference: &Image, q: Option<Comparison>) -> Result<Row> {
        let e = &rendering.estimate;
        let image = Image { width: e.width as usize, height: e.height as usize, data: e.mean.clone() };
        let total = rendering.total();
        let each = |f: fn(&IterationReport) -> f64| rendering.iterations.iter().map(f).collect::<Vec<f64>>();
        let guide = rendering.guide.as_ref();
        let part = |first| compare(&part(preset.view, &image, first), &part(preset.view, reference, first));
        let parts = [part(true)?, part(false)?];
        Ok(Row {
            preset: preset.name,
            compared_with: preset.compared_with(),
            about: preset.about,
            spp: rendering.samples,
            spp_kept: e.samples,
            wall_seconds: rendering.wall_seconds,
            learn_wall_seconds: rendering.all_iterations().map(|i| i.learn_wall_seconds).sum(),
            rays_per_path: per_path(&total, total.rays + total.shadow_rays),
            path_lengths: each(|i| per_path(&i.counters, i.counters.rays)),
            zero_contribution_shares: each(|i| per_path(&i.counters, i.counters.zero_contribution)),
            wall_seconds_per_spp: each(|i| i.wall_seconds / i.samples.max(1) as f64),
            guide_states: guide.map_or(0, |g| g.states()),
            guide_bytes: guide.map_or(0, |g| g.bytes()),
            errors: compare(&image, reference)?,
            parts: preset.view.parts,
            relmse_trimmed_of_parts: parts.map(|errors| errors.relmse_trimmed),
            smape_of_parts: parts.map(|errors| errors.smape),
            q,
        })
    }

    fn cells(&self, rows: &[Row]) -> [String; 12] {
        let first = rows.iter().find(|row| row.preset == self.compared_with);
        let ratio = first.map_or("–".into(), |first| format!("{:.2}", self.wall_seconds / first.wall_seconds));
        let ends = |values: &[f64], digits: usize| match values {
            [one] => format!("{one:.digits$}"),
            [from, .., to] => format!("{from:.digits$} → {to:.digits$}"),
            [] => String::new(),
        };
        let [first, second] = [0, 1].map(|i| format!("{} {:.3}", self.parts[i], self.smape_of_parts[i]));
        [
            self.preset.into(),
            self.about.into(),
            format!("{} ({})", self.spp, self.spp_kept),
            format!("{:.1} ({:.1})", self.wall_seconds, self.learn_wall_seconds),
            ratio,
            format!("{:.1}", self.rays_per_path),
            ends(&self.path_lengths, 1),
            ends(&self.zero_contribution_shares, 2),
            format!("{:.1}", self.guide_bytes as f64 / (1 << 20) as f64),
            format!("{:.3} ({:.3})", self.errors.relmse, self.errors.relmse_trimmed),
            format!("{:.3}", self.errors.smape),
            format!("{first}, {second}"),
        ]
    }
}

fn per_path(counters: &Counters, events: u64) -> f64 {
    events as f64 / counters.paths.max(1) as f64
}

/// The pixels of one part of a picture, in a row.
fn part(view: &View, image: &Image, first: bool) -> Image {
    let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let inside =
        |i: usize| (view.in_first)(at(i % image.width, image.width), at(i / image.width, image.height)) == first;
    let data: Vec<_> = (0..image.data.len()).filter(|&i| inside(i)).map(|i| image.data[i]).collect();
    Image { width: data.len(), height: 1, data }
}

const HEADINGS: [&str; 12] = [
    "preset",
    "what",
    "spp (kept)",
    "wall seconds (learning)",
    "ratio",
    "rays per path",
    "path length",
    "without light",
    "guide, MiB",
    "relMSE (trimmed)",
    "SMAPE",
    "SMAPE, by part",
];

/// Prints the rows as a Markdown table; the first iteration stands before the arrow, the last behind it.
pub(crate) fn print(rows: &[Row]) -> Result<()> {
    let line = |cells: &[String]| format!("| {} |", cells.join(" | "));
    crate::cli::print(&line(&HEADINGS.map(String::from)))?;
    crate::cli::print(&line(&HEADINGS.map(|_| "---".to_string())))?;
    rows.iter().try_for_each(|row| crate::cli::print(&line(&row.cells(rows))))
}

pub(crate) fn write(rows: &[Row], path: &Path) -> Result<()> {
    let text = serde_json::to_string_pretty(&File { platform: Platform::here()?, presets: rows })? + "\n";
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}
