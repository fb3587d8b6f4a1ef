//! The graph as those who run it want it: a job's file for HyperQueue, and a script that submits to Slurm.

use super::graph::Graph;
use serde::Serialize;
use std::path::Path;

/// A job of HyperQueue: <https://it4innovations.github.io/hyperqueue/stable/jobs/jobfile/>.
#[derive(Serialize)]
struct Job {
    name: String,
    /// The first task that fails ends all: no other could make up for it.
    max_fails: u32,
    task: Vec<JobTask>,
}

#[derive(Serialize)]
struct JobTask {
    id: usize,
    stdout: &'static str,
    stderr: String,
    command: Vec<String>,
    deps: Vec<usize>,
    request: Vec<Request>,
}

#[derive(Serialize)]
struct Request {
    resources: Resources,
}

#[derive(Serialize)]
struct Resources {
    cpus: &'static str,
}

/// The command of a task on any machine that has the folder.
fn command(program: &str, folder: &Path, task: &str) -> Vec<String> {
    [program, "farm", "task", &folder.display().to_string(), task].map(str::to_string).to_vec()
}

/// What `hq job submit-file` takes. Each task has a worker for itself.
pub(super) fn hyperqueue(graph: &Graph, program: &str, folder: &Path) -> String {
    let id = |name: &String| graph.tasks.iter().position(|task| task.name == *name);
    let tasks = graph.tasks.iter().enumerate().map(|(k, task)| JobTask {
        id: k,
        stdout: "none",
        stderr: folder.join(format!("logs/{}.log", task.name)).display().to_string(),
        command: command(program, folder, &task.name),
        deps: task.after.iter().filter_map(id).collect(),
        request: vec![Request { resources: Resources { cpus: "all" } }],
    });
    let name = folder.file_name().map_or_else(|| "phototaxis".into(), |name| name.to_string_lossy().into_owned());
    let job = Job { name, max_fails: 1, task: tasks.collect() };
    toml::to_string(&job).expect("a job is texts, numbers and lists of them")
}

/// A script that submits each stage as an array that begins when the stage before is done.
pub(super) fn slurm(graph: &Graph, program: &str, folder: &Path) -> String {
    let stages = graph.stages().into_iter().map(|(stage, tasks)| format!("submit {stage} {tasks}\n"));
    SLURM
        .replace("{program}", &quoted(program))
        .replace("{folder}", &quoted(&folder.display().to_string()))
        .replace("{stages}", &stages.collect::<String>())
}

/// A word of a shell.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

const SLURM: &str = r#"#!/usr/bin/env bash
# Submits the render to Slurm: one array of jobs for each stage, which begins when all jobs of the stage before have ended well.
# Arguments are for sbatch, for example: slurm.sh --partition=long --cpus-per-task=32
# Jobs whose files are there already end at once, so that the script may be run again after a failure.
set -euo pipefail

program={program}
folder={folder}
options=("$@")
after=()

submit() {
    local stage=$1 tasks=$2 job task
    task="$(printf '%q ' "$program" farm task "$folder")$stage-\$SLURM_ARRAY_TASK_ID"
    job=$(sbatch --parsable --job-name="$stage" --array="1-$tasks" --requeue --kill-on-invalid-dep=yes \
        --output="$folder/logs/$stage-%a.log" "${after[@]}" "${options[@]}" --wrap "$task")
    after=(--dependency="afterok:${job%%;*}")
    echo "$stage: job ${job%%;*}, $tasks tasks"
}

{stages}"#;
