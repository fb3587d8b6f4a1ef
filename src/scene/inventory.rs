//! What a scene consists of, in numbers.

use super::Scene;
use super::description::MaterialDescription;
use crate::texture::Texture;

/// Who describes a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaterialSource {
    SceneFile,
    /// A library that the model names.
    Library,
    /// Nobody does: it is grey.
    Nobody,
}

/// A material as it is understood.
#[derive(Clone, Debug)]
pub(crate) struct DescribedMaterial {
    pub(crate) name: String,
    /// With all its pictures, be they there or not.
    pub(crate) description: MaterialDescription,
    pub(crate) source: MaterialSource,
}

/// What is made of a material. Instances count in each of their places.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MaterialUse {
    pub(crate) triangles: usize,
    /// In the scene's own unit, squared.
    pub(crate) area: f64,
}

/// Numbers of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Inventory {
    pub(crate) meshes: usize,
    pub(crate) instances: usize,
    pub(crate) mesh_bytes: usize,
    pub(crate) texture_bytes: usize,
    /// By number.
    pub(crate) materials: Vec<MaterialUse>,
    /// Luminance of the power of each light that is no surface, in W: first those of the description, then a sky that was
    /// added.
    pub(crate) far_power: Vec<f64>,
}

impl Scene {
    /// All materials, by number.
    pub(crate) fn described_materials(&self) -> &[DescribedMaterial] {
        &self.described_materials
    }

    /// Counts what there is.
    pub(crate) fn inventory(&self) -> Inventory {
        let (shared, instances) = self.instances.counts();
        let meshes = self.meshes.iter().chain(shared.iter().flat_map(|group| group.iter()));
        let radius = 0.5 * (self.bounds.1 - self.bounds.0).length();
        let powers = self.lights.far_powers(radius);
        Inventory {
            meshes: meshes.clone().count(),
            instances,
            mesh_bytes: meshes.map(|mesh| mesh.bytes()).sum(),
            texture_bytes: self.textures.iter().map(Texture::bytes).sum(),
            materials: self.uses(),
            far_power: powers.into_iter().map(|power| power * self.light_unit.value()).collect(),
        }
    }

    fn uses(&self) -> Vec<MaterialUse> {
        let mut uses = vec![MaterialUse::default(); self.described_materials.len()];
        let own = self.meshes.iter().flat_map(|mesh| &mesh.materials);
        let placed = self.instances.surfaces().flat_map(|(_, mesh, _)| &mesh.materials);
        for (&material, [a, b, c]) in own.chain(placed).zip(self.facets()) {
            let used = &mut uses[material as usize];
            used.triangles += 1;
            used.area += 0.5 * (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
        }
        uses
    }
}
