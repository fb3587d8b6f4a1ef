//! Directives, in their order, and the state that they change.

mod blocks;
mod steps;

use super::parameters::{Parameter, Parameters, Warnings};
use super::shape::{self, Shape};
use super::tokens::Tokens;
use crate::Result;
use crate::document::read_text;
use crate::error::SourceLocation;
use crate::io::paths;
use crate::scene::description::InstanceDescription;
use crate::scene::model::Model;
use glam::{DAffine3, DMat3};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Files may be included so deep, and so many in all: a file may include itself.
const DEEPEST_INCLUDE: usize = 16;
const MOST_INCLUDES: usize = 1000;

/// What a shape is made of.
#[derive(Clone, Debug)]
pub(super) enum MaterialRef {
    Named(String, SourceLocation),
    Own(Rc<Parameters>),
}

/// What holds for the directives that follow.
#[derive(Clone)]
struct State {
    transform: DAffine3,
    material: MaterialRef,
    area_light: Option<Rc<Parameters>>,
    reverse: bool,
    /// Of `Attribute`, by what it is about.
    attributes: HashMap<String, Vec<Rc<Parameter>>>,
    /// Only the second of two transforms, for moving things, is being said.
    at_end: bool,
}

/// What opened a block: `AttributeBegin`, `TransformBegin` or `ObjectBegin`.
#[derive(Clone, Copy, PartialEq)]
enum Block {
    Attribute,
    Transform,
    Object,
}

/// A light that is no surface, and where it stands.
pub(super) struct Light {
    pub(crate) parameters: Parameters,
    pub(crate) to_world: DAffine3,
}

/// All that a scene says.
pub(super) struct World {
    /// What names of files are relative to.
    folder: PathBuf,
    /// The scene is one of version 3.
    pub(crate) old: bool,
    pub(crate) warnings: Warnings,
    /// `Film`, `Camera` and others that are there once.
    pub(crate) settings: HashMap<&'static str, Rc<Parameters>>,
    pub(crate) camera_to_world: DAffine3,
    pub(crate) textures: HashMap<String, Rc<Parameters>>,
    pub(crate) float_textures: HashMap<String, Rc<Parameters>>,
    pub(crate) materials: HashMap<String, Rc<Parameters>>,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) lights: Vec<Light>,
    pub(crate) instances: Vec<InstanceDescription>,
    /// A sphere, seen from outside and from inside, which are made once.
    pub(crate) spheres: [OnceCell<Arc<Model>>; 2],
    coordinate_systems: HashMap<String, DAffine3>,
    objects: HashMap<String, bool>,
    state: State,
    stack: Vec<(Block, State, SourceLocation)>,
    object: Option<String>,
    includes: usize,
}

/// Directives of which one holds for the whole scene.
const SETTINGS: &[&str] = &["Accelerator", "Camera", "Film", "Integrator", "PixelFilter", "Sampler"];

impl World {
    pub(crate) fn read(path: &Path) -> Result<World> {
        let text = read_text(path)?;
        let start = SourceLocation { path: path.to_path_buf(), line: 1, column: 1 };
        let state = State {
            transform: DAffine3::IDENTITY,
            material: MaterialRef::Own(Rc::new(Parameters::none("Material", "diffuse", start))),
            area_light: None,
            reverse: false,
            attributes: HashMap::new(),
            at_end: false,
        };
        let mut world = World {
            folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            // version 4 refuses the word
            old: memchr::memmem::find(text.as_bytes(), b"WorldEnd").is_some(),
            warnings: Warnings::default(),
            settings: HashMap::new(),
            camera_to_world: DAffine3::IDENTITY,
            textures: HashMap::new(),
            float_textures: HashMap::new(),
            materials: HashMap::new(),
            shapes: Vec::new(),
            lights: Vec::new(),
            instances: Vec::new(),
            spheres: Default::default(),
            coordinate_systems: HashMap::new(),
            objects: HashMap::new(),
            state,
            stack: Vec::new(),
            object: None,
            includes: 0,
        };
        world.directives(&mut Tokens::new(path, &text), 0)?;
        match world.stack.pop() {
            Some((_, _, at)) => Err(at.error("nothing ends what begins here")),
            None => Ok(world),
        }
    }

