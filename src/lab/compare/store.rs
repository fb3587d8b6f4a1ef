//! What has been measured so far, on disk: runs.jsonl. A line is added and reaches the disk after every run, so that a
//! comparison that was interrupted goes on where it stopped.

use super::plan::Plan;
use super::record::{ReferenceRecord, Run};
use super::schedule::Slot;
use crate::io::memory;
use crate::{Error, Result};
use rustc_hash::FxHasher;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::hash::Hasher;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Version of the lines; those of another version are not read.
const FORMAT: u32 = 2;

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Line {
    Plan { format: u32, hash: String, title: String },
    Reference { scene: String, reference: ReferenceRecord },
    Repeat { scene: String, method: String, spp: u32, equal: bool },
    Run(Box<Run>),
}

/// The file and what it holds.
pub struct Store {
    path: PathBuf,
    file: File,
    runs: Vec<Run>,
    references: BTreeMap<String, ReferenceRecord>,
    /// Whether two renders were equal, by scene, method and samples per pixel.
    repeats: BTreeMap<(String, String, u32), bool>,
}

impl Store {
    /// Opens the file of a comparison, or begins it. `hash` tells plans apart ([`plan_hash`]).
    ///
    /// # Errors
    /// [`Error::File`] where it belongs to another plan, [`Error::Parse`] where it is damaged, [`Error::Io`].
    pub fn open(path: &Path, hash: &str, title: &str) -> Result<Store> {
        let text = match text(path) {
            Err(Error::Io { error, .. }) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text?,
        };
        // What has no end of line was cut off while it was written, by a crash or a full disk.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(Error::io(path))?;
        file.set_len(whole as u64).map_err(Error::io(path))?;
        let mut store = Store {
            path: path.to_path_buf(),
            file,
            runs: Vec::new(),
            references: BTreeMap::new(),
            repeats: BTreeMap::new(),
        };
        for (index, line) in text[..whole].lines().enumerate() {
            store.read(index + 1, line, hash)?;
        }
        if whole == 0 {
            store.append(&Line::Plan { format: FORMAT, hash: hash.into(), title: title.into() })?;
        }
        Ok(store)
    }

    /// Takes in what the file of another part of the comparison holds and this does not, as what was found here.
    ///
    /// # Errors
    /// As of [`Self::open`]; and where there is no such file.
    pub(crate) fn join(&mut self, path: &Path, hash: &str) -> Result<()> {
        let text = text(path)?;
        let (mut runs, mut references) = (Vec::new(), Vec::new());
        for (number, line) in (1..).zip(text.lines()) {
            match parsed((path, number), line, hash)? {
                Line::Run(run) => runs.push(run),
                Line::Reference { scene, reference } => references.push((scene, reference)),
                Line::Plan { .. } | Line::Repeat { .. } => {}
            }
        }
        let new = references.iter().filter(|(scene, _)| !self.references.contains_key(scene)).collect::<Vec<_>>();
        new.into_iter().try_for_each(|(scene, reference)| self.add_reference(scene, reference))?;
        let key = |run: &Run| (run.seed, run.scene.clone(), run.method.clone(), run.budget.clone());
        let known: BTreeSet<_> = self.runs.iter().map(key).collect();
        runs.into_iter().filter(|run| !known.contains(&key(run))).try_for_each(|run| self.add(*run))
    }

    fn read(&mut self, number: usize, line: &str, hash: &str) -> Result<()> {
        match parsed((&self.path, number), line, hash)? {
            Line::Plan { .. } => {}
            Line::Run(run) => self.runs.push(*run),
            Line::Reference { scene, reference } => {
                self.references.insert(scene, reference);
            }
            Line::Repeat { scene, method, spp, equal } => {
                self.repeats.insert((scene, method, spp), equal);
            }
        }
        Ok(())
    }

