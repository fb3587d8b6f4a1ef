//! Tasks, the files that they read and write, and which come after which.

use anyhow::{Context as _, Result, ensure};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const VERSION: u32 = 1;

/// The name of a graph's file in the folder of a render.
const FILE: &str = "plan.json";

/// The name of the file that says what the picture took.
pub(super) const FIGURES: &str = "figures.json";

/// All there is to do for a render, or a comparison. Paths are relative to its folder, in which tasks run.
#[derive(Serialize, Deserialize)]
pub(in crate::cli) struct Graph {
    version: u32,
    pub machines: u32,
    /// Samples per pixel of the picture; 0 where it makes none.
    pub samples: u32,
    /// Samples per pixel of each iteration that the guide learns from.
    pub learning: Vec<u32>,
    /// The pictures, or what else there is at the end.
    pub pictures: Vec<PathBuf>,
    /// Each after all that it depends on, those of a stage one after the other.
    pub tasks: Vec<Task>,
}

/// One command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::cli) struct Task {
    /// Its stage and its number in that, from 1.
    pub name: String,
    /// Tasks of a stage may run at the same time.
    pub stage: String,
    pub command: Vec<String>,
    pub inputs: Vec<PathBuf>,
    pub outputs: Vec<PathBuf>,
    /// Names of the tasks that make its inputs.
    pub after: Vec<String>,
}

/// What a graph is made of.
pub(super) struct Work {
    /// The program, and what it is to render with which options.
    pub program: String,
    pub scene: String,
    pub options: Vec<String>,
    pub machines: u32,
    /// As in [`Graph`].
    pub samples: u32,
    pub learning: Vec<u32>,
    pub pictures: Vec<PathBuf>,
    /// Films that share the samples of the picture.
    pub films: u32,
}

impl Graph {
    pub(super) fn of(work: Work) -> Graph {
        let mut tasks = Vec::new();
        let mut guide = None;
        for (k, &samples) in (1..).zip(&work.learning) {
            let parts = work.machines.min(samples);
            let lesson = |n: u32| PathBuf::from(format!("lessons/{k}-{n}.lesson"));
            let stage = format!("learn-{k}");
            add_parts(&mut tasks, &work, &stage, (samples, parts), guide.as_deref(), "--learn-out", &lesson);
            let next = PathBuf::from(format!("guides/{k}.guide"));
            tasks.push(work.lessons(k, (1..=parts).map(lesson).collect(), guide.as_deref(), &next));
            guide = Some(next);
        }
        let film = |n: u32| PathBuf::from(format!("films/{n}.film"));
        add_parts(&mut tasks, &work, "film", (work.samples, work.films), guide.as_deref(), "--film-out", &film);
        tasks.push(work.merge((1..=work.films).map(film).collect()));
        connect(&mut tasks);
        let Work { machines, samples, learning, pictures, .. } = work;
        Graph { version: VERSION, machines, samples, learning, pictures, tasks }
    }

    /// Of tasks that render no single picture; `results` are what the last of them writes.
    #[cfg_attr(not(feature = "lab"), allow(dead_code))]
    pub fn of_tasks(mut tasks: Vec<Task>, results: Vec<PathBuf>) -> Graph {
        connect(&mut tasks);
        Graph { version: VERSION, machines: 1, samples: 0, learning: Vec::new(), pictures: results, tasks }
    }

    /// Whether it makes one picture, of films.
    pub fn is_of_picture(&self) -> bool {
        self.samples > 0
    }

    /// The stages, in their order, and how many tasks each has.
    pub fn stages(&self) -> Vec<(&str, usize)> {
        self.tasks.chunk_by(|a, b| a.stage == b.stage).map(|tasks| (tasks[0].stage.as_str(), tasks.len())).collect()
    }

    /// Reads that of a folder.
    pub fn read(folder: &Path) -> Result<Graph> {
        let path = Graph::path(folder);
        let text = std::fs::read_to_string(&path);
        let text = text.with_context(|| format!("{}: phototaxis farm plan writes it", path.display()))?;
        let graph: Graph = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        let (name, version) = (path.display(), graph.version);
        ensure!(version == VERSION, "{name}: it is of version {version} of the format; this program reads {VERSION}");
        Ok(graph)
    }

    pub fn path(folder: &Path) -> PathBuf {
        folder.join(FILE)
    }
}

impl Task {
    /// Whether all that it makes is there. Files are renamed to their names when they are whole.
    pub fn is_done(&self, folder: &Path) -> bool {
        self.outputs.iter().all(|path| folder.join(path).is_file())
    }

    /// Whether all that it needs is there.
    pub fn is_ready(&self, folder: &Path) -> bool {
        self.inputs.iter().all(|path| folder.join(path).is_file())
    }
}

