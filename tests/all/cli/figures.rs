//! `phototaxis figures`, with budgets of fractions of a second.

use super::{folder, names, program, stderr};
use std::path::Path;

/// In the project's folder, where the scenes are, into another one.
fn figures(out: &Path, more: &[&str]) -> std::process::Output {
    let mut command = std::process::Command::new(program());
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["figures", "--quick", "--real", "nowhere"]);
    command.args(["--output"]).arg(out.join("docs")).arg("--work").arg(out.join("work")).args(more).output().unwrap()
}

#[test]
fn pictures_and_pages_are_made_and_say_what_made_them() {
    let here = folder();
    let only = ["--only", "pictures,results,rates,inspect", "--scenes", "cornell,direct", "--time", "0.02"];
    let output = figures(here.path(), &only);
    assert!(output.status.success(), "{}", stderr(&output));
    let docs = here.path().join("docs");
    let made = [
        "crops-door.png",
        "door.png",
        "efficiency-scenes.png",
        "efficiency-scenes.svg",
        "inspect-door.png",
        "rates.png",
        "rates.svg",
        "results.md",
    ];
    assert_eq!(names(&docs), made);
    let stamp = |text: &str| text.contains("phototaxis ") && text.contains("Embree ") && text.contains("compiled for ");
    for name in ["door.png", "crops-door.png", "efficiency-scenes.png", "inspect-door.png", "rates.png"] {
        assert!(phototaxis::image::png::text(&docs.join(name), "Comment").is_some_and(|text| stamp(&text)), "{name}");
    }
    let page = std::fs::read_to_string(docs.join("results.md")).unwrap();
    assert!(stamp(page.lines().nth(1).unwrap()) && page.contains("2 scenes, 2 runs"), "{page}");
    for row in ["| `cornell` | ", "| `direct` | ", "| **geometric mean** | ", "repository: veach-ajar, "] {
        assert!(page.contains(row), "{row} is not in {page}");
    }
    let root = env!("CARGO_MANIFEST_DIR");
    assert!(
        !page.contains(root) && !page.contains(&here.path().display().to_string()),
        "no path of this machine: {page}"
    );
    assert!(stderr(&output).contains("SKIPPED: veach-ajar"), "{}", stderr(&output));
}

#[test]
fn methods_can_be_chosen_and_steps_share_references() {
    let here = folder();
    let only = ["--only", "results,validation", "--scenes", "cornell,wall", "--methods", "none,voronoi"];
    let output = figures(here.path(), &[&only[..], &["--time", "0.02"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let page = std::fs::read_to_string(here.path().join("docs/results.md")).unwrap();
    assert!(page.contains("| scene | relMSE of `none` | `voronoi` × |\n"), "{page}");
    let references = names(&here.path().join("work/references"));
    assert_eq!(references.len(), 2, "one a scene, for both steps: {references:?}");
    assert!(!here.path().join("work/validation-resolution/references").exists());
}

#[test]
fn an_unknown_scene_of_the_results_is_refused() {
    let here = folder();
    let output = figures(here.path(), &["--only", "results", "--scenes", "cornel"]);
    assert!(!output.status.success() && stderr(&output).contains("no scene `cornel`"), "{}", stderr(&output));
}

#[test]
fn an_unknown_step_is_refused_before_anything_is_made() {
    let here = folder();
    let output = figures(here.path(), &["--only", "pictures,graphs"]);
    assert!(!output.status.success() && stderr(&output).contains("no step `graphs`"), "{}", stderr(&output));
    assert!(names(here.path()).is_empty());
}
