//! The folders of `src` stand in layers: each uses only what is listed before it, so that data flows one way and a folder
//! can be read, tested and replaced without those above it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// From the ground up. `error` is a single file; `lib.rs` and `main.rs` only name the others.
const LAYERS: &[&str] = &[
    "error",
    "simd",
    "io",
    "math",
    "document",
    "stats",
    "geometry",
    "embree",
    "image",
    "draw",
    "denoise",
    "texture",
    "fields",
    "film",
    "bsdf",
    "light",
    "guiding",
    "scene",
    "integrator",
    "render",
    "format",
    "platform",
    "inspect",
    "lab",
    "cli",
];

/// The guide could be a crate of its own: it sees positions, normals and directions, and needs nothing else.
const GUIDING_USES: &[&str] = &["math", "simd"];

/// Modules that the text of a source file names after `crate::`, comments and tests left out.
fn uses(text: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    let code: String = lines.collect::<Vec<_>>().join("\n");
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        let listed = rest.strip_prefix('{').map(|rest| rest.split_once('}').map_or(rest, |(list, _)| list));
        let names = listed.unwrap_or(rest).split(',').take(if listed.is_some() { usize::MAX } else { 1 });
        found.extend(
            names.map(|name| {
                name.trim().chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect::<String>()
            }),
        );
    }
    found.remove("");
    found
}

/// Source files of the library by their folder, without tests.
fn sources() -> BTreeMap<String, Vec<PathBuf>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut sources, mut folders) = (BTreeMap::<String, Vec<PathBuf>>::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            if name.ends_with("tests") || name == "fixtures" {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let top = path.strip_prefix(&root).unwrap().iter().next().unwrap();
                let top = Path::new(top).file_stem().unwrap().to_string_lossy().into_owned();
                sources.entry(top).or_default().push(path);
            }
        }
    }
    sources.retain(|top, _| top != "lib" && top != "main");
    sources
}

/// What is wrong with `folder` using `used`.
fn fault(folder: &str, used: &str) -> Option<String> {
    let level = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let (Some(own), Some(other)) = (level(folder), level(used)) else {
        return Some(format!("{folder} uses {used}, and one of them is no layer"));
    };
    (other > own).then(|| format!("{folder} uses {used}, which is built on it"))
}

#[test]
fn no_folder_uses_one_that_is_built_on_it() {
    let sources = sources();
    let known: BTreeSet<&str> = LAYERS.iter().copied().collect();
    assert_eq!(sources.keys().map(String::as_str).collect::<BTreeSet<_>>(), known, "every folder is a layer");
    for (folder, files) in &sources {
        for file in files {
            let used = uses(&std::fs::read_to_string(file).unwrap());
            for used in used.iter().filter(|used| known.contains(used.as_str()) && *used != folder) {
                let fault = fault(folder, used);
                assert!(fault.is_none(), "{}: {}", file.display(), fault.unwrap());
            }
        }
    }
}

#[test]
fn the_guide_needs_nothing_but_numbers() {
    for file in &sources()["guiding"] {
        let used = uses(&std::fs::read_to_string(file).unwrap());
        let foreign = used.iter().filter(|used| *used != "guiding" && LAYERS.contains(&used.as_str()));
        let foreign: Vec<_> = foreign.filter(|used| !GUIDING_USES.contains(&used.as_str())).collect();
        assert!(foreign.is_empty(), "{}: {foreign:?}", file.display());
    }
}

/// Folders in which the compiler's rules may be broken, each with its reasons beside.
const UNSAFE: [&str; 3] = ["denoise", "embree", "simd"];

#[test]
fn unsafe_code_is_where_it_is_said_to_be() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut folders) = (BTreeSet::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if std::fs::read_to_string(&path).is_ok_and(|text| allows_unsafe(&text)) {
                let top = path.strip_prefix(&root).unwrap().iter().next().unwrap();
                found.insert(top.to_string_lossy().into_owned());
            }
        }
    }
    assert_eq!(found, UNSAFE.map(String::from).into());
}

