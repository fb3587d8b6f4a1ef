//! `scene.json`: a small interchange form beside an OBJ file, with Mitsuba's conventions. It says the camera,
//! the materials that MTL cannot, and lights that are no surfaces. Materials it does not name stay as in the MTL.
//!
//! Its tree is brought into the shape of a scene file's and then read by the same code.

use super::SceneFile;
use super::model::whole_file;
use super::sections::scattering::KINDS;
use super::sections::{camera, materials, world};
use crate::Result;
use crate::document::{At, COORDINATE, Entries, Entry, Fault, NOT_NEGATIVE, Node, Reader, Source, UNIT, Value};
use crate::document::{from_json, read_text};
use crate::film::SIDE;
use crate::math::Rgb;
use crate::scene::description::{CameraDescription, NamedCamera, SceneDescription};
use std::path::Path;

/// What says where a scene comes from, or again what the OBJ says.
const DOCUMENTATION: &[&str] = &["name", "source", "licence", "credit", "stats", "notes", "missing_textures"];

pub(super) fn read(path: &Path) -> Result<(SceneFile, Vec<String>)> {
    let (scene, warnings) = parse(&read_text(path)?, path)?;
    Ok((SceneFile { scene, ..Default::default() }, warnings))
}

/// Parses the text of a `scene.json`. `path` names it in errors, and paths in it are relative to its folder.
/// Also returns warnings: fields that mean nothing here, and lights that contradict their material.
///
/// # Errors
/// [`crate::Error::Parse`] with line and column.
fn parse(text: &str, path: &Path) -> Result<(SceneDescription, Vec<String>)> {
    let source = Source { path, text, overrides: &[] };
    let mut import = Import { base: source.folder(), scene: SceneDescription::default(), warnings: Vec::new() };
    from_json(text).and_then(|root| import.root(root)).map_err(|fault| source.error(fault))?;
    Ok((import.scene, import.warnings))
}

struct Import<'a> {
    base: &'a Path,
    scene: SceneDescription,
    warnings: Vec<String>,
}

