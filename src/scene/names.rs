//! What things of a scene are called, and which object a hit is on.

use super::assets::LoadedAssets;
use super::description::SceneDescription;
use super::instances::NO_INSTANCE;
use crate::geometry::Hit;
use std::collections::HashMap;

/// Names by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneNames {
    pub(crate) materials: Vec<String>,
    /// Objects: those of meshes that stand by themselves, by the names in their files or, without any, by those of the files; then
    /// instances, by their groups. Each name is there once.
    pub(crate) objects: Vec<String>,
    /// Where the objects of those meshes begin.
    meshes: Vec<MeshObjects>,
    /// Number of the first instance among the objects.
    first_instance: u32,
}

/// The objects of one mesh: where each run of triangles of one object begins, in ascending order, and the object's number.
#[derive(Clone, Debug)]
struct MeshObjects(Vec<(u32, u32)>);

impl SceneNames {
    pub(super) fn of(description: &SceneDescription, gathered: &LoadedAssets) -> SceneNames {
        let (mut objects, mut meshes) = (Vec::new(), Vec::new());
        for (mesh, parts) in description.meshes.iter().zip(&gathered.parts).filter(|(mesh, _)| mesh.group.is_none()) {
            meshes.push(MeshObjects::number(&mesh.source.name(), parts, &mut objects));
        }
        let first_instance = objects.len() as u32;
        objects.extend(description.instances.iter().map(|instance| instance.group.clone()));
        let objects = each_once(objects.into_iter());
        SceneNames { materials: gathered.names.clone(), objects, meshes, first_instance }
    }

    /// Number of the object that a hit is on, among [`Self::objects`].
    pub(super) fn object(&self, hit: &Hit) -> u32 {
        match hit.instance {
            NO_INSTANCE => self.meshes[hit.geometry as usize].at(hit.primitive),
            instance => self.first_instance + instance,
        }
    }
}

impl MeshObjects {
    /// Numbers the objects of a mesh that is called `file`, whose `parts` are as of the model; their names go behind `objects`.
    fn number(file: &str, parts: &[(u32, String)], objects: &mut Vec<String>) -> MeshObjects {
        let mut numbers: HashMap<&str, u32> = HashMap::new();
        let before = parts.first().is_none_or(|(start, _)| *start > 0).then_some((0, file));
        let named = parts.iter().map(|(start, name)| (*start, if name.is_empty() { file } else { name.as_str() }));
        let number = |(start, name)| {
            let number = *numbers.entry(name).or_insert_with(|| {
                objects.push(name.to_string());
                objects.len() as u32 - 1
            });
            (start, number)
        };
        MeshObjects(before.into_iter().chain(named).map(number).collect())
    }

    /// Number of the object of a triangle.
    fn at(&self, triangle: u32) -> u32 {
        self.0[self.0.partition_point(|(start, _)| *start <= triangle) - 1].1
    }
}

/// Adds numbers to names that were there before, as Blender does.
fn each_once(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut taken = Vec::new();
    for name in names {
        let count = seen.entry(name.clone()).or_default();
        taken.push(if *count == 0 { name } else { format!("{name}.{count:03}") });
        *count += 1;
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::{MeshObjects, each_once};

    #[test]
    fn triangles_are_of_the_object_that_was_named_before_them() {
        let mut objects = vec!["earlier".to_string()];
        let parts = [(2, "lamp"), (5, ""), (7, "chair"), (9, "lamp")].map(|(start, name)| (start, name.to_string()));
        let mesh = MeshObjects::number("room", &parts, &mut objects);
        assert_eq!(objects, ["earlier", "room", "lamp", "chair"]);
        assert_eq!([0, 1, 2, 4, 5, 6, 7, 8, 9, 100].map(|t| mesh.at(t)), [1, 1, 2, 2, 1, 1, 3, 3, 2, 2]);
        assert_eq!(MeshObjects::number("plain", &[], &mut objects).at(3), 4);
    }

    #[test]
    fn equal_names_are_told_apart() {
        let names = ["a", "b", "a", "a"].map(String::from);
        assert_eq!(each_once(names.into_iter()), ["a", "b", "a.001", "a.002"]);
    }
}
