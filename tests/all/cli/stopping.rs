//! Renders that end by the clock or by a signal.

use super::{TINY, folder, names, phototaxis, program, scene};
use phototaxis::image::exr::{ExrFile, read_layers};
use serde_json::Value;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

#[test]
fn time_ends_a_render() {
    let here = folder();
    let arguments = ["--time", "1", "-o", "a.exr", "--json", "-"];
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments);
    let output = command.assert().code(0).get_output().clone();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let seconds = report["render_wall_seconds"].as_f64().unwrap();
    // A pass of this picture takes a millisecond; the rest is room for a machine that is busy with other tests.
    assert!((0.9..2.0).contains(&seconds), "{seconds} s");
    assert!(report["spp"].as_u64().unwrap() > 64, "time, not the scene file's spp, decides: {report}");
}

#[test]
fn noise_ends_a_render() {
    let here = folder();
    let report = |arguments: &[&str]| -> Value {
        let mut command = phototaxis(here.path());
        command.arg("render").arg(scene("cornell.toml")).args(TINY).args(["-q", "-o", "a.exr", "--json", "-"]);
        serde_json::from_slice(&command.args(arguments).assert().code(0).get_output().stdout).unwrap()
    };
    let good = report(&["--noise", "15%"]);
    let error = good["relative_error"].as_f64().unwrap();
    assert!((0.05..=0.15).contains(&error) && good["spp"].as_u64().unwrap() >= 16, "{good}");
    let few = report(&["--noise", "0.000001", "--spp", "18"]);
    assert!(few["spp"] == 18 && few["relative_error"].as_f64().unwrap() > 0.01, "{few}");
    assert!(report(&["--spp", "18"])["relative_error"].is_null());
}

#[test]
fn of_time_and_samples_the_first_ends_it() {
    let here = folder();
    let arguments = ["--time", "100", "--spp", "3", "-o", "a.png", "--json", "-"];
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments);
    let output = command.assert().code(0).get_output().clone();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["spp"], 3);
}

#[test]
fn each_signal_ends_a_render_with_its_own_exit_code() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let here = folder();
        let mut render = Running::start(here.path(), &long_render());
        render.wait_until_it_catches_signals();
        assert_eq!(render.after(&[signal]).code(), Some(code), "{}", render.said());
        assert!(render.said().contains(&format!("SIG{signal}: stopping now")), "{}", render.said());
        assert_eq!(names(here.path()), ["a.exr", "a.guide", "a.json", "a.png"]);
        assert!(read_layers(&here.path().join("a.exr")).unwrap().channels["R"].iter().any(|&x| x > 0.0));
        let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
        assert_eq!(report["exit"], "interrupted");
        let mut go_on = phototaxis(here.path());
        let arguments = ["--spp", "1", "-q", "-o", "b.exr", "--guide-in", "a.guide"];
        go_on.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments).assert().code(0);
    }
}

#[test]
fn a_large_picture_is_answered_for_in_the_middle_of_its_pass() {
    // the same view with fewer pixels, each of which is a block of the large one
    let here = folder();
    let mut small = phototaxis(here.path());
    let arguments = ["--set", "film.width=192", "--set", "film.height=108", "--spp", "128", "-q", "-o", "small.exr"];
    small.arg("render").arg(scene("cornell.toml")).args(DEEP).args(arguments).assert().code(0);
    let small = read_layers(&here.path().join("small.exr")).unwrap();
    let mut render = vec![scene("cornell.toml").display().to_string()];
    render.extend(DEEP.map(String::from));
    // what is heard is the answer and no line about progress
    let large = ["--size", "3840x2160", "--time", "600", "-o", "a.exr", "--progress", "none"];
    render.extend(large.map(String::from));
    for signals in [&["INT"][..], &["INT", "TERM"]] {
        let mut render = Running::start(here.path(), &render);
        render.wait_until_it_catches_signals();
        render.wait_until_it_has_worked(Duration::from_secs(3));
        let asked = Instant::now();
        render.send(signals[0]);
        render.hear();
        let heard = asked.elapsed();
        std::thread::sleep(Duration::from_millis(400));
        assert!(render.said().starts_with("SIGINT: stopping now"), "{}", render.said());
        assert!(render.child.try_wait().unwrap().is_none(), "it says so before it is done");
        assert_eq!(render.after(&signals[1..]).code(), Some(130), "{}", render.said());
        // most of it is writing, on a machine that runs other tests meanwhile
        let [heard, written] = [heard, asked.elapsed()].map(|t| t.as_secs_f64());
        eprintln!("{signals:?} at 3840 × 2160: said after {heard:.2} s, written after {written:.1} s");
        assert!(asked.elapsed() < Duration::from_secs(60), "{:?}", asked.elapsed());
        check_against(&small, &read_layers(&here.path().join("a.exr")).unwrap());
    }
}