    /// The file that the scene means by a name.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        paths::resolve(&self.folder, name.as_bytes())
    }

    fn directives(&mut self, tokens: &mut Tokens, depth: usize) -> Result<()> {
        while let Some(token) = tokens.next()? {
            let at = tokens.place(&token);
            if token.quoted {
                return Err(at.error(format!("a directive belongs here, not the string \"{}\"", token.text)));
            }
            if let Some(name) = SETTINGS.iter().find(|name| **name == token.text) {
                self.setting(tokens, name, at)?;
                continue;
            }
            match &*token.text {
                "Include" | "Import" => self.include(tokens, &at, depth)?,
                "WorldBegin" => self.world_begin(&at)?,
                "WorldEnd" => return Ok(()),
                "AttributeBegin" => self.begin(Block::Attribute, at),
                "AttributeEnd" => self.end(Block::Attribute, &at)?,
                "TransformBegin" => self.begin(Block::Transform, at),
                "TransformEnd" => self.end(Block::Transform, &at)?,
                "ObjectBegin" => self.object_begin(tokens, at)?,
                "ObjectEnd" => self.end(Block::Object, &at)?,
                "ObjectInstance" => self.instance(tokens, at)?,
                "ReverseOrientation" => self.state.reverse = !self.state.reverse,
                "Option" => drop((tokens.needed("a name")?, tokens.needed("a value")?)),
                "ColorSpace" => self.color_space(tokens, &at)?,
                "MediumInterface" => self.medium_interface(tokens, &at)?,
                _ if self.transform(tokens, &token)? => (),
                _ => self.thing(tokens, &token.text, at)?,
            }
        }
        Ok(())
    }

    fn include(&mut self, tokens: &mut Tokens, at: &SourceLocation, depth: usize) -> Result<()> {
        let name = string(tokens, "a file's name")?;
        self.includes += 1;
        if depth >= DEEPEST_INCLUDE || self.includes > MOST_INCLUDES {
            return Err(at.error("too many files are included: does one include itself?"));
        }
        let path = self.file(&name);
        let text = read_text(&path)?;
        self.directives(&mut Tokens::new(&path, &text), depth + 1)
    }

    fn parameters(&self, tokens: &mut Tokens, directive: &'static str, at: SourceLocation) -> Result<Parameters> {
        let plugin = string(tokens, "a type")?;
        let about = match directive {
            "Shape" => "shape",
            "Material" | "MakeNamedMaterial" => "material",
            "LightSource" | "AreaLightSource" => "light",
            "Texture" => "texture",
            _ => "",
        };
        let common = self.state.attributes.get(about).cloned().unwrap_or_default();
        Parameters::read(tokens, directive, plugin, at, common)
    }

    fn setting(&mut self, tokens: &mut Tokens, name: &'static str, at: SourceLocation) -> Result<()> {
        let parameters = self.parameters(tokens, name, at.clone())?;
        if name == "Camera" {
            // the transform goes from the world to the camera
            let linear = self.state.transform.matrix3;
            if !is_regular(&linear) {
                return Err(at.error("the transform of the camera flattens the view"));
            }
            self.camera_to_world = self.state.transform.inverse();
            self.coordinate_systems.insert("camera".into(), self.camera_to_world);
        }
        self.settings.insert(name, Rc::new(parameters));
        Ok(())
    }

    fn world_begin(&mut self, at: &SourceLocation) -> Result<()> {
        if !self.stack.is_empty() {
            return Err(at.error("WorldBegin stands within a block"));
        }
        self.state.transform = DAffine3::IDENTITY;
        self.state.at_end = false;
        self.coordinate_systems.insert("world".into(), DAffine3::IDENTITY);
        Ok(())
    }

    fn color_space(&mut self, tokens: &mut Tokens, at: &SourceLocation) -> Result<()> {
        let name = string(tokens, "the name of a colour space")?;
        if name != "srgb" {
            self.warnings
                .add(at, format!("the colour space \"{name}\" is not known here: colours are taken for sRGB's"));
        }
        Ok(())
    }

    fn medium_interface(&mut self, tokens: &mut Tokens, at: &SourceLocation) -> Result<()> {
        let mut named = !string(tokens, "the name of a medium")?.is_empty();
        if tokens.peek()?.is_some_and(|token| token.quoted) {
            named |= !string(tokens, "the name of a medium")?.is_empty();
        }
        if named {
            self.warnings.add(at, "nothing scatters light between surfaces here");
        }
        Ok(())
    }

    /// Directives that make something of a type and parameters.
    fn thing(&mut self, tokens: &mut Tokens, directive: &str, at: SourceLocation) -> Result<()> {
        match directive {
            "Shape" => {
                let parameters = self.parameters(tokens, "Shape", at)?;
                self.shape(parameters)
            }
            "LightSource" => {
                let parameters = self.parameters(tokens, "LightSource", at)?;
                self.lights.push(Light { parameters, to_world: self.state.transform });
                Ok(())
            }
            "AreaLightSource" => {
                self.state.area_light = Some(Rc::new(self.parameters(tokens, "AreaLightSource", at)?));
                Ok(())
            }
            "Material" => {
                self.state.material = MaterialRef::Own(Rc::new(self.parameters(tokens, "Material", at)?));
                Ok(())
            }
            "NamedMaterial" => {
                self.state.material = MaterialRef::Named(string(tokens, "the name of a material")?, at);
                Ok(())
            }
            "MakeNamedMaterial" => {
                let mut parameters = self.parameters(tokens, "MakeNamedMaterial", at)?;
                let name = parameters.plugin.clone();
                let kind = parameters.text("type")?.map(str::to_string);
                parameters.plugin = kind.ok_or_else(|| parameters.error("a named material needs \"string type\""))?;
                let (at, new) = (parameters.at.clone(), Rc::new(parameters));
                self.define(at, "material", &name, |world| world.materials.insert(name.clone(), new).is_some())
            }
            "Texture" => self.texture(tokens, at),
            "Attribute" => {
                let about = string(tokens, "what it is about")?;
                let said = Parameters::read(tokens, "Attribute", about.clone(), at, Vec::new())?;
                self.state.attributes.entry(about).or_default().extend(said.into_list());
                Ok(())
            }
            "MakeNamedMedium" => self.parameters(tokens, "MakeNamedMedium", at).map(drop),
            other => Err(at.error(format!("`{other}` is no directive"))),
        }
    }

    fn texture(&mut self, tokens: &mut Tokens, at: SourceLocation) -> Result<()> {
        let (name, kind) = (string(tokens, "a name")?, string(tokens, "a type")?);
        let float = match kind.as_str() {
            "float" => true,
            "spectrum" | "color" => false,
            other => return Err(at.error(format!("a texture is of `float` or `spectrum`, not `{other}`"))),
        };
        let new = Rc::new(self.parameters(tokens, "Texture", at.clone())?);
        self.define(at, "texture", &name, |world| {
            let all = if float { &mut world.float_textures } else { &mut world.textures };
            all.insert(name.clone(), new).is_some()
        })
    }

    /// Version 3 lets a name be defined anew.
    fn define(
        &mut self,
        at: SourceLocation,
        what: &str,
        name: &str,
        insert: impl FnOnce(&mut World) -> bool,
    ) -> Result<()> {
        match (insert(self), self.old) {
            (false, _) => Ok(()),
            (true, false) => Err(at.error(format!("there are two {what}s \"{name}\""))),
            (true, true) => {
                self.warnings
                    .add(&at, format!("the {what} \"{name}\" is defined again, which holds for all of the scene"));
                Ok(())
            }
        }
    }

    fn shape(&mut self, parameters: Parameters) -> Result<()> {
        let State { transform, material, area_light, reverse, .. } = &self.state;
        let placed = shape::Placed {
            transform: *transform,
            reverse: *reverse,
            material: material.clone(),
            area_light: area_light.clone(),
            object: self.object.clone(),
        };
        let shape = shape::read(self, &parameters, placed)?;
        if let Some(shape) = shape {
            if let Some(object) = &self.object {
                self.objects.insert(object.clone(), true);
            }
            self.shapes.push(shape);
        }
        Ok(())
    }
}

/// Whether a transform flattens nothing.
pub(super) fn is_regular(linear: &DMat3) -> bool {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *linear;
    x.cross(y).dot(z).abs() > 1e-7 * x.length() * y.length() * z.length()
}

fn string(tokens: &mut Tokens, what: &str) -> Result<String> {
    let token = tokens.needed(what)?;
    if token.quoted {
        return Ok(token.text.into_owned());
    }
    Err(tokens.place(&token).error(format!("{what} in quotes belongs here, not `{}`", token.text)))
}
