//! Meshes that stand in many places.

use crate::geometry::{Hit, Mesh, Placement, SurfaceInteraction, Surfaces};
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// What a hit carries as its instance where the mesh is the scene's own.
pub(super) const NO_INSTANCE: u32 = u32::MAX;

/// The instances of a scene, in the order of their ids.
///
/// Each mesh of each instance is a *surface* of its own for lights, with a number: the scene's own meshes are numbered
/// first, then those of one instance after the other.
#[derive(Default)]
pub(super) struct Instances {
    groups: Vec<Vec<Arc<Mesh>>>,
    places: Vec<Place>,
    /// Id of the first instance, those below being the scene's own meshes.
    first_id: u32,
    /// Number of the next instance's first surface.
    next_surface: u32,
}

struct Place {
    group: usize,
    placement: Placement,
    first_surface: u32,
}

impl Instances {
    /// No instances yet of `groups`, in a scene with `own` meshes that are no part of a group.
    pub(crate) fn new(groups: Vec<Vec<Arc<Mesh>>>, own: u32) -> Instances {
        Instances { groups, places: Vec::new(), first_id: own, next_surface: own }
    }

    /// The next instance; ids are given one by one.
    ///
    /// # Errors
    /// Beyond 2³² − 1 surfaces.
    pub(crate) fn push(&mut self, group: usize, placement: Placement) -> Result<()> {
        self.places.push(Place { group, placement, first_surface: self.next_surface });
        let meshes = self.groups[group].len() as u32;
        let next = self.next_surface.checked_add(meshes);
        self.next_surface = next.ok_or_else(|| Error::Scene("the scene has too many instances".into()))?;
        Ok(())
    }

    /// The surface point of a hit on an instance.
    #[inline(never)]
    pub(crate) fn interaction(&self, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        let (mesh, placement) = self.placed(hit);
        SurfaceInteraction::placed(mesh, placement, hit, wo)
    }

    /// The same for lane `k` of a packet.
    #[inline(never)]
    pub(crate) fn meet(&self, k: usize, hit: Hit, surfaces: &mut Surfaces) {
        let (mesh, placement) = self.placed(&hit);
        surfaces.push_placed(k, mesh, placement, &hit);
    }

    /// The mesh that was hit.
    #[inline(never)]
    pub(crate) fn mesh(&self, hit: Hit) -> &Mesh {
        self.placed(&hit).0
    }

    /// The mesh that was hit, and where it stands.
    fn placed(&self, hit: &Hit) -> (&Mesh, &Placement) {
        let place = self.place(hit);
        (&self.groups[place.group][hit.geometry as usize], &place.placement)
    }

    /// Number of the surface that a hit on an instance is on.
    pub(crate) fn surface(&self, hit: &Hit) -> u32 {
        self.place(hit).first_surface + hit.geometry
    }

    /// The mesh that was hit, and the corners of the triangle in world space, in the mesh's order.
    pub(crate) fn corners(&self, hit: &Hit) -> (&Mesh, [Vec3; 3]) {
        let (mesh, placement) = self.placed(hit);
        (mesh, mesh.corners(hit.primitive as usize).map(|p| placement.point(p)))
    }

    /// Whether the mesh that was hit stands mirrored.
    pub(crate) fn mirrored(&self, hit: &Hit) -> bool {
        self.place(hit).placement.mirrored()
    }

    fn place(&self, hit: &Hit) -> &Place {
        &self.places[(hit.instance - self.first_id) as usize]
    }

    /// The groups' meshes, and how many places there are.
    pub(crate) fn counts(&self) -> (&[Vec<Arc<Mesh>>], usize) {
        (&self.groups, self.places.len())
    }

    /// Every surface: its number, its mesh, and where it stands.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = (u32, &Arc<Mesh>, &Placement)> + Clone {
        self.places.iter().flat_map(|place| {
            let meshes = &self.groups[place.group];
            (place.first_surface..).zip(meshes).map(|(number, mesh)| (number, mesh, &place.placement))
        })
    }
}

#[cfg(test)]
mod tests;
