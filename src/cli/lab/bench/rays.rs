//! `phototaxis bench rays`: how much of the time is Embree's.

use super::output::{Output, Table, written};
use super::{Subject, name};
use crate::lab::bench::{self, RayOrder, RaysReport, ReplayFigure};
use crate::lab::compare::chart::{Sheet, Stack, stacks};
use anyhow::Result;
use clap::Args;

#[derive(Args)]
pub(crate) struct RaysArguments {
    #[command(flatten)]
    subject: Subject,
    /// Samples per pixel of the render whose rays are kept, 32 bytes each.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &RaysArguments) -> Result<()> {
    let RaysArguments { subject, spp, output } = arguments;
    output.check()?;
    let (description, scene) = subject.load(&[format!("render.spp={spp}")])?;
    let report = bench::rays(&scene, &description, rayon::current_num_threads(), output.turns())?;
    let intervals = output.intervals();
    let tables = [whole(&report, &intervals), replays(&report, &intervals)];
    output.write("rays", &subject.scene, &tables, &report, chart(&report, &name(&subject.scene), &intervals))
}

fn whole(report: &RaysReport, intervals: &str) -> Table {
    let row = |f: &bench::WholeFigure| {
        let rates = [&f.renderer, &f.stage, &f.embree].map(|m| written(m, 2));
        let shares = [&f.share, &f.stage_share].map(|m| written(m, 3));
        [vec![f.threads.to_string()], rates.to_vec(), shares.to_vec()].concat()
    };
    let r = report;
    let title = format!(
        "{}×{}, {} spp, depth {}: {} paths, {} rays ({:.0} % hit), {} shadow rays ({:.0} % blocked)",
        r.width,
        r.height,
        r.spp,
        r.max_depth,
        r.paths,
        r.rays,
        100.0 * r.hit_share,
        r.shadow_rays,
        100.0 * r.occluded_share,
    );
    let headings =
        vec!["threads", "renderer Mrays/s", "its Embree stage", "Embree alone", "renderer/alone", "stage/alone"];
    Table { title, headings, rows: report.whole.iter().map(row).collect(), foot: intervals.to_owned() }
}

fn replays(report: &RaysReport, intervals: &str) -> Table {
    let row = |f: &ReplayFigure| {
        let (set, order) = (f.set.name().to_owned(), f.order.name().to_owned());
        let (width, threads) = (f.width.to_string(), f.threads.to_string());
        vec![set, order, width, threads, written(&f.mrays_per_second, 2), written(&f.ratio, 2)]
    };
    Table {
        title: "Embree alone, by kind of ray".into(),
        headings: vec!["rays", "order", "width", "threads", "Mrays/s", "against single, as they come"],
        rows: report.replays.iter().map(row).collect(),
        foot: format!("orders: as they come (paths), as the renderer has them (waves), waves sorted; {intervals}"),
    }
}

fn chart(report: &RaysReport, scene: &str, intervals: &str) -> Option<String> {
    let bar = |name: String, m: &crate::stats::Median, more: &str| Stack {
        name,
        parts: vec![m.median],
        interval: Some((m.low, m.high)),
        figures: format!("{:.2}{more}", m.median),
    };
    let heading = |name: String| Stack { name, parts: Vec::new(), interval: None, figures: String::new() };
    let mut rows = Vec::new();
    for f in &report.whole {
        rows.push(heading(format!("All rays, threads: {}", f.threads)));
        rows.push(bar("whole renderer".into(), &f.renderer, &format!(" ({:.0} % of alone)", 100.0 * f.share.median)));
        rows.push(bar("Embree alone".into(), &f.embree, ""));
    }
    rows.push(heading("By kind, one thread".into()));
    let shown = |f: &&ReplayFigure| f.threads == 1 && f.order == RayOrder::Waves && f.width != 8;
    for f in report.replays.iter().filter(shown) {
        rows.push(bar(format!("{}, {} wide", f.set.name(), f.width), &f.mrays_per_second, ""));
    }
    let title = format!("Rays: {scene}");
    stacks(&Sheet { title: &title, note: intervals, label: "Mrays/s", parts: &[] }, &rows)
}
