//! docs/scene-file.md against the readers: its tables are theirs, and what it says is a default changes nothing.

use super::*;
use crate::format::reference::{self, Section};
use std::collections::{BTreeMap, BTreeSet};

const PAGE: &str = include_str!("../../../docs/scene-file.md");

/// The least that must be said before the keys under a heading can be left out or given.
const MINIMAL: &[(&str, &str)] = &[
    ("[camera]", "[camera]\norigin = [0, 1, 5]\ntarget = [0, 1, 0]\n"),
    ("[[camera.key]]", "[camera]\norigin = [0, 1, 5]\ntarget = [0, 1, 0]\n[[camera.key]]\nframe = 1\n"),
    ("[film]", "[film]\n"),
    ("[[mesh]]", "[[mesh]]\npath = 'a.obj'\n"),
    ("[[instance]]", "[[mesh]]\npath = 'a.obj'\ngroup = 'a'\n[[instance]]\ngroup = 'a'\n"),
    ("rotate", "[[mesh]]\npath = 'a.obj'\n[mesh.rotate]\naxis = [0, 1, 0]\nangle = 30\n"),
    ("[material.NAME]", "[material.A]\ntype = 'diffuse'\n"),
    ("diffuse", "[material.A]\ntype = 'diffuse'\n"),
    ("diffuse_transmitter", "[material.A]\ntype = 'diffuse_transmitter'\n"),
    ("mirror", "[material.A]\ntype = 'mirror'\n"),
    ("conductor", "[material.A]\ntype = 'conductor'\n"),
    ("dielectric", "[material.A]\ntype = 'dielectric'\n"),
    ("plastic", "[material.A]\ntype = 'plastic'\n"),
    ("principled", "[material.A]\ntype = 'principled'\n"),
    (
        "blend",
        "[material.B]\ntype = 'diffuse'\n[material.C]\ntype = 'diffuse'\n[material.A]\ntype = 'blend'\nmaterials = ['B', 'C']\n",
    ),
    ("texture", "[material.A]\ntype = 'diffuse'\n[material.A.reflectance]\ntexture = 'a.png'\n"),
    ("opacity", "[material.A]\ntype = 'diffuse'\n[material.A.opacity]\ntexture = 'a.png'\n"),
    ("emission", "[material.A]\ntype = 'diffuse'\n[material.A.emission]\ntexture = 'a.png'\n"),
    ("normal_map", "[material.A]\ntype = 'diffuse'\n[material.A.normal_map]\ntexture = 'a.png'\n"),
    ("bump_map", "[material.A]\ntype = 'diffuse'\n[material.A.bump_map]\ntexture = 'a.png'\n"),
    ("[[light]]", "[[light]]\ntype = 'constant'\nradiance = 1\n"),
    ("constant", "[[light]]\ntype = 'constant'\nradiance = 1\n"),
    ("environment", "[[light]]\ntype = 'environment'\npath = 'a.exr'\n"),
    ("point", "[[light]]\ntype = 'point'\nposition = [0, 1, 0]\nintensity = 1\n"),
    ("directional", "[[light]]\ntype = 'directional'\ndirection = [0, 1, 0]\nirradiance = 1\n"),
    ("sun", "[[light]]\ntype = 'sun'\ndirection = [0, -1, 0]\nirradiance = 1\n"),
    ("sky", "[[light]]\ntype = 'sky'\nsun_direction = [0, 1, 0]\n"),
    ("spot", "[[light]]\ntype = 'spot'\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\nintensity = 1\n"),
    ("[integrator]", "[integrator]\n"),
    ("[guiding]", "[guiding]\n"),
    ("[render]", "[render]\n"),
];

/// The same of `[camera]`.
const WITH_OF_CAMERA: &[(&[&str], &str)] = &[(&["view_height"], "projection = 'orthographic'\n")];

/// What keys of `[guiding]` are refused without.
const WITH: &[(&[&str], &str)] = &[
    (&["normals"], "method = 'grid'\n"),
    (&["sites", "placement"], "method = 'voronoi'\n"),
    (&["strata", "smoothing"], "table = 'hemisphere'\n"),
    (&["blend_visits"], "rule = 'blend'\n"),
    (&["alpha"], "rate = 'constant'\n"),
    (&["leaf_samples", "rho", "directional_filter"], "method = 'sdtree'\n"),
];

/// Of every heading with a table: its keys and what stands in the column "default".
fn page() -> BTreeMap<String, BTreeMap<String, String>> {
    let mut sections: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    let mut heading = "";
    for line in PAGE.lines() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim().trim_matches('`');
        } else if line.starts_with("| `") {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let key = cells[1].trim_matches('`').to_string();
            sections.entry(heading.to_string()).or_default().insert(key, cells[3].to_string());
        }
    }
    sections
}

