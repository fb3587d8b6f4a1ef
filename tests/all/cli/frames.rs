//! Animations: a camera that moves, and one picture after the other.

use super::resuming::{start, wait_for, wait_until_it_renders};
use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use crate::common::welch;
use phototaxis::image::exr::{Attribute, read_attributes, read_layers};
use phototaxis::stats::{Summary, sidak};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

/// Keys of the project's box: it is approached, and passed on a curve.
const KEYS: [&str; 2] = [
    "--set",
    "camera.key=[{frame=1, origin=[0, 0.275, 1.08]}, {frame=3, origin=[0.06, 0.3, 1], vfov=45}, {frame=5, origin=[0.1, 0.28, 0.9]}]",
];

/// What the program says that renders the project's box, tiny, with these arguments.
fn render(here: &Path, code: i32, arguments: &[&str]) -> String {
    let mut command = phototaxis(here);
    command.arg("render").arg(scene("cornell.toml")).args(TINY).args(arguments);
    stderr(command.assert().code(code).get_output()).to_string()
}

fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    read_layers(path).unwrap().channels.into_iter().collect()
}

#[test]
fn frames_without_a_guide_are_single_renders() {
    let here = folder();
    let at = |name: &str| channels(&here.path().join(name));
    let how = [&["--spp", "4", "--seed", "100", "--guide", "none"], &KEYS[..]].concat();
    let said = render(here.path(), 0, &[&how[..], &["--frames", "1..5:2", "-o", "a.####.exr"]].concat());
    assert!(said.contains("frame 3 (2 of 3):") && said.contains("wrote a.0005.exr"), "{said}");
    assert_eq!(names(here.path()), ["a.0001.exr", "a.0003.exr", "a.0005.exr"]);
    render(here.path(), 0, &[&how[..], &["--frames", "3..4", "-o", "b%d.exr"]].concat());
    assert!(at("a.0003.exr") == at("b3.exr"), "a frame does not depend on where the range begins");
    assert!(at("b3.exr") != at("b4.exr"));
    let single = ["--spp", "4", "--seed", "103", "--guide", "none", "--set", "camera.origin=[0.06, 0.3, 1]"];
    render(here.path(), 0, &[&single[..], &["--set", "camera.vfov=45", "-o", "c.exr"]].concat());
    assert!(at("a.0003.exr") == at("c.exr"), "frame 3 is what seed 100 + 3 gives from its place");
}

#[test]
fn a_turntable_begins_with_the_view_and_goes_around() {
    let here = folder();
    let how = ["--spp", "2", "--guide", "none", "--seed", "0"];
    let said = render(here.path(), 0, &[&how[..], &["--turntable", "4", "-o", "t##.exr"]].concat());
    assert!(said.contains("turns around its target, (0, 0.275, 0)"), "{said}");
    let at = |name: &str| channels(&here.path().join(name));
    render(here.path(), 0, &["--spp", "2", "--guide", "none", "--seed", "1", "-o", "a.exr"]);
    assert!(at("t01.exr") == at("a.exr"));
    let behind =
        ["--spp", "2", "--guide", "none", "--seed", "3", "--set", "camera.origin=[0, 0.275, -1.08]", "-o", "b.exr"];
    render(here.path(), 0, &behind);
    let [turned, placed] = ["t03.exr", "b.exr"].map(|name| at(name)["Z"].iter().map(|z| f64::from(*z)).sum::<f64>());
    assert!((turned / placed - 1.0).abs() < 1e-4, "{turned}, {placed}");
}

#[test]
fn frames_that_are_there_are_kept_skipped_or_replaced() {
    let here = folder();
    let how = [&["--spp", "1", "--guide", "none"], &KEYS[..]].concat();
    let go = |code, more: &[&str]| render(here.path(), code, &[&how[..], more].concat());
    go(0, &["--frames", "2..3"]);
    assert_eq!(names(here.path()), ["cornell.0002.exr", "cornell.0002.png", "cornell.0003.exr", "cornell.0003.png"]);
    std::fs::remove_file(here.path().join("cornell.0003.png")).unwrap();
    let said = go(1, &["--frames", "1..4"]);
    assert!(said.contains("cornell.0002.exr: is there already, and 2 more") && said.contains("--force"), "{said}");
    assert_eq!(names(here.path()).len(), 3);
    let said = go(0, &["--frames", "1..4", "--skip-existing"]);
    assert!(
        said.contains("frame 3 (2 of 3):") && !said.contains("frame 2 "),
        "what is there in part is made anew: {said}"
    );
    assert!(go(0, &["--frames", "1..4", "--skip-existing"]).contains("all frames are there already"));
    assert!(go(0, &["--frames", "2", "--force"]).contains("frame 2 (1 of 1):"));
}