impl Import<'_> {
    fn root(&mut self, root: Node) -> Result<(), Fault> {
        let mut t = Reader::new("the scene", root)?;
        self.scene.meshes.push(whole_file(&t.require("obj")?.path("obj", self.base)?));
        if let Some(node) = t.take("camera") {
            let NamedCamera { camera, size, .. } = self.camera("camera".into(), node)?;
            self.scene.film.resize(size);
            self.scene.camera = Some(camera);
        }
        if let Some(node) = t.take("cameras") {
            self.cameras(node)?;
        }
        if let Some(node) = t.take("materials") {
            self.materials(node)?;
        }
        if let Some(node) = t.take("emitters") {
            for emitter in node.tables("emitters")? {
                self.emitter(emitter)?;
            }
        }
        ignore(&mut t, DOCUMENTATION);
        self.finish(&t)?;
        Ok(())
    }

    /// An object with a camera for each name.
    fn cameras(&mut self, node: Node) -> Result<(), Fault> {
        let mut entries: Vec<(String, Entry)> = Reader::new("cameras", node)?.into_entries().into_iter().collect();
        entries.sort_by_key(|(_, entry)| entry.key);
        for (name, entry) in entries {
            let camera = self.camera(format!("camera `{name}`"), entry.node)?;
            self.scene.cameras.push(NamedCamera { name, ..camera });
        }
        Ok(())
    }

    /// Perspective; the film's size is here too. `to_world` says the same as origin, target and up.
    fn camera(&mut self, label: String, node: Node) -> Result<NamedCamera, Fault> {
        let mut t = Reader::new(label, node)?;
        t.chosen("type", &[("perspective", ())])?;
        let mut c = CameraDescription::default();
        t.point("origin", COORDINATE, &mut c.origin)?;
        t.point("target", COORDINATE, &mut c.target)?;
        t.vector("up", COORDINATE, &mut c.up)?;
        t.number("vfov_deg", camera::VFOV, &mut c.vfov)?;
        t.flag("mirrored_x", &mut c.mirrored)?;
        camera::needs(&t, &["origin", "target", "vfov_deg"])?;
        camera::check_camera(&t, &c)?;
        let mut size = [1; 2];
        t.integer("width", SIDE, &mut size[0])?;
        t.integer("height", SIDE, &mut size[1])?;
        let size = [("width", size[0]), ("height", size[1])].map(|(key, side)| t.has(key).then_some(side));
        ignore(&mut t, &["to_world"]);
        self.finish(&t)?;
        Ok(NamedCamera { name: String::new(), camera: c, size })
    }

    fn materials(&mut self, node: Node) -> Result<(), Fault> {
        for (name, entry) in Reader::new("materials", node)?.into_entries() {
            let mut node = entry.node;
            if let Value::Table(entries) = &mut node.value {
                self.adapt_material(&name, entries)?;
            }
            let mut t = Reader::new(format!("material `{name}`"), node)?;
            let kind = t.chosen(materials::TYPE, KINDS)?;
            let material = materials::material(&mut t, kind, None, self.base)?;
            let (_, material) = material.ok_or_else(|| t.missing("type"))?;
            self.finish(&t)?;
            self.scene.materials.insert(name, material);
        }
        Ok(())
    }

    /// Turns a material's table into that of a scene file.
    fn adapt_material(&mut self, name: &str, entries: &mut Entries) -> Result<(), Fault> {
        for entry in entries.values_mut() {
            if let Value::Table(texture) = &mut entry.node.value {
                adapt_filter(texture)?;
            }
        }
        // A mask goes by the stored luminance: the renderer that this form comes from drops an alpha channel.
        if let Some(Entry { key, node }) = entries.get_mut("opacity")
            && let Value::Table(texture) = &mut node.value
        {
            let channel = Node { at: node.at, value: Value::String("luminance".to_string()) };
            texture.insert("channel".to_string(), Entry { key: *key, node: channel });
        }
        let kind = entries.get("type").and_then(|e| e.node.string("type").ok()).map(str::to_string);
        match kind.as_deref() {
            Some("phong") => phong(name, entries),
            Some("principled") => self.principled(name, entries),
            _ => Ok(()),
        }
    }

    /// Its `reflectance` and `alpha` are for readers that do not know the model.
    fn principled(&mut self, name: &str, entries: &mut Entries) -> Result<(), Fault> {
        entries.remove("reflectance");
        entries.remove("alpha");
        if let Some(Entry { node, .. }) = entries.remove("spec_trans")
            && node.number("spec_trans", UNIT)? > 0.0
        {
            let message = format!("material `{name}` transmits light, which `principled` cannot");
            return Err(Fault::new(node.at, message));
        }
        if let Some(Entry { node, .. }) = entries.remove("anisotropic")
            && node.number("anisotropic", UNIT)? > 0.0
        {
            self.warnings.push(format!("material `{name}`: `anisotropic` is taken for 0"));
        }
        Ok(())
    }

    fn emitter(&mut self, mut node: Node) -> Result<(), Fault> {
        if let Value::Table(entries) = &mut node.value {
            let kind = entries.get_mut("type").map(|e| &mut e.node.value);
            match kind {
                Some(Value::String(s)) if s == "area" => return self.area(node),
                Some(Value::String(s)) if s == "envmap" => *s = "environment".to_string(),
                _ => (),
            }
            if let Some(file) = entries.remove("filename") {
                entries.insert("path".to_string(), file);
            }
        }
        let mut t = Reader::new("emitter", node)?;
        world::light(&mut t, self.base, &mut self.scene)?;
        self.finish(&t)?;
        Ok(())
    }

    /// The material says the same; a warning where it does not.
    fn area(&mut self, node: Node) -> Result<(), Fault> {
        let mut t = Reader::new("emitter", node)?;
        let mut radiance = Rgb::ZERO;
        t.color("radiance", NOT_NEGATIVE, &mut radiance)?;
        let node = t.require("material")?;
        let name = node.string("material")?;
        if let Some(material) = self.scene.materials.get(name)
            && material.emission != radiance
        {
            self.warnings.push(format!(
                "material `{name}` emits {}, but its emitter says {radiance}: the material counts",
                material.emission
            ));
        }
        ignore(&mut t, &["type", "object"]);
        self.finish(&t)?;
        Ok(())
    }

    /// Fields that nothing has asked for are no errors here: other programs may write more. Missing ones are.
    fn finish(&mut self, t: &Reader) -> Result<(), Fault> {
        for (key, _) in t.left_over() {
            self.warnings.push(format!("{}: `{key}` is not known and means nothing", t.label()));
        }
        t.complete()
    }
}

fn ignore(t: &mut Reader, keys: &[&'static str]) {
    for key in keys {
        t.take(key);
    }
}

/// `filter` of a texture: what is not nearest is bilinear (there are no MIP maps).
fn adapt_filter(texture: &mut Entries) -> Result<(), Fault> {
    let Some(Entry { key, node }) = texture.remove("filter") else { return Ok(()) };
    let nearest = match node.string("filter")? {
        "nearest" => true,
        "bilinear" | "trilinear" => false,
        other => {
            let message = format!("unknown filter `{other}`: known are nearest, bilinear, trilinear");
            return Err(Fault::new(node.at, message));
        }
    };
    let node = Node { at: node.at, value: Value::Boolean(nearest) };
    texture.insert("nearest".to_string(), Entry { key, node });
    Ok(())
}

/// A Phong exponent e becomes rough plastic of α = √(2/(e + 2)), by which Beckmann's lobe has about its width
/// (Walter et al. 2007, §5.2).
fn phong(name: &str, entries: &mut Entries) -> Result<(), Fault> {
    let Some(Entry { node: kind, .. }) = entries.get_mut("type") else { return Ok(()) };
    kind.value = Value::String("plastic".to_string());
    let at: At = kind.at;
    let Some(Entry { key, node }) = entries.remove("exponent") else {
        let message = format!("material `{name}` is of type `phong` and needs `exponent`");
        return Err(Fault::new(at, message));
    };
    let exponent = node.number("exponent", NOT_NEGATIVE)?;
    let alpha = (2.0 / (f64::from(exponent) + 2.0)).sqrt();
    let node = Node { at: node.at, value: Value::Float(alpha) };
    entries.insert("alpha".to_string(), Entry { key, node });
    Ok(())
}

#[cfg(test)]
mod tests;
