//! From meshes to what answers ray queries.

use super::description::{InstanceDescription, SceneDescription};
use super::instances::Instances;
use super::material::{Material, opacity_test};
use crate::embree::{
    self, BuildOptions, Device, Instance, LARGEST_COORDINATE, SMALLEST_EXTENT, SceneBuilder, Triangles,
};
use crate::error::SourceLocation;
use crate::geometry::{Mesh, Placement};
use crate::texture::Texture;
use crate::{Error, Result};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// What acceleration structures are made with.
pub(super) struct Build<'a> {
    pub(crate) device: Arc<Device>,
    pub(crate) options: BuildOptions,
    pub(crate) materials: &'a Arc<Vec<Material>>,
    pub(crate) textures: &'a Arc<Vec<Texture>>,
}

impl Build<'_> {
    /// The scene's own meshes, its instances, and the structure over both: first the meshes, then the instances.
    /// `meshes` are those of the description, in its order.
    pub(crate) fn world(
        &self,
        description: &SceneDescription,
        meshes: Vec<Mesh>,
    ) -> Result<(Vec<Arc<Mesh>>, Instances, embree::Scene)> {
        let Sorted { own, groups, names } = sort(description, meshes);
        let shared = groups.iter().map(|group| Ok(Arc::new(self.start(group)?.commit()?)));
        let shared = shared.collect::<Result<Vec<_>>>()?;
        let mut world = self.start(&own)?;
        let mut instances = Instances::new(groups, own.len() as u32);
        let mut placed = Vec::new();
        for instance in &description.instances {
            let group = *names.get(&*instance.group).ok_or_else(|| no_group(&instance.group))?;
            let to_world = instance.transform.as_affine3a();
            let placement = Placement::new(to_world);
            // Nothing is seen of a group without triangles.
            let Some((low, high)) = shared[group].bounds() else { continue };
            check_extent(low, high, &format!("the group `{}`", instance.group), instance.location.as_ref())?;
            let own = low.abs().max(high.abs());
            check_reach(placement.reach(own).max_element(), instance)?;
            world.add_instance(Instance { scene: shared[group].clone(), to_world })?;
            instances.push(group, placement)?;
            placed.push((instance, placement, own.max_element()));
        }
        let world = world.commit()?;
        let (low, high) = world.bounds().ok_or_else(|| Error::Scene("the scene has no extent".into()))?;
        check_extent(low, high, "the scene", description.meshes.iter().find_map(|mesh| mesh.location.as_ref()))
            .map_err(|error| of_model(error, description))?;
        let camera = description.camera.as_ref().map_or(Vec3::ZERO, |camera| camera.origin.as_vec3().abs());
        let largest = low.abs().max(high.abs()).max(camera).max_element();
        for (instance, placement, own) in placed {
            check_inverse(&placement, largest, own, instance)?;
        }
        Ok((own, instances, world))
    }

    /// A structure of these meshes, in their order.
    fn start(&self, meshes: &[Arc<Mesh>]) -> Result<SceneBuilder> {
        let mut builder = SceneBuilder::new(&self.device, self.options)?;
        for mesh in meshes {
            builder.add_mesh(mesh.clone(), buffers, opacity_test(mesh, self.materials, self.textures))?;
        }
        Ok(builder)
    }
}

/// What Embree reads of a mesh.
fn buffers(mesh: &Mesh) -> Triangles<'_> {
    Triangles { positions: &mesh.positions, triangles: &mesh.triangles }
}

/// An error at a place of the scene file, where there is one.
fn refused(location: Option<&SourceLocation>, message: String) -> Error {
    match location {
        Some(location) => location.error(message),
        None => Error::Scene(message),
    }
}

/// An error without a place is one of the scene's model, where there is nothing but that.
fn of_model(error: Error, description: &SceneDescription) -> Error {
    match (error, &*description.meshes) {
        (Error::Scene(message), [model]) => model.source.error(message),
        (error, _) => error,
    }
}

fn check_extent(low: Vec3, high: Vec3, what: &str, location: Option<&SourceLocation>) -> Result<()> {
    let extent = (high - low).max_element();
    if extent >= SMALLEST_EXTENT {
        return Ok(());
    }
    let message = format!("{what} has an extent of {extent:e}, and less than {SMALLEST_EXTENT:e} cannot be traced");
    Err(refused(location, format!("{message}: choose a smaller unit")))
}

fn check_reach(reach: f32, instance: &InstanceDescription) -> Result<()> {
    if reach <= LARGEST_COORDINATE {
        return Ok(());
    }
    let message = format!("an instance of the group `{}` reaches beyond coordinates of 1e12", instance.group);
    Err(refused(instance.location.as_ref(), message))
}

fn check_inverse(placement: &Placement, world: f32, own: f32, instance: &InstanceDescription) -> Result<()> {
    if placement.carries_rays(world, own) {
        return Ok(());
    }
    let message = format!(
        "an instance of the group `{}` is too flat, too small or too large for single precision: rays cannot be moved \
         into its space",
        instance.group
    );
    Err(refused(instance.location.as_ref(), message))
}

fn no_group(name: &str) -> Error {
    Error::Scene(format!("an instance is of the group `{name}`, to which no mesh belongs"))
}

/// Meshes by what they are part of.
#[derive(Default)]
struct Sorted<'a> {
    own: Vec<Arc<Mesh>>,
    groups: Vec<Vec<Arc<Mesh>>>,
    /// Index in `groups` by name.
    names: FxHashMap<&'a str, usize>,
}

fn sort(description: &SceneDescription, meshes: Vec<Mesh>) -> Sorted<'_> {
    let mut sorted = Sorted::default();
    for (mesh, said) in meshes.into_iter().map(Arc::new).zip(&description.meshes) {
        let Some(name) = &said.group else {
            sorted.own.push(mesh);
            continue;
        };
        let group = *sorted.names.entry(name).or_insert(sorted.groups.len());
        if group == sorted.groups.len() {
            sorted.groups.push(Vec::new());
        }
        sorted.groups[group].push(mesh);
    }
    sorted
}