#[test]
fn what_no_animation_can_be_made_of_is_refused() {
    let here = folder();
    for (arguments, why) in [
        (&["--frames", "1..3"][..], "nothing moves"),
        (&["--frames", "1..3", "--turntable", "3", KEYS[0], KEYS[1]], "moves already"),
        (&["--frames", "1..3", KEYS[0], KEYS[1], "-o", "a.exr"], "a.exr: several frames need a name with ####"),
        (&["--frames", "1..3", KEYS[0], KEYS[1], "--json", "a.json"], "a.json: several frames"),
        (&["--skip-existing"], "--skip-existing needs --frames"),
        (&["--frames", "1", "--set", "camera.key=[{frame=1}, {frame=1}]"], "two keys at frame 1"),
        (&["--frames", "1", "--set", "camera.key=[{frame=1, target=[0, 0.275, 1.08]}]"], "frame 1: "),
    ] {
        let said = render(here.path(), 1, arguments);
        assert!(said.contains(why), "{arguments:?}: {said}");
    }
    render(here.path(), 2, &["--frames", "1..3", "--part", "1/2", "--film-out", "a.film"]);
    assert!(names(here.path()).is_empty());
}

/// An animation that is killed again and again, and one that nobody disturbs.
#[test]
fn an_animation_goes_on_in_the_frame_where_it_was_killed() {
    let here = folder();
    let how = ["--spp", "1200", "--guide", "adaptive", "--exposure", "auto", "--frames", "1..5:2", KEYS[0], KEYS[1]];
    render(here.path(), 0, &[&how[..], &["-o", "w#.exr", "-o", "w#.png", "-q"]].concat());
    let scene = scene("cornell.toml").display().to_string();
    let kept = ["-o", "a#.exr", "-o", "a#.png", "-q", "--checkpoint", "c", "--every", "10ms"];
    let mut child = start(here.path(), &[&["render", &scene], &TINY[..], &how, &kept].concat());
    wait_for(&here.path().join("c"));
    for kill in 1..=8u32 {
        wait_until_it_renders(&mut child);
        std::thread::sleep(Duration::from_millis(u64::from(kill.wrapping_mul(0x9e37_79b9) >> 24)));
        child.kill().unwrap();
        child.wait().unwrap();
        child = start(here.path(), &["resume", "c", "-q"]);
    }
    assert!(child.wait().unwrap().success());
    for frame in [1, 3, 5] {
        let [own, whole] = ["a", "w"].map(|run| here.path().join(format!("{run}{frame}.exr")));
        assert!(channels(&own) == channels(&whole), "frame {frame} is another");
        let [own, whole] = [own, whole].map(|path| std::fs::read(path.with_extension("png")).unwrap());
        assert!(own == whole, "frame {frame} is shown otherwise");
    }

    // of frames that are done nothing is made again
    for name in ["a1.exr", "a1.png", "a3.exr", "a3.png"] {
        std::fs::remove_file(here.path().join(name)).unwrap();
    }
    let resume = |code, more: &[&str]| {
        let mut command = phototaxis(here.path());
        stderr(command.args([&["resume", "c", "--progress", "none"], more].concat()).assert().code(code).get_output())
    };
    let said = resume(0, &[]);
    assert!(said.contains("frame 5 (3 of 3):") && !said.contains("frame 3"), "{said}");
    assert!(!names(here.path()).contains(&"a3.exr".to_string()));
    assert!(resume(1, &["--spp", "2000"]).contains("an animation goes on with the budget that it had"));
    let merge = phototaxis(here.path()).args(["merge", "c", "-o", "m.exr"]).assert().code(1).get_output().clone();
    assert!(stderr(&merge).contains("this is of an animation"), "{}", stderr(&merge));
}

#[test]
fn a_frame_that_a_signal_stops_is_written_and_made_anew() {
    let here = folder();
    let scene = scene("cornell.toml").display().to_string();
    let how = ["--time", "100", "--frames", "1..2", KEYS[0], KEYS[1], "-o", "a##.exr", "-o", "a##.png"];
    let all: Vec<String> = [&[scene.as_str()], &TINY[..], &how].concat().iter().map(|a| a.to_string()).collect();
    let mut running = super::stopping::Running::start(here.path(), &all);
    running.wait_until_it_catches_signals();
    assert_eq!(running.after(&["INT"]).code(), Some(130), "{}", running.said());
    assert_eq!(names(here.path()), ["a01.exr", "a01.png"]);
    let incomplete = |name: &str| read_attributes(&here.path().join(name)).unwrap().get("incomplete").cloned();
    assert!(matches!(incomplete("a01.exr"), Some(Attribute::Int(samples)) if samples > 0));
    let again =
        ["--spp", "1", "--frames", "1..2", KEYS[0], KEYS[1], "-o", "a##.exr", "-o", "a##.png", "--skip-existing"];
    let said = render(here.path(), 0, &again);
    assert!(said.contains("frame 1 (1 of 2):") && incomplete("a01.exr").is_none(), "{said}");
}

