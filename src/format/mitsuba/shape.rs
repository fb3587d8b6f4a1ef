//! Shapes, and where they stand.

use super::bsdf::Materials;
use crate::Result;
use crate::format::SceneFile;
use crate::format::xml::object::{Object, Objects};
use crate::format::{tessellate, xml};
use crate::math::Rgb;
use crate::scene::adaptation::{Adaptation, NormalsChange};
use crate::scene::description::{InstanceDescription, MaterialDescription, MeshDescription};
use crate::scene::model::{MeshSource, Model};
use crate::texture::ReliefKind;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

/// Shapes are gathered here.
pub(super) struct Shapes<'a> {
    pub(crate) objects: &'a Objects,
    pub(crate) materials: &'a Materials<'a>,
    pub(crate) file: &'a mut SceneFile,
    /// Names of materials that have been described, by where their bsdf stands.
    names: HashMap<*const Object, String>,
    /// Emitters that belong to shapes.
    shining: HashSet<*const Object>,
    round: Round,
}

/// Shapes that are made once.
#[derive(Default)]
struct Round {
    made: HashMap<&'static str, Arc<Model>>,
}

impl Round {
    fn get(&mut self, name: &'static str, make: fn() -> Arc<Model>) -> MeshSource {
        MeshSource::Memory(self.made.entry(name).or_insert_with(make).clone())
    }
}

