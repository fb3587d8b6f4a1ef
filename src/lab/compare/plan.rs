//! What is compared: scenes × methods × budgets × runs.

use super::gallery::Gallery;
use super::sweep;
use crate::document::suggest;
use crate::format::{self, SceneFile};
use crate::guiding::settings::GuidingMethod;
use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Runs of each cell where nobody says how many.
const RUNS: u32 = 5;

/// Runs of a comparison at most; each is kept in memory.
const MOST_RUNS: usize = 1_000_000;

/// A key of the scene file and what it is set to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Override {
    pub(crate) key: String,
    /// As TOML, or a bare word, as of `--set`.
    pub(crate) value: String,
    pub(crate) origin: Origin,
}

/// Where a setting is written, for messages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Origin {
    /// An argument of the command line.
    Argument(&'static str),
    /// A place in the comparison's file; both from 1.
    File { path: PathBuf, line: usize, column: usize },
}

impl Override {
    /// `key=value`.
    pub(crate) fn text(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// A name and what it changes of the scene's settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Method {
    pub(crate) name: String,
    pub(crate) overrides: Vec<Override>,
}

/// A scene and what it is compared with.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SceneEntry {
    /// Told apart by it; the file's name without its end unless given.
    pub(crate) name: Option<String>,
    pub(crate) path: PathBuf,
    pub(crate) overrides: Vec<Override>,
    /// `None`: it is made.
    pub(crate) reference: Option<PathBuf>,
    /// Another scene of which the reference is made, because it gives the same picture by easier means.
    pub(crate) reference_scene: Option<PathBuf>,
    /// Samples per pixel at most, whatever the budget.
    pub(crate) samples: Option<u32>,
}

impl SceneEntry {
    pub(crate) fn name(&self) -> String {
        let stem = || match self.path.file_stem().map(|s| s.to_string_lossy().into_owned()) {
            // interchange scenes are all called so, in folders that are not
            Some(stem) if stem == "scene" => self
                .path
                .canonicalize()
                .ok()
                .and_then(|p| Some(p.parent()?.file_name()?.to_string_lossy().into_owned())),
            other => other,
        };
        self.name.clone().or_else(stem).unwrap_or_else(|| "scene".into())
    }
}

/// How long a run may take: seconds or samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Budget {
    Seconds(f64),
    Samples(u32),
}

impl Budget {
    pub(crate) fn name(self) -> String {
        match self {
            Budget::Seconds(seconds) => format!("{seconds} s"),
            Budget::Samples(spp) => format!("{spp} spp"),
        }
    }

    pub(crate) fn amount(self) -> f64 {
        match self {
            Budget::Seconds(seconds) => seconds,
            Budget::Samples(spp) => f64::from(spp),
        }
    }
}

/// What the command line and a file say between them, before it is known whether it goes together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    pub(crate) title: Option<String>,
    pub(crate) scenes: Vec<SceneEntry>,
    /// For all scenes and methods.
    pub(crate) overrides: Vec<Override>,
    /// Names of methods, and sweeps, in their order.
    pub(crate) methods: Vec<String>,
    /// Methods that are not built in.
    pub(crate) defined: BTreeMap<String, Vec<Override>>,
    pub(crate) budgets: Vec<Budget>,
    pub(crate) runs: Option<u32>,
    pub(crate) seed: Option<u64>,
    pub(crate) baseline: Option<String>,
    pub(crate) reference_noise: Option<f64>,
    pub(crate) reference_time: Option<f64>,
    pub(crate) references: Option<PathBuf>,
    pub(crate) gallery: Option<Gallery>,
}

/// A comparison that can be carried out.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(crate) title: String,
    pub(crate) scenes: Vec<SceneEntry>,
    pub(crate) overrides: Vec<Override>,
    pub(crate) methods: Vec<Method>,
    /// From the smallest to the largest.
    pub(crate) budgets: Vec<Budget>,
    pub(crate) runs: u32,
    pub(crate) seed: u64,
    /// Index of the method that the others are measured against.
    pub(crate) baseline: usize,
    /// Share of the smallest error that a reference's own noise may have.
    pub(crate) reference_noise: f64,
    /// Seconds that a reference may take.
    pub(crate) reference_time: f64,
    /// Folder of the references that are made; a relative one is within the folder of the comparison.
    pub(crate) references: PathBuf,
    /// Whether a matrix of verdicts is made, and by which bounds.
    pub(crate) gallery: Option<Gallery>,
}

