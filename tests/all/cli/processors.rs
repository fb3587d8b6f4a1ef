//! The program as on other processors: Embree held to each instruction set, what is said of that, and threads.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use phototaxis::embree::{ISA_VARIABLE, Isa};
use phototaxis::image::exr::{Attribute, read_layers};
use phototaxis::platform::Platform;
use serde_json::Value;
use std::path::Path;

/// A cube with the bottom open, in halves of two materials, and its corners.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    usemtl one\nf 4 3 2 1\nf 5 6 7 8\nf 2 3 7 6\nusemtl two\nf 1 5 8 4\nf 4 8 7 3\n";

const ROUGH_GLASS: &str = "[[mesh]]\npath = \"cube.obj\"\n[film]\nwidth = 40\nheight = 30\n\
    [material.one]\ntype = \"dielectric\"\nalpha = 0.3\n\
    [[light]]\ntype = \"constant\"\nradiance = 1\n[[light]]\ntype = \"point\"\nposition = [2, 3, 2]\nintensity = 5\n";

/// Bare models and small scenes, whose waves of shadow rays seldom fill their packets. Without AVX-512 Embree 3 looks at
/// lanes that no ray is in, and a build of it with assertions ends the process where they are no numbers.
#[test]
fn small_scenes_render_at_every_instruction_set() {
    let here = folder();
    std::fs::write(here.path().join("cube.obj"), CUBE).unwrap();
    std::fs::write(here.path().join("glass.toml"), ROUGH_GLASS).unwrap();
    let cornell = scene("cornell.obj");
    for isa in Isa::available() {
        for (subject, size) in [("cube.obj", [64, 36]), ("glass.toml", [40, 30]), (cornell.to_str().unwrap(), [64, 48])]
        {
            let [width, height] = size;
            let mut command = phototaxis(here.path());
            command.args(["render", subject, "--isa", isa.name(), "--spp", "16", "-q", "-o", "a.exr"]);
            command.args(["--set", &format!("film.width={width}"), "--set", &format!("film.height={height}")]);
            command.assert().code(0);
            let picture = read_layers(&here.path().join("a.exr")).unwrap();
            let red = &picture.channels["R"];
            assert!(red.iter().all(|x| x.is_finite()) && red.iter().any(|&x| x > 0.0), "{subject}, {}", isa.name());
        }
    }
}

/// The program told an instruction set by its option, or by the environment.
fn with(here: &Path, option: Option<&str>, variable: Option<&str>) -> assert_cmd::Command {
    let mut command = phototaxis(here);
    command.env_remove(ISA_VARIABLE);
    command.arg("render").arg(scene("cornell.toml")).args(TINY);
    option.iter().for_each(|isa| _ = command.args(["--isa", isa]));
    variable.iter().for_each(|isa| _ = command.env(ISA_VARIABLE, isa));
    command
}

#[test]
fn the_option_goes_before_the_environment_and_both_are_told() {
    let sets: Vec<Isa> = Isa::available().collect();
    let (Some(smallest), Some(largest)) = (sets.first(), sets.last()) else { return };
    let (smallest, largest) = (smallest.name(), largest.name());
    for (option, variable, expected) in [
        (None, None, largest),
        (Some(smallest), None, smallest),
        (None, Some(smallest), smallest),
        (Some(largest), Some(smallest), largest),
    ] {
        let here = folder();
        let mut command = with(here.path(), option, variable);
        let output = command.args(["--spp", "2", "-o", "a.exr", "--json", "-"]).assert().code(0).get_output().clone();
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["platform"]["embree_isa"], expected, "{option:?} {variable:?}");
        let attributes = read_layers(&here.path().join("a.exr")).unwrap().attributes;
        assert_eq!(attributes["embreeIsa"], Attribute::Text(expected.into()));
        for (key, name) in [("compiled_for", "compiledFor"), ("embree", "embree")] {
            let told = report["platform"][key].as_str().unwrap_or_else(|| panic!("{key} in {report}"));
            assert_eq!(attributes[name], Attribute::Text(told.into()));
        }
    }
}

