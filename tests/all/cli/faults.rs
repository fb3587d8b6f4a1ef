//! `phototaxis render`, when something is wrong: exit code 1, one clear message, and no picture.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use std::path::Path;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// Runs a render that fails, and returns its message.
fn failure(here: &Path, arguments: &[&str]) -> String {
    let output = phototaxis(here).arg("render").args(arguments).args(TINY).assert().code(1).get_output().clone();
    assert_eq!(stdout(&output), "");
    assert!(stderr(&output).starts_with("error: "), "{}", stderr(&output));
    stderr(&output).trim_end().to_string()
}

/// The message about a file with this text.
fn failure_of(name: &str, text: &str) -> String {
    let here = folder();
    std::fs::write(here.path().join(name), text).unwrap();
    std::fs::write(here.path().join("good.obj"), format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    let message = failure(here.path(), &[name]);
    assert_eq!(names(here.path()).len(), 2, "something was written: {:?}", names(here.path()));
    message
}

#[test]
fn a_missing_file_is_named_once() {
    let message = failure(folder().path(), &["nowhere.toml"]);
    assert!(message.starts_with("error: nowhere.toml: No such file or directory"), "{message}");
    assert_eq!(message.matches("No such file").count(), 1, "{message}");
    let message = failure_of("a.toml", "[[mesh]]\npath = \"nowhere.obj\"\n");
    assert!(message.contains("nowhere.obj: No such file"), "{message}");
}

#[test]
fn a_file_of_another_kind_is_refused() {
    let message = failure_of("a.stl", "solid");
    assert!(message.contains("a.stl") && message.contains(".obj"), "{message}");
}

#[test]
fn a_file_that_a_decoder_panics_on_is_an_error_and_nothing_else() {
    // gltf-json 1.4 looks up the accessor without asking whether there is one.
    let primitive = r#"{"primitives": [{"attributes": {"POSITION": 0}}]}"#;
    let message = failure_of("a.gltf", &format!(r#"{{"asset": {{"version": "2.0"}}, "meshes": [{primitive}]}}"#));
    assert!(message.starts_with("error: a.gltf: ") && message.lines().count() == 1, "{message}");
}

#[test]
fn faults_of_a_model_have_file_and_line() {
    let number = failure_of("a.obj", "v 0 0 0\nv 1 zero 0\n");
    assert!(number.starts_with("error: a.obj:2:"), "{number}");
    let index = failure_of("b.obj", &format!("{TRIANGLE}f 1 2 4\n"));
    assert!(index.starts_with("error: b.obj:4:"), "{index}");
    let nan = failure_of("c.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    assert!(nan.starts_with("error: c.obj:2") && nan.contains("not finite"), "{nan}");
    let empty = failure_of("d.obj", "# nothing\n");
    assert!(empty.contains("no triangles"), "{empty}");
}

#[test]
fn faults_of_a_scene_file_have_line_column_and_advice() {
    let key = failure_of("a.toml", "[[mesh]]\npath = \"good.obj\"\n\n[film]\nwidht = 64\n");
    assert!(key.starts_with("error: a.toml:5:1: ") && key.contains("`width`"), "{key}");
    let range = failure_of("b.toml", "[guiding]\nbsdf_fraction = 2\n");
    assert!(range.starts_with("error: b.toml:2:17: "), "{range}");
    let syntax = failure_of("c.toml", "[film\nwidth = 3\n");
    assert!(syntax.starts_with("error: c.toml:1:"), "{syntax}");
}

#[test]
fn faults_of_set_quote_it() {
    let here = folder();
    let file = scene("cornell.toml");
    let message = failure(here.path(), &[file.to_str().unwrap(), "--set", "guiding.resolutoin=3"]);
    assert!(message.contains("--set 'guiding.resolutoin=3'") && message.contains("`resolution`"), "{message}");
    assert!(names(here.path()).is_empty());
}

#[test]
fn what_could_not_be_written_is_refused_before_rendering() {
    let here = folder();
    std::fs::create_dir(here.path().join("folder.exr")).unwrap();
    let file = scene("cornell.toml");
    // So many samples would take hours.
    let long = [file.to_str().unwrap(), "--spp", "1000000000"];
    let cases: [(&[&str], &str); 5] = [
        (&["-o", "a.jpg"], "error: a.jpg: pictures are written as .exr or .png"),
        (&["-o", "a"], "error: a: pictures are written as .exr or .png"),
        (&["-o", "no/a.exr"], "error: no/a.exr: its folder does not exist"),
        (&["-o", "folder.exr"], "error: folder.exr: it is a folder"),
        (&["-o", "a.exr", "--json", "no/a.json"], "error: no/a.json: its folder does not exist"),
    ];
    for (arguments, expected) in cases {
        assert_eq!(failure(here.path(), &[&long[..], arguments].concat()), expected);
    }
    assert_eq!(names(here.path()), ["folder.exr"]);
}

#[cfg(unix)]
#[test]
fn a_full_disk_fails_but_the_other_files_are_written() {
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: this system has no /dev/full");
        return;
    }
    let here = folder();
    std::os::unix::fs::symlink("/dev/full", here.path().join("full.exr")).unwrap();
    let file = scene("cornell.toml");
    let outputs = ["--spp", "1", "-o", "full.exr", "-o", "a.png", "-o", "b.exr", "--json", "/dev/full"];
    let message = failure(here.path(), &[&[file.to_str().unwrap()][..], &outputs].concat());
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), 2, "{message}");
    assert!(lines[0].starts_with("error: full.exr: No space left"), "{message}");
    assert!(lines[1].starts_with("error: /dev/full: No space left"), "{message}");
    assert_eq!(names(here.path()), ["a.png", "b.exr", "full.exr"]);
    assert!(phototaxis::image::exr::read_layers(&here.path().join("b.exr")).is_ok());
    assert!(image::open(here.path().join("a.png")).is_ok());
}

#[test]
fn sizes_that_there_is_no_memory_for_are_errors_by_name() {
    let here = folder();
    let size = |side: &str| [format!("film.width={side}"), format!("film.height={side}")];
    let message = |limit: &str, set: &[String]| {
        // a shell sets the limit of address space
        let mut shell = assert_cmd::Command::new("sh");
        shell.current_dir(here.path()).args(["-c", &format!("ulimit -v {limit}; exec \"$0\" \"$@\"")]);
        shell.arg(assert_cmd::cargo::cargo_bin!("phototaxis")).arg("render").arg(scene("cornell.toml"));
        shell.args(set.iter().flat_map(|text| ["--set", text])).args(["--threads", "1", "-q"]);
        stderr(shell.assert().code(1).get_output()).trim_end().to_string()
    };
    let film = message("unlimited", &size("65536"));
    assert!(film.starts_with("error: film.width × film.height: 65536 × 65536 pixels take "), "{film}");
    assert!(film.ends_with(" are free") && film.lines().count() == 1, "{film}");
    // 6.4 GB of pixels where the process may have 3
    let film = message("3000000", &size("5000"));
    assert!(film.starts_with("error: film.width × film.height: 5000 × 5000 pixels take "), "{film}");
    let guide = message("unlimited", &["guiding.memory=9000 TiB".to_string()]);
    assert!(guide.starts_with("error: guiding.memory: tables of the guide may take 8.79 PiB, "), "{guide}");
    assert!(names(here.path()).is_empty());
}

#[test]
fn pictures_that_are_missing_are_errors_where_strict() {
    let here = folder();
    std::fs::write(here.path().join("a.mtl"), "newmtl m\nmap_Kd nowhere.png\n").unwrap();
    std::fs::write(here.path().join("a.obj"), format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n")).unwrap();
    let message = failure(here.path(), &["a.obj", "--strict"]);
    assert!(message.contains("nowhere.png: the picture of material `m` is missing"), "{message}");
    let output = phototaxis(here.path()).args(["render", "a.obj", "--spp", "1"]).args(TINY).assert().success();
    assert!(stderr(output.get_output()).contains("warning: nowhere.png: the picture of material `m` is missing"));
}
