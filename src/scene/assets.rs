//! Meshes in place, with numbers for their materials: what a scene consists of before anything is built.

use super::description::{MaterialDescription, MeshDescription, SceneDescription};
use super::hash;
use crate::Result;
use crate::embree::LARGEST_COORDINATE;
use crate::geometry::{Indices, Mesh, Placement};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What is gathered from the files before anything is built.
#[derive(Default)]
pub(crate) struct LoadedAssets {
    /// In the description's order and in place.
    pub(crate) meshes: Vec<Mesh>,
    /// Of each mesh, as its file has it.
    pub(crate) hashes: Vec<u64>,
    /// What the meshes' material numbers mean.
    pub(crate) materials: Vec<MaterialDescription>,
    /// Of the materials.
    pub(crate) names: Vec<String>,
    /// Of each material, whether a library describes it and not the scene file.
    pub(super) of_library: Vec<bool>,
    /// Index in `materials` by library and name: two models may use one name for two things.
    ids: FxHashMap<(Option<usize>, String), u32>,
    pub(crate) warnings: Vec<String>,
}

impl LoadedAssets {
    /// Reads all models that the description names.
    pub(crate) fn of(description: &SceneDescription) -> Result<LoadedAssets> {
        let mut gathered = LoadedAssets::default();
        for (k, mesh) in description.meshes.iter().enumerate() {
            gathered.add_mesh(k, mesh, description)?;
        }
        Ok(gathered)
    }

    /// Loads one model, moves it into place, and gives its materials their numbers in the scene.
    fn add_mesh(&mut self, model: usize, place: &MeshDescription, scene: &SceneDescription) -> Result<()> {
        let loaded = place.source.load()?;
        self.warnings.extend(loaded.warnings.iter().map(ToString::to_string));
        let numbers: Vec<u32> = loaded
            .material_names
            .iter()
            .map(|name| self.material(model, place.material.as_ref().unwrap_or(name), &loaded.materials, scene))
            .collect();
        let mut mesh = match loaded {
            Cow::Owned(model) => model.mesh,
            Cow::Borrowed(model) => model.mesh.clone(),
        };
        mesh.materials.iter_mut().for_each(|m| *m = numbers[*m as usize]);
        self.hashes.push(hash::mesh(&mesh, place.transform));
        transform(&mut mesh, &Placement::new(place.transform));
        check_positions(&mesh, place)?;
        // Embree reads a vertex with 16 bytes, four more than the last one has.
        mesh.positions.reserve_exact(1);
        self.meshes.push(mesh);
        Ok(())
    }

    /// A name means what the scene file says of it, else what the model's own library says, else grey.
    fn material(
        &mut self,
        model: usize,
        name: &str,
        library: &BTreeMap<String, MaterialDescription>,
        scene: &SceneDescription,
    ) -> u32 {
        let named = scene.materials.get(name);
        let owner = if named.is_some() { None } else { Some(model) };
        if let Some(&id) = self.ids.get(&(owner, name.to_string())) {
            return id;
        }
        self.materials.push(named.or_else(|| library.get(name)).cloned().unwrap_or_default());
        self.of_library.push(named.is_none());
        self.names.push(name.to_string());
        let id = self.materials.len() as u32 - 1;
        self.ids.insert((owner, name.to_string()), id);
        id
    }
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
