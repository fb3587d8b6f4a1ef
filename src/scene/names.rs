//! What things of a scene are called.

use super::assets::LoadedAssets;
use super::description::SceneDescription;
use std::collections::HashMap;

/// Names by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneNames {
    pub(crate) materials: Vec<String>,
    /// Meshes that stand by themselves, by their files; then instances, by their groups. Each name is there once.
    pub(crate) objects: Vec<String>,
}

impl SceneNames {
    pub(super) fn of(description: &SceneDescription, gathered: &LoadedAssets) -> SceneNames {
        let own = description.meshes.iter().filter(|mesh| mesh.group.is_none()).map(|mesh| mesh.source.name());
        let placed = description.instances.iter().map(|instance| instance.group.clone());
        SceneNames { materials: gathered.names.clone(), objects: each_once(own.chain(placed)) }
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
    use super::each_once;

    #[test]
    fn equal_names_are_told_apart() {
        let names = ["a", "b", "a", "a"].map(String::from);
        assert_eq!(each_once(names.into_iter()), ["a", "b", "a.001", "a.002"]);
    }
}
