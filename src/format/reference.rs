//! What can be written in a scene file: every key with its values, default, range, unit and meaning, as the readers themselves say
//! it. The reference page's tables, `phototaxis keys` and the help of options that stand for keys are made of it.

use super::SceneFile;
pub(crate) use super::sections::guiding::METHODS;
use super::sections::scattering::{KINDS, Kind};
use super::sections::{blend, camera, guiding, materials, textures, world};
use crate::document::{Fault, KeyInfo, Reader};
use crate::light::LightType;
use crate::math::Rgb;
use crate::scene::description::{MaterialDescription, Projection};
use crate::texture::ReliefKind;
use std::path::Path;

/// The keys under one heading of the reference page.
pub(crate) struct Section {
    /// "[film]", "[[mesh]]", or the name of a material's or a light's type.
    pub(crate) heading: String,
    pub(crate) keys: Vec<KeyInfo>,
}

/// All keys, in the order of the page.
pub(crate) fn sections() -> Vec<Section> {
    let mut file = SceneFile::default();
    let base = Path::new("");
    let mut all = vec![
        section("[camera]", |t| camera::camera(t, &mut None)),
        section("[[camera.key]]", |t| camera::camera_key(t, Projection::Perspective).map(drop)),
        section("[film]", |t| file.scene.film.read(t)),
        section("[[mesh]]", |t| world::mesh(t, base).map(drop)),
        section("rotate", |t| world::rotation(t).map(drop)),
        section("[[instance]]", |t| world::instance(t, &[]).map(drop)),
    ];
    all.extend(materials());
    all.push(section("[[light]]", |t| world::light_type(t).map(drop)));
    all.extend(LightType::NAMES.iter().map(|(name, kind)| section(name, |t| kind.read(t, base).map(drop))));
    all.push(section("[integrator]", |t| file.integrator.read(t)));
    all.push(section("[guiding]", |t| guiding::guiding(t, &mut file.guiding)));
    all.push(section("[render]", |t| file.render.read(t)));
    all
}

fn materials() -> Vec<Section> {
    let base = Path::new("");
    let every = section("[material.NAME]", |t| {
        materials::chosen_type(t)?;
        materials::common(t, Kind::Diffuse, &mut MaterialDescription::default(), base)
    });
    let own = KINDS.iter().map(|(name, kind)| section(name, |t| kind.read(t, &mut kind.bsdf(), base)));
    let own = own.chain([section(blend::NAME, |t| blend::own_keys(t, None, base, &mut Vec::new()).map(drop))]);
    let color = section("texture", |t| {
        t.flag(textures::VERTEX_COLOR, &mut true)?;
        textures::color_image(t, None, base).map(drop)
    });
    let mut channel = textures::Channel::Alpha;
    let mut opacity = section("opacity", |t| textures::scalar_image(t, None, &mut channel, base).map(drop));
    opacity.keys.retain(|info| color.keys.iter().all(|known| known.key.name != info.key.name));
    let mut emission =
        section("emission", |t| textures::emission_image(t, None, base, &mut Rgb::ONE.clone()).map(drop));
    emission.keys.retain(|info| info.key.name == "tint");
    let relief = |heading, key: &str, kind| {
        let mut relief = section(heading, |t| textures::relief_image(t, None, kind, base).map(drop));
        relief.keys.retain(|info| info.key.name == key);
        relief
    };
    let reliefs =
        [relief("normal_map", "strength", ReliefKind::Normals), relief("bump_map", "height", ReliefKind::Heights)];
    [every].into_iter().chain(own).chain([color, opacity, emission]).chain(reliefs).collect()
}

/// Whatever `read` asks for; that nothing is there is a fault that does not matter.
fn section(heading: &str, read: impl FnOnce(&mut Reader) -> Result<(), Fault>) -> Section {
    let mut probe = Reader::probe();
    _ = read(&mut probe);
    Section { heading: heading.to_string(), keys: probe.asked().to_vec() }
}

impl KeyInfo {
    /// The key's row in the reference page.
    pub(crate) fn row(&self) -> String {
        let default = match self.default.as_str() {
            "" | "none" | "required" => self.default.clone(),
            value => format!("`{value}`"),
        };
        let cells =
            [&format!("`{}`", self.key.name), &self.kind, &default, &self.range, self.key.unit, &self.meaning()];
        let line: Vec<String> =
            cells.iter().map(|cell| if cell.is_empty() { " ".into() } else { format!(" {cell} ") }).collect();
        format!("|{}|", line.join("|"))
    }

    /// What the key means, and with what.
    pub(crate) fn meaning(&self) -> String {
        match self.key.with {
            "" => self.key.meaning.to_string(),
            with => format!("{} (with {with})", self.key.meaning),
        }
    }
}

/// The keys of settings that `--set` can change, such as `film.width`; those of materials are left out.
pub(crate) fn setting_keys() -> Vec<String> {
    let settings = ["camera", "film", "integrator", "guiding", "render"];
    let name = |section: &Section| section.heading.trim_matches(['[', ']']).to_string();
    let all = sections().into_iter().map(|section| (name(&section), section.keys));
    let of_settings = all.filter(|(name, _)| settings.contains(&name.as_str()));
    of_settings.flat_map(|(name, keys)| keys.into_iter().map(move |info| format!("{name}.{}", info.key.name))).collect()
}

/// The help of an option that stands for the key `section.key` ("render.spp").
///
/// # Panics
/// Where no reader asks for such a key.
pub(crate) fn help(path: &str) -> String {
    let (name, key) = path.split_once('.').expect("section.key");
    let of = sections().into_iter().find(|section| section.heading.trim_matches(['[', ']']) == name);
    let info = of.and_then(|section| section.keys.into_iter().find(|info| info.key.name == key));
    let info = info.unwrap_or_else(|| panic!("no key {path}"));
    let unit = if info.key.unit.is_empty() { String::new() } else { format!("{}: ", info.key.unit) };
    let meaning = without_links(&info.meaning().replace('`', ""));
    format!("{unit}{meaning} [default: the scene file's {path}, else {}]", info.default)
}

/// Markdown links as their words alone: `[pictures.md](pictures.md#layers)` is `pictures.md`.
fn without_links(text: &str) -> String {
    let mut parts = text.split("](");
    let first = parts.next().unwrap_or_default().to_string();
    let plain = parts.fold(first, |all, part| all + part.split_once(')').map_or(part, |(_, rest)| rest));
    plain.replace('[', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_has_units_and_no_markdown() {
        assert!(
            help("render.spp").starts_with("samples per pixel: over all iterations [default: "),
            "{}",
            help("render.spp")
        );
        assert!(help("render.layers").contains("See pictures.md [default"), "{}", help("render.layers"));
        assert_eq!(without_links("see [a](b#c) and [d](e)."), "see a and d.");
    }
}
