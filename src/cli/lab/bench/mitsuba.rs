//! `phototaxis bench mitsuba`: beside Mitsuba 3.

use super::output::{Output, Table, written, written_or};
use super::{Subject, name};
use crate::cli::progress::say;
use crate::cli::render::warn;
use crate::format;
use crate::lab::bench::{Mitsuba, MitsubaPlan, MitsubaReport};
use crate::lab::compare::chart::{Sheet, Stack, stacks};
use anyhow::{Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(crate) struct MitsubaArguments {
    #[command(flatten)]
    subject: Subject,
    /// Samples per pixel of each render.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// The Python interpreter that has Mitsuba's module. [default: python3]
    #[arg(long, value_name = "FILE")]
    python: Option<PathBuf>,
    /// Keeps the scene as it was written for Mitsuba, and all pictures, in this folder.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &MitsubaArguments) -> Result<()> {
    let MitsubaArguments { subject, output, .. } = arguments;
    output.check()?;
    if let Some(path) = arguments.python.as_ref().filter(|path| !path.is_file()) {
        bail!("{}: there is no such program", path.display());
    }
    let python = arguments.python.as_deref().unwrap_or(Path::new("python3"));
    subject.machine.start(false)?;
    let (description, warnings) = format::load(&subject.scene, &subject.set)?;
    warn(&warnings);
    let plan = MitsubaPlan { spp: arguments.spp, threads: rayon::current_num_threads() };
    let mitsuba = Mitsuba::start(&description, plan, python, arguments.keep.as_deref())?;
    warn(mitsuba.warnings());
    for missing in mitsuba.missing() {
        let (variant, python, reason) = (missing.variant, python.display(), &missing.reason);
        say(&format!("SKIPPED: Mitsuba's {variant} does not run by {python}: {reason}"));
        say("(pip install mitsuba; llvm_ad_rgb needs LLVM: apt-get install libllvm19, DRJIT_LIBLLVM_PATH)");
    }
    let report = mitsuba.measure(output.turns())?;
    let intervals = output.intervals();
    let chart = chart(&report, &name(&subject.scene), &intervals);
    output.write("mitsuba", &subject.scene, &[table(&report, &intervals)], &report, chart)
}

fn table(r: &MitsubaReport, intervals: &str) -> Table {
    let ours = &r.phototaxis;
    let mut rows = vec![vec![
        "phototaxis".to_owned(),
        written(&ours.msamples_per_second, 3),
        written_or(&ours.msamples_per_cpu_second, 4),
        String::new(),
        String::new(),
        String::new(),
    ]];
    rows.extend(r.mitsuba.iter().map(|m| {
        vec![
            format!("Mitsuba {} {}", m.version, m.variant),
            written(&m.msamples_per_second, 3),
            written_or(&m.msamples_per_cpu_second, 4),
            written(&m.ratio, 2),
            written_or(&m.cpu_ratio, 2),
            format!("{:.4} ± {:.4}", m.agreement.brightness, m.agreement.noise),
        ]
    }));
    Table {
        title: format!(
            "{}×{}, {} triangles, {} spp, depth {}, threads: {}",
            r.width, r.height, r.triangles, r.plan.spp, r.max_depth, r.plan.threads
        ),
        headings: vec![
            "",
            "Msamples/s",
            "Msamples per CPU s",
            "phototaxis ×",
            "per CPU s ×",
            "brightness of phototaxis' picture ×",
        ],
        rows,
        foot: intervals.to_owned(),
    }
}

fn chart(r: &MitsubaReport, scene: &str, intervals: &str) -> Option<String> {
    let theirs = r.mitsuba.iter().map(|m| (format!("Mitsuba {}", m.variant), &m.msamples_per_second));
    let all = [("phototaxis".to_owned(), &r.phototaxis.msamples_per_second)].into_iter().chain(theirs);
    let rows: Vec<Stack> = all
        .map(|(name, m)| Stack {
            name,
            parts: vec![m.median],
            interval: Some((m.low, m.high)),
            figures: format!("{:.3}", m.median),
        })
        .collect();
    let title = format!("Beside Mitsuba 3: {scene}");
    stacks(&Sheet { title: &title, note: intervals, label: "Msamples/s, all threads", parts: &[] }, &rows)
}