/// How long it takes is only printed, as it is a matter of the machine and what else that does; what is given up is tested where it
/// is decided.
#[test]
fn a_second_signal_gives_up_the_checkpoint_under_way() {
    let here = folder();
    let arguments = ["-o", "a.exr", "-o", "a.png", "--checkpoint", "c", "--every", "1ms", "--progress", "none"];
    let arguments = [scene("door.toml").to_str().unwrap(), "--size", "1280x720", "--time", "600"]
        .iter()
        .chain(&arguments)
        .map(ToString::to_string)
        .collect::<Vec<_>>();
    let mut render = Running::start(here.path(), &arguments);
    let start = Instant::now();
    while !names(here.path()).iter().any(|name| name.ends_with(".tmp")) {
        assert!(start.elapsed() < Duration::from_secs(100), "no checkpoint is begun");
        std::thread::sleep(Duration::from_millis(1));
    }
    render.wait_until_it_catches_signals();
    render.send("INT");
    std::thread::sleep(Duration::from_millis(300));
    let asked = Instant::now();
    render.send("TERM");
    assert_eq!(render.wait().code(), Some(130), "{}", render.said());
    eprintln!(
        "at 1280 × 720 with a checkpoint under way: {:.2} s after the second signal",
        asked.elapsed().as_secs_f64()
    );
    assert!(asked.elapsed() < Duration::from_secs(30), "{:?}", asked.elapsed());
    assert!(render.said().contains("SIGTERM: writing what there is"), "{}", render.said());
    let left = names(here.path());
    assert!(left == ["a.exr", "a.png"] || left == ["a.exr", "a.png", "c"], "{left:?}");
    let picture = read_layers(&here.path().join("a.exr")).unwrap();
    assert!(picture.channels["G"].iter().any(|&x| x > 0.0));
    if left.len() == 3 {
        let mut go_on = phototaxis(here.path());
        go_on.args(["resume", "c", "--time", "1ms", "-q", "-o", "b.exr"]).assert().code(0);
    }
}

/// Paths of up to 64 segments, none of which ends by chance.
const DEEP: [&str; 6] = ["--set", "integrator.roulette=none", "--set", "integrator.max_depth=64", "--guide", "none"];

/// Blocks of the large picture that have all their samples are together as bright as the pixels of the small one there.
fn check_against(small: &ExrFile, large: &ExrFile) {
    let (side, green, counts) = (large.width / small.width, &large.channels["G"], &large.channels["samples.Y"]);
    assert!(large.channels.values().flatten().all(|x| x.is_finite()));
    assert!((0..green.len()).all(|i| counts[i] > 0.0 || green[i] == 0.0), "a pixel without samples is black");
    let (mut blocks, mut expected, mut found) = (0, 0.0, 0.0);
    for block in 0..small.width * small.height {
        let (left, top) = (block % small.width * side, block / small.width * side);
        let pixels = || (0..side * side).map(|k| (top + k / side) * large.width + left + k % side);
        if pixels().all(|i| counts[i] > 0.0) {
            blocks += 1;
            expected += f64::from(small.channels["G"][block]);
            found += pixels().map(|i| f64::from(green[i])).sum::<f64>() / (side * side) as f64;
        }
    }
    // 400 samples in each, whose relative variance is a few: they tell the mean to 1 %
    assert!(blocks >= 100, "only {blocks} blocks have samples");
    assert!((found / expected - 1.0).abs() < 0.05, "{} of what is expected in {blocks} blocks", found / expected);
}

