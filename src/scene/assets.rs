//! Meshes in place, with numbers for their materials: what a scene consists of before anything is built.

use super::description::{MaterialDescription, MeshDescription, SceneDescription};
use super::inventory::{DescribedMaterial, MaterialSource};
use super::model::Model;
use super::{hash, origin};
use crate::Result;
use crate::bsdf::color_textures;
use crate::document::suggest::{list, nearest};
use crate::embree::LARGEST_COORDINATE;
use crate::geometry::{Indices, Mesh, Placement};
use crate::texture::ColorTexture;
use glam::{Affine3A, DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// What is gathered from the files before anything is built.
#[derive(Default)]
pub(crate) struct LoadedAssets {
    /// In the description's order and in place.
    pub(crate) meshes: Vec<Mesh>,
    /// Of each mesh, as its file has it.
    pub(crate) hashes: Vec<u64>,
    /// Of each mesh, its objects, as [`Model::parts`].
    pub(super) parts: Vec<Vec<(u32, String)>>,
    /// What the meshes' material numbers mean.
    pub(crate) materials: Vec<MaterialDescription>,
    /// Of the materials.
    pub(crate) names: Vec<String>,
    /// The materials before pictures that are missing are replaced, with who describes them.
    pub(super) described: Vec<DescribedMaterial>,
    /// Of each material, whether a library describes it and not the scene file.
    pub(super) of_library: Vec<bool>,
    /// Index in `materials` by library and name: two models may use one name for two things.
    ids: FxHashMap<(Option<usize>, String), u32>,
    pub(crate) warnings: Vec<String>,
    /// With all of it counted from `origin`, and transforms that take the models there from where they are counted from.
    pub(crate) description: SceneDescription,
    /// In the coordinates of the files.
    pub(crate) origin: DVec3,
}

impl LoadedAssets {
    /// Reads all models that the description names.
    pub(crate) fn of(description: &SceneDescription) -> Result<LoadedAssets> {
        let mut gathered = LoadedAssets::default();
        let mut origins = Vec::with_capacity(description.meshes.len());
        let mut known = BTreeSet::new();
        for (k, mesh) in description.meshes.iter().enumerate() {
            origins.push(gathered.add_mesh(k, mesh, description, &mut known)?);
        }
        gathered.warnings.extend(check_names(description, known)?);
        (gathered.description, gathered.origin) = origin::rebase(description, &gathered.meshes, &origins);
        gathered.warnings.extend(origin::note(gathered.origin));
        for (mesh, place) in gathered.meshes.iter_mut().zip(&gathered.description.meshes) {
            let to_world = place.transform.as_affine3a();
            gathered.hashes.push(hash::mesh(mesh, to_world));
            transform(mesh, &Placement::new(to_world));
            check_positions(mesh, place)?;
            // Embree reads a vertex with 16 bytes, four more than the last one has.
            mesh.positions.reserve_exact(1);
        }
        Ok(gathered)
    }

    /// Loads one model and gives its materials their numbers in the scene. Returns what the model is counted from. `known` are the names
    /// of all models' materials.
    fn add_mesh(
        &mut self,
        model: usize,
        place: &MeshDescription,
        scene: &SceneDescription,
        known: &mut BTreeSet<String>,
    ) -> Result<DVec3> {
        let loaded = place.source.load()?;
        known.extend(loaded.material_names.iter().chain(loaded.materials.keys()).cloned());
        check_replacement(place, &loaded, scene)?;
        self.warnings.extend(loaded.warnings.iter().map(ToString::to_string));
        let numbers = loaded
            .material_names
            .iter()
            .map(|name| self.material(model, place.material.as_ref().unwrap_or(name), &loaded, scene))
            .collect::<Result<Vec<u32>>>()?;
        for &number in &numbers {
            self.check_vertex_colors(number, &loaded, place)?;
        }
        let origin = loaded.origin;
        let (mut mesh, parts) = match loaded {
            Cow::Owned(model) => (model.mesh, model.parts),
            Cow::Borrowed(model) => (model.mesh.clone(), model.parts.clone()),
        };
        self.parts.push(parts);
        mesh.materials.iter_mut().for_each(|m| *m = numbers[*m as usize]);
        self.meshes.push(mesh);
        Ok(origin)
    }

    /// That a material which takes the colours of vertices finds some.
    fn check_vertex_colors(&self, number: u32, loaded: &Model, place: &MeshDescription) -> Result<()> {
        let (material, name) = (&self.materials[number as usize], &self.names[number as usize]);
        let asks = |texture: Option<ColorTexture>| matches!(texture, Some(ColorTexture::Vertex(_)));
        let mut asked = false;
        material.each_single(&mut |single| asked |= color_textures(&single.bsdf).into_iter().any(asks));
        if loaded.mesh.colors.is_some() || !asked {
            return Ok(());
        }
        Err(place.source.error(format!("material `{name}` takes the colours of vertices, and there are none")))
    }

    /// A name means what the scene file says of it, else what the model's own library says, else grey, with the scene file's changes.
    fn material(&mut self, model: usize, name: &str, loaded: &Model, scene: &SceneDescription) -> Result<u32> {
        let named = scene.materials.get(name);
        let owner = if named.is_some() { None } else { Some(model) };
        if let Some(&id) = self.ids.get(&(owner, name.to_string())) {
            return Ok(id);
        }
        let unknown = || MaterialDescription::unknown(loaded.mesh.colors.is_some());
        let mut material = named.or_else(|| loaded.materials.get(name)).cloned().unwrap_or_else(unknown);
        for change in scene.material_changes.iter().filter(|change| change.name == name) {
            material = (change.apply)(&material)?;
        }
        self.described.push(described(name, &material, named.is_some(), loaded.materials.contains_key(name)));
        self.materials.push(material);
        self.of_library.push(named.is_none());
        self.names.push(name.to_string());
        let id = self.materials.len() as u32 - 1;
        self.ids.insert((owner, name.to_string()), id);
        Ok(id)
    }
}

/// That the material which replaces a model's own is described somewhere.
fn check_replacement(place: &MeshDescription, loaded: &Model, scene: &SceneDescription) -> Result<()> {
    let Some(name) = &place.material else { return Ok(()) };
    if scene.materials.contains_key(name) || loaded.materials.contains_key(name) {
        return Ok(());
    }
    let candidates: BTreeSet<&str> =
        scene.materials.keys().chain(loaded.materials.keys()).map(String::as_str).collect();
    let message = no_material(&format!("no material `{name}` is described"), name, candidates);
    Err(match &place.material_location {
        Some(location) => location.error(message),
        None => place.source.error(message),
    })
}

/// That materials which the scene file names are those of a model. Files of other programs do not say where they name them: of those it
/// is a warning.
fn check_names(description: &SceneDescription, mut known: BTreeSet<String>) -> Result<Vec<String>> {
    known.extend(description.meshes.iter().filter_map(|mesh| mesh.material.clone()));
    description.materials.values().for_each(|material| material.add_names_of_parts(&mut known));
    known.remove("");
    let message = |name: &str| {
        let subject = format!("no model has a material `{name}`");
        no_material(&subject, name, known.iter().map(String::as_str).collect())
    };
    let missing = |name: &str| !name.is_empty() && !known.contains(name);
    match description.named_materials.iter().find(|(name, _)| missing(name)) {
        Some((name, place)) => Err(place.error(message(name))),
        None => Ok(description.materials.keys().filter(|name| missing(name)).map(|name| message(name)).collect()),
    }
}

/// Names that a message lists before it only counts them.
const LISTED: usize = 8;

fn no_material(subject: &str, name: &str, known: BTreeSet<&str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    match nearest(name, &known) {
        Some(best) => format!("{subject}: did you mean `{best}`?"),
        None if known.is_empty() => format!("{subject}: their faces name none"),
        None if known.len() > LISTED => {
            format!("{subject}: there are {}, among them {}", known.len(), list(&known[..LISTED]))
        }
        None => format!("{subject}: known are {}", list(&known)),
    }
}

/// A material, with who describes it.
fn described(name: &str, material: &MaterialDescription, by_scene: bool, by_library: bool) -> DescribedMaterial {
    let source = match (by_scene, by_library) {
        (true, _) => MaterialSource::SceneFile,
        (false, true) => MaterialSource::Library,
        (false, false) => MaterialSource::Nobody,
    };
    DescribedMaterial { name: name.to_string(), description: material.clone(), source }
}

/// That the transform has not carried the mesh beyond what can be traced; what its own file says is within it.
fn check_positions(mesh: &Mesh, place: &MeshDescription) -> Result<()> {
    let traced = |p: &[f32; 3]| p.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
    if mesh.positions.par_iter().all(traced) {
        return Ok(());
    }
    let message = "this transform carries the mesh beyond coordinates of 1e12";
    Err(match &place.location {
        Some(location) => location.error(message),
        None => place.source.error(message),
    })
}

/// Moves a mesh into place. A mirroring turns the corners' order round, so that the winding keeps its meaning.
fn transform(mesh: &mut Mesh, placement: &Placement) {
    if placement.to_world() == Affine3A::IDENTITY {
        return;
    }
    mesh.positions.par_iter_mut().for_each(|p| *p = placement.point(Vec3::from(*p)).into());
    if let Some(normals) = &mut mesh.normals {
        normals.values.par_iter_mut().for_each(|n| *n = placement.normal(Vec3::from(*n)).into());
    }
    if placement.mirrored() {
        let own = [mesh.normals.as_mut().map(|n| &mut n.indices), mesh.uvs.as_mut().map(|uvs| &mut uvs.indices)];
        for indices in own.into_iter().flatten() {
            if let Indices::Own(indices) = indices {
                indices.iter_mut().for_each(|t| t.swap(1, 2));
            }
        }
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
