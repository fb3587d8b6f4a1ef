//! The steps, in their order.

use super::crops::{self, Part};
use super::scenes::{self, Content};
use super::{Desk, blocks, page, validation};
use anyhow::{Context as _, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(super) type Step = fn(&mut Desk) -> Result<()>;

pub(super) const STEPS: [(&str, Step); 9] = [
    ("pictures", pictures),
    ("results", results),
    ("sdtree", sdtree),
    ("gallery", gallery),
    ("paper", paper),
    ("rates", rates),
    ("inspect", inspect),
    ("bench", bench),
    ("validation", validate),
];

/// Thresholds of the SD-tree, c: that of the paper, which the program scales by the number of paths, and others.
const THRESHOLDS: &str = "sweep:guiding.method=sdtree;guiding.leaf_samples=1500,3000,6000,12000,24000";

/// Words to a command line.
fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(String::from).collect()
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// The time and the end of a render's name.
fn render(desk: &mut Desk, settings: &str, to: &Path) -> Result<()> {
    let mut arguments = words(&format!("render scenes/door.toml --quiet {settings}"));
    arguments.extend(["-o".into(), text(to)]);
    desk.run(&arguments).map(drop)
}

fn pictures(desk: &mut Desk) -> Result<()> {
    let (spp, door) = (desk.budgets.spp, desk.work("door.png"));
    render(desk, &format!("--size 416x234 --spp {spp}"), &door)?;
    desk.publish(&door, "door.png")?;
    let seconds = desk.budgets.crop_time;
    let [none, auto, long] = ["crop-none.exr", "crop-auto.exr", "crop-long.exr"].map(|name| desk.work(name));
    render(desk, &format!("--guide none --time {seconds}"), &none)?;
    render(desk, &format!("--time {seconds}"), &auto)?;
    let much = desk.budgets.long_time;
    render(desk, &format!("--time {much} --seed 1"), &long)?;
    let names = [format!("no guide, {seconds} s"), format!("auto, {seconds} s"), format!("auto, {much} s")];
    let files = [none, auto, long];
    let pictures: Vec<(&str, &Path)> = names.iter().zip(&files).map(|(n, f)| (n.as_str(), f.as_path())).collect();
    let part = Part { x: 0.34, y: 0.40, width: 0.29, height: 0.46 };
    let note = "The scene door, part of 512 × 288 pixels. The only lamp is in the other room.";
    crops::write(
        &desk.output("crops-door.png"),
        "The same time, with and without a guide",
        note,
        &pictures,
        &part,
        2,
        &desk.stamp,
    )
}

/// Compares by a plan in the folder for work; where the results are.
pub(super) fn compare(desk: &mut Desk, arguments: Vec<String>, name: &str) -> Result<(PathBuf, Value)> {
    let folder = desk.work(name);
    let mut all = vec!["compare".into()];
    all.extend(arguments);
    // steps that have scenes in common have their references in common
    let references = text(&desk.work("references"));
    all.extend(["--allow-noisy-reference".into(), "--references".into(), references, "-o".into(), text(&folder)]);
    desk.run(&all)?;
    let json = std::fs::read(folder.join("results.json")).context("results.json")?;
    Ok((folder, serde_json::from_slice(&json)?))
}

fn results(desk: &mut Desk) -> Result<()> {
    let begun = Instant::now();
    let missing = scenes::write_plan(desk, "results.toml", &Content::Results)?;
    let plan = text(&desk.work("results.toml"));
    let (folder, results) = compare(desk, vec!["--plan".into(), plan, "--no-images".into()], "results")?;
    let charts = [
        ("efficiency-all", "efficiency-scenes"),
        ("error-time-door", "error-time-door"),
        ("error-time-wall", "error-time-wall"),
        ("error-time-city", "error-time-city"),
        ("efficiency-door", "efficiency-door"),
    ];
    for (chart, name) in charts {
        for extension in ["svg", "png"] {
            let file = folder.join("charts").join(format!("{chart}.{extension}"));
            if file.exists() {
                desk.publish(&file, &format!("{name}.{extension}"))?;
            }
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    let text = page::results(&results, &missing, seconds)?;
    blocks::replace(&desk.output("results.md"), "results", &desk.stamp, &text)
}

fn sdtree(desk: &mut Desk) -> Result<()> {
    let seconds = desk.budgets.time.iter().copied().fold(0.0, f64::max);
    let (width, runs, time) = (desk.budgets.width, desk.budgets.runs, desk.budgets.reference_time);
    let height = (f64::from(width) * 9.0 / 16.0).round();
    let mut arguments = words(&format!(
        "scenes/door.toml --no-images --set film.width={width} --set film.height={height} --time {seconds} --runs {runs} \
         --reference-time {time} --methods none"
    ));
    arguments.extend(["--methods".into(), THRESHOLDS.into()]);
    let (_, results) = compare(desk, arguments, "sdtree")?;
    let text = format!("{}\n{}", page::commands(&desk.commands), page::methods(&results)?);
    blocks::replace(&desk.output("results.md"), "sdtree", &desk.stamp, &text)
}

fn gallery(desk: &mut Desk) -> Result<()> {
    let (runs, seconds, time) = (desk.budgets.gallery_runs, desk.budgets.gallery_time, desk.budgets.reference_time);
    let arguments =
        words(&format!("--gallery --no-images --runs {runs} --time {seconds} --reference-time {}", time.min(60.0)));
    // the cells that have a picture, where it is only to be seen that it works
    let few = if desk.arguments.quick { words("--only corners,turned-door,keyhole") } else { Vec::new() };
    let (folder, _) = compare(desk, [arguments, few].concat(), "gallery")?;
    let found = std::fs::read_to_string(folder.join("stability.md")).context("stability.md")?;
    // the sentences on each red cell link to pictures that stay with the comparison
    let tables = page::without_links(found.split("\n\n").take(3).collect::<Vec<_>>().join("\n\n").as_str());
    let shown = [
        ("corners", "paper-order", "order"),
        ("corners", "paper-full", "roulette"),
        ("turned-door", "paper-sphere", "door"),
        ("keyhole", "auto", "keyhole"),
    ];
    for (scene, method, name) in shown {
        let file = folder.join("pictures").join(format!("{scene}_{method}.png"));
        if file.exists() {
            desk.publish(&file, &format!("stability-{name}.png"))?;
        }
    }
    blocks::replace(&desk.output("stability.md"), "gallery", &desk.stamp, &tables)
}

fn paper(desk: &mut Desk) -> Result<()> {
    let (spp, scale) = (desk.budgets.paper_spp, desk.budgets.paper_scale);
    let folder = desk.work("paper");
    let mut arguments = words(&format!("paper --quiet --spp {spp} --reference-spp {} --scale {scale} --out", 4 * spp));
    arguments.push(text(&folder));
    let printed = desk.run(&arguments)?;
    let three = |names: [&str; 3]| names.map(|name| folder.join(format!("{name}.exr")));
    let row = |desk: &Desk, to: &str, title: &str, names: [&str; 3]| {
        let files = three(names);
        let pictures: Vec<(&str, &Path)> = names.into_iter().zip(files.iter().map(PathBuf::as_path)).collect();
        let whole = Part { x: 0.0, y: 0.0, width: 1.0, height: 1.0 };
        crops::write(&desk.output(to), title, "", &pictures, &whole, 2, &desk.stamp)
    };
    row(desk, "paper-order.png", "Learnt progressively, in one go, and cosine", ["fig1a", "fig1c", "fig1d"])?;
    row(
        desk,
        "paper-stripes.png",
        "The leaf of a door: sphere, hemisphere, with normals",
        ["fig3", "fig3-hemisphere", "fig3-normals"],
    )?;
    desk.publish(&folder.join("fig1f-latlong.png"), "paper-q-door.png")?;
    desk.publish(&folder.join("fig2f-hemisphere.png"), "paper-q-wall.png")?;
    let text = format!("{}\n{}\n", page::commands(&desk.commands), printed.trim_end());
    blocks::replace(&desk.output("paper.md"), "paper", &desk.stamp, &text)
}

fn rates(desk: &mut Desk) -> Result<()> {
    let folder = desk.work("rates");
    let mut arguments = words(&format!("rates --spp {} --out", desk.budgets.rates_spp));
    arguments.push(text(&folder));
    desk.run(&arguments)?;
    desk.publish(&folder.join("rates.svg"), "rates.svg")?;
    desk.publish(&folder.join("rates.png"), "rates.png")
}

fn inspect(desk: &mut Desk) -> Result<()> {
    let folder = desk.work("inspect");
    let (spp, samples) = (desk.budgets.spp.div_ceil(2).max(4), desk.budgets.truth_samples);
    let mut arguments = words(&format!(
        "inspect scenes/door.toml --quiet --guide adaptive --spp {spp} --pixel 30,100 --truth-samples {samples} -o"
    ));
    arguments.push(text(&folder));
    desk.run(&arguments)?;
    desk.publish(&folder.join("hemisphere.png"), "inspect-door.png")
}

fn bench(desk: &mut Desk) -> Result<()> {
    let (turns, size) = (desk.budgets.turns, 2 * desk.budgets.width);
    let city = desk.work(&format!("city-{}", desk.budgets.triangles));
    if !city.join("city.toml").exists() {
        let mut arguments = words(&format!("generate city --triangles {} --out", desk.budgets.triangles));
        arguments.push(text(&city));
        desk.run(&arguments)?;
    }
    let mut printed = String::new();
    desk.commands.clear();
    for (scene, options) in [
        (PathBuf::from("scenes/cornell.toml"), format!("--set film.width={size} --set film.height={size}")),
        (
            city.join("city.toml"),
            format!("--set film.width={size} --set film.height={} --set integrator.max_depth=8", size * 9 / 16),
        ),
    ] {
        for kind in ["rays", "render"] {
            let methods = if kind == "render" { " --methods none,adaptive,grid,sdtree" } else { "" };
            let mut arguments = words(&format!("bench {kind} --turns {turns} {options}{methods}"));
            arguments.push(text(&scene));
            printed += &desk.run(&arguments)?;
            printed.push('\n');
        }
    }
    let text = format!("{}\n```text\n{}\n```\n", page::commands(&desk.commands), printed.trim_end());
    blocks::replace(&desk.output("benchmarks.md"), "bench", &desk.stamp, &text)
}

fn validate(desk: &mut Desk) -> Result<()> {
    let text = validation::table(desk)?;
    blocks::replace(&desk.output("validation.md"), "validation", &desk.stamp, &text)
}
