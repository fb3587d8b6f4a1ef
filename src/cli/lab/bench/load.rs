//! `phototaxis bench load`: what opening a model costs.

use super::name;
use super::output::{Output, Table, written};
use crate::cli::choices::Machine;
use crate::format;
use crate::lab::bench::{self, LoadReport};
use crate::lab::compare::chart::{Sheet, Stack, stacks};
use crate::stats::Median;
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct LoadArguments {
    /// Model (.obj).
    model: PathBuf,
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &LoadArguments) -> Result<()> {
    let LoadArguments { model, machine, output } = arguments;
    output.check()?;
    let threads = machine.start(false)?;
    let (description, _) = format::load(model, &[])?;
    let report = bench::load(&description, threads, output.turns())?;
    let intervals = output.intervals();
    output.write("load", model, &[table(&report, &intervals)], &report, chart(&report, &name(model), &intervals))
}

fn table(r: &LoadReport, intervals: &str) -> Table {
    let (mega, million) = (r.file_bytes as f64 * 1e-6, r.triangles as f64 * 1e-6);
    let row = |name: &str, m: &Median, read: bool| {
        let rates = [mega / m.median, million / m.median].map(|rate| format!("{rate:.2}"));
        vec![name.into(), written(m, 4), if read { rates[0].clone() } else { "-".into() }, rates[1].clone()]
    };
    let mut rows =
        vec![row("parse", &r.parse, true), row("build", &r.build, false), row("first pixel", &r.first_pixel, true)];
    rows.extend(r.tobj.wall_seconds.as_ref().map(|m| row("tobj alone", m, true)));
    let mib = |bytes: u64| bytes as f64 / (1 << 20) as f64;
    let peak = r.peak_bytes.map_or(String::new(), |b| format!(", {:.1} MiB at the most", mib(b)));
    let tobj = match (&r.tobj.failure, &r.tobj.ratio) {
        (Some(failure), _) => format!("tobj cannot read this file: {failure}"),
        (None, ratio) => format!(
            "tobj: {} triangles, {} × the time of parse",
            r.tobj.triangles.unwrap_or(0),
            ratio.as_ref().map_or("-".into(), |m| written(m, 2))
        ),
    };
    Table {
        title: format!("{:.1} MB, {} triangles", mega, r.triangles),
        headings: vec!["", "wall seconds", "MB/s", "Mtriangles/s"],
        rows,
        foot: format!(
            "memory: mesh {:.1} MiB, Embree {:.1} MiB{peak}; {:.0} bytes a triangle\n{tobj}\n{intervals}",
            mib(r.mesh_bytes as u64),
            mib(r.embree_bytes),
            r.bytes_per_triangle,
        ),
    }
}

fn chart(r: &LoadReport, model: &str, intervals: &str) -> Option<String> {
    let all = [("parse", Some(&r.parse)), ("build", Some(&r.build)), ("first pixel", Some(&r.first_pixel))];
    let rows: Vec<Stack> = all
        .into_iter()
        .chain([("tobj alone", r.tobj.wall_seconds.as_ref())])
        .filter_map(|(name, m)| {
            let m = m?;
            let (interval, figures) = (Some((m.low, m.high)), format!("{:.3} s", m.median));
            Some(Stack { name: name.into(), parts: vec![m.median], interval, figures })
        })
        .collect();
    let title = format!("Loading: {model}, {} triangles", r.triangles);
    stacks(&Sheet { title: &title, note: intervals, label: "Seconds", parts: &[] }, &rows)
}