impl<'a> Shapes<'a> {
    pub(crate) fn new(objects: &'a Objects, materials: &'a Materials<'a>, file: &'a mut SceneFile) -> Shapes<'a> {
        Shapes { objects, materials, file, names: HashMap::new(), shining: HashSet::new(), round: Round::default() }
    }

    /// All shapes of the scene. Returns the emitters that belong to shapes, some of which may stand beside them and be referred to.
    pub(crate) fn read(mut self) -> Result<HashSet<*const Object>> {
        let objects = self.objects;
        for (_, shape) in objects.children(&objects.root, "shape")? {
            self.shape(&shape, None)?;
        }
        Ok(self.shining)
    }

    /// One shape, as a part of `group` where there is one.
    fn shape(&mut self, shape: &Rc<Object>, group: Option<&str>) -> Result<()> {
        match shape.kind.as_str() {
            "shapegroup" => self.group(shape, group),
            "instance" => self.instance(shape, group),
            "merge" => {
                for (_, part) in self.objects.children(shape, "shape")? {
                    self.shape(&part, group)?;
                }
                Ok(())
            }
            _ => self.mesh(shape, group),
        }
    }

    fn group(&mut self, shape: &Rc<Object>, within: Option<&str>) -> Result<()> {
        if within.is_some() {
            return Err(shape.error("a `shapegroup` within another is not read"));
        }
        let name = shape.id.clone().ok_or_else(|| shape.error("a `shapegroup` needs an `id`"))?;
        for (_, part) in self.objects.children(shape, "shape")? {
            if matches!(part.kind.as_str(), "shapegroup" | "instance") {
                return Err(part.error("instances within a `shapegroup` are not read"));
            }
            self.shape(&part, Some(&name))?;
        }
        Ok(())
    }

    fn instance(&mut self, shape: &Rc<Object>, within: Option<&str>) -> Result<()> {
        if within.is_some() {
            return Err(shape.error("an instance within a `shapegroup` is not read"));
        }
        let group = self.objects.child(shape, "shape")?.filter(|group| group.kind == "shapegroup");
        let name = group.and_then(|group| group.id.clone());
        let name = name.ok_or_else(|| shape.error("an `instance` needs a reference to a `shapegroup`"))?;
        let transform = self.placed(shape)?;
        let location = Some(shape.at.clone());
        self.file.scene.instances.push(InstanceDescription { group: name, transform, location });
        self.objects.finish(shape);
        Ok(())
    }

    /// `to_world`, which flattens nothing.
    fn placed(&self, shape: &Object) -> Result<DAffine3> {
        let transform = shape.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
        xml::transform::check_regular(shape, &transform)?;
        Ok(transform)
    }

    fn mesh(&mut self, shape: &Rc<Object>, group: Option<&str>) -> Result<()> {
        let to_world = self.placed(shape)?;
        let flip = shape.flag("flip_normals", false)?;
        let (source, own) = self.source(shape, flip)?;
        let transform = to_world * own;
        xml::transform::check_regular(shape, &transform)?;
        let material = self.material(shape)?;
        let source = self.with_attribute(shape, source)?;
        for name in ["interior", "exterior"] {
            if let Some(medium) = shape.find(name) {
                self.objects.warn(&medium.at, format!("`{name}`: nothing scatters light between surfaces here"));
            }
        }
        shape.ignore(&["silhouette_sampling_weight"]);
        self.objects.finish(shape);
        self.file.scene.meshes.push(MeshDescription {
            source,
            transform,
            material,
            material_location: Some(shape.at.clone()),
            group: group.map(str::to_string),
            location: Some(shape.at.clone()),
        });
        Ok(())
    }

    /// The shape's mesh, and where that stands in the shape's own space.
    fn source(&mut self, shape: &Object, flip: bool) -> Result<(MeshSource, DAffine3)> {
        let own = |translation: DVec3, linear: DMat3| DAffine3 { matrix3: linear, translation };
        let (source, place) = match shape.kind.as_str() {
            "obj" | "ply" | "serialized" => return Ok((self.of_file(shape, flip)?, DAffine3::IDENTITY)),
            "rectangle" => (self.round.get("rectangle", tessellate::rectangle), DAffine3::IDENTITY),
            "cube" => (self.round.get("cube", tessellate::cube), DAffine3::IDENTITY),
            "disk" => (self.round.get("disk", tessellate::disk), DAffine3::IDENTITY),
            "sphere" => {
                let centre = shape.vector("center")?.unwrap_or(DVec3::ZERO);
                let radius = shape.number("radius", 1.0)?;
                let place = own(centre, DMat3::from_diagonal(DVec3::splat(radius)));
                (self.round.get("sphere", tessellate::sphere), place)
            }
            "cylinder" => {
                let [a, b] = [shape.vector("p0")?.unwrap_or(DVec3::ZERO), shape.vector("p1")?.unwrap_or(DVec3::Z)];
                let radius = shape.number("radius", 1.0)?;
                let axis = (b - a).try_normalize().ok_or_else(|| shape.error("`p0` and `p1` are at one place"))?;
                let (x, y) = axis.any_orthonormal_pair();
                let place = own(a, DMat3::from_cols(x * radius, y * radius, b - a));
                (self.round.get("cylinder", tessellate::cylinder), place)
            }
            kind => return Err(shape.error(format!("the shape `{kind}` has no counterpart"))),
        };
        let MeshSource::Memory(model) = source else { return Ok((source, place)) };
        let model = if flip { Arc::new(crate::scene::adaptation::flipped(&model)) } else { model };
        Ok((MeshSource::Memory(model), place))
    }

    fn of_file(&self, shape: &Object, flip: bool) -> Result<MeshSource> {
        let path = shape.file()?.to_path_buf();
        let obj = shape.kind == "obj";
        let normals = if shape.flag("face_normals", false)? { NormalsChange::Drop } else { NormalsChange::Smooth };
        let part = match shape.kind.as_str() {
            "serialized" => Some(shape.number("shape_index", 0.0)?.max(0.0) as usize),
            _ => None,
        };
        if shape.maybe_number("max_smooth_angle")?.is_some() {
            self.objects.warn(&shape.at, "`max_smooth_angle` has no counterpart: all edges are smooth");
        }
        // v counts from below here, as in OBJ files; in the other forms as Mitsuba counts, from above
        let flip_v = shape.flag("flip_tex_coords", obj)? != obj;
        let flip_v = if obj { flip_v } else { !flip_v };
        shape.ignore(&["collapse", "shape_index"]);
        Ok(MeshSource::Adapted(path, Adaptation { part, normals, flip, flip_v, ..Adaptation::default() }))
    }

    /// The mesh with the attribute that its material took, if it took one. Only PLY files have others than colours of vertices.
    fn with_attribute(&self, shape: &Object, source: MeshSource) -> Result<MeshSource> {
        let Some(name) = self.materials.textures.take_attribute() else { return Ok(source) };
        match source {
            MeshSource::Adapted(path, adaptation) if shape.kind == "ply" => {
                Ok(MeshSource::Adapted(path, Adaptation { colors: Some(name), ..adaptation }))
            }
            MeshSource::Adapted(..) if name == "vertex_color" => Ok(source),
            _ => Err(shape.error(format!("the {} has no attribute `{name}`", shape.label()))),
        }
    }

    /// The name of the shape's material, which is described under it. `None`: what the file itself says.
    fn material(&mut self, shape: &Object) -> Result<Option<String>> {
        let bsdf = self.objects.child(shape, "bsdf")?;
        let emitter = self.objects.child(shape, "emitter")?;
        if bsdf.is_none() && emitter.is_none() && self.objects.is_old() && shape.kind == "obj" {
            return Ok(None);
        }
        let (name, mut material) = match &bsdf {
            Some(bsdf) => (self.name(bsdf), self.materials.material(bsdf)?),
            None => ("default".to_string(), Materials::default_material(emitter.is_some())),
        };
        let name = match emitter {
            None => name,
            Some(emitter) => {
                self.emission(&emitter, &mut material)?;
                self.shining.insert(Rc::as_ptr(&emitter));
                format!("{name} light")
            }
        };
        // green is across u, seen from outside, whichever way v counts in the picture
        let upright = shape.flag("flip_tex_coords", shape.kind == "obj")?;
        material.change_singles(&mut |single| {
            if let Some(relief) = single.relief.as_mut().filter(|relief| relief.kind == ReliefKind::Normals && !upright)
            {
                relief.kind = ReliefKind::NormalsDown;
            }
        });
        let name = self.free(&name, &material);
        self.file.scene.materials.insert(name.clone(), material);
        Ok(Some(name))
    }

    fn emission(&self, emitter: &Object, material: &mut MaterialDescription) -> Result<()> {
        if emitter.kind != "area" {
            return Err(emitter.error(format!("a shape cannot be the emitter `{}`", emitter.kind)));
        }
        (material.emission, material.emission_map) = self.materials.textures.radiance(emitter, "radiance")?;
        emitter.ignore(&["sampling_weight"]);
        self.objects.finish(emitter);
        if material.emission == Rgb::ZERO {
            material.emission_map = None;
        }
        Ok(())
    }

    /// What a bsdf is called: by its id, else by its number.
    fn name(&mut self, bsdf: &Rc<Object>) -> String {
        let key = Rc::as_ptr(bsdf);
        if let Some(name) = self.names.get(&key) {
            return name.clone();
        }
        let name = bsdf.id.clone().unwrap_or_else(|| format!("{} in line {}", bsdf.kind, bsdf.at.line));
        let taken = |name: &str| self.names.values().any(|known| known == name);
        let name = (1..).map(|k| if k == 1 { name.clone() } else { format!("{name} {k}") }).find(|name| !taken(name));
        let name = name.unwrap_or_default();
        self.names.insert(key, name.clone());
        name
    }

    /// A name that stands for this material, or for none yet.
    fn free(&self, name: &str, material: &MaterialDescription) -> String {
        let known = &self.file.scene.materials;
        let usable = |name: &String| known.get(name).is_none_or(|known| known == material);
        (1..).map(|k| if k == 1 { name.to_string() } else { format!("{name} {k}") }).find(usable).unwrap_or_default()
    }
}