#[test]
fn wrong_instruction_sets_are_refused_with_those_there_are() {
    let here = folder();
    let lacking = Isa::ALL.into_iter().find(|isa| Isa::available().all(|there| there != *isa)).map(Isa::name);
    for wrong in ["avx1024", "", "AVX2"].into_iter().chain(lacking) {
        for (option, variable) in [(Some(wrong), None), (None, Some(wrong))] {
            let output = with(here.path(), option, variable).assert().code(2).get_output().clone();
            let message = stderr(&output);
            assert!(Isa::available().all(|isa| message.contains(isa.name())), "{message}");
            assert!(message.contains("--isa"), "{message}");
        }
        // what knows no --isa is told by the environment alone
        let mut version = phototaxis(here.path());
        let output = version.arg("--version").env(ISA_VARIABLE, wrong).assert().code(1).get_output().clone();
        assert!(stderr(&output).contains(ISA_VARIABLE), "{}", stderr(&output));
    }
    assert!(names(here.path()).is_empty());
}

#[test]
fn the_version_names_build_processor_and_embree() {
    let here = folder();
    for isa in Isa::available() {
        for flag in ["--version", "-V"] {
            let mut command = phototaxis(here.path());
            let output = command.arg(flag).env(ISA_VARIABLE, isa.name()).assert().code(0).get_output().clone();
            let text = stdout(&output);
            assert!(text.starts_with(&format!("phototaxis {}", env!("CARGO_PKG_VERSION"))), "{text}");
            assert!(text.contains("compiled for ") && text.contains("Embree "), "{text}");
            assert!(text.lines().next().unwrap().ends_with(&format!("with {}", isa.name())), "{text}");
            let all = text.contains(&format!("compiled for {},", Platform::here().unwrap().processor));
            assert_eq!(text.contains("make build") && text.contains("make portable"), !all, "{text}");
        }
    }
}

#[test]
fn errors_and_benches_say_what_they_ran_on() {
    let here = folder();
    let of = |arguments: &[&str]| -> String {
        let output = phototaxis(here.path()).args(arguments).assert().code(0).get_output().clone();
        stdout(&output)
    };
    let scene = scene("cornell.toml");
    let scene = scene.to_str().unwrap();
    of(&[&["render", scene, "-q", "--spp", "2", "-o", "a.exr"], &TINY[..]].concat());
    let json = |text: String| serde_json::from_str::<Value>(&text).unwrap()["platform"]["embree_isa"].clone();
    assert!(json(of(&["error", "a.exr", "--reference", "a.exr"])).is_string());
    let bench = [&["bench", "render", scene, "--turns", "1", "--spp", "32", "--methods", "none"], &TINY[..]].concat();
    assert!(json(of(&[&bench[..], &["--json", "-"]].concat())).is_string());
    let table = of(&bench);
    assert!(table.starts_with("phototaxis ") && table.lines().next().unwrap().contains("Embree"), "{table}");
}

#[test]
fn more_threads_than_processors_are_limited_with_a_word() {
    let here = folder();
    let processors = std::thread::available_parallelism().unwrap().get();
    let render = |threads: usize, more: &[&str]| {
        let mut command = phototaxis(here.path());
        command
            .arg("render")
            .arg(scene("cornell.toml"))
            .args(TINY)
            .args(["--spp", "2", "-o", "a.exr", "--json", "a.json"]);
        let output = command.args(["--threads", &threads.to_string()]).args(more).assert().code(0).get_output().clone();
        let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
        (stderr(&output), report["threads"].as_u64().unwrap() as usize)
    };
    let (said, used) = render(4000.max(2 * processors), &[]);
    assert!(said.contains("--threads 4000") || processors > 2000, "{said}");
    assert!(said.contains(&processors.to_string()) && used == processors, "{used} threads: {said}");
    let (said, used) = render(processors, &[]);
    assert!(!said.contains("--threads") && used == processors, "{used} threads: {said}");
    assert_eq!(render(4000.max(2 * processors), &["-q"]), (String::new(), processors), "a warning is not for --quiet");
}
