//! `phototaxis compare --gallery` and `phototaxis generate --gallery`, tiny.

use super::{folder, names, phototaxis, stderr, stdout};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

fn compare(folder: &Path, arguments: &[&str], code: i32) -> Output {
    let mut command = phototaxis(folder);
    command.args(["compare", "-q", "--reference-time", "0.5"]).args(arguments);
    command.assert().code(code).get_output().clone()
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join("compare-out").join(name)).unwrap()
}

const TWO_ROWS: [&str; 9] =
    ["--gallery", "--only", "black,triangle", "--methods", "none,grid,paper-order", "--spp", "4", "--runs", "3"];

#[test]
fn two_rows_of_the_gallery_are_judged() {
    let here = folder();
    compare(here.path(), &TWO_ROWS, 0);
    let out = here.path().join("compare-out");
    assert_eq!(names(&out.join("pictures")).len(), 6);
    assert_eq!(names(&out.join("images")).len(), 12, "the last picture and the worst");
    let csv = read(here.path(), "matrix.csv");
    assert_eq!(csv.lines().count(), 7, "{csv}");
    let table = read(here.path(), "stability.md");
    assert!(table.contains("| | none | grid | paper-order |") && table.contains("| `black` | "), "{table}");
    let results: Value = serde_json::from_str(&read(here.path(), "results.json")).unwrap();
    let cells = results["gallery"]["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 6);
    for cell in cells {
        assert_eq!(cell["repeatable"], true, "{cell}");
        assert_eq!(cell["findings"].as_array().unwrap().len(), 7);
        assert_eq!(cell["findings"][1]["colour"], "green", "finite: {cell}");
        assert_eq!(cell["findings"][5]["colour"], "green", "memory: {cell}");
    }
    // without light all is known: equal pictures, by any method
    let black = cells.iter().filter(|cell| cell["scene"] == "black");
    black.for_each(|cell| assert_eq!(cell["findings"][0]["says"], "equal to the reference", "{cell}"));
    assert!(read(here.path(), "report.html").contains("\"gallery\":{"));
    // what was found is kept: nothing is rendered again
    let lines = read(here.path(), "runs.jsonl").lines().count();
    assert_eq!(lines, 1 + 2 + 6 + 18);
    compare(here.path(), &TWO_ROWS, 0);
    assert_eq!(read(here.path(), "runs.jsonl").lines().count(), lines);
}

#[test]
fn what_is_rendered_block_by_block_gets_samples_for_its_time() {
    let here = folder();
    let timed = ["--gallery", "--only", "triangle", "--methods", "none,paper-order", "--time", "0.05", "--runs", "1"];
    compare(here.path(), &timed, 0);
    let results: Value = serde_json::from_str(&read(here.path(), "results.json")).unwrap();
    let run = results["runs"].as_array().unwrap().iter().find(|r| r["method"] == "paper-order").unwrap();
    // many times as long on a busy machine, but neither one sample nor billions
    let samples = run["samples"].as_u64().unwrap();
    assert!((1..100_000).contains(&samples) && run["wall_seconds"].as_f64().unwrap() < 5.0, "{run}");
}

#[test]
fn only_what_is_there_can_be_chosen() {
    let here = folder();
    let refused = compare(here.path(), &["--gallery", "--only", "furnance"], 1);
    assert!(stderr(&refused).contains("unknown scene `furnance`: did you mean `furnace`?"), "{}", stderr(&refused));
    compare(here.path(), &["--gallery", "--plan", "gallery.toml"], 2);
}

#[test]
fn generate_writes_the_gallery() {
    let here = folder();
    let output = phototaxis(here.path()).args(["generate", "--gallery", "--out", "made"]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let told = stdout(&output);
    assert_eq!(told.lines().count(), names(&here.path().join("made")).len());
    assert!(told.starts_with("made/gallery.toml\n"), "{told}");
}
