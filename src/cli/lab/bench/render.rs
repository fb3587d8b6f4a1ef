//! `phototaxis bench render`: speed and stages, by method.

use super::output::{Output, Table, written, written_or};
use super::{Subject, name};
use crate::guiding::settings::GuidingMethod;
use crate::lab::bench::{self, MethodReport};
use crate::lab::compare::chart::{Sheet, Stack, stacks};
use anyhow::Result;
use clap::Args;
use serde::Serialize;

#[derive(Args)]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    subject: Subject,
    /// Samples per pixel of each render.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Methods to measure: none, auto, adaptive, grid, voronoi, sdtree.
    #[arg(long, value_name = "METHODS", value_delimiter = ',', value_parser = method,
        default_values = ["none", "adaptive", "grid", "voronoi", "sdtree"])]
    methods: Vec<GuidingMethod>,
    #[command(flatten)]
    output: Output,
}

fn method(text: &str) -> Result<GuidingMethod, String> {
    let named = GuidingMethod::NAMES.iter().find(|(name, _)| *name == text);
    named.map(|(_, method)| *method).ok_or_else(|| format!("there is no method '{text}'"))
}

#[derive(Serialize)]
struct Report {
    spp: u32,
    methods: Vec<MethodReport>,
}

pub(crate) fn run(arguments: &RenderArguments) -> Result<()> {
    let RenderArguments { subject, spp, methods, output } = arguments;
    output.check()?;
    let (description, scene) = subject.load(&[format!("render.spp={spp}")])?;
    let methods = bench::render(&scene, &description, methods, output.turns())?;
    let report = Report { spp: *spp, methods };
    let intervals = output.intervals();
    let chart = chart(&report.methods, &name(&subject.scene));
    output.write("render", &subject.scene, &[speeds(&report, &intervals), shares(&report.methods)], &report, chart)
}

fn speeds(report: &Report, intervals: &str) -> Table {
    let row = |m: &MethodReport| {
        vec![
            m.method.to_owned(),
            written(&m.msamples_per_second, 3),
            written(&m.mrays_per_second, 2),
            written_or(&m.msamples_per_cpu_second, 3),
            format!("{:.2}", m.rays_per_sample),
        ]
    };
    Table {
        title: format!("{} spp, threads: {}", report.spp, rayon::current_num_threads()),
        headings: vec!["method", "Msamples/s", "Mrays/s", "Msamples per CPU s", "rays per sample"],
        rows: report.methods.iter().map(row).collect(),
        foot: intervals.to_owned(),
    }
}

fn shares(methods: &[MethodReport]) -> Table {
    let row = |m: &MethodReport| {
        let shares = m.shares.iter().map(|s| format!("{:.1}", 100.0 * s.share));
        let name = std::iter::once(m.method.to_owned());
        name.chain(shares).chain([format!("{:.0}", m.stamp_nanoseconds), format!("{:.2}", m.watching)]).collect()
    };
    let stages = methods.first().map_or(Vec::new(), |m| m.shares.iter().map(|s| s.stage).collect());
    Table {
        title: "Share of the threads' time, in per cent".into(),
        headings: [vec!["method"], stages, vec!["stamp ns", "watched ×"]].concat(),
        rows: methods.iter().map(row).collect(),
        foot:
            "means over turns; what a stamp of the clock costs is taken off; watched: how much longer that render took"
                .into(),
    }
}

fn chart(methods: &[MethodReport], scene: &str) -> Option<String> {
    let row = |m: &MethodReport| Stack {
        name: m.method.to_owned(),
        parts: m.shares.iter().map(|s| 100.0 * s.share.max(0.0)).collect(),
        interval: None,
        figures: format!("{:.2} Mrays/s", m.mrays_per_second.median),
    };
    let rows: Vec<Stack> = methods.iter().map(row).collect();
    let parts: Vec<&str> = methods.first()?.shares.iter().map(|s| s.stage).collect();
    let (title, note) = (format!("What the time goes into: {scene}"), "Shares of the threads' time, means over turns");
    stacks(&Sheet { title: &title, note, label: "Share of the time [%]", parts: &parts }, &rows)
}
