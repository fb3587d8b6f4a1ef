//! One picture by many machines: the plan, those who carry it out, and what they make of it.
//!
//! The package `hyperqueue` (PyPI) is needed for one of these, in the Python that `$PHOTOTAXIS_PYTHON` names, or `python3`. Without it
//! that is skipped, and says so.

use super::{folder, names, phototaxis, program, scene, stderr};
use phototaxis::image::exr::read_layers;
use std::collections::BTreeMap;
use std::fs::{read_to_string, write};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Plans a small render into the folder `name`, for a guide that learns in two iterations.
fn plan(here: &Path, name: &str, machines: &str, more: &[&str]) -> String {
    let door = scene("door.toml");
    let plan = ["farm", "plan", door.to_str().unwrap(), "--machines", machines, "--learn", "3", "-o", name];
    let options = ["--", "--size", "24x14", "--guide", "adaptive", "--threads", "1", "-q"];
    stderr(phototaxis(here).args(plan).args(more).args(options).assert().success().get_output())
}

type Channels = BTreeMap<String, Vec<f32>>;

fn picture(folder: &Path) -> Channels {
    read_layers(&folder.join("picture.exr")).unwrap().channels.into_iter().collect()
}

/// Does all tasks of a plan one after the other.
fn carry_out(folder: &Path) {
    let text = read_to_string(folder.join("plan.json")).unwrap();
    let graph: serde_json::Value = serde_json::from_str(&text).unwrap();
    for task in graph["tasks"].as_array().unwrap() {
        phototaxis(folder).args(["farm", "task", ".", task["name"].as_str().unwrap()]).assert().success();
    }
}

/// Puts a program of this text into a folder of programs.
fn stub(here: &Path, name: &str, text: &str) -> PathBuf {
    let path = here.join(name);
    write(&path, text).unwrap();
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
    path
}

/// Does the jobs of an array at once, if the jobs that it depends on are done.
const SBATCH: &str = r#"#!/usr/bin/env bash
set -euo pipefail
here=$(dirname "$0")
tasks=0 after='' command='' log=/dev/null
while (($#)); do
    case $1 in
        --array=1-*) tasks=${1#--array=1-} ;;
        --dependency=afterok:*) after=${1#*:} ;;
        --output=*) log=${1#--output=} ;;
        --wrap) shift; command=$1 ;;
        --partition=long) touch "$here/partition" ;;
    esac
    shift
done
[ -z "$after" ] || [ -e "$here/done-$after" ]
for ((k = 1; k <= tasks; k++)); do
    SLURM_ARRAY_TASK_ID=$k bash -c "$command" 2>"${log//%a/$k}"
done
job=$(($(ls "$here" | grep -c ^done-) + 1)) || job=1
touch "$here/done-$job"
echo "$job;cluster"
"#;

/// Submits by running all commands of a job's file, one after the other.
const HQ: &str = r#"#!/usr/bin/env bash
set -euo pipefail
case "$*" in
    'server info' | 'job wait 7') ;;
    '--output-mode=quiet job submit-file '*)
        sed -n 's/^command = \[\(.*\)\]$/\1/p' "$4" | sed 's/, / /g' | while read -r line; do eval "$line" 2>/dev/null || true; done
        echo 7 ;;
    *) exit 9 ;;
esac
"#;

