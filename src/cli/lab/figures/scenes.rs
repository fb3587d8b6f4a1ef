//! What the results are measured on: the project's own scenes, the rows of its gallery, a generated city, and real scenes where they
//! are.

use super::Desk;
use crate::cli::progress::say;
use anyhow::{Context as _, Result, bail};
use std::path::Path;
use toml::{Table, Value};

/// Methods of the results. The paper's are those of the gallery: `paper` as it is written, and `paper-full` with what this program
/// adds to it.
pub(super) const METHODS: [&str; 8] = ["none", "auto", "adaptive", "grid", "voronoi", "sdtree", "paper", "paper-full"];

/// Width over height.
const OWN: [(&str, f64); 3] = [("door", 512.0 / 288.0), ("wall", 512.0 / 384.0), ("cornell", 1.0)];

/// Folders of the real scenes, each with a scene.json.
const REAL: [&str; 8] = [
    "veach-ajar",
    "veach-bidir",
    "veach-mis",
    "cornell-box",
    "staircase2",
    "living-room",
    "lumen-occluded",
    "lumen-occluded2",
];

/// What a plan compares.
pub(super) enum Content<'a> {
    /// The methods of the results on all scenes, at all budgets.
    Results,
    /// A method or a sweep on all scenes but those of the gallery, at the largest budget.
    Method(&'a str),
}

/// Writes a plan into the folder for work; the names of scenes that are not there.
pub(super) fn write_plan(desk: &mut Desk, name: &str, content: &Content) -> Result<Vec<String>> {
    let gallery_file = Path::new("scenes/gallery/gallery.toml");
    let text = std::fs::read_to_string(gallery_file).with_context(|| gallery_file.display().to_string())?;
    let gallery: Table = text.parse().context("scenes/gallery/gallery.toml")?;
    let own = std::env::current_dir().context("the current folder")?;
    let mut scenes = Vec::new();
    for (name, aspect) in OWN {
        scenes.push(sized(&own.join(format!("scenes/{name}.toml")), name, desk.budgets.width, aspect));
    }
    scenes.push(sized(&city(desk)?, "city", desk.budgets.width, 16.0 / 9.0));
    let whole = matches!(content, Content::Results);
    let rows = gallery.get("scene").and_then(Value::as_array).context("the gallery has no scenes")?;
    scenes.extend(
        rows.iter().filter_map(Value::as_table).filter(|_| whole).map(|row| moved(row, &own.join("scenes/gallery"))),
    );
    let mut missing = Vec::new();
    for name in REAL {
        let file = desk.arguments.real.join(name).join("scene.json");
        match aspect(&file) {
            Some(aspect) => scenes.push(sized(&std::path::absolute(&file)?, name, desk.budgets.width, aspect)),
            None => {
                if whole {
                    say(&format!(
                        "SKIPPED: {name}: it is not part of this repository, and --real names no folder that has it"
                    ));
                }
                missing.push(name.to_string());
            }
        }
    }
    let wanted = &desk.arguments.scenes;
    let is_known = |name: &&String| {
        missing.contains(*name) || scenes.iter().any(|scene| scene["name"].as_str() == Some(name.as_str()))
    };
    if let Some(unknown) = wanted.iter().find(|name| whole && !is_known(name)) {
        bail!("there is no scene `{unknown}` among those of the results");
    }
    scenes.retain(|scene| wanted.is_empty() || wanted.iter().any(|name| scene["name"].as_str() == Some(name)));
    let methods = gallery.get("methods").and_then(Value::as_table).context("the gallery has no methods")?;
    let chosen = &desk.budgets.methods;
    let paper = methods.iter().filter(|(name, _)| chosen.contains(name));
    let mut plan = Table::new();
    let (compared, time) = match content {
        Content::Results => (chosen.iter().map(|name| Value::from(name.as_str())).collect(), desk.budgets.time.clone()),
        Content::Method(method) => {
            (vec![Value::from(*method)], vec![desk.budgets.time.iter().copied().fold(0.0, f64::max)])
        }
    };
    plan.insert("title".into(), "Results".into());
    plan.insert("compare".into(), compared.into());
    plan.insert("time".into(), time.into());
    plan.insert("runs".into(), i64::from(desk.budgets.runs).into());
    plan.insert("reference_time".into(), desk.budgets.reference_time.into());
    plan.insert("scene".into(), Value::Array(scenes.into_iter().map(Value::Table).collect()));
    if whole {
        let paper = paper.map(|(name, value)| (name.clone(), value.clone())).collect();
        plan.insert("methods".into(), Value::Table(paper));
    }
    std::fs::write(desk.work(name), toml::to_string(&plan)?).with_context(|| name.to_string())?;
    Ok(missing)
}

/// The city, generated where it is not there yet.
fn city(desk: &mut Desk) -> Result<std::path::PathBuf> {
    let folder = desk.work(&format!("city-{}", desk.budgets.triangles));
    let file = folder.join("city.toml");
    if !file.exists() {
        let triangles = desk.budgets.triangles.to_string();
        let out = folder.display().to_string();
        desk.run(&["generate", "city", "--triangles", &triangles, "--out", &out].map(String::from))?;
    }
    Ok(std::path::absolute(file)?)
}

/// A scene at so many pixels of width.
fn sized(path: &Path, name: &str, width: u32, aspect: f64) -> Table {
    let height = (f64::from(width) / aspect).round().max(1.0) as i64;
    let mut set = Table::new();
    set.insert("film.width".into(), i64::from(width).into());
    set.insert("film.height".into(), height.into());
    let mut scene = Table::new();
    scene.insert("name".into(), name.into());
    scene.insert("path".into(), path.display().to_string().into());
    scene.insert("set".into(), Value::Table(set));
    scene
}

/// A row of the gallery, from another folder. Its pictures keep their size.
fn moved(row: &Table, folder: &Path) -> Table {
    let mut scene = row.clone();
    for key in ["path", "reference_scene", "reference"] {
        if let Some(path) = row.get(key).and_then(Value::as_str) {
            scene.insert(key.into(), folder.join(path).display().to_string().into());
        }
    }
    if !row.contains_key("name") {
        let stem =
            row.get("path").and_then(Value::as_str).and_then(|path| path.strip_suffix(".toml")).unwrap_or("scene");
        scene.insert("name".into(), stem.into());
    }
    scene
}

/// Width over height of the picture that a scene.json asks for.
fn aspect(file: &Path) -> Option<f64> {
    let scene: serde_json::Value = serde_json::from_slice(&std::fs::read(file).ok()?).ok()?;
    let size = |key: &str| scene["camera"][key].as_f64().filter(|size| *size > 0.0);
    Some(size("width")? / size("height")?)
}
