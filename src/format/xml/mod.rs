//! From XML to objects with properties: includes, defaults, and names in the spelling of Mitsuba 3. Scenes of Mitsuba and of
//! nori are both `<scene>`, and their readers share what is here.

pub(crate) mod color;
pub(crate) mod object;
mod properties;
pub(crate) mod transform;

use crate::document::read_text;
use crate::error::SourceLocation;
use crate::format::definitions::{Definition, Definitions};
use crate::io::paths;
use crate::{Error, Result};
use object::{Dialect, Item, Object, Objects, Value};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Objects may be within each other so deep.
const DEEPEST: usize = 64;

/// Files may be included so deep, and so many in all: a file may include itself.
const DEEPEST_INCLUDE: usize = 16;
const MOST_INCLUDES: usize = 1000;

/// What stands in scenes of Mitsuba alone.
const MITSUBAS: &[&str] = &["alias", "default", "include", "luminaire", "sensor", "shape"];

/// The tags of what is made of properties and other objects.
const OBJECTS: &[&str] = &[
    "bsdf",
    "emitter",
    "luminaire",
    "film",
    "guider",
    "integrator",
    "medium",
    "mesh",
    "phase",
    "rfilter",
    "sampler",
    "scene",
    "sensor",
    "camera",
    "shape",
    "spectrum",
    "subsurface",
    "test",
    "texture",
    "volume",
];

/// Reads a scene and all that it includes.
///
/// # Errors
/// With file and line: text that is no XML, a tag that is not known, a value that is none, a `$name` that nothing says.
pub(crate) fn read(path: &Path, definitions: &Definitions) -> Result<Objects> {
    let given = definitions.list.iter().map(|definition| (definition.name.clone(), definition.value.clone()));
    let mut reader = Reader {
        ids: HashMap::new(),
        defaults: given.collect(),
        dialect: Dialect::default(),
        includes: 0,
        folders: vec![folder_of(path).to_path_buf()],
        definitions,
        said: HashSet::new(),
    };
    let root = reader.file(path, 0)?;
    definitions.check_used(reader.said.iter().map(String::as_str))?;
    Ok(Objects::new(root, reader.ids, reader.dialect))
}

struct Reader<'d> {
    ids: HashMap<String, Rc<Object>>,
    defaults: HashMap<String, String>,
    /// That of the file that was opened first.
    dialect: Dialect,
    includes: usize,
    /// Where files are looked for that are not beside the file that names them: the folder of the scene, then each `<path>`.
    folders: Vec<PathBuf>,
    /// What was said from outside of the file, which holds over what it says itself.
    definitions: &'d Definitions,
    /// Names of its own defaults.
    said: HashSet<String>,
}

/// Where a file is read from.
struct Source<'a> {
    path: &'a Path,
    document: &'a Document<'a>,
    depth: usize,
}

impl Source<'_> {
    fn place(&self, node: Node) -> SourceLocation {
        let at = self.document.text_pos_at(node.range().start);
        SourceLocation { path: self.path.to_path_buf(), line: at.row as usize, column: at.col as usize }
    }

    fn fault(&self, node: Node, message: impl Into<String>) -> Error {
        self.place(node).error(message)
    }
}

