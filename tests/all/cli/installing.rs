//! What stands beside the program once it is installed: manual pages and completions.

use super::{folder, names, phototaxis, program, stderr, stdout};
use std::path::Path;
use std::process::Command;

#[test]
fn every_command_has_a_manual_page_with_its_options() {
    let here = folder();
    phototaxis(here.path()).args(["man", "--output", "man1"]).assert().code(0);
    let pages = names(&here.path().join("man1"));
    for page in ["phototaxis.1", "phototaxis-render.1", "phototaxis-farm-plan.1", "phototaxis-bench-rays.1"] {
        assert!(pages.contains(&page.to_string()), "{page} is not in {pages:?}");
    }
    let all = std::fs::read_to_string(here.path().join("man1/phototaxis.1")).unwrap();
    for name in pages.iter().filter_map(|page| page.strip_prefix("phototaxis-")?.strip_suffix(".1")) {
        assert!(name.contains('-') || all.contains(&format!("phototaxis\\-{name}(1)")), "{name} is not in:\n{all}");
    }
    let printed = stdout(&phototaxis(here.path()).args(["man", "render"]).assert().code(0).get_output().clone());
    assert_eq!(printed, std::fs::read_to_string(here.path().join("man1/phototaxis-render.1")).unwrap());
    assert!(printed.contains(".TH phototaxis-render 1") && printed.contains("\\-\\-spp"), "{printed}");
    let unknown = phototaxis(here.path()).args(["man", "bench", "raze"]).assert().code(1).get_output().clone();
    assert!(stderr(&unknown).contains("no command `raze` in `phototaxis-bench`"), "{}", stderr(&unknown));
}

/// What bash offers once `line` has been typed.
fn offered(script: &Path, line: &[&str]) -> String {
    let words = line.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" ");
    let code = format!(
        "source {}; COMP_WORDS=({words}); COMP_CWORD={}; _phototaxis phototaxis '{}' '{}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        script.display(),
        line.len() - 1,
        line[line.len() - 1],
        line[line.len() - 2],
    );
    stdout(&Command::new("bash").args(["-c", &code]).output().unwrap())
}

#[test]
fn bash_completes_commands_options_and_their_values() {
    let here = folder();
    let script = here.path().join("phototaxis.bash");
    let printed = phototaxis(here.path()).args(["completions", "bash"]).assert().code(0).get_output().clone();
    std::fs::write(&script, printed.stdout).unwrap();
    assert_eq!(offered(&script, &["phototaxis", "ren"]).trim(), "render");
    let options = offered(&script, &["phototaxis", "render", "--gu"]);
    assert!(options.lines().any(|line| line == "--guide"), "{options}");
    let values = offered(&script, &["phototaxis", "render", "--guide", "ad"]);
    assert_eq!(values.trim(), "adaptive");
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let printed = phototaxis(here.path()).args(["completions", shell]).assert().code(0).get_output().clone();
        assert!(stdout(&printed).contains("--guide") || stdout(&printed).contains("-l guide"), "{shell}");
    }
}

#[test]
fn make_install_puts_all_below_its_prefix_and_uninstall_takes_all_away() {
    let here = folder();
    let make = |target: &str| {
        let mut command = Command::new("make");
        command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["-s", target, "PREFIX=/usr"]);
        command.arg(format!("DESTDIR={}", here.path().display()));
        command.arg(format!("PROGRAM={}", program().display()));
        command.status()
    };
    let Ok(status) = make("install") else {
        eprintln!("SKIPPED: make install was not tried: there is no make");
        return;
    };
    assert!(status.success());
    let usr = here.path().join("usr");
    for file in [
        "bin/phototaxis",
        "share/man/man1/phototaxis.1",
        "share/bash-completion/completions/phototaxis",
        "share/zsh/site-functions/_phototaxis",
        "share/fish/vendor_completions.d/phototaxis.fish",
    ] {
        assert!(usr.join(file).metadata().is_ok_and(|found| found.len() > 1000), "{file}");
    }
    assert!(Command::new(usr.join("bin/phototaxis")).arg("--version").status().unwrap().success());
    assert!(make("uninstall").unwrap().success());
    for folder in ["bin", "share/man/man1", "share/zsh/site-functions"] {
        assert!(names(&usr.join(folder)).is_empty(), "{folder}");
    }
}
