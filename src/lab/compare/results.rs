//! results.json and results.csv: all figures of a comparison, for programs. The shape is described in docs/compare.md.

use super::cell::{CONFIDENCE, Cell};
use super::chart::Chart;
use super::executor::picture_path;
use super::gallery::matrix::Matrix;
use super::overall::Overall;
use super::plan::{Plan, file_stem};
use super::record::{ReferenceRecord, Run};
use super::rgbe;
use super::scene_cache::SceneCache;
use super::schedule::order;
use super::store::Store;
use crate::Result;
use crate::image::exr::read_rgb;
use crate::io::clock;
use crate::platform::Platform;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Version of the JSON's shape; a change that breaks readers raises it.
const FORMAT: u32 = 2;

/// All of a comparison, ready to be written.
#[derive(Serialize)]
pub(crate) struct Results {
    format: u32,
    title: String,
    command: String,
    version: &'static str,
    platform: Platform,
    /// When it was written, in UTC.
    date: String,
    machine: Value,
    baseline: String,
    confidence: f64,
    scenes: Vec<SceneResult>,
    methods: Vec<Value>,
    budgets: Vec<Value>,
    runs: Vec<Value>,
    cells: Vec<Cell>,
    /// Geometric means over scenes.
    overall: Vec<Overall>,
    charts: Vec<Chart>,
    images: Vec<Picture>,
    /// Where the plan has a gallery.
    #[serde(skip_serializing_if = "Option::is_none")]
    gallery: Option<Matrix>,
}

#[derive(Serialize)]
struct SceneResult {
    name: String,
    path: String,
    width: u32,
    height: u32,
    triangles: usize,
    reference: Option<ReferenceRecord>,
}

#[derive(Serialize)]
struct Picture {
    scene: String,
    /// `reference` for the reference.
    method: String,
    budget: Option<String>,
    seed: Option<u64>,
    width: usize,
    height: usize,
    rgbe: String,
}

impl Results {
    /// `command` is the command line, for the reader.
    pub(crate) fn new(
        plan: &Plan,
        scene_cache: &SceneCache,
        store: &Store,
        command: &str,
        cells: Vec<Cell>,
        overall: Vec<Overall>,
        charts: Vec<Chart>,
    ) -> Results {
        let platform = scene_cache.platform();
        Results {
            format: FORMAT,
            title: plan.title.clone(),
            command: command.into(),
            version: env!("CARGO_PKG_VERSION"),
            date: clock::utc_now(),
            machine: json!({
                "cpu": platform.cpu,
                "threads": rayon::current_num_threads(),
                "os": std::env::consts::OS,
            }),
            platform,
            baseline: plan.methods[plan.baseline].name.clone(),
            confidence: CONFIDENCE,
            scenes: (0..plan.scenes.len()).map(|k| scene(plan, scene_cache, store, k)).collect(),
            methods: (0..plan.methods.len()).map(|k| method(plan, k)).collect(),
            budgets: plan.budgets.iter().map(|b| budget(*b)).collect(),
            runs: runs(plan, store).map(run).collect(),
            cells,
            overall,
            charts,
            images: Vec::new(),
            gallery: None,
        }
    }

    pub(crate) fn add_gallery(&mut self, matrix: Matrix) {
        self.gallery = Some(matrix);
    }

    /// Adds the pictures: of each scene the reference and each method's last at the largest budget, as far as they are
    /// there.
    ///
    /// # Errors
    /// A picture that cannot be read.
    pub(crate) fn add_pictures(&mut self, plan: &Plan, store: &Store, folder: &Path) -> Result<()> {
        for (index, entry) in plan.scenes.iter().enumerate() {
            if let Some(known) = store.reference(&entry.name()) {
                self.add_picture(&entry.name(), "reference", None, &known.file(folder))?;
            }
            for method in 0..plan.methods.len() {
                let path = picture_path(folder, plan, index, method);
                let of_this = order(plan).into_iter().filter(|s| s.scene == index && s.method == method);
                let largest = of_this.filter(|s| s.budget == plan.budgets.len() - 1);
                let last = largest.filter_map(|slot| store.find(plan, &slot)).next_back();
                if let Some(run) = last.filter(|_| path.exists()) {
                    self.add_picture(&run.scene, &run.method, Some(run), &path)?;
                }
            }
        }
        Ok(())
    }

    fn add_picture(&mut self, scene: &str, method: &str, run: Option<&Run>, path: &Path) -> Result<()> {
        let image = read_rgb(path)?;
        self.images.push(Picture {
            scene: scene.into(),
            method: method.into(),
            budget: run.map(|r| r.budget.clone()),
            seed: run.map(|r| r.seed),
            width: image.width,
            height: image.height,
            rgbe: rgbe::encode(&image)?,
        });
        Ok(())
    }

    /// As JSON text.
    ///
    /// # Errors
    /// None that is known: all of it is strings and numbers.
    pub(crate) fn to_json(&self) -> Result<String> {
        serde_json::to_string(self).map(|text| text + "\n").map_err(|e| crate::Error::Scene(e.to_string()))
    }
}

/// The runs of a plan that are there, in its order.
fn runs<'a>(plan: &'a Plan, store: &'a Store) -> impl Iterator<Item = &'a Run> {
    order(plan).into_iter().filter_map(|slot| store.find(plan, &slot))
}

fn scene(plan: &Plan, scene_cache: &SceneCache, store: &Store, index: usize) -> SceneResult {
    let (loaded, _) = scene_cache.plain(index);
    let entry = &plan.scenes[index];
    SceneResult {
        name: entry.name(),
        path: entry.path.display().to_string(),
        width: loaded.camera.width,
        height: loaded.camera.height,
        triangles: loaded.triangles(),
        reference: store.reference(&entry.name()).cloned(),
    }
}

