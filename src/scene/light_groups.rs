//! Lights that are told apart in pictures.

use super::description::{MaterialDescription, SceneDescription};
use crate::light::{Light, LightSource};
use crate::{Error, Result};
use std::collections::BTreeSet;

/// The group of all lights that are in no other.
pub(crate) const DEFAULT: &str = "default";

/// The groups of a scene's lights. Number 0 is [`DEFAULT`].
#[derive(Clone, Debug)]
pub(crate) struct LightGroups {
    names: Vec<String>,
}

impl LightGroups {
    /// Those that lights and `materials` of the scene name.
    pub(super) fn of<'a>(
        scene: &'a SceneDescription,
        materials: impl Iterator<Item = &'a MaterialDescription>,
    ) -> LightGroups {
        let named = materials.filter_map(|material| material.light_group.as_ref());
        let all: BTreeSet<&String> = scene.light_groups.iter().flatten().chain(named).collect();
        let others = all.into_iter().filter(|name| *name != DEFAULT).cloned();
        LightGroups { names: std::iter::once(DEFAULT.to_string()).chain(others).collect() }
    }

    /// The names by number.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of a group; of none, 0.
    pub(super) fn number(&self, name: Option<&String>) -> u32 {
        name.and_then(|name| self.names.iter().position(|known| known == name)).unwrap_or(0) as u32
    }

    /// The numbers of the groups of the lights that are no surfaces.
    ///
    /// # Errors
    /// Surroundings in two groups: they shine from the same directions, and are sampled as one light.
    pub(super) fn of_lights(&self, scene: &SceneDescription, lights: &[Light]) -> Result<Vec<u32>> {
        let name = |k: usize| scene.light_groups.get(k).and_then(Option::as_ref);
        let groups: Vec<u32> = (0..lights.len()).map(|k| self.number(name(k))).collect();
        let of_surroundings = lights.iter().zip(&groups).filter(|(light, _)| light.surrounds());
        let numbers: BTreeSet<u32> = of_surroundings.map(|(_, group)| *group).collect();
        let names: Vec<String> = numbers.iter().map(|&k| format!("`{}`", self.names[k as usize])).collect();
        match numbers.len() {
            0 | 1 => Ok(groups),
            _ => Err(Error::Scene(format!(
                "light_group: lights that surround the scene shine from the same directions and must be in one group, not in {}",
                names.join(" and ")
            ))),
        }
    }
}

impl SceneDescription {
    /// How many groups its lights are in, as far as the scene file says.
    pub(crate) fn light_group_count(&self) -> usize {
        LightGroups::of(self, self.materials.values()).names.len()
    }
}