/// Whether an attribute of the text switches the lint off.
fn allows_unsafe(text: &str) -> bool {
    text.split("#![allow(")
        .chain(text.split("#[allow("))
        .skip(1)
        .any(|rest| rest.trim_start().starts_with("unsafe_code"))
}

#[test]
fn unsafe_code_elsewhere_would_be_seen() {
    assert!(allows_unsafe("//! a\n#![allow(unsafe_code)]") && allows_unsafe("#[allow(\n    unsafe_code\n)]"));
    assert!(!allows_unsafe("#![allow(dead_code)] // unsafe_code"));
}

#[test]
fn an_arrow_that_runs_back_up_would_be_seen() {
    let text = "//! crate::cli\nuse crate::{Result, render, math::Rgb};\nfn f(s: &crate::scene::Scene) {}\n\
                #[cfg(test)]\nmod tests { use crate::cli::run; }";
    assert_eq!(uses(text), ["math", "render", "scene"].map(String::from).into());
    assert!(fault("math", "render").is_some() && fault("math", "nowhere").is_some());
    assert!(fault("render", "math").is_none());
}

/// Files that a source file's `mod NAME;` lines lead to, and those that these lead to.
fn reach(path: &Path, reached: &mut BTreeSet<PathBuf>) {
    let Ok(text) = std::fs::read_to_string(path) else { return };
    if !reached.insert(path.to_path_buf()) {
        return;
    }
    let (folder, stem) = (path.parent().unwrap(), path.file_stem().unwrap().to_string_lossy().into_owned());
    let below = if ["mod", "lib", "main"].contains(&&*stem) { folder.to_path_buf() } else { folder.join(&stem) };
    let mut named = None;
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix("#[path = \"").and_then(|rest| rest.strip_suffix("\"]")) {
            named = Some(folder.join(name));
        } else if let Some(module) =
            line.strip_suffix(';').and_then(|line| line.rsplit_once("mod ")).map(|(_, name)| name)
        {
            match named.take() {
                Some(path) => reach(&path, reached),
                None => {
                    reach(&below.join(format!("{module}.rs")), reached);
                    reach(&below.join(module).join("mod.rs"), reached);
                }
            }
        }
    }
}

/// A file of tests that no module names would never run, and nobody would see.
#[test]
fn every_source_file_is_part_of_a_module() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut reached = BTreeSet::new();
    for top in ["src/lib.rs", "src/main.rs", "tests/all/main.rs", "tests/fuzz/main.rs"] {
        reach(&root.join(top), &mut reached);
    }
    let mut folders = vec![root.join("src"), root.join("tests/all"), root.join("tests/fuzz")];
    let mut lost = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && !reached.contains(&path) {
                lost.push(path);
            }
        }
    }
    assert!(lost.is_empty(), "no module names {lost:?}");
    assert!(reached.len() > 200, "the walk itself found {} files", reached.len());
}

/// docs/validation.md lists constants that were chosen; each must stand in the source with the value that is told.
#[test]
fn the_constants_that_the_documentation_tells_are_those_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/validation.md")).unwrap();
    let rows = page.lines().filter(|line| line.starts_with("| `") && line.contains(".rs |"));
    let mut count = 0;
    for row in rows {
        let fields: Vec<&str> = row.split('|').map(|field| field.trim().trim_matches('`')).collect();
        let [_, name, value, file, ..] = fields[..] else { panic!("{row}") };
        let source = std::fs::read_to_string(root.join("src").join(file)).unwrap();
        let line = source.lines().find(|line| line.contains(&format!("const {name}:")));
        assert!(
            line.is_some_and(|line| line.ends_with(&format!(" = {value};"))),
            "{name} is {line:?} in {file}, not {value}"
        );
        count += 1;
    }
    assert!(count > 10, "{count} rows");
}
