//! A comparison as tasks, which many machines do: `farm run`, HyperQueue and Slurm take them.
//!
//! A task is a round: one run of every method and budget on a scene, in turns, so that all methods have the same machine under them.
//! What it finds it writes into a file of its own, in the form of `runs.jsonl`; where all are there, the comparison takes them in.

use super::CompareArguments;
use crate::cli::farm::{Graph, Task, write_graph};
use crate::cli::progress::say;
use crate::lab::compare::executor::RenderExecutor;
use crate::lab::compare::plan::Plan;
use crate::lab::compare::scene_cache::SceneCache;
use crate::lab::compare::schedule::{Executor, Slot, order};
use crate::lab::compare::store::Store;
use crate::render::Stop;
use anyhow::{Context as _, Result, ensure};
use std::path::{Path, PathBuf};

/// Where tasks write what they find, within the folder of the comparison.
const FOLDER: &str = "runs";

/// What the comparison writes at its end.
const REPORT: [&str; 2] = ["report.html", "results.json"];

/// What one task does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Share {
    /// The reference of a scene.
    Reference(usize),
    /// Run `run` of all methods and budgets on a scene.
    Round { scene: usize, run: u32 },
}

impl Share {
    /// Stage and number, from 1.
    fn place(self, plan: &Plan) -> (&'static str, u32) {
        match self {
            Share::Reference(scene) => ("reference", scene as u32 + 1),
            Share::Round { scene, run } => ("round", scene as u32 * plan.runs + run + 1),
        }
    }

    fn name(self, plan: &Plan) -> String {
        let (stage, number) = self.place(plan);
        format!("{stage}-{number}")
    }

    /// Its file, within the folder of the comparison.
    fn file(self, plan: &Plan) -> PathBuf {
        Path::new(FOLDER).join(format!("{}.jsonl", self.name(plan)))
    }

    fn all(plan: &Plan) -> Vec<Share> {
        let scenes = 0..plan.scenes.len();
        let rounds = scenes.clone().flat_map(|scene| (0..plan.runs).map(move |run| Share::Round { scene, run }));
        scenes.map(Share::Reference).chain(rounds).collect()
    }

    fn scene(self) -> usize {
        match self {
            Share::Reference(scene) | Share::Round { scene, .. } => scene,
        }
    }

    /// The runs that it makes.
    fn slots(self, plan: &Plan) -> Vec<Slot> {
        let Share::Round { scene, run } = self else { return Vec::new() };
        order(plan).into_iter().filter(|slot| (slot.scene, slot.run) == (scene, run)).collect()
    }
}

/// Writes down what there is to do.
pub(super) fn write(arguments: &CompareArguments, plan: &Plan) -> Result<()> {
    ensure!(plan.gallery.is_none(), "--tasks: a gallery looks at all runs of a scene together, on one machine");
    let folder = std::path::absolute(&arguments.output)?;
    let program = std::env::current_exe()?.to_str().context("a plan takes names in UTF-8")?.to_string();
    let command = |more: &[&str]| -> Result<Vec<String>> {
        let words = arguments.words()?.into_iter().chain(more.iter().map(ToString::to_string));
        Ok([program.clone(), "compare".into()].into_iter().chain(words).collect())
    };
    let mut tasks = Vec::new();
    for share in Share::all(plan) {
        let inputs = match share {
            Share::Reference(_) => Vec::new(),
            Share::Round { scene, .. } => vec![Share::Reference(scene).file(plan)],
        };
        let (stage, number) = share.place(plan);
        let command = command(&["--task", &share.name(plan), "--quiet"])?;
        tasks.push(Task::new(stage, number, command, inputs, vec![share.file(plan)]));
    }
    let found = tasks.iter().flat_map(|task| task.outputs.clone()).collect();
    tasks.push(Task::new("report", 1, command(&["--quiet"])?, found, REPORT.map(PathBuf::from).to_vec()));
    let graph = Graph::of_tasks(tasks, REPORT.iter().map(|file| folder.join(file)).collect());
    for file in REPORT.iter().map(|file| folder.join(file)).filter(|file| file.exists()) {
        // it is of fewer runs
        std::fs::remove_file(&file).with_context(|| file.display().to_string())?;
    }
    write_graph(&graph, &program, &folder)?;
    if !arguments.quiet {
        let stages: Vec<String> =
            graph.stages().iter().map(|(stage, tasks)| format!("{tasks} of stage {stage}")).collect();
        say(&format!("{} tasks: {}", graph.tasks.len(), stages.join(", ")));
        say(&format!("phototaxis farm run {} does them", arguments.output.display()));
    }
    Ok(())
}