#[test]
fn any_number_of_machines_makes_the_same_picture_by_any_engine() {
    let here = folder();
    let at = |name: &str| here.path().join(name);
    let said = plan(here.path(), "one", "1", &["--spp", "12"]);
    assert!(
        said.contains("7 tasks: the guide learns from 3 samples per pixel in 2 iterations; then 2 films"),
        "{said}"
    );
    carry_out(&at("one"));
    assert_eq!(names(&at("one/guides")), ["1.guide", "2.guide"]);

    // Slurm
    plan(here.path(), "a farm's", "3", &["--spp", "12"]);
    std::fs::create_dir(at("bin")).unwrap();
    stub(&at("bin"), "sbatch", SBATCH);
    let path = format!("{}:{}", at("bin").display(), std::env::var("PATH").unwrap());
    assert!(Command::new("bash").arg("-n").arg(at("a farm's/slurm.sh")).status().unwrap().success());
    let slurm = || Command::new(at("a farm's/slurm.sh")).arg("--partition=long").env("PATH", &path).output().unwrap();
    let output = slurm();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(at("bin/partition").exists() && names(&at("a farm's/films")).len() == 6);
    assert!(picture(&at("one")) == picture(&at("a farm's")), "three machines by Slurm");
    let guides = ["one", "a farm's"].map(|name| std::fs::read(at(name).join("guides/2.guide")).unwrap());
    assert!(guides[0] == guides[1], "the guide");

    // hq
    plan(here.path(), "hq", "2", &["--spp", "12"]);
    let hq = stub(&at("bin"), "hyperqueue", HQ);
    let run = || phototaxis(here.path()).args(["farm", "run", "hq"]).env("PHOTOTAXIS_HQ", &hq).assert();
    let said = stderr(run().success().get_output());
    assert!(
        said.contains("2 of 2 iterations learnt, 4 of 4 films, 10 of 10 tasks") && said.contains("to learn"),
        "{said}"
    );
    assert!(picture(&at("one")) == picture(&at("hq")), "two machines by hq");

    // what failed is done again, and nothing else
    let kept = at("hq/films/1.film");
    let made = kept.metadata().unwrap().modified().unwrap();
    std::fs::remove_file(at("hq/films/2.film")).unwrap();
    std::fs::remove_file(at("hq/picture.exr")).unwrap();
    std::fs::remove_file(at("hq/figures.json")).unwrap();
    write(at("hq/guides/2.guide"), "no guide").unwrap();
    let said = stderr(run().code(1).get_output());
    assert!(said.contains("logs/film-2.log tells of one that failed"), "{said}");
    std::fs::copy(at("one/guides/2.guide"), at("hq/guides/2.guide")).unwrap();
    run().success();
    assert!(picture(&at("one")) == picture(&at("hq")) && kept.metadata().unwrap().modified().unwrap() == made);
}

#[test]
fn plans_that_cannot_be_carried_out_are_refused() {
    let here = folder();
    let door = scene("door.toml");
    let refused = |more: &[&str], code: i32, text: &str| {
        let plan = ["farm", "plan", door.to_str().unwrap(), "--machines", "2", "-o", "x"];
        let said = stderr(phototaxis(here.path()).args(plan).args(more).assert().code(code).get_output());
        assert!(said.contains(text), "{said}");
        assert!(!here.path().join("x").exists(), "nothing is left: {more:?}");
    };
    refused(&["--spp", "2"], 1, "too few for a guide");
    refused(&["--spp", "9", "--", "--guide", "sdtree"], 1, "--learn-out needs guiding.method auto, adaptive or grid");
    refused(&["--time", "1ms", "--", "--size", "8x8"], 1, "it is over before the first sample");
    refused(&["--spp", "9", "--time", "9"], 2, "cannot be used with");
    refused(&["--spp", "9", "--learn", "4", "--", "--guide", "none"], 1, "--learn needs a guide");
    refused(&["--spp", "9", "--", "--adaptive"], 1, "--part cannot render adaptively");
    refused(&["--spp", "9", "--", "--time", "9"], 2, "cannot be used with");
    refused(&["--spp", "9", "--", "--set", "film.widht=3"], 1, "widht");
    refused(&["--spp", "9", "--picture", "a.jpg"], 1, "a.jpg");
    plan(here.path(), "y", "2", &["--spp", "9"]);
    let plan = ["farm", "plan", door.to_str().unwrap(), "--machines", "2", "--spp", "9", "-o", "y"];
    let said = stderr(phototaxis(here.path()).args(plan).assert().code(1).get_output());
    assert!(said.contains("there is a plan already"), "{said}");
    let said = stderr(phototaxis(here.path()).args(["farm", "task", "y", "film-9"]).assert().code(1).get_output());
    assert!(said.contains("there is no task film-9"), "{said}");
    let run = |folder: &str| {
        let mut command = phototaxis(here.path());
        command.args(["farm", "run", folder]).env("PATH", "/nowhere").env("PHOTOTAXIS_PYTHON", "/nowhere/python");
        stderr(command.assert().code(1).get_output())
    };
    assert!(run("y").contains("HyperQueue is not here"), "{}", run("y"));
    assert!(run("z").contains("phototaxis farm plan writes it"), "{}", run("z"));
}