impl Draft {
    /// Leaves out all scenes but those of these names; without any name, none.
    ///
    /// # Errors
    /// [`Error::Scene`] for a name that is not there.
    pub(crate) fn keep_scenes(&mut self, names: &[String]) -> Result<()> {
        let there: Vec<String> = self.scenes.iter().map(SceneEntry::name).collect();
        if let Some(name) = names.iter().find(|name| !there.contains(name)) {
            let known = there.iter().map(String::as_str);
            return Err(Error::Scene(suggest::unknown(&format!("unknown scene `{name}`"), name, known)));
        }
        self.scenes.retain(|scene| names.is_empty() || names.contains(&scene.name()));
        Ok(())
    }

    /// # Errors
    /// [`Error::Scene`] that names what is missing, unknown or there twice.
    pub fn finish(self) -> Result<Plan> {
        let methods = self.chosen_methods()?;
        let baseline = find_baseline(&methods, self.baseline.as_deref())?;
        let scene_names: Vec<String> = self.scenes.iter().map(SceneEntry::name).collect();
        let title = || {
            let names: Vec<&str> = methods.iter().map(|m| m.name.as_str()).collect();
            format!("{}: {}", scene_names.join(", "), names.join(", "))
        };
        let plan = Plan {
            title: self.title.clone().unwrap_or_else(title),
            budgets: ordered(&self.budgets)?,
            runs: self.runs.unwrap_or(RUNS),
            seed: self.seed.unwrap_or(0),
            reference_noise: self.reference_noise.unwrap_or(0.05),
            reference_time: self.reference_time.unwrap_or(600.0),
            references: self.references.unwrap_or_else(|| "references".into()),
            scenes: self.scenes.into_iter().map(|s| SceneEntry { name: Some(s.name()), ..s }).collect(),
            overrides: self.overrides,
            gallery: self.gallery,
            methods,
            baseline,
        };
        if plan.scenes.is_empty() {
            return Err(Error::Scene("there is no scene to compare methods on".into()));
        }
        told_apart("scenes", scene_names.iter().map(String::as_str))?;
        told_apart("methods", plan.methods.iter().map(|m| m.name.as_str()))?;
        check_length(&plan)?;
        Ok(plan)
    }

    fn chosen_methods(&self) -> Result<Vec<Method>> {
        let mut methods = Vec::new();
        for name in &self.methods {
            match name.strip_prefix(sweep::PREFIX) {
                Some(text) => methods.extend(sweep::expand(text)?),
                None => methods.push(self.named(name)?),
            }
        }
        if methods.is_empty() {
            return Err(Error::Scene("there is no method to compare".into()));
        }
        Ok(methods)
    }

    /// A method of the file, or a built-in one: those of the key guiding.method.
    fn named(&self, name: &str) -> Result<Method> {
        if let Some(overrides) = self.defined.get(name) {
            return Ok(Method { name: name.into(), overrides: overrides.clone() });
        }
        let built_in: Vec<&str> = GuidingMethod::NAMES.iter().map(|(name, _)| *name).collect();
        if built_in.contains(&name) {
            let (key, value) = ("guiding.method".to_string(), name.to_string());
            let origin = Origin::Argument("--methods");
            return Ok(Method { name: name.into(), overrides: vec![Override { key, value, origin }] });
        }
        let known = built_in.into_iter().chain(self.defined.keys().map(String::as_str));
        Err(Error::Scene(suggest::unknown(&format!("unknown method `{name}`"), name, known)))
    }
}