fn method(plan: &Plan, index: usize) -> Value {
    let method = &plan.methods[index];
    let overrides: Map<String, Value> =
        plan.overrides.iter().chain(&method.overrides).map(|o| (o.key.clone(), typed(&o.value))).collect();
    json!({"name": method.name, "overrides": overrides, "baseline": index == plan.baseline})
}

/// A value of a scene file in JSON: bare words are text.
fn typed(value: &str) -> Value {
    let table = format!("value = {value}").parse::<toml::Table>().ok();
    let read = table.as_ref().and_then(|t| t.get("value")).and_then(|v| serde_json::to_value(v).ok());
    read.unwrap_or_else(|| value.into())
}

fn budget(budget: super::plan::Budget) -> Value {
    use super::plan::Budget;
    match budget {
        Budget::Seconds(seconds) => json!({"name": budget.name(), "wall_seconds": seconds, "spp": null}),
        Budget::Samples(spp) => json!({"name": budget.name(), "wall_seconds": null, "spp": spp}),
    }
}

/// A run without what only the test of bias needs.
fn run(run: &Run) -> Value {
    let mut value = json!(run);
    if let Some(fields) = value.as_object_mut() {
        fields.remove("blocks");
    }
    value
}

/// Figures of a run that have one number each, in the order of columns.
type Column = (&'static str, fn(&Run) -> String);

const COLUMNS: [Column; 32] = [
    ("scene", |r| quoted(&r.scene)),
    ("method", |r| quoted(&r.method)),
    ("budget", |r| quoted(&r.budget)),
    ("seed", |r| r.seed.to_string()),
    ("samples", |r| r.samples.to_string()),
    ("wall_seconds", |r| number(r.wall_seconds)),
    ("cpu_seconds", |r| number(r.cpu_seconds)),
    ("learn_wall_seconds", |r| number(r.learn_wall_seconds)),
    ("film_wall_seconds", |r| number(r.film_wall_seconds)),
    ("mse", |r| number(r.errors.mse)),
    ("relmse", |r| number(r.errors.relmse)),
    ("relmse_trimmed", |r| number(r.errors.relmse_trimmed)),
    ("mape", |r| number(r.errors.mape)),
    ("smape", |r| number(r.errors.smape)),
    ("flip", |r| number(r.errors.flip)),
    ("worst_permille", |r| number(r.errors.worst_permille)),
    ("mean_r", |r| number(r.mean[0])),
    ("mean_g", |r| number(r.mean[1])),
    ("mean_b", |r| number(r.mean[2])),
    ("non_finite", |r| r.non_finite.to_string()),
    ("broken_pixels", |r| r.broken_pixels.to_string()),
    ("negative_pixels", |r| r.negative_pixels.to_string()),
    ("rays", |r| r.rays.to_string()),
    ("shadow_rays", |r| r.shadow_rays.to_string()),
    ("paths", |r| r.paths.to_string()),
    ("mean_path_length", |r| number(r.mean_path_length)),
    ("zero_share", |r| number(r.zero_share)),
    ("guide_bytes", |r| r.guide_bytes.to_string()),
    ("guide_states", |r| r.guide_states.to_string()),
    ("peak_bytes", |r| r.peak_bytes.map_or(String::new(), |b| b.to_string())),
    ("msamples_per_second", |r| number(1e-6 * r.paths as f64 / r.wall_seconds)),
    ("mrays_per_second", |r| number(1e-6 * (r.rays + r.shadow_rays) as f64 / r.wall_seconds)),
];

/// A table of all runs, with headings (RFC 4180, but for the ends of lines). What is not a number is empty.
pub(crate) fn csv(plan: &Plan, store: &Store) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let head = line(COLUMNS.iter().map(|(name, _)| name.to_string()).collect());
    runs(plan, store).fold(head, |text, run| text + &line(COLUMNS.iter().map(|(_, value)| value(run)).collect()))
}

fn number(x: f64) -> String {
    if x.is_finite() { x.to_string() } else { String::new() }
}

pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_string() }
}

/// Name of a chart's files.
pub(crate) fn chart_file(chart: &Chart) -> String {
    file_stem(&chart.id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::compare::fixtures;

    #[test]
    fn the_table_has_a_row_for_each_run_and_quotes_what_needs_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut plan = fixtures::plan();
        plan.methods[1].name = "a, \"b\"".into();
        let mut store = Store::open(&folder.path().join("runs.jsonl"), "", "").unwrap();
        for slot in order(&plan) {
            store.add(fixtures::run(&plan, &slot)).unwrap();
        }
        let text = csv(&plan, &store);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 25);
        assert!(lines[0].starts_with("scene,method,budget,seed,samples,wall_seconds,"));
        assert!(lines[2].starts_with("s0,\"a, \"\"b\"\"\",2 s,1,128,2,"), "{}", lines[2]);
        assert_eq!(lines[1].split(',').count(), COLUMNS.len());
    }

    #[test]
    fn settings_keep_their_types() {
        assert_eq!(typed("grid"), json!("grid"));
        assert_eq!(typed("\"grid\""), json!("grid"));
        assert_eq!(typed("32"), json!(32));
        assert_eq!(typed("[1, 2.5]"), json!([1, 2.5]));
        assert_eq!(typed("true"), json!(true));
        assert_eq!(typed("64 MiB"), json!("64 MiB"));
    }

    #[test]
    fn runs_are_without_their_blocks() {
        let plan = fixtures::plan();
        let value = run(&fixtures::run(&plan, &order(&plan)[1]));
        assert!(value.get("blocks").is_none());
        assert_eq!((value["relmse"].as_f64(), value["iterations"].as_array().unwrap().len()), (Some(0.25), 5));
    }
}
