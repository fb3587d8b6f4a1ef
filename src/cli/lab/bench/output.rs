//! Figures as a table, as JSON and as a chart.

use crate::cli::output::{check_writable, write_json};
use crate::draw::svg::Svg;
use crate::io::atomic::write_atomically;
use crate::io::clock;
use crate::platform::Platform;
use crate::stats::{Median, median::confidence};
use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Version of the JSON's shape; a change that breaks readers raises it.
const SCHEMA: u32 = 2;

#[derive(Args)]
pub(crate) struct Output {
    /// How often every variant takes its turn; medians are printed, with intervals.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    turns: u16,
    /// Writes the figures as JSON; "-" is standard output, in place of the table.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the chart.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
}

/// What a report says of itself.
#[derive(Serialize)]
struct Head<'a, T> {
    schema: u32,
    phototaxis: &'static str,
    platform: Platform,
    /// When it was written, in UTC.
    date: String,
    bench: &'static str,
    subject: String,
    threads: usize,
    turns: usize,
    /// Of the intervals of medians.
    confidence: f64,
    #[serde(flatten)]
    figures: &'a T,
}

impl Output {
    pub(crate) fn turns(&self) -> usize {
        self.turns as usize
    }

    /// Refuses files that could not be written, before anything is measured.
    pub(crate) fn check(&self) -> Result<()> {
        if let Some(path) = &self.svg {
            if path.extension().is_none_or(|e| e != "svg") {
                bail!("{}: charts are written as .svg", path.display());
            }
            check_writable(path)?;
        }
        let mut json = self.json.iter().filter(|path| path.as_os_str() != "-");
        json.try_for_each(|path| check_writable(path))
    }

    /// What intervals mean, for the foot of a table and the note of a chart.
    pub(crate) fn intervals(&self) -> String {
        let n = self.turns();
        format!("medians of {n} turns [{:.0} % intervals from order statistics]", 100.0 * confidence(n))
    }

    /// Prints and writes what was asked for.
    pub(crate) fn write<T: Serialize>(
        &self,
        bench: &'static str,
        subject: &Path,
        tables: &[Table],
        figures: &T,
        chart: Option<String>,
    ) -> Result<()> {
        let (turns, threads) = (self.turns(), rayon::current_num_threads());
        let subject = subject.display().to_string();
        let (phototaxis, confidence) = (env!("CARGO_PKG_VERSION"), confidence(turns));
        let platform = Platform::here()?;
        let date = clock::utc_now();
        let head =
            Head { schema: SCHEMA, phototaxis, platform, date, bench, subject, threads, turns, confidence, figures };
        if self.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
            let platform = &head.platform;
            crate::cli::print(&format!("{}, {}", platform.stamp(), platform.packets()))?;
            platform.advice().iter().try_for_each(|advice| crate::cli::print(advice))?;
            tables.iter().try_for_each(Table::print)?;
        }
        if let Some(path) = &self.json {
            write_json(path, &head)?;
        }
        if let Some((path, chart)) = self.svg.as_ref().zip(chart) {
            let chart = Svg::with_metadata(&chart, &head.platform.stamp());
            write_atomically(path, |file| file.write_all(chart.as_bytes()))?;
        }
        Ok(())
    }
}

/// Rows under headings; the first column is flush left.
pub(crate) struct Table {
    pub(crate) title: String,
    pub(crate) headings: Vec<&'static str>,
    pub(crate) rows: Vec<Vec<String>>,
    pub(crate) foot: String,
}

impl Table {
    fn print(&self) -> Result<()> {
        let headings = self.headings.iter().map(ToString::to_string).collect();
        let all: Vec<&Vec<String>> = std::iter::once(&headings).chain(&self.rows).collect();
        let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..headings.len()).map(width).collect();
        crate::cli::print(&self.title)?;
        for row in &all {
            let cell = |(k, text): (usize, &String)| match k {
                0 => format!("{text:<w$}", w = widths[k]),
                _ => format!("{text:>w$}", w = widths[k]),
            };
            crate::cli::print(row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end())?;
        }
        crate::cli::print(&format!("{}\n", self.foot))
    }
}

/// A median and its interval.
pub(crate) fn written(m: &Median, digits: usize) -> String {
    format!("{:.digits$} [{:.digits$}, {:.digits$}]", m.median, m.low, m.high)
}

/// The same where there may be none.
pub(crate) fn written_or(m: &Option<Median>, digits: usize) -> String {
    m.as_ref().map_or("-".into(), |m| written(m, digits))
}