fn check_length(plan: &Plan) -> Result<()> {
    let factors = [plan.scenes.len(), plan.methods.len(), plan.budgets.len(), plan.runs as usize];
    match factors.iter().try_fold(1usize, |product, factor| product.checked_mul(*factor)) {
        Some(0..=MOST_RUNS) => Ok(()),
        _ => {
            let [scenes, methods, budgets, runs] = factors;
            let product = format!("{scenes} scenes × {methods} methods × {budgets} budgets × {runs} runs");
            Err(Error::Scene(format!("{product} are more than {MOST_RUNS} renders")))
        }
    }
}

fn find_baseline(methods: &[Method], name: Option<&str>) -> Result<usize> {
    let find = |name: &str| methods.iter().position(|m| m.name == name);
    match name {
        None => Ok(find("none").unwrap_or(0)),
        Some(name) => find(name).ok_or_else(|| Error::Scene(format!("the baseline `{name}` is none of the methods"))),
    }
}

fn ordered(budgets: &[Budget]) -> Result<Vec<Budget>> {
    let mut budgets = budgets.to_vec();
    let timed = budgets.iter().filter(|b| matches!(b, Budget::Seconds(_))).count();
    if budgets.is_empty() || (timed != 0 && timed != budgets.len()) {
        return Err(Error::Scene("a comparison needs budgets: seconds (--time) or samples per pixel (--spp)".into()));
    }
    budgets.sort_by(|a, b| a.amount().total_cmp(&b.amount()));
    budgets.dedup();
    Ok(budgets)
}

/// That names differ, in names of files too.
fn told_apart<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(file_stem(name)) {
            return Err(Error::Scene(format!("{what} need names that tell them apart, and `{name}` is taken")));
        }
    }
    Ok(())
}

/// A name as part of a file's name.
pub(crate) fn file_stem(name: &str) -> String {
    let kept = |c: char| c.is_alphanumeric() || "._=".contains(c);
    name.chars().map(|c| if kept(c) { c } else { '-' }).collect::<String>().to_lowercase()
}

impl Plan {
    /// What a method makes of a scene, with its warnings.
    ///
    /// # Errors
    /// As [`format::load`]; a wrong setting is named with its place in the comparison's file where it has one.
    pub(crate) fn describe(&self, scene: &SceneEntry, method: Option<&Method>) -> Result<(SceneFile, Vec<String>)> {
        self.described(&scene.path, &scene.overrides, method.map_or(&[], |m| &m.overrides))
    }

    /// The scene of which the reference is made, where that is another.
    ///
    /// # Errors
    /// As [`Plan::describe`].
    pub(crate) fn describe_reference(&self, scene: &SceneEntry) -> Result<Option<(SceneFile, Vec<String>)>> {
        scene.reference_scene.as_ref().map(|path| self.described(path, &[], &[])).transpose()
    }

    /// A method's settings are read over those of the plan and the scene, which hold for whatever method they mean something with.
    fn described(&self, path: &Path, scene: &[Override], method: &[Override]) -> Result<(SceneFile, Vec<String>)> {
        let common = self.overrides.iter().chain(scene);
        let all: Vec<&Override> = common.chain(method).collect();
        let texts: Vec<String> = all.iter().map(|o| o.text()).collect();
        let (common, method) = texts.split_at(texts.len() - method.len());
        format::load_layers(path, common, method).map_err(|error| match error {
            Error::Override { index, message, .. } => placed(all[index], message),
            other => other,
        })
    }
}

fn placed(wrong: &Override, message: String) -> Error {
    match &wrong.origin {
        Origin::File { path, line, column } => Error::parse(path, *line, *column, message),
        Origin::Argument(argument) => Error::Scene(format!("{argument} '{}': {message}", wrong.text())),
    }
}

/// Splits `--set`'s argument.
///
/// # Errors
/// [`Error::Scene`] without an equals sign.
pub(crate) fn parse_set(text: &str) -> Result<Override> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| Error::Scene(format!("--set '{text}': expected key=value, for example film.width=640")))?;
    let (key, value) = (key.trim().to_string(), value.trim().to_string());
    Ok(Override { key, value, origin: Origin::Argument("--set") })
}

/// A path to a scene, with nothing changed.
pub(crate) fn plain_scene(path: &Path) -> SceneEntry {
    SceneEntry { path: path.to_path_buf(), ..SceneEntry::default() }
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