/// Adds the parts of a range of samples: `to` says what each writes, by the option `out`.
fn add_parts(
    tasks: &mut Vec<Task>,
    work: &Work,
    stage: &str,
    (samples, parts): (u32, u32),
    guide: Option<&Path>,
    out: &str,
    to: &dyn Fn(u32) -> PathBuf,
) {
    for n in 1..=parts {
        let mut command = vec![work.program.clone(), "render".into(), work.scene.clone()];
        command.extend(work.options.iter().cloned());
        command.extend(["--spp".into(), samples.to_string(), "--part".into(), format!("{n}/{parts}")]);
        command.extend(guide.iter().flat_map(|guide| ["--guide-in".into(), text(guide)]));
        command.extend([out.into(), text(&to(n)), "--progress".into(), "none".into()]);
        let inputs = guide.map(Path::to_path_buf).into_iter().collect();
        tasks.push(Task::new(stage, n, command, inputs, vec![to(n)]));
    }
}

impl Work {
    /// The guide learns from the lessons of iteration `k`.
    fn lessons(&self, k: usize, lessons: Vec<PathBuf>, guide: Option<&Path>, next: &Path) -> Task {
        let mut command = vec![self.program.clone(), "guide".into(), "merge".into()];
        command.extend(lessons.iter().map(|path| text(path)));
        command.extend(guide.iter().flat_map(|guide| ["--guide-in".into(), text(guide)]));
        command.extend(["-o".into(), text(next)]);
        let inputs = lessons.into_iter().chain(guide.map(Path::to_path_buf)).collect();
        Task::new(&format!("guide-{k}"), 1, command, inputs, vec![next.to_path_buf()])
    }

    /// All films become the pictures.
    fn merge(&self, films: Vec<PathBuf>) -> Task {
        let mut command = vec![self.program.clone(), "merge".into()];
        command.extend(films.iter().map(|path| text(path)));
        command.extend(self.pictures.iter().flat_map(|path| ["-o".into(), text(path)]));
        command.extend(["--json".into(), FIGURES.into()]);
        let outputs = self.pictures.iter().cloned().chain([FIGURES.into()]).collect();
        Task::new("merge", 1, command, films, outputs)
    }
}

impl Task {
    pub fn new(stage: &str, number: u32, command: Vec<String>, inputs: Vec<PathBuf>, outputs: Vec<PathBuf>) -> Task {
        Task { name: format!("{stage}-{number}"), stage: stage.into(), command, inputs, outputs, after: Vec::new() }
    }
}

/// Has each task come after those that make its inputs.
fn connect(tasks: &mut [Task]) {
    for at in 0..tasks.len() {
        let (before, rest) = tasks.split_at_mut(at);
        let needed = |task: &&Task| task.outputs.iter().any(|output| rest[0].inputs.contains(output));
        rest[0].after = before.iter().filter(needed).map(|task| task.name.clone()).collect();
    }
}

/// Paths of a graph are made of text.
fn text(path: &Path) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn graph(machines: u32, learning: &[u32]) -> Graph {
        Graph::of(Work {
            program: "phototaxis".into(),
            scene: "/scenes/a.toml".into(),
            options: vec!["--seed".into(), "3".into()],
            machines,
            samples: 64,
            learning: learning.to_vec(),
            pictures: vec!["picture.exr".into()],
            films: 2 * machines,
        })
    }

    #[test]
    fn an_iteration_has_as_many_parts_as_machines_or_samples() {
        let graph = graph(3, &[1, 2, 4]);
        let expected = [("learn-1", 1), ("guide-1", 1), ("learn-2", 2), ("guide-2", 1), ("learn-3", 3), ("guide-3", 1)];
        assert_eq!(graph.stages()[..6], expected);
        assert_eq!(graph.stages()[6..], [("film", 6), ("merge", 1)]);
    }

    #[test]
    fn each_task_comes_after_all_that_makes_what_it_reads() {
        for graph in [graph(3, &[1, 2, 4]), graph(2, &[])] {
            let mut made = BTreeSet::new();
            for task in &graph.tasks {
                assert!(task.inputs.iter().all(|input| made.contains(input)), "{task:?}");
                let makers = graph.tasks.iter().filter(|other| other.outputs.iter().any(|o| task.inputs.contains(o)));
                assert_eq!(task.after, makers.map(|other| other.name.clone()).collect::<Vec<_>>(), "{task:?}");
                assert!(
                    task.outputs.iter().all(|output| made.insert(output.clone())),
                    "{task:?} writes what another does"
                );
            }
        }
    }

    #[test]
    fn commands_are_those_that_one_would_type() {
        let graph = graph(2, &[1, 2]);
        let command = |name: &str| graph.tasks.iter().find(|task| task.name == name).unwrap().command.join(" ");
        assert_eq!(
            command("learn-2-2"),
            "phototaxis render /scenes/a.toml --seed 3 --spp 2 --part 2/2 --guide-in guides/1.guide --learn-out lessons/2-2.lesson \
             --progress none"
        );
        assert_eq!(
            command("guide-2-1"),
            "phototaxis guide merge lessons/2-1.lesson lessons/2-2.lesson --guide-in guides/1.guide -o guides/2.guide"
        );
        assert!(command("film-4").contains("--spp 64 --part 4/4 --guide-in guides/2.guide --film-out films/4.film"));
        assert!(command("merge-1").ends_with("films/4.film -o picture.exr --json figures.json"));
    }
}