#[test]
fn a_third_signal_ends_the_program_at_once() {
    let here = folder();
    // nobody reads the pipe, so that writing never ends
    make_pipe(&here.path().join("a.exr"));
    let arguments = ["--time", "300", "-o", "a.exr"].map(String::from);
    let mut render = Running::start(here.path(), &[&tiny()[..], &arguments].concat());
    render.wait_until_it_catches_signals();
    assert_eq!(render.after(&["HUP", "INT", "TERM"]).code(), Some(143), "{}", render.said());
    assert!(render.said().contains("SIGINT: writing what there is"), "{}", render.said());
    assert_eq!(names(here.path()), ["a.exr"]);
}

#[test]
fn signals_that_follow_at_once_are_one() {
    let here = folder();
    let mut render = Running::start(here.path(), &long_render());
    render.wait_until_it_catches_signals();
    (0..5).for_each(|_| render.send("TERM"));
    assert_eq!(render.wait().code(), Some(143));
    assert_eq!(render.said().matches("SIGTERM").count(), 1, "{}", render.said());
    assert_eq!(names(here.path()), ["a.exr", "a.guide", "a.json", "a.png"]);
}

#[test]
fn a_terminal_that_is_gone_takes_no_picture_with_it() {
    let here = folder();
    let mut render = Running::start(here.path(), &long_render());
    // from now on whatever it says is an error of a broken pipe
    drop(render.child.stderr.take());
    render.wait_until_it_catches_signals();
    assert_eq!(render.after(&["HUP"]).code(), Some(129));
    assert_eq!(names(here.path()), ["a.exr", "a.guide", "a.json", "a.png"]);
}

#[test]
fn a_signal_that_was_ignored_from_the_start_stays_ignored() {
    let here = folder();
    // as nohup does
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$@\"", "sh"]).arg(program()).arg("render");
    let mut render = Running::spawn(shell, here.path(), &long_render());
    render.wait_until_it_catches_signals();
    render.send("HUP");
    std::thread::sleep(Duration::from_millis(600));
    assert_eq!(render.after(&["TERM"]).code(), Some(143), "{}", render.said());
    assert!(!render.said().contains("SIGHUP"), "{}", render.said());
}

#[test]
fn while_a_scene_is_loaded_there_is_nothing_to_write() {
    use std::os::unix::process::ExitStatusExt;
    let here = folder();
    // a scene that never comes
    make_pipe(&here.path().join("scene.toml"));
    let arguments = ["scene.toml", "-o", "a.exr"].map(String::from);
    let mut render = Running::start(here.path(), &arguments);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(render.after(&["TERM"]).signal(), Some(15));
    assert_eq!(names(here.path()), ["scene.toml"]);
}

