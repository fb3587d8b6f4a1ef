//! From files to an immutable scene.

mod camera;
pub mod description;
pub mod file;
pub mod interchange;
mod load;
pub mod material;
pub mod obj;
pub mod texture;

pub use camera::Camera;

use crate::bsdf::Bsdf;
use crate::embree::{self, Hit, Ray};
use crate::geometry::{Mesh, SurfaceInteraction};
use crate::light::Lights;
use crate::math::Rgb;
use glam::Vec3;
use material::Material;
use std::sync::Arc;
use texture::Texture;

/// A scene, loaded and built. Nothing of it changes while it is rendered.
pub struct Scene {
    pub camera: Camera,
    geometry: embree::Scene,
    meshes: Vec<Arc<Mesh>>,
    materials: Arc<Vec<Material>>,
    textures: Arc<Vec<Texture>>,
    lights: Lights,
    bounds: (Vec3, Vec3),
    hash: u64,
    content_hash: u64,
    build_seconds: f64,
}

impl Scene {
    /// What answers ray queries; mesh k of the scene is its geometry k.
    #[inline]
    pub fn geometry(&self) -> &embree::Scene {
        &self.geometry
    }

    /// The surface point of a hit, seen from `wo` (unit, away from the surface).
    #[inline]
    pub fn interaction(&self, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        SurfaceInteraction::new(&self.meshes[hit.geometry as usize], hit, wo)
    }

    /// How the surface scatters there, textures looked up.
    #[inline]
    pub fn bsdf(&self, si: &SurfaceInteraction) -> Bsdf<'_> {
        self.materials[si.material as usize].bsdf(&self.textures, si.uv)
    }

    /// Radiance that the surface emits to the side it is seen from.
    #[inline]
    pub fn emission(&self, si: &SurfaceInteraction) -> Rgb {
        self.materials[si.material as usize].emission(si.front)
    }

    /// Density per steradian with which next-event estimation at the ray's origin would draw the ray.
    pub fn emitter_pdf(&self, hit: &Hit, si: &SurfaceInteraction, ray: &Ray) -> f32 {
        let light = self.lights.triangle_light(hit.geometry, hit.primitive);
        light.map_or(0.0, |light| self.lights.pdf_triangle(light, ray.org, si.p))
    }

    #[inline]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Corners of the box around all surfaces.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// Mesh k is geometry k of [`Self::geometry`].
    pub fn meshes(&self) -> &[Arc<Mesh>] {
        &self.meshes
    }

    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    /// The corners of all triangles in world space, counter-clockwise seen from outside, mesh by mesh.
    pub fn facets(&self) -> impl Iterator<Item = [Vec3; 3]> + Clone + '_ {
        let corners = |mesh: &Mesh, triangle: &[u32; 3]| triangle.map(|i| Vec3::from(mesh.positions[i as usize]));
        self.meshes.iter().flat_map(move |mesh| mesh.triangles.iter().map(move |triangle| corners(mesh, triangle)))
    }

    /// Tells scenes apart: a hash over geometry, materials, lights and camera, in hexadecimal.
    pub fn hash_text(&self) -> String {
        format!("{:016x}", self.hash)
    }

    /// As [`Self::hash_text`], camera and film left out: the same for all views of one scene.
    pub fn content_hash_text(&self) -> String {
        format!("{:016x}", self.content_hash)
    }

    /// Seconds that building the acceleration structure took.
    pub fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}