impl Reader<'_> {
    fn file(&mut self, path: &Path, depth: usize) -> Result<Rc<Object>> {
        let text = read_text(path)?;
        // no entities are defined, so none are expanded
        let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&text, options).map_err(|error| {
            let at = error.pos();
            Error::parse(path, at.row as usize, at.col as usize, format!("not XML: {error}"))
        })?;
        let source = Source { path, document: &document, depth };
        let root = document.root_element();
        if root.tag_name().name() != "scene" {
            let message = format!("`{}` is no scene: the first tag must be <scene>", root.tag_name().name());
            return Err(source.fault(root, message));
        }
        if depth == 0 {
            self.dialect = dialect(&source, root)?;
        }
        let object = self.object(&source, root, 0)?;
        Ok(Rc::new(object))
    }

    fn object(&mut self, source: &Source, node: Node, depth: usize) -> Result<Object> {
        if depth > DEEPEST {
            return Err(source.fault(node, format!("more than {DEEPEST} objects are within each other")));
        }
        let tag = match node.tag_name().name() {
            "luminaire" => "emitter",
            "camera" => "sensor",
            tag => tag,
        };
        let kind = self.attribute(source, node, "type")?.unwrap_or_default();
        let mut object = Object::new(tag, &kind, source.place(node));
        object.id = self.attribute(source, node, "id")?;
        for child in node.children().filter(Node::is_element) {
            self.child(source, child, &mut object, depth)?;
        }
        Ok(object)
    }

    /// One thing within an object.
    fn child(&mut self, source: &Source, node: Node, parent: &mut Object, depth: usize) -> Result<()> {
        let tag = node.tag_name().name();
        let is_object = OBJECTS.contains(&tag) && (tag != "spectrum" || node.attribute("type").is_some());
        // programs of courses add kinds of objects to nori
        let is_object = is_object || self.dialect == Dialect::Nori && node.attribute("type").is_some();
        match tag {
            "default" => {
                let (name, value) = (self.needed(source, node, "name")?, self.needed(source, node, "value")?);
                // one that nothing asks for is no slip of the one who defines it
                self.definitions.find(&name).into_iter().for_each(Definition::use_it);
                self.said.insert(name.clone());
                self.defaults.entry(name).or_insert(value);
                Ok(())
            }
            "include" => self.include(source, node, parent),
            "alias" => {
                let (id, other) = (self.needed(source, node, "id")?, self.needed(source, node, "as")?);
                let Some(object) = self.ids.get(&id).cloned() else {
                    return Err(source.fault(node, format!("nothing before this line has the id `{id}`")));
                };
                self.ids.insert(other, object);
                Ok(())
            }
            "path" => self.search_folder(source, node),
            _ if is_object => {
                let name = self.attribute(source, node, "name")?.unwrap_or_default();
                let object = Rc::new(self.object(source, node, depth + 1)?);
                if let Some(id) = &object.id
                    && self.ids.insert(id.clone(), object.clone()).is_some()
                {
                    return Err(source.fault(node, format!("there are two objects with the id `{id}`")));
                }
                parent.items.push(Item::new(snake(&name), source.place(node), Value::Object(object)));
                Ok(())
            }
            _ => {
                let item = self.property(source, node, parent.tag == "emitter")?;
                parent.items.push(item);
                Ok(())
            }
        }
    }

    /// `<path value="…">`: one more folder in which files are looked for.
    fn search_folder(&mut self, source: &Source, node: Node) -> Result<()> {
        let name = self.needed(source, node, "value")?;
        let name = name.replace('\\', "/");
        let folder = self.places(source).map(|place| place.join(&name)).find(|folder| folder.is_dir());
        let folder = folder.ok_or_else(|| {
            let expected = folder_of(source.path).join(&name);
            source.fault(node, format!("there is no folder {}", expected.display()))
        })?;
        self.folders.push(folder);
        Ok(())
    }

    /// Where files are looked for, in this order.
    fn places<'a>(&'a self, source: &'a Source) -> impl Iterator<Item = &'a Path> {
        std::iter::once(folder_of(source.path)).chain(self.folders.iter().map(PathBuf::as_path))
    }

    /// The file that a scene means by a name: beside the file that names it, else in one of the folders; where there is none,
    /// the first of these paths.
    fn find_file(&self, source: &Source, name: &str) -> PathBuf {
        let found = self.places(source).find_map(|folder| paths::find(folder, name.as_bytes()));
        found.unwrap_or_else(|| paths::resolve(folder_of(source.path), name.as_bytes()))
    }

    fn include(&mut self, source: &Source, node: Node, parent: &mut Object) -> Result<()> {
        let name = self.needed(source, node, "filename")?;
        self.includes += 1;
        if source.depth >= DEEPEST_INCLUDE || self.includes > MOST_INCLUDES {
            return Err(source.fault(node, "too many files are included: does one include itself?"));
        }
        let path = self.find_file(source, &name);
        let included = self.file(&path, source.depth + 1)?;
        // what it says counts as if it were said here
        parent.items.extend(included.items.iter().cloned());
        Ok(())
    }

    fn needed(&self, source: &Source, node: Node, name: &str) -> Result<String> {
        let tag = node.tag_name().name();
        self.attribute(source, node, name)?
            .ok_or_else(|| source.fault(node, format!("<{tag}> needs the attribute `{name}`")))
    }

    /// An attribute, in which `$name` stands for what a default says. What a default says is not looked into again.
    fn attribute(&self, source: &Source, node: Node, name: &str) -> Result<Option<String>> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        if self.dialect == Dialect::Nori {
            return Ok(Some(text.to_string()));
        }
        let mut parts = text.split('$');
        let mut all = parts.next().unwrap_or_default().to_string();
        for part in parts {
            let length = part.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(part.len());
            // the longest name that is known: `$spp0` may be `$spp` and a 0
            let known = (1..=length)
                .rev()
                .filter(|&k| part.is_char_boundary(k))
                .find(|&k| self.defaults.contains_key(&part[..k]));
            let Some(known) = known else {
                return Err(source.fault(
                    node,
                    format!("nothing says what `${0}` is: <default> or -D {0}=VALUE does", &part[..length]),
                ));
            };
            self.definitions.find(&part[..known]).into_iter().for_each(Definition::use_it);
            all += &self.defaults[&part[..known]];
            all += &part[known..];
        }
        Ok(Some(all))
    }
}

/// A scene without a version and without anything that is Mitsuba's alone is one of nori.
fn dialect(source: &Source, root: Node) -> Result<Dialect> {
    let foreign = |node: Node| MITSUBAS.contains(&node.tag_name().name());
    let version = match root.attribute("version") {
        Some(version) => version,
        None if root.children().any(foreign) => "3.0.0",
        None => return Ok(Dialect::Nori),
    };
    let number = version.splitn(3, '.').take(2).collect::<Vec<_>>().join(".").parse();
    number.map(Dialect::Mitsuba).map_err(|_| source.fault(root, format!("`{version}` is no version")))
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// `toWorld` as `to_world`, as versions before 2 spell it; `intIOR` is `int_ior`.
fn snake(name: &str) -> String {
    let mut spelt = String::with_capacity(name.len() + 4);
    let mut before_lower = false;
    for c in name.chars() {
        if c.is_uppercase() && before_lower {
            spelt.push('_');
        }
        before_lower = c.is_lowercase() || c.is_ascii_digit();
        spelt.extend(c.to_lowercase());
    }
    spelt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_names_are_those_of_today() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("diffuseReflectance", "diffuse_reflectance"),
            ("sampleCount", "sample_count"),
            ("fov", "fov"),
            ("to_world", "to_world"),
        ] {
            assert_eq!(snake(old), new);
        }
    }
}
