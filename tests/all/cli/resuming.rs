//! Renders that are left, by whatever ends a program, and go on from their checkpoints.

use super::stopping::catches_signals;
use super::{folder, names, phototaxis, program, scene, stderr, stdout};
use phototaxis::image::exr::read_layers;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A render of the door that takes some tenths of a second.
const SHORT: [&str; 7] = ["--size", "32x18", "--spp", "400", "--guide", "adaptive", "-q"];

pub(super) fn start(here: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(program());
    command.current_dir(here).args(arguments).stdin(Stdio::null()).stderr(Stdio::piped()).stdout(Stdio::null());
    command.spawn().unwrap()
}

fn begin<'a>(door: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["render", door][..], &SHORT, more].concat()
}

/// Waits until a render has written a checkpoint.
pub(super) fn wait_for(path: &Path) {
    let begin = Instant::now();
    while !path.exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "there is no {}", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn run(here: &Path, arguments: &[&str], code: i32) -> String {
    stderr(phototaxis(here).args(arguments).assert().code(code).get_output())
}

/// Whether two pictures hold the same, bit for bit.
fn same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(|path| read_layers(path).unwrap());
    let scenes = [&a, &b].map(|picture| picture.attributes.get("scene").cloned());
    a.channels == b.channels && scenes[0] == scenes[1]
}

/// Thirty kills at random moments, half of which come soon after the program was started, and half after it has begun to render. A
/// render that is over before all have come begins anew.
#[test]
fn killed_thirty_times_a_render_ends_with_the_same_picture() {
    let here = folder();
    let (door, at) = (scene("door.toml"), here.path().join("c"));
    let door = door.to_str().unwrap();
    run(here.path(), &begin(door, &["-o", "whole.exr"]), 0);
    let first = begin(door, &["-o", "a.exr", "--checkpoint", "c", "--every", "5ms"]);
    let picture = here.path().join("a.exr");
    let anew = || {
        let child = start(here.path(), &first);
        wait_for(&at);
        child
    };
    let mut child = anew();
    for kill in 1..=30u32 {
        if kill % 2 == 0 {
            wait_until_it_renders(&mut child);
        }
        // times that have nothing to do with each other: multiples of the golden ratio
        std::thread::sleep(Duration::from_millis(u64::from(kill.wrapping_mul(0x9e37_79b9) >> 27)));
        child.kill().unwrap();
        child.wait().unwrap();
        child = match picture.exists() {
            true => {
                assert!(same(&picture, &here.path().join("whole.exr")), "after {kill} kills");
                [&picture, &at].iter().for_each(|path| std::fs::remove_file(path).unwrap());
                anew()
            }
            false => start(here.path(), &["resume", "c", "-q"]),
        };
    }
    child.kill().unwrap();
    child.wait().unwrap();
    run(here.path(), &["resume", "c", "-q"], 0);
    assert!(same(&picture, &here.path().join("whole.exr")));
    assert_eq!(names(here.path()), ["a.exr", "c", "whole.exr"], "what a killed run left is removed");
}

/// Waits until the program has loaded its scene, or has ended.
pub(super) fn wait_until_it_renders(child: &mut Child) {
    let begin = Instant::now();
    while !catches_signals(child.id()) && child.try_wait().unwrap().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(60), "the program does not begin");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_signal_leaves_a_checkpoint_and_from_any_folder_the_render_goes_on() {
    let (here, elsewhere) = (folder(), folder());
    let door = scene("door.toml");
    let door = door.to_str().unwrap();
    run(here.path(), &begin(door, &["-o", "whole.exr"]), 0);
    // only the signal writes it
    let mut child = start(here.path(), &begin(door, &["-o", "a.exr", "--checkpoint", "c", "--preview", "p.exr"]));
    wait_for(&here.path().join("p.exr"));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert_eq!(names(here.path()), ["a.exr", "c", "p.exr", "whole.exr"]);
    let again = run(here.path(), &begin(door, &["--checkpoint", "c"]), 1);
    assert!(again.contains("there is a checkpoint already: go on by phototaxis resume c"), "{again}");
    assert!(!same(&here.path().join("a.exr"), &here.path().join("whole.exr")), "the signal came too late");
    let file = here.path().join("c");
    let file = file.to_str().unwrap();
    let said = run(elsewhere.path(), &["resume", file, "--progress", "none"], 0);
    assert!(said.contains(&format!("phototaxis resume {file} goes on")), "{said}");
    assert!(same(&here.path().join("a.exr"), &here.path().join("whole.exr")));
    assert_eq!(names(elsewhere.path()), [] as [&str; 0]);

    // it is done: the same budget leaves nothing to do, and a larger one does
    run(elsewhere.path(), &["resume", file, "-o", "same.exr", "-q"], 0);
    assert!(same(&elsewhere.path().join("same.exr"), &here.path().join("whole.exr")));
    let fewer = run(elsewhere.path(), &["resume", file, "--spp", "3"], 1);
    assert!(fewer.contains("--spp 3: the render has 400 samples per pixel already"), "{fewer}");
    let spp = |arguments: &[&str]| -> u64 {
        let mut command = phototaxis(elsewhere.path());
        let all = [&["resume", file, "-o", "b.exr", "--json", "-", "-q"][..], arguments].concat();
        let report: Value = serde_json::from_str(&stdout(command.args(all).assert().code(0).get_output())).unwrap();
        report["spp"].as_u64().unwrap()
    };
    assert_eq!(spp(&["--spp", "430"]), 430);
    assert!(spp(&["--time", "50ms"]) > 430);
}

#[test]
fn checkpoints_that_cannot_be_written_or_read_are_told_of() {
    let here = folder();
    let door = scene("door.toml");
    let door = door.to_str().unwrap();
    let tiny = ["render", door, "--size", "8x6", "--spp", "40", "-o", "a.exr", "--progress", "none"];
    if Path::new("/dev/full").exists() {
        std::os::unix::fs::symlink("/dev/full", here.path().join("full")).unwrap();
        let said = run(here.path(), &[&tiny[..], &["--checkpoint", "full", "--every", "1ms"]].concat(), 0);
        assert!(said.matches("warning").count() == 1 && said.contains("No space left"), "{said}");
        assert!(said.contains("the render goes on") && !said.contains("wrote full"), "{said}");
    }
    for (more, why) in [
        (&["--checkpoint", "none/c"][..], "its folder does not exist"),
        (&["--checkpoint", "c", "--set", "render.order=blocks", "--guide", "none"], "needs render.order"),
        (&["--every", "3s"], "--every needs --preview or --checkpoint"),
    ] {
        let said = run(here.path(), &[&tiny[..], more].concat(), 1);
        assert!(said.contains(why), "{said}");
    }
    for name in ["door.toml", "door.obj", "door.mtl"] {
        std::fs::copy(scene(name), here.path().join(name)).unwrap();
    }
    run(here.path(), &["render", "door.toml", "--size", "8x6", "--spp", "4", "-q", "--checkpoint", "c"], 0);
    let copy = here.path().join("door.toml");
    let text = std::fs::read_to_string(&copy).unwrap();
    assert!(text.contains("alpha = 0.15"));
    std::fs::write(&copy, text.replace("alpha = 0.15", "alpha = 0.16")).unwrap();
    let said = run(here.path(), &["resume", "c"], 1);
    assert!(said.contains("c: the checkpoint: it is of another scene"), "{said}");
    assert!(run(here.path(), &["resume", "door.exr"], 1).contains("door.exr: this is no checkpoint"));
    assert!(run(here.path(), &["resume", "nothing"], 1).contains("nothing: "));
}
