//! What happens around Mitsuba, with a shell script in Python's place.

use super::*;

/// An interpreter that says `first` and then answers orders by `then`, in which `$picture` is where the picture goes
/// and `$right` what Phototaxis makes of the room.
#[cfg(unix)]
fn imposter(description: &SceneFile, first: &str, then: &str) -> (TempDir, PathBuf) {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let right = folder.path().join("right.exr");
    let (scene, _) = description.load_scene(1).unwrap();
    let mut own = settings(description, GuidingMethod::None);
    own.render.spp = 256;
    let (_, estimate) = Own::render(&scene, &own).unwrap();
    let window = Window::full(estimate.width as usize, estimate.height as usize);
    exr::write(&right, &window, vec![Layer::color("", &estimate.mean)], &Metadata::default()).unwrap();
    let path = folder.path().join("python");
    let (seen, right) = (folder.path().join("seen"), right.display());
    let script = format!(
        "#!/bin/sh\nright='{right}'\necho \"$@\" >> {seen}\n{first}\nwhile read -r order; do\necho \"$order\" >> {seen}\n\
         picture=$(echo \"$order\" | sed 's/.*\"picture\":\"\\([^\"]*\\)\".*/\\1/')\n{then}\ndone\n",
        seen = seen.display()
    );
    fs::write(&path, script).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    (folder, path)
}

#[cfg(unix)]
const HELLO: &str = "echo '{\"version\":\"3.x\"}'";

#[cfg(unix)]
const RIGHT: &str = "cp \"$right\" \"$picture\"; echo '{\"seconds\":0.5,\"cpu_seconds\":0.25}'";

#[cfg(unix)]
fn measured(first: &str, then: &str, turns: usize) -> Result<MitsubaReport> {
    let (_room, description) = room("");
    let (_folder, python) = imposter(&description, first, then);
    Mitsuba::start(&description, PLAN, &python, None)?.measure(turns)
}

#[cfg(unix)]
#[test]
fn orders_are_given_in_turns_and_answers_become_figures() {
    let (_room, description) = room("");
    let (folder, python) = imposter(&description, HELLO, RIGHT);
    let keep = folder.path().join("a new folder");
    let report = Mitsuba::start(&description, PLAN, &python, Some(&keep)).unwrap().measure(2).unwrap();
    assert!(report.missing.is_empty());
    assert_eq!(report.mitsuba.iter().map(|m| m.variant).collect::<Vec<_>>(), VARIANTS);
    for m in &report.mitsuba {
        // 32 × 24 × 64 samples in half a second
        assert!((m.msamples_per_second.median - 0.098_304).abs() < 1e-9, "{m:?}");
        assert!((m.msamples_per_cpu_second.unwrap().median - 0.196_608).abs() < 1e-9, "{m:?}");
        let ratio = report.phototaxis.msamples_per_second.median / m.msamples_per_second.median;
        assert!(m.ratio.low <= ratio && ratio <= m.ratio.high && m.version == "3.x", "{m:?}");
        assert!(m.agreement.worst < 1.0, "{m:?}");
    }
    let seen = fs::read_to_string(folder.path().join("seen")).unwrap();
    let seen: Vec<&str> = seen.lines().collect();
    // one process for each variant; a turn that does not count and two that do, variants one after the other
    assert!(seen[0].contains("driver.py scalar_rgb") && seen[0].ends_with("scene.xml 1"), "{seen:?}");
    assert!(seen[1].contains("driver.py llvm_ad_rgb"), "{seen:?}");
    for (order, seed) in seen[2..].iter().zip([3, 3, 4, 4, 5, 5]) {
        assert!(order.starts_with(&format!("{{\"spp\":64,\"seed\":{seed},")), "{order}");
    }
    assert_eq!(seen.len(), 8);
    for name in ["scene.xml", "driver.py", "phototaxis.png", "scalar_rgb.png", "llvm_ad_rgb.exr"] {
        assert!(keep.join(name).is_file(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn another_picture_is_refused() {
    let (_room, mut description) = room("");
    let (folder, python) = imposter(&description, HELLO, RIGHT);
    // what the imposter shows was not seen from here
    description.scene.camera.as_mut().unwrap().vfov = 55.0;
    let started = Mitsuba::start(&description, PLAN, &python, None).unwrap();
    let error = started.measure(1).unwrap_err().to_string();
    assert!(error.contains("scalar_rgb renders another picture"), "{error}");
    description.scene.film.width = 40;
    let started = Mitsuba::start(&description, PLAN, &python, None).unwrap();
    let error = started.measure(1).unwrap_err().to_string();
    assert!(error.contains("32 × 24 pixels, not 40 × 24"), "{error}");
    drop(folder);
}

#[cfg(unix)]
#[test]
fn a_process_that_fails_or_babbles_is_an_error() {
    for (first, then, word) in [
        ("echo 'a: line' >&2; echo >&2; exit 3", "", "scalar_rgb: it failed with exit status: 3: a: line"),
        (HELLO, "echo 'no memory' >&2; exit 4", "it failed with exit status: 4: no memory"),
        ("echo hello", "", "unexpected answer: hello"),
        (HELLO, "echo '{\"seconds\":1}'", "unexpected answer"),
        (HELLO, "echo '{\"seconds\":0,\"cpu_seconds\":0}'", "it took no time"),
        (HELLO, "echo '{\"seconds\":1,\"cpu_seconds\":1}'", "scalar_rgb.exr"),
    ] {
        let error = measured(first, then, 1).unwrap_err().to_string();
        assert!(error.contains(word), "{word} is missing in: {error}");
    }
}

#[cfg(unix)]
#[test]
fn variants_that_are_missing_are_named_and_the_others_measured() {
    let first = format!("[ $2 = scalar_rgb ] && {HELLO} || {{ echo '{{\"missing\":\"no LLVM\"}}'; exit; }}");
    let report = measured(&first, RIGHT, 1).unwrap();
    assert_eq!(report.mitsuba.iter().map(|m| m.variant).collect::<Vec<_>>(), ["scalar_rgb"]);
    assert_eq!((report.missing[0].variant, &*report.missing[0].reason), ("llvm_ad_rgb", "no LLVM"));
}

#[test]
fn without_the_interpreter_only_ours_is_measured() {
    let (folder, description) = room("");
    let started = Mitsuba::start(&description, PLAN, &folder.path().join("no python"), None).unwrap();
    assert_eq!(started.missing().iter().map(|m| m.variant).collect::<Vec<_>>(), VARIANTS);
    let left = started.folder.clone();
    let report = started.measure(1).unwrap();
    assert!(report.mitsuba.is_empty() && report.phototaxis.msamples_per_second.median > 0.0);
    assert!(!left.exists(), "nothing is left behind");
}

#[cfg(unix)]
#[test]
fn processes_end_with_the_measurement() {
    let (_room, description) = room("");
    let (folder, python) = imposter(&description, HELLO, RIGHT);
    let file = folder.path().join("scene.xml");
    let Started::Ready(process) = Process::start(&python, VARIANTS[0], &file, 1).unwrap() else {
        panic!("the imposter is there");
    };
    let id = process.id();
    drop(process);
    assert!(!Path::new(&format!("/proc/{id}")).exists());
}