#[test]
fn a_comparison_that_is_stopped_keeps_its_runs() {
    let here = folder();
    let arguments = ["--methods", "none", "--spp", "4", "--runs", "10000", "--reference-time", "0.2"];
    let arguments = [&tiny()[..], &arguments.map(String::from), &["--allow-noisy-reference".into()]].concat();
    let mut command = listening_program();
    command.arg("compare");
    let mut compare = Running::spawn(command, here.path(), &arguments);
    let log = here.path().join("compare-out/runs.jsonl");
    let runs = || std::fs::read_to_string(&log).unwrap_or_default().matches("\n{\"run\":").count();
    let start = Instant::now();
    while runs() < 2 {
        assert!(start.elapsed() < Duration::from_secs(120), "no run is over");
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(compare.after(&["TERM"]).code(), Some(143));
    let results = std::fs::read(here.path().join("compare-out/results.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    assert_eq!(results["runs"].as_array().unwrap().len(), runs());
    assert!(here.path().join("compare-out/report.html").exists());
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let here = folder();
    let [left, live] = [".phototaxis-killed000000.tmp", ".phototaxis-alive0000000.tmp"].map(|n| here.path().join(n));
    std::fs::write(&left, "half a picture").unwrap();
    let writer = std::fs::File::create(&live).unwrap();
    writer.lock().unwrap();
    let mut render = phototaxis(here.path());
    let arguments = ["--spp", "1", "-q", "-o", "a.exr"];
    render.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments).assert().code(0);
    assert_eq!(names(here.path()), [".phototaxis-alive0000000.tmp", "a.exr"]);
}

fn tiny() -> Vec<String> {
    std::iter::once(scene("cornell.toml").display().to_string()).chain(TINY.map(String::from)).collect()
}

/// Arguments of a render that would take minutes.
fn long_render() -> Vec<String> {
    let outputs = ["-o", "a.exr", "-o", "a.png", "--json", "a.json", "--guide-out", "a.guide", "--time", "300"];
    tiny().into_iter().chain(outputs.map(String::from)).collect()
}

fn make_pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// The program, for which no signal is ignored: a shell without job control has what it runs in the background ignore SIGINT.
fn listening_program() -> Command {
    let all = 1 | 1 << (2 - 1) | 1 << (15 - 1);
    let program = program();
    if signals(std::process::id(), "SigIgn:") & all == 0 {
        return Command::new(program);
    }
    let mut command = Command::new("env");
    command.arg("--default-signal=HUP,INT,TERM").arg(program);
    command
}

/// A process of the program. It ends with the test, however that ends.
pub(super) struct Running {
    child: Child,
    said: String,
}

impl Running {
    /// Renders.
    pub(super) fn start(here: &Path, arguments: &[String]) -> Running {
        let mut command = listening_program();
        command.arg("render");
        Running::spawn(command, here, arguments)
    }

    fn spawn(mut command: Command, here: &Path, arguments: &[String]) -> Running {
        let command = command.args(arguments).current_dir(here).stdout(Stdio::null()).stderr(Stdio::piped());
        Running { child: command.spawn().unwrap(), said: String::new() }
    }

    /// Waits until it catches signals.
    pub(super) fn wait_until_it_catches_signals(&self) {
        let start = Instant::now();
        while !catches_signals(self.child.id()) {
            assert!(start.elapsed() < Duration::from_secs(60), "the program catches no signals");
            std::thread::sleep(Duration::from_millis(10));
        }
        // and for the thread that listens
        std::thread::sleep(Duration::from_millis(100));
    }

    /// Waits until it has had so much more processor time, which may take long on a busy machine.
    fn wait_until_it_has_worked(&self, time: Duration) {
        let (start, before) = (Instant::now(), processor_time(self.child.id()));
        while processor_time(self.child.id()) < before + time {
            assert!(start.elapsed() < Duration::from_secs(100), "the program does not work");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub(super) fn send(&self, signal: &str) {
        // The shell's own `kill`: a small system has no program of that name.
        let kill = format!("kill -s {signal} {}", self.child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    }

    /// Sends signals, as somebody does who has had enough, and waits for the end.
    pub(super) fn after(&mut self, signals: &[&str]) -> ExitStatus {
        for signal in signals {
            self.send(signal);
            std::thread::sleep(Duration::from_millis(600));
        }
        self.wait()
    }

    pub(super) fn wait(&mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                let rest = self.child.stderr.take();
                rest.into_iter().for_each(|mut rest| _ = rest.read_to_string(&mut self.said).unwrap());
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(100), "the program goes on");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits for a line on standard error.
    pub(super) fn hear(&mut self) {
        let stderr = self.child.stderr.as_mut().unwrap();
        let mut byte = [0];
        while !self.said.ends_with('\n') && stderr.read(&mut byte).unwrap() == 1 {
            self.said.push(byte[0].into());
        }
    }

    /// What was on standard error.
    pub(super) fn said(&self) -> &str {
        &self.said
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // An error: it has ended, as it should.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether there is a handler of SIGTERM (15), the last but one that the program catches, as the kernel tells.
pub(super) fn catches_signals(process: u32) -> bool {
    signals(process, "SigCgt:") >> (15 - 1) & 1 == 1
}

/// Bit n − 1: what a field of a process's status says of signal n.
fn signals(process: u32, field: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix(field)).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap()
}

/// Of a process and its threads so far.
fn processor_time(process: u32) -> Duration {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    // behind the name in brackets; user and system time in hundredths of a second
    let fields: Vec<&str> = stat[stat.rfind(')').unwrap()..].split_whitespace().collect();
    [12, 13].map(|k| Duration::from_millis(10 * fields[k].parse::<u64>().unwrap())).iter().sum()
}
