//! The add-on for Blender, by its own tests: against Cycles, and against this program.
//!
//! Needs a Python that has Blender as a module (PyPI's `bpy`), which `$PHOTOTAXIS_BPY` names; without one the tests are skipped, and say so.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What the tests may take; they take some two minutes.
const PATIENCE: Duration = Duration::from_secs(900);

fn addon() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("addons/blender")
}

fn program() -> PathBuf {
    std::env::var_os("PHOTOTAXIS_PROGRAM")
        .map_or_else(|| assert_cmd::cargo::cargo_bin!("phototaxis").to_path_buf(), PathBuf::from)
}

#[test]
fn the_add_on_agrees_with_cycles_and_with_the_command_line() {
    let Some(python) = std::env::var_os("PHOTOTAXIS_BPY") else {
        println!("skipped: PHOTOTAXIS_BPY names no Python that has Blender as a module (pip install bpy)");
        return;
    };
    let mut tests = Command::new(&python)
        .arg(addon().join("tests/run.py"))
        .env("PHOTOTAXIS", program())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("PHOTOTAXIS_BPY is {python:?}: {error}"));
    let mut standard_error = tests.stderr.take().unwrap();
    let reader = std::thread::spawn(move || {
        let mut said = Vec::new();
        standard_error.read_to_end(&mut said).unwrap();
        String::from_utf8_lossy(&said).into_owned()
    });
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = tests.try_wait().unwrap() {
            break status;
        }
        if begun.elapsed() > PATIENCE {
            tests.kill().unwrap();
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let said = reader.join().unwrap();
    assert!(status.success(), "the add-on's tests failed ({status}):\n{said}");
}

/// Blender asks for these, and for nothing that the package does not hold.
#[test]
fn the_manifest_says_what_blender_asks_for() {
    let text = std::fs::read_to_string(addon().join("phototaxis/blender_manifest.toml")).unwrap();
    let manifest: toml::Table = text.parse().unwrap();
    for key in
        ["schema_version", "id", "version", "name", "tagline", "maintainer", "type", "blender_version_min", "license"]
    {
        assert!(manifest.contains_key(key), "the manifest has no {key}");
    }
    assert_eq!(
        manifest["version"].as_str(),
        Some(env!("CARGO_PKG_VERSION")),
        "the add-on is released with the program"
    );
    let tagline = manifest["tagline"].as_str().unwrap();
    assert!(tagline.len() <= 64 && !tagline.ends_with('.'), "Blender refuses such a tagline");
}