/// The page with its tables as the readers have them.
fn written_anew() -> String {
    let sections = reference::sections();
    let (mut page, mut heading, mut in_table) = (String::new(), "", false);
    for line in PAGE.lines() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim().trim_matches('`');
        }
        let known = sections.iter().find(|section| section.heading == heading);
        let row = line.starts_with("| `");
        match known {
            Some(section) if row && !in_table => section.keys.iter().for_each(|info| page += &(info.row() + "\n")),
            Some(_) if row => {}
            _ => page += &(line.to_string() + "\n"),
        }
        in_table = row;
    }
    page
}

/// With `UPDATE_REFERENCE=1` in the environment the page is written.
#[test]
fn the_page_s_tables_are_the_readers() {
    let anew = written_anew();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene-file.md");
        std::fs::write(path, &anew).unwrap();
        return;
    }
    for (is, should) in PAGE.lines().zip(anew.lines()) {
        assert_eq!(is, should, "UPDATE_REFERENCE=1 make test writes docs/scene-file.md anew");
    }
    assert_eq!(PAGE.lines().count(), anew.lines().count());
}

#[test]
fn methods_are_listed_as_the_help_lists_them() {
    for (name, meaning) in reference::METHODS {
        let line = format!("- `\"{name}\"`: {meaning}");
        assert!(PAGE.lines().any(|l| l.starts_with(&line)), "{line}");
    }
    let names = GuidingMethod::NAMES.map(|(name, _)| name);
    assert_eq!(names, reference::METHODS.map(|(name, _)| name));
}

#[test]
fn every_key_has_a_meaning() {
    for Section { heading, keys } in reference::sections() {
        for info in keys {
            assert!(!info.key.meaning.is_empty(), "{heading} {}", info.key.name);
        }
    }
}

#[test]
fn every_table_of_the_page_is_of_the_reader() {
    let read: BTreeSet<&str> = MINIMAL.iter().map(|(heading, _)| *heading).collect();
    let written = page();
    assert_eq!(read, written.keys().map(String::as_str).collect());
}

/// What a text says, but for the lines on which it does.
fn read(text: &str) -> String {
    let (mut file, warnings) = parse(text, Path::new("s.toml"), &[]).unwrap_or_else(|e| panic!("{text}: {e}"));
    file.scene.meshes.iter_mut().for_each(|mesh| mesh.location = None);
    file.scene.instances.iter_mut().for_each(|instance| instance.location = None);
    format!("{:?}", (file, warnings))
}

#[test]
fn defaults_are_the_page_s() {
    let page = page();
    let mut tried = 0;
    for (heading, minimal) in MINIMAL {
        for (key, default) in &page[*heading] {
            if default == "required" || default == "none" {
                continue;
            }
            let known = if *heading == "[guiding]" { WITH } else { WITH_OF_CAMERA };
            let with = known.iter().find(|(keys, _)| keys.contains(&key.as_str()));
            let minimal = format!("{minimal}{}", with.map_or("", |(_, text)| text));
            let said = format!("{minimal}{key} = {}\n", default.trim_matches('`'));
            assert_eq!(read(&said), read(&minimal), "{heading} {key}");
            tried += 1;
        }
    }
    assert!(tried > 40, "{tried}");
    assert_ne!(read("[film]\nwidth = 1281"), read("[film]\n"), "a wrong default would be seen");
}

#[test]
fn keys_of_another_method_are_refused_in_the_document_that_gives_them() {
    for (keys, with) in WITH {
        for key in *keys {
            let info = reference::sections().into_iter().find(|s| s.heading == "[guiding]").unwrap().keys;
            let default = info.iter().find(|info| info.key.name == *key).unwrap().default.clone();
            let alone = format!("[guiding]\n{key} = {default}\n");
            let fault = parse(&alone, Path::new("s.toml"), &[]).unwrap_err().to_string();
            assert!(fault.starts_with(&format!("s.toml:2:{}: `{key}` in [guiding] needs ", key.len() + 4)), "{fault}");
            // the file was right for its own method, and what is laid over it is of another
            let text = format!("[guiding]\n{with}{key} = {default}\n");
            let other = ["guiding.method=none".to_string()];
            assert!(parse(&text, Path::new("s.toml"), &other).is_ok(), "{text}");
            let both = ["guiding.method=none".to_string(), format!("guiding.{key}={default}")];
            assert!(parse("", Path::new("s.toml"), &both).is_err(), "{key}");
        }
    }
}

#[test]
fn the_example_is_right() {
    let text = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let (SceneFile { scene, guiding, .. }, warnings) = parse(text, Path::new("s.toml"), &[]).unwrap();
    assert!(warnings.is_empty());
    assert_eq!((scene.meshes.len(), scene.materials.len(), scene.lights.len()), (2, 2, 1));
    assert_eq!(guiding.memory, 512 << 20);
}
