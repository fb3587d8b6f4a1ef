//! docs/scene-file.md against the reader: the same keys, the same defaults.

use super::reader::Reader;
use super::scattering::{KINDS, Kind};
use super::tree::{At, Fault, from_toml};
use super::*;
use crate::texture::ScalarTexture;
use std::collections::{BTreeMap, BTreeSet};

const PAGE: &str = include_str!("../../../docs/scene-file.md");

/// The least that must be said before the keys under a heading can be left out or given.
const MINIMAL: &[(&str, &str)] = &[
    ("[camera]", "[camera]\norigin = [0, 1, 5]\ntarget = [0, 1, 0]\n"),
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
    ("texture", "[material.A]\ntype = 'diffuse'\n[material.A.reflectance]\ntexture = 'a.png'\n"),
    ("opacity", "[material.A]\ntype = 'diffuse'\n[material.A.opacity]\ntexture = 'a.png'\n"),
    ("[[light]]", "[[light]]\ntype = 'constant'\nradiance = 1\n"),
    ("constant", "[[light]]\ntype = 'constant'\nradiance = 1\n"),
    ("environment", "[[light]]\ntype = 'environment'\npath = 'a.exr'\n"),
    ("point", "[[light]]\ntype = 'point'\nposition = [0, 1, 0]\nintensity = 1\n"),
    ("directional", "[[light]]\ntype = 'directional'\ndirection = [0, 1, 0]\nirradiance = 1\n"),
    ("[integrator]", "[integrator]\n"),
    ("[guiding]", "[guiding]\n"),
    ("[render]", "[render]\n"),
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

fn keys(page: &BTreeMap<String, BTreeMap<String, String>>, heading: &str) -> BTreeSet<String> {
    page.get(heading).map(|rows| rows.keys().cloned().collect()).unwrap_or_default()
}

/// The keys that are asked for when `text`, a table, is read.
fn asked<T>(text: &str, read: impl FnOnce(&mut Reader) -> Result<T, Fault>) -> BTreeSet<String> {
    let mut t = Reader::new("", from_toml(text, &At::Text).unwrap()).unwrap();
    assert!(read(&mut t).is_ok(), "{text}");
    t.asked().iter().map(|info| info.key.name.to_string()).collect()
}

/// The table under the last header of a [`MINIMAL`] text.
fn body(heading: &str) -> &'static str {
    let text = MINIMAL.iter().find(|(h, _)| *h == heading).unwrap().1;
    let header = text.rfind("\n[").map_or(0, |i| i + 1);
    text[header..].split_once('\n').unwrap().1
}

#[test]
fn sections_have_the_page_s_keys() {
    let (page, base) = (page(), Path::new(""));
    let mut scene = SceneDescription::default();
    let check = |heading: &str, read: &mut dyn FnMut(&mut Reader) -> Result<(), Fault>| {
        assert_eq!(asked(body(heading), read), keys(&page, heading), "{heading}");
    };
    check("[camera]", &mut |t| settings::camera(t, &mut scene.camera));
    check("[film]", &mut |t| settings::film(t, &mut scene.film));
    check("[integrator]", &mut |t| settings::integrator(t, &mut scene.integrator));
    check("[guiding]", &mut |t| settings::guiding(t, &mut scene.guiding));
    check("[render]", &mut |t| settings::render(t, &mut scene.render));
    check("[[mesh]]", &mut |t| world::mesh(t, base).map(drop));
    let grouped = MeshDescription { group: Some("a".into()), ..whole_file(Path::new("a.obj")) };
    check("[[instance]]", &mut |t| world::instance(t, std::slice::from_ref(&grouped)).map(drop));
    check("rotate", &mut |t| world::rotation(t).map(drop));
    check("texture", &mut |t| textures::color_image(t, None, base).map(drop));

    let mut channel: textures::Channel = ScalarTexture::Image;
    let opacity = asked(body("texture"), |t| textures::scalar_image(t, None, &mut channel, base));
    let colour = keys(&page, "texture");
    let own: BTreeSet<_> = opacity.difference(&colour).cloned().collect();
    assert_eq!(own, keys(&page, "opacity"), "`opacity` has keys of its own");
}

#[test]
fn lights_have_the_page_s_keys() {
    let page = page();
    for (name, _) in world::LIGHTS {
        let mut expected = keys(&page, "[[light]]");
        expected.extend(keys(&page, name));
        assert_eq!(asked(body(name), |t| world::light(t, Path::new(""))), expected, "{name}");
    }
}

#[test]
fn materials_have_the_page_s_keys() {
    let page = page();
    let mut common = BTreeSet::new();
    for (name, kind) in KINDS {
        let own = asked("", |t| kind.read(t, &mut kind.bsdf(), Path::new("")));
        assert_eq!(own, keys(&page, name), "{name}");
        let text = format!("type = '{name}'");
        let all = asked(&text, |t| materials::material(t, None, Path::new("")));
        assert_eq!(all.contains("two_sided"), kind.is_opaque());
        assert_eq!(all.contains("opacity"), *kind != Kind::Null);
        common.extend(all.difference(&own).cloned());
    }
    assert_eq!(common, keys(&page, "[material.NAME]"));
}

#[test]
fn every_table_of_the_page_is_of_the_reader() {
    let read: BTreeSet<&str> = MINIMAL.iter().map(|(heading, _)| *heading).collect();
    let written = page();
    assert_eq!(read, written.keys().map(String::as_str).collect());
    let root = asked("", |t| {
        sections(t, Path::new(""), &mut SceneDescription::default())?;
        t.take("mesh");
        t.take("instance");
        t.take("light");
        Ok(())
    });
    let headings = written.keys().filter(|h| h.starts_with('['));
    let names = headings.map(|h| h.trim_matches(['[', ']']).replace(".NAME", ""));
    assert_eq!(root, names.collect());
}

/// What a text says, but for the lines on which it does.
fn read(text: &str) -> String {
    let (mut scene, warnings) = parse(text, Path::new("s.toml"), &[]).unwrap_or_else(|e| panic!("{text}: {e}"));
    scene.meshes.iter_mut().for_each(|mesh| mesh.location = None);
    scene.instances.iter_mut().for_each(|instance| instance.location = None);
    format!("{:?}", (scene, warnings))
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
            let said = format!("{minimal}{key} = {}\n", default.trim_matches('`'));
            assert_eq!(read(&said), read(minimal), "{heading} {key}");
            tried += 1;
        }
    }
    assert!(tried > 40, "{tried}");
    assert_ne!(read("[film]\nwidth = 1281"), read("[film]\n"), "a wrong default would be seen");
}

#[test]
fn the_example_is_right() {
    let text = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let (scene, warnings) = parse(text, Path::new("s.toml"), &[]).unwrap();
    assert!(warnings.is_empty());
    assert_eq!((scene.meshes.len(), scene.materials.len(), scene.lights.len()), (2, 2, 1));
    assert_eq!(scene.guiding.memory, 512 << 20);
}