/// Mean luminances of a picture of 16 × 12 pixels and of its quarters.
fn means(path: &Path) -> Vec<f64> {
    let channels = channels(path);
    let light = |i: usize| {
        [("R", 0.2126), ("G", 0.7152), ("B", 0.0722)]
            .iter()
            .map(|(name, w)| w * f64::from(channels[*name][i]))
            .sum::<f64>()
    };
    let mut sums = vec![0.0; 5];
    for i in 0..16 * 12 {
        let quarter = 1 + i / 16 / 6 * 2 + i % 16 / 8;
        sums[0] += light(i) / 192.0;
        sums[quarter] += light(i) / 48.0;
    }
    sums
}

/// A camera that stands still has frames of one and the same view. With a guide from frame to frame, each learns from all before
/// it; their means must be those of frames without. A false alarm in 10,000 runs of all tests; 5 % more light must be found.
#[test]
fn frames_with_a_guide_from_earlier_ones_are_unbiased() {
    const FRAMES: usize = 48;
    const FALSE_ALARM: f64 = 1e-4;
    let here = folder();
    let still = ["--set", "camera.key=[{frame=1, vfov=39}]", "--spp", "24"];
    let range = format!("1..{FRAMES}");
    let runs = |guide: &str, settings: &[&str], seed: &str| -> Vec<Vec<f64>> {
        let pattern = format!("{guide}.##.exr");
        let more = ["--frames", &range, "--guide", guide, "--seed", seed, "-o", &pattern, "--json", "-"];
        let mut command = phototaxis(here.path());
        command.arg("render").arg(scene("cornell.toml")).args(TINY).args(still).args(settings).args(more);
        let said = stdout(command.assert().code(0).get_output()).to_string();
        let reports = serde_json::Deserializer::from_str(&said).into_iter::<serde_json::Value>();
        let drawn: Vec<f64> =
            reports.map(|r| r.unwrap()["iterations"][0]["guide_drawn_share"].as_f64().unwrap()).collect();
        assert_eq!(drawn.len(), FRAMES);
        assert_eq!(drawn[0], 0.0, "the first iteration of all knows nothing");
        assert!(drawn[1..].iter().all(|share| (*share > 0.2) == (guide != "none")), "{guide}: {drawn:?}");
        (1..=FRAMES).map(|k| means(&here.path().join(format!("{guide}.{k:02}.exr")))).collect()
    };
    let (plain, guided) = (runs("none", &[], "1000"), runs("grid", &["--set", "guiding.resolution=4"], "0"));
    let level = sidak(FALSE_ALARM, 5);
    let smallest = |factor: f64| {
        let column = |runs: &[Vec<f64>], k: usize, factor: f64| {
            Summary::of(&runs.iter().map(|run| run[k] * factor).collect::<Vec<_>>()).unwrap()
        };
        (0..5).map(|k| welch(&column(&guided, k, factor), &column(&plain, k, 1.0)).1).fold(1.0, f64::min)
    };
    println!("guided frames: p = {:.1e}, 5 % more light p = {:.1e}", smallest(1.0), smallest(1.05));
    assert!(smallest(1.0) >= level, "not what frames without a guide give");
    assert!(smallest(1.05) < level, "a bias of 0.05 goes unseen");
}

#[test]
fn all_frames_have_the_exposure_that_suits_the_first() {
    let here = folder();
    let stops = |name: &str| match read_attributes(&here.path().join(name)).unwrap().get("viewExposure") {
        Some(Attribute::Float(stops)) => *stops,
        other => panic!("{name}: {other:?}"),
    };
    let how = [&["--spp", "4", "--guide", "none", "--exposure", "auto"], &KEYS[..]].concat();
    let go = |more: &[&str]| render(here.path(), 0, &[&how[..], more].concat());
    go(&["--frames", "1..5:2", "-o", "a#.exr", "-o", "a#.png"]);
    go(&["--frames", "5", "-o", "b.exr", "-o", "b.png"]);
    assert!(stops("a1.exr") == stops("a3.exr") && stops("a3.exr") == stops("a5.exr"));
    assert_ne!(stops("a5.exr"), stops("b.exr"), "by itself it would be shown otherwise: else this tells nothing");
    // those that are there already are taken for it
    let shown = std::fs::read(here.path().join("a5.png")).unwrap();
    std::fs::remove_file(here.path().join("a5.png")).unwrap();
    go(&["--frames", "1..5:2", "-o", "a#.exr", "-o", "a#.png", "--skip-existing"]);
    assert!(std::fs::read(here.path().join("a5.png")).unwrap() == shown);
}
