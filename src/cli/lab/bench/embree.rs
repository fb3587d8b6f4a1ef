//! `phototaxis bench embree`: beside the path tracer of Embree's own tutorials.

use super::output::{Output, Table, written, written_or};
use super::{Subject, name};
use crate::cli::progress::say;
use crate::lab::bench::{self, EmbreePlan, EmbreeReport};
use crate::lab::compare::chart::{Sheet, Stack, stacks};
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct EmbreeArguments {
    #[command(flatten)]
    subject: Subject,
    /// Samples per pixel of each frame.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Frames that are timed.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Segments of a path at most.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    depth: u32,
    /// Albedo of all surfaces, in (0, 1].
    #[arg(long, default_value_t = 0.7, value_parser = albedo)]
    albedo: f32,
    /// The program; without this it is looked for as embree_pathtracer and pathtracer.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &EmbreeArguments) -> Result<()> {
    let EmbreeArguments { subject, output, .. } = arguments;
    output.check()?;
    let program = program(arguments)?;
    let (description, scene) = subject.load(&[])?;
    let EmbreeArguments { spp, frames, depth, albedo, .. } = *arguments;
    let plan = EmbreePlan { spp, frames, depth, albedo, threads: rayon::current_num_threads() };
    let report = bench::embree(&scene, &description, &plan, program.as_deref(), plan.threads, output.turns())?;
    let intervals = output.intervals();
    let chart = chart(&report, &name(&subject.scene), &intervals);
    output.write("embree", &subject.scene, &[table(&report, &intervals)], &report, chart)
}

/// A program that was named must be there; one that was not is missed aloud.
fn program(arguments: &EmbreeArguments) -> Result<Option<PathBuf>> {
    if let Some(path) = &arguments.program {
        return if path.is_file() {
            Ok(Some(path.clone()))
        } else {
            bail!("{}: there is no such program", path.display())
        };
    }
    let found = bench::find_pathtracer(&std::env::var_os("PATH").unwrap_or_default());
    if found.is_none() {
        say("SKIPPED: Embree's path tracer is not installed (Debian: apt-get install embree-tools)");
    }
    Ok(found)
}

fn table(r: &EmbreeReport, intervals: &str) -> Table {
    let ours = &r.phototaxis;
    let row = |name: &str, samples: String, rays: String, cpu: String, per: f64| {
        vec![name.to_owned(), samples, rays, cpu, format!("{per:.3}")]
    };
    let mut rows = vec![row(
        "phototaxis",
        written(&ours.msamples_per_second, 3),
        written(&ours.mrays_per_second, 2),
        written_or(&ours.msamples_per_cpu_second, 4),
        ours.rays_per_sample,
    )];
    let mut foot = intervals.to_owned();
    if let Some(theirs) = &r.pathtracer {
        let (samples, rays) = (written(&theirs.msamples_per_second, 3), written(&theirs.mrays_per_second, 2));
        let cpu = written_or(&theirs.msamples_per_cpu_second, 4);
        rows.push(row("Embree's pathtracer", samples, rays, cpu, theirs.rays_per_sample));
        foot = format!(
            "phototaxis against it: {} × samples, {} × per CPU second; {} × rays per CPU second\n{intervals}",
            written(&theirs.ratio, 2),
            written_or(&theirs.cpu_ratio, 2),
            written_or(&theirs.cpu_ray_ratio, 2),
        );
    }
    let (plan, light) = (&r.plan, &r.light);
    Table {
        title: format!(
            "{}×{}, {} triangles, {} × {} spp, depth {}, albedo {}, a point light at {} ({})",
            r.width,
            r.height,
            r.triangles,
            plan.frames,
            plan.spp,
            plan.depth,
            plan.albedo,
            light.position,
            light.origin
        ),
        headings: vec!["", "Msamples/s", "Mrays/s", "Msamples per CPU s", "rays per sample"],
        rows,
        foot,
    }
}

fn chart(r: &EmbreeReport, scene: &str, intervals: &str) -> Option<String> {
    let theirs = r.pathtracer.as_ref().map(|f| ("Embree's pathtracer", &f.msamples_per_second));
    let all = [("phototaxis", &r.phototaxis.msamples_per_second)].into_iter().chain(theirs);
    let rows: Vec<Stack> = all
        .map(|(name, m)| Stack {
            name: name.into(),
            parts: vec![m.median],
            interval: Some((m.low, m.high)),
            figures: format!("{:.3}", m.median),
        })
        .collect();
    let title = format!("Beside Embree's tutorial path tracer: {scene}");
    stacks(&Sheet { title: &title, note: intervals, label: "Msamples/s, all threads", parts: &[] }, &rows)
}

fn albedo(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("expected a number in (0, 1]".into()),
    }
}
