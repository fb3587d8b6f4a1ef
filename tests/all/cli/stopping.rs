//! Renders that end by the clock or by a signal.

use super::{TINY, folder, names, phototaxis, program, scene};
use phototaxis::image::exr::read_layers;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

#[test]
fn time_ends_a_render() {
    let here = folder();
    let arguments = ["--time", "1", "-o", "a.exr", "--json", "-"];
    let mut command = phototaxis(here.path());
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments);
    let output = command.assert().code(0).get_output().clone();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let seconds = report["render_seconds"].as_f64().unwrap();
    // A pass of this picture takes a millisecond; the rest is room for a machine that is busy with other tests.
    assert!((0.9..2.0).contains(&seconds), "{seconds} s");
    assert!(report["spp"].as_u64().unwrap() > 64, "time, not the scene file's spp, decides: {report}");
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

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_writes_the_picture_so_far() {
    for signal in ["INT", "TERM"] {
        let here = folder();
        let mut render = LongRender::start(here.path());
        render.wait_until_it_catches_signals();
        // The shell's own `kill`: a small system has no program of that name.
        let kill = format!("kill -s {signal} {}", render.0.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        let asked = Instant::now();
        assert_eq!(render.0.wait().unwrap().code(), Some(130));
        assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
        assert_eq!(names(here.path()), ["a.exr", "a.guide", "a.json", "a.png"]);
        assert!(read_layers(&here.path().join("a.exr")).unwrap().channels["R"].iter().any(|&x| x > 0.0));
        let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
        assert_eq!(report["exit"], "interrupted");
        let mut go_on = phototaxis(here.path());
        let arguments = ["--spp", "1", "-q", "-o", "b.exr", "--guide-in", "a.guide"];
        go_on.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments).assert().code(0);
    }
}

/// A render that would take minutes. It ends with the test, however that ends.
struct LongRender(Child);

impl LongRender {
    fn start(here: &Path) -> LongRender {
        let mut command = Command::new(program());
        command.current_dir(here).arg("render").arg(scene("cornell.toml")).args(TINY);
        command.args([
            "--time",
            "300",
            "-q",
            "-o",
            "a.exr",
            "-o",
            "a.png",
            "--json",
            "a.json",
            "--guide-out",
            "a.guide",
        ]);
        LongRender(command.spawn().unwrap())
    }

    /// Waits for handlers of SIGINT (2) and SIGTERM (15), as the kernel tells.
    fn wait_until_it_catches_signals(&self) {
        let start = Instant::now();
        let both = 1 << (2 - 1) | 1 << (15 - 1);
        while caught_signals(self.0.id()) & both != both {
            assert!(start.elapsed() < Duration::from_secs(60), "the program catches no signals");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for LongRender {
    fn drop(&mut self) {
        // An error: it has ended, as it should.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Bit n − 1: signal n has a handler.
fn caught_signals(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap()
}
