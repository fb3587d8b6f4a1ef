//! The lights of a scene: triangles that emit, wherever they stand, beside those that a scene file names.

use super::instances::Instances;
use super::material::{Material, emitter_pattern};
use crate::geometry::{Mesh, Placement};
use crate::io::memory;
use crate::light::{ConstantLight, EmissiveTriangle, Light, LightUnit, Lights};
use crate::math::Rgb;
use crate::texture::Texture;
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// All surfaces of a scene and what they are made of.
pub(super) struct Surfaces<'a> {
    pub(crate) meshes: &'a [Arc<Mesh>],
    pub(crate) instances: &'a Instances,
    pub(crate) materials: &'a Arc<Vec<Material>>,
    pub(crate) textures: &'a Arc<Vec<Texture>>,
}

/// All lights of a scene.
pub(super) struct Lighting {
    pub(crate) lights: Lights,
    /// Of their emission.
    pub(crate) unit: LightUnit,
    /// Whether there was none, and a sky was added.
    pub(crate) sky_added: bool,
}

/// A light for scenes that have none.
pub(super) fn sky() -> Light {
    ConstantLight { radiance: Rgb::ONE }.into()
}

/// The lights of the surfaces, beside the `others`; a sky where there are neither.
pub(super) fn lights(mut others: Vec<Light>, surfaces: &Surfaces, bounds: (Vec3, Vec3)) -> Result<Lighting> {
    let own = (0..).zip(surfaces.meshes).flat_map(|(k, mesh)| surfaces.emitters(k, mesh, None));
    let placed = surfaces.instances.surfaces();
    let placed = placed.flat_map(|(k, mesh, place)| surfaces.emitters(k, mesh, Some(place)));
    let mut emissive = collected(own.chain(placed))?;
    let sky_added = emissive.is_empty() && others.is_empty();
    if sky_added {
        others.push(sky());
    }
    let radius = 0.5 * (bounds.1 - bounds.0).length();
    let unit = LightUnit::of(&emissive, &others, radius);
    emissive.iter_mut().for_each(|triangle| triangle.radiance = unit.divide(triangle.radiance));
    let others = others.into_iter().map(|light| unit.divide_light(light)).collect();
    Ok(Lighting { lights: Lights::build(&emissive, others, radius)?, unit, sky_added })
}

impl<'a> Surfaces<'a> {
    /// The triangles of surface `k` that emit, in world space; `place`: of an instance of the mesh.
    fn emitters(
        &self,
        k: u32,
        mesh: &'a Arc<Mesh>,
        place: Option<&'a Placement>,
    ) -> impl Iterator<Item = EmissiveTriangle> + use<'a> {
        let (materials, textures) = (self.materials, self.textures);
        let emits = materials.iter().any(|m| m.emits());
        let candidates = if emits { &mesh.materials[..] } else { &[] };
        let mirrored = place.is_some_and(|place| place.mirrored());
        let mut pattern = None;
        let glows = move |triangle: usize, m: u32| {
            let material = &materials[m as usize];
            material.emits() && !material.is_dark(textures, || mesh.uvs_of(triangle))
        };
        let candidates = candidates.iter().enumerate().filter(move |(triangle, m)| glows(*triangle, **m));
        candidates.map(move |(triangle, m)| {
            let material = &materials[*m as usize];
            let constant = material.constant_opacity(textures).filter(|_| !material.has_emission_map());
            let mut varying =
                || pattern.get_or_insert_with(|| emitter_pattern(mesh, materials, textures, mirrored)).clone();
            EmissiveTriangle {
                mesh: k,
                triangle: triangle as u32,
                corners: place.map_or_else(|| mesh.corners(triangle), |place| place.facet(mesh, triangle)),
                radiance: material.brightest_emission() * constant.unwrap_or(1.0),
                two_sided: material.emission_two_sided(),
                group: material.light_group(),
                pattern: constant.is_none().then(&mut varying),
                slack: place.map_or(0.0, |place| place.slack_of(mesh, triangle)),
            }
        })
    }
}

/// In a vector that is held against the memory whenever it grows: instances make many lights of few.
fn collected(triangles: impl Iterator<Item = EmissiveTriangle>) -> Result<Vec<EmissiveTriangle>> {
    let mut all = Vec::new();
    for triangle in triangles {
        if all.len() == all.capacity() {
            let more = all.len().max(1024);
            check_lights(all.len() + more)?;
            all.reserve_exact(more);
        }
        all.push(triangle);
    }
    Ok(all)
}

fn check_lights(triangles: usize) -> Result<()> {
    let bytes = triangles as u64 * Lights::BYTES_PER_TRIANGLE;
    memory::check(bytes).map_err(|shortage| {
        Error::Scene(format!("triangles that emit light, of all instances, are too many: {triangles} {shortage}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn places_that_make_too_many_lights_are_an_error_and_not_an_abort() {
        let triangle = || EmissiveTriangle {
            mesh: 0,
            triangle: 0,
            corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
            radiance: Rgb::ONE,
            two_sided: false,
            group: 0,
            pattern: None,
            slack: 0.0,
        };
        assert_eq!(collected(std::iter::repeat_with(triangle).take(5000)).unwrap().len(), 5000);
        let message = check_lights(1 << 50).unwrap_err().to_string();
        assert!(message.contains("1125899906842624 take "), "{message}");
    }
}