/// Does one of them; `false` where it was told to stop.
pub(super) fn carry_out(
    arguments: &CompareArguments,
    plan: &Plan,
    scene_cache: &SceneCache,
    name: &str,
    stop: &Stop,
) -> Result<bool> {
    let share = Share::all(plan).into_iter().find(|share| share.name(plan) == name);
    let share = share.with_context(|| format!("--task {name}: this comparison has no such task"))?;
    let (folder, hash) = (&arguments.output, scene_cache.plan_hash(plan));
    let whole = folder.join(share.file(plan));
    let partial = whole.with_extension("part");
    let parent = whole.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
    if partial.exists() {
        // of one that was ended before
        std::fs::remove_file(&partial).with_context(|| partial.display().to_string())?;
    }
    let mut store = Store::open(&partial, &hash, &plan.title)?;
    if let Share::Round { scene, .. } = share {
        store.join(&folder.join(Share::Reference(scene).file(plan)), &hash)?;
    }
    let mut listener = |_: crate::lab::compare::executor::Event| ();
    let mut executor =
        RenderExecutor::new(plan, scene_cache, folder, arguments.allow_noisy_reference, stop, &mut listener);
    let mut is_whole = executor.reference(share.scene(), &mut store)? && executor.prepare(share.scene(), &mut store)?;
    for slot in share.slots(plan) {
        let run = if is_whole { executor.run(&slot)? } else { None };
        is_whole = run.is_some();
        run.map_or(Ok(()), |run| store.add(run))?;
    }
    if is_whole {
        std::fs::rename(&partial, &whole).with_context(|| whole.display().to_string())?;
    }
    Ok(is_whole)
}

/// Takes in what tasks have found.
pub(super) fn take_in(folder: &Path, store: &mut Store, hash: &str) -> Result<()> {
    let folder = folder.join(FOLDER);
    let Ok(entries) = std::fs::read_dir(&folder) else { return Ok(()) };
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>();
    let mut paths = paths.with_context(|| folder.display().to_string())?;
    paths.sort();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "jsonl"));
    paths.iter().try_for_each(|path| Ok(store.join(path, hash)?))
}

/// Forgets what tasks have found.
pub(super) fn forget(folder: &Path) -> Result<()> {
    let folder = folder.join(FOLDER);
    match std::fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| folder.display().to_string())
        }
        _ => Ok(()),
    }
}

impl CompareArguments {
    /// The same comparison, asked for from any folder.
    fn words(&self) -> Result<Vec<String>> {
        let absolute = |path: &Path| -> Result<String> {
            let path = std::path::absolute(path)?;
            path.to_str()
                .map(str::to_string)
                .with_context(|| format!("{}: a plan takes names in UTF-8", path.display()))
        };
        let scenes = self.scenes.iter().map(|path| absolute(path)).collect::<Result<Vec<_>>>()?;
        let mut words = Vec::new();
        let mut say = |option: &str, values: &[String]| {
            words.extend(values.iter().flat_map(|value| [option.to_string(), value.clone()]));
        };
        let texts = |values: &[String]| values.to_vec();
        let path = |path: &Option<PathBuf>| path.as_deref().map(absolute).transpose().map(Vec::from_iter);
        fn of<T: ToString>(values: impl IntoIterator<Item = T>) -> Vec<String> {
            values.into_iter().map(|value| value.to_string()).collect()
        }
        say("--plan", &path(&self.plan)?);
        say("--only", &texts(&self.only));
        say("--methods", &texts(&self.methods));
        say("--time", &of(&self.time));
        say("--spp", &of(&self.spp));
        say("--runs", &of(self.runs));
        say("--seed", &of(self.seed));
        say("--baseline", &of(self.baseline.clone()));
        say("--reference", &path(&self.reference)?);
        say("--reference-noise", &of(self.reference_noise));
        say("--reference-time", &of(self.reference_time));
        say("--references", &path(&self.references)?);
        say("--set", &texts(&self.set));
        say("--title", &of(self.title.clone()));
        say("--output", &[absolute(&self.output)?]);
        words.extend(self.machine.words());
        let flags = [("--allow-noisy-reference", self.allow_noisy_reference), ("--no-images", self.no_images)];
        words.extend(flags.iter().filter(|(_, given)| *given).map(|(flag, _)| flag.to_string()));
        words.extend(scenes);
        Ok(words)
    }
}
