//! From meshes to what answers ray queries.

use super::description::SceneDescription;
use super::instances::Instances;
use super::material::{Material, opacity_test};
use super::texture::Texture;
use crate::embree::{self, Device, Instance, LARGEST_COORDINATE, SceneBuilder};
use crate::geometry::{Mesh, Placement};
use crate::{Error, Result};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// What acceleration structures are made with.
pub(super) struct Build<'a> {
    pub device: Arc<Device>,
    pub robust: bool,
    pub materials: &'a Arc<Vec<Material>>,
    pub textures: &'a Arc<Vec<Texture>>,
}

impl Build<'_> {
    /// The scene's own meshes, its instances, and the structure over both: first the meshes, then the instances.
    /// `meshes` are those of the description, in its order.
    pub fn world(
        &self,
        description: &SceneDescription,
        meshes: Vec<Mesh>,
    ) -> Result<(Vec<Arc<Mesh>>, Instances, embree::Scene)> {
        let Sorted { own, groups, names } = sort(description, meshes);
        let shared = groups.iter().map(|group| Ok(Arc::new(self.start(group)?.commit()?)));
        let shared = shared.collect::<Result<Vec<_>>>()?;
        let mut world = self.start(&own)?;
        let mut instances = Instances::new(groups, own.len() as u32);
        for instance in &description.instances {
            let group = *names.get(&*instance.group).ok_or_else(|| no_group(&instance.group))?;
            let placement = Placement::new(instance.transform);
            // Nothing is seen of a group without triangles.
            let Some((low, high)) = shared[group].bounds() else { continue };
            check_reach(placement.reach(low.abs().max(high.abs())).max_element(), &instance.group)?;
            world.add_instance(Instance { scene: shared[group].clone(), to_world: instance.transform })?;
            instances.push(group, placement)?;
        }
        Ok((own, instances, world.commit()?))
    }

    /// A structure of these meshes, in their order.
    fn start(&self, meshes: &[Arc<Mesh>]) -> Result<SceneBuilder> {
        let mut builder = SceneBuilder::new(&self.device, self.robust)?;
        for mesh in meshes {
            builder.add_mesh(mesh.clone(), opacity_test(mesh, self.materials, self.textures))?;
        }
        Ok(builder)
    }
}

fn check_reach(reach: f32, group: &str) -> Result<()> {
    if reach <= LARGEST_COORDINATE {
        return Ok(());
    }
    Err(Error::Scene(format!("an instance of the group `{group}` reaches beyond coordinates of 1.8e18")))
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
