//! The commands of README.md, as they stand there but for budgets that a test has time for.

use super::{folder, phototaxis, stderr};
use std::path::Path;

/// The lines of the fenced blocks of commands, without comments.
fn commands() -> Vec<String> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let blocks = text.split("```sh\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0));
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" #").next().unwrap_or_default().trim().to_string());
    lines.filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

/// A command with less to do: tenths of a second in place of minutes, a picture of some hundred pixels, one run.
fn small(command: &str) -> Vec<String> {
    let mut words: Vec<String> = command.split_whitespace().skip(1).map(String::from).collect();
    for k in 1..words.len() {
        match words[k - 1].as_str() {
            "--time" => words[k] = if words[k].contains(',') { "0.05,0.1".into() } else { "0.1".into() },
            "--reference-time" => words[k] = "0.2".into(),
            // pixels of the whole picture count from 0 to 15 and to 11
            "--pixel" => words[k] = "3,9".into(),
            _ => {}
        }
    }
    words.iter_mut().filter(|word| *word == "--serve").for_each(|word| *word = "--serve=127.0.0.1:0".into());
    let more: &[&str] = match words[0].as_str() {
        "render" => &["--quiet", "--set", "film.width=16", "--set", "film.height=12"],
        "inspect" => {
            &["--quiet", "--set", "film.width=16", "--set", "film.height=12", "--spp", "4", "--truth-samples", "2"]
        }
        "compare" => &["--quiet", "--set", "film.width=16", "--set", "film.height=12", "--runs", "1"],
        _ => &[],
    };
    words.extend(more.iter().map(|word| word.to_string()));
    words
}

#[test]
fn every_command_of_the_readme_does_what_it_says() {
    let here = folder();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::os::unix::fs::symlink(root.join("scenes"), here.path().join("scenes")).unwrap();
    let makefile = std::fs::read_to_string(root.join("Makefile")).unwrap();
    let all = commands();
    assert!(all.len() >= 7, "{all:?}");
    for command in all {
        if let Some(target) = command.strip_prefix("make ") {
            assert!(makefile.contains(&format!("\n{target}:")), "{command}");
            continue;
        }
        let output = phototaxis(here.path()).args(small(&command)).output().unwrap();
        let said = stderr(&output);
        if command.contains("--denoise") && said.contains("Open Image Denoise") && !output.status.success() {
            eprintln!("SKIPPED: `{command}` of README.md: Open Image Denoise is not installed");
            continue;
        }
        assert!(output.status.success(), "{command}: {said}");
    }
    for file in ["door.exr", "door.png", "brighter.png", "compare-out/report.html", "look/hemisphere.png"] {
        assert!(here.path().join(file).exists(), "{file}");
    }
}

#[test]
fn the_readme_is_short_and_its_links_and_pictures_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("README.md")).unwrap();
    assert!(text.lines().count() <= 120, "{} lines", text.lines().count());
    let targets = text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    let own: Vec<&str> = targets.filter(|target| !target.contains("://")).collect();
    assert!(own.len() > 20, "{own:?}");
    for target in own {
        let (file, heading) = target.split_once('#').unwrap_or((target, ""));
        assert!(root.join(file).exists(), "{file} is missing");
        let anchor = |line: &str| -> String {
            let kept = line.trim_start_matches('#').trim().to_lowercase();
            kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
        };
        let there = || {
            std::fs::read_to_string(root.join(file))
                .unwrap()
                .lines()
                .any(|l| l.starts_with('#') && anchor(l) == heading)
        };
        assert!(heading.is_empty() || there(), "{target}");
    }
}