/// A process that is there until it is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        kill(self.0.id());
        _ = self.0.wait();
    }
}

/// SIGKILL for a process and its children, none of which has a chance to clean up.
fn kill(process: u32) {
    let all = children(process).into_iter().chain([process]).map(|id| id.to_string());
    _ = Command::new("kill").arg("-9").args(all).stderr(Stdio::null()).status();
}

fn children(process: u32) -> Vec<u32> {
    let tasks = std::fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    let of_task = |task: std::fs::DirEntry| read_to_string(task.path().join("children")).unwrap_or_default();
    tasks
        .flat_map(|task| of_task(task).split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<_>>())
        .collect()
}

/// A process of the cluster, once it is ready.
fn cluster(python: &Path, arguments: &[&Path]) -> Running {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/cli/hyperqueue_cluster.py");
    let mut command = Command::new(python);
    command.arg(script).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut running = Running(command.spawn().unwrap());
    let lines = BufReader::new(running.0.stdout.take().unwrap()).lines();
    assert!(lines.map_while(Result::ok).any(|line| line == "ready"), "the cluster does not start");
    running
}

#[test]
fn a_worker_that_is_killed_costs_time_and_no_bit_of_the_picture() {
    let python = PathBuf::from(std::env::var_os("PHOTOTAXIS_PYTHON").unwrap_or_else(|| "python3".into()));
    let has = Command::new(&python).args(["-c", "import hyperqueue"]).stderr(Stdio::null()).status();
    if !has.is_ok_and(|status| status.success()) {
        eprintln!("SKIPPED: {} has no package hyperqueue (pip install hyperqueue)", python.display());
        return;
    }
    let here = folder();
    let at = |name: &str| here.path().join(name);
    plan(here.path(), "one", "1", &["--spp", "2k"]);
    carry_out(&at("one"));
    plan(here.path(), "four", "4", &["--spp", "2k"]);
    std::fs::create_dir(at("server")).unwrap();
    let _server = cluster(&python, &[Path::new("server"), &at("server")]);
    let workers: Vec<Running> = (0..4)
        .map(|k| {
            let own = at(&format!("worker-{k}"));
            std::fs::create_dir(&own).unwrap();
            cluster(&python, &[Path::new("worker"), &at("server"), &own])
        })
        .collect();
    let mut command = Command::new(program());
    command.args(["farm", "run", "four", "--preview", "now.exr", "--every", "1ms"]).current_dir(here.path());
    command.env("PHOTOTAXIS_PYTHON", &python).env("HQ_SERVER_DIR", at("server")).env("PATH", "/usr/bin:/bin");
    let mut run = Running(command.stderr(Stdio::piped()).spawn().unwrap());
    let start = Instant::now();
    let killed = loop {
        let busy = workers.iter().find(|worker| !children(worker.0.id()).is_empty());
        match busy.filter(|_| !names(&at("four/films")).is_empty()) {
            Some(worker) => break worker,
            None => assert!(start.elapsed() < Duration::from_secs(120), "no film is ever made"),
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(names(&at("four/films")).len() < 8, "it was over before anybody was killed");
    kill(killed.0.id());
    while run.0.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(300), "it never ends");
        std::thread::sleep(Duration::from_millis(50));
    }
    let said: Vec<String> = BufReader::new(run.0.stderr.take().unwrap()).lines().map_while(Result::ok).collect();
    assert!(run.0.wait().unwrap().success(), "{said:?}");
    assert!(picture(&at("one")) == picture(&at("four")), "the picture is another");
    let partial = read_layers(&at("now.exr")).unwrap();
    assert!(partial.channels.contains_key("R"));
}