    /// Adds a run.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(crate) fn add(&mut self, run: Run) -> Result<()> {
        let line = Line::Run(Box::new(run));
        self.append(&line)?;
        if let Line::Run(run) = line {
            self.runs.push(*run);
        }
        Ok(())
    }

    /// Sets down what a scene is compared with.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(crate) fn add_reference(&mut self, scene: &str, reference: &ReferenceRecord) -> Result<()> {
        self.append(&Line::Reference { scene: scene.into(), reference: reference.clone() })?;
        self.references.insert(scene.into(), reference.clone());
        Ok(())
    }

    /// Sets down whether two renders of a scene and method with the same seed and `spp` samples per pixel were equal.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(crate) fn add_repeat(&mut self, scene: &str, method: &str, spp: u32, equal: bool) -> Result<()> {
        let (scene, method) = (scene.to_owned(), method.to_owned());
        self.append(&Line::Repeat { scene: scene.clone(), method: method.clone(), spp, equal })?;
        self.repeats.insert((scene, method, spp), equal);
        Ok(())
    }

    /// Whether two such renders were equal; `None` where that was not tried.
    pub(crate) fn repeatable(&self, scene: &str, method: &str, spp: u32) -> Option<bool> {
        self.repeats.get(&(scene.to_owned(), method.to_owned(), spp)).copied()
    }

    fn append(&mut self, line: &Line) -> Result<()> {
        let text = serde_json::to_string(line).map_err(|e| Error::file(&self.path, e.to_string()))? + "\n";
        let write = |file: &mut File| file.write_all(text.as_bytes()).and_then(|()| file.sync_data());
        write(&mut self.file).map_err(Error::io(&self.path))
    }

    /// The run of a slot, where it is there.
    pub(crate) fn find(&self, plan: &Plan, slot: &Slot) -> Option<&Run> {
        let (scene, budget) = (plan.scenes[slot.scene].name(), plan.budgets[slot.budget].name());
        let method = &plan.methods[slot.method].name;
        self.runs.iter().find(|r| r.seed == slot.seed && r.scene == scene && r.budget == budget && r.method == *method)
    }

    /// The largest relMSE of a method's runs on a scene, infinite where one has none.
    pub(crate) fn worst(&self, scene: &str, method: &str, budget: &str) -> Option<f64> {
        let own = self.runs.iter().filter(|r| r.scene == scene && r.method == method && r.budget == budget);
        own.map(Run::badness).max_by(f64::total_cmp)
    }

    pub(crate) fn reference(&self, scene: &str) -> Option<&ReferenceRecord> {
        self.references.get(scene)
    }
}

fn text(path: &Path) -> Result<String> {
    let bytes = memory::read_file(path, u64::MAX)?;
    String::from_utf8(bytes).map_err(|_| Error::file(path, "damaged: its text is not UTF-8"))
}

/// A line of a comparison's file, of which the first is the plan.
fn parsed((path, number): (&Path, usize), line: &str, hash: &str) -> Result<Line> {
    let malformed = |e: serde_json::Error| Error::parse(path, number, e.column(), e.to_string());
    match (number, serde_json::from_str(line).map_err(malformed)?) {
        (1, Line::Plan { format: FORMAT, hash: found, title }) if found == hash => {
            Ok(Line::Plan { format: FORMAT, hash: found, title })
        }
        (1, Line::Plan { .. }) => {
            let message = "it holds the runs of another comparison, or of this one by another build or instruction set: choose another folder, \
                 or --restart to delete them";
            Err(Error::file(path, message))
        }
        (1, _) | (_, Line::Plan { .. }) => {
            Err(Error::parse(path, number, 0, "the plan must be the first line, and only that"))
        }
        (_, line) => Ok(line),
    }
}

/// Tells plans apart by all that decides what a run measures: scenes (`contents` are hashes of what was loaded for each
/// method), settings, budgets and seed, and this program's version. The number of runs is left out: it may grow.
pub(crate) fn plan_hash(plan: &Plan, contents: &[String]) -> String {
    let mut hasher = FxHasher::default();
    let methods: Vec<&str> = plan.methods.iter().map(|m| m.name.as_str()).collect();
    let scenes: Vec<_> = plan.scenes.iter().map(|s| (s.name(), &s.reference)).collect();
    let text = format!("{methods:?} {scenes:?} {:?} {} {contents:?}", plan.budgets, plan.seed);
    hasher.write(text.as_bytes());
    hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
    format!("{:016x}", hasher.finish())
}
