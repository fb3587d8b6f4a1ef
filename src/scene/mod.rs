//! From files to an immutable scene.

pub(crate) mod adaptation;
mod animation;
mod assets;
mod blend;
mod build;
mod camera;
pub mod description;
mod emitters;
mod hash;
mod instances;
mod inventory;
mod light_groups;
mod load;
pub(crate) mod material;
pub(crate) mod model;
mod names;
pub mod obj;
mod origin;
pub mod ply;
mod repair;
mod serialized;
mod stand_ins;
mod triangulate;
mod view;

pub(crate) use assets::LoadedAssets;
pub use camera::Camera;
pub(crate) use inventory::{DescribedMaterial, Inventory, MaterialSource, MaterialUse};
pub(crate) use load::{LoadOptions, LoadStage};

use crate::bsdf::Bsdf;
use crate::embree;
use crate::geometry::{Hit, Mesh, SurfaceInteraction, Surfaces};
use crate::light::{LightSampleContext, LightSampler, LightUnit, Lights};
use crate::math::Rgb;
use crate::texture::{Relief, Tangents, Texture};
use glam::{DVec3, Vec3};
use instances::{Instances, NO_INSTANCE};
use light_groups::LightGroups;
use material::Material;
pub(crate) use names::SceneNames;
use std::sync::Arc;
pub(crate) use view::{FoundCamera, why_dark};

/// A scene, loaded and built. Nothing of it changes while it is rendered.
pub struct Scene {
    pub camera: Camera,
    /// Where nobody has said where it stands or whither it looks.
    found_camera: Option<FoundCamera>,
    geometry: embree::Scene,
    /// Those that are no part of a group.
    meshes: Vec<Arc<Mesh>>,
    instances: Instances,
    materials: Arc<Vec<Material>>,
    described_materials: Vec<DescribedMaterial>,
    textures: Arc<Vec<Texture>>,
    lights: Lights,
    /// What all emission here is a multiple of.
    light_unit: LightUnit,
    light_groups: LightGroups,
    names: SceneNames,
    bounds: (Vec3, Vec3),
    /// What all coordinates here are counted from.
    origin: DVec3,
    hash: u64,
    content_hash: u64,
    build_seconds: f64,
}

impl Scene {
    /// What answers ray queries. Mesh k of the scene is its geometry k; instances come after the meshes.
    #[inline]
    pub(crate) fn geometry(&self) -> &embree::Scene {
        &self.geometry
    }

    /// The surface point of a hit, seen from `wo` (unit, away from the surface).
    #[inline]
    pub(crate) fn interaction(&self, hit: &Hit, wo: Vec3) -> SurfaceInteraction {
        if hit.instance != NO_INSTANCE {
            return self.instances.interaction(hit, wo);
        }
        SurfaceInteraction::new(&self.meshes[hit.geometry as usize], hit, wo)
    }

    /// The same for lane `k` of a packet, which knows the rest, on the scene's own mesh `geometry`.
    #[inline(always)]
    pub(crate) fn meet<'a>(&'a self, k: usize, geometry: u32, primitive: u32, surfaces: &mut Surfaces<'a>) {
        surfaces.push(k, &self.meshes[geometry as usize], primitive);
    }

    /// The same on an instance.
    pub(crate) fn meet_instance(&self, k: usize, hit: Hit, surfaces: &mut Surfaces) {
        self.instances.meet(k, hit, surfaces);
    }

    /// Number of the object that a hit is on, among [`SceneNames::objects`].
    pub(crate) fn object(&self, hit: &Hit) -> u32 {
        self.names.object(hit)
    }

    pub(crate) fn light_groups(&self) -> &LightGroups {
        &self.light_groups
    }

    pub(crate) fn names(&self) -> &SceneNames {
        &self.names
    }

    #[inline]
    pub(crate) fn material(&self, index: u32) -> &Material {
        &self.materials[index as usize]
    }

    /// What a surface is at a vertex: its material, or one of those that this is mixed of, by the chance `u` in [0, 1). Whatever happens
    /// at the vertex must go by one such choice.
    #[inline]
    pub(crate) fn choose_material(&self, material: u32, uv: [f32; 2], u: impl FnOnce() -> f32) -> &Material {
        self.material(material).choose(&self.textures, uv, u)
    }

    /// Calls `each` with what a surface of the material may be, and how probable that is.
    #[inline]
    pub(crate) fn each_choice<'a>(
        &self,
        material: &'a Material,
        uv: [f32; 2],
        each: &mut dyn FnMut(&'a Material, f32),
    ) {
        material.each_choice(&self.textures, uv, 1.0, each);
    }

    /// Whether any material reads pictures.
    #[inline(always)]
    pub(crate) fn has_textures(&self) -> bool {
        !self.textures.is_empty()
    }

    /// Asks for what [`Self::bsdf`] will read of pictures.
    #[inline(always)]
    pub(crate) fn prefetch(&self, material: u32, uv: [f32; 2]) {
        self.material(material).prefetch(&self.textures, uv);
    }

    /// How a surface of that material scatters, textures looked up; `vertex_color` finds the colour of its mesh's vertices.
    /// Pictures that turn its normals are for [`Self::in_relief`].
    #[inline]
    pub(crate) fn bsdf<'a>(&self, material: &'a Material, uv: [f32; 2], vertex_color: impl Fn() -> Rgb) -> Bsdf<'a> {
        material.bsdf(&self.textures, uv, vertex_color)
    }

    /// The colour of the mesh's vertices at a hit; white where it has none.
    pub(crate) fn vertex_color(&self, hit: &Hit) -> Rgb {
        self.mesh(hit).color(hit.primitive as usize, hit.u, hit.v)
    }

    #[inline(always)]
    fn mesh(&self, hit: &Hit) -> &Mesh {
        if hit.instance != NO_INSTANCE { self.instances.mesh(*hit) } else { &self.meshes[hit.geometry as usize] }
    }

    /// The BSDF of that material about the normal that its relief has where `hit` met the surface `si`.
    #[inline(never)]
    pub(crate) fn in_relief<'a>(
        &self,
        bsdf: Bsdf<'a>,
        relief: &Relief,
        hit: Option<Hit>,
        si: &SurfaceInteraction,
    ) -> Bsdf<'a> {
        let Some(tangents) = hit.and_then(|hit| self.tangents(&hit)) else { return bsdf };
        bsdf.with_normal(relief.normal(&self.textures, si.uv, &si.frame, tangents))
    }

    /// `None` where texture coordinates have no area, or where there are none.
    fn tangents(&self, hit: &Hit) -> Option<Tangents> {
        let triangle = hit.primitive as usize;
        let (mesh, corners) = if hit.instance == NO_INSTANCE {
            let mesh = &*self.meshes[hit.geometry as usize];
            (mesh, mesh.corners(triangle))
        } else {
            self.instances.corners(hit)
        };
        mesh.uvs.as_ref()?.corners(&mesh.triangles, triangle).and_then(|uvs| Tangents::of(corners, uvs))
    }

    /// The unit of all light in this scene: of its lights, and of what is traced in it.
    #[inline]
    pub(crate) fn light_unit(&self) -> LightUnit {
        self.light_unit
    }

    /// Radiance that the surface emits to the side it is seen from, in [`Self::light_unit`].
    #[inline]
    pub(crate) fn emission(&self, si: &SurfaceInteraction) -> Rgb {
        self.materials[si.material as usize].emission(si.front, &self.textures, si.uv)
    }

    /// Whether the surface of a hit emits to any side.
    #[inline(always)]
    pub(crate) fn emits(&self, hit: Hit) -> bool {
        self.materials[self.mesh(&hit).materials[hit.primitive as usize] as usize].emits()
    }

    /// Density per steradian with which next-event estimation at `ctx` would draw the way to the surface `si` of a hit.
    pub(crate) fn emitter_pdf(
        &self,
        by: LightSampler,
        ctx: &LightSampleContext,
        hit: &Hit,
        si: &SurfaceInteraction,
    ) -> f32 {
        let instanced = hit.instance != NO_INSTANCE;
        let surface = if instanced { self.instances.surface(hit) } else { hit.geometry };
        let Some(light) = self.lights.triangle_light(surface, hit.primitive) else { return 0.0 };
        // corners of mirrored triangles that emit come in another order
        let mirrored = instanced && self.instances.mirrored(hit);
        let weights = if mirrored { [hit.v, hit.u] } else { [hit.u, hit.v] };
        self.lights.pdf_triangle(by, ctx, light, si.p, weights)
    }

    #[inline]
    pub(crate) fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The camera, where it was found by what can be seen.
    pub(crate) fn found_camera(&self) -> Option<&FoundCamera> {
        self.found_camera.as_ref()
    }

    /// Corners of the box around all surfaces.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// Where 0 of all coordinates here is in those of the scene's files: 0, unless the scene is far from that for its size.
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The meshes that stand by themselves; mesh k is geometry k of [`Self::geometry`].
    pub(crate) fn meshes(&self) -> &[Arc<Mesh>] {
        &self.meshes
    }

    /// Triangles that are seen: those of a group count in each of its places.
    pub fn triangles(&self) -> usize {
        let own = self.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>();
        own + self.instances.surfaces().map(|(_, mesh, _)| mesh.triangles.len()).sum::<usize>()
    }

    /// The corners of all triangles in world space, counter-clockwise seen from outside, mesh by mesh and then instance
    /// by instance.
    pub(crate) fn facets(&self) -> impl Iterator<Item = [Vec3; 3]> + Clone + '_ {
        let own = self.meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(|t| mesh.corners(t)));
        let placed = self.instances.surfaces();
        let placed = placed.flat_map(|(_, mesh, place)| (0..mesh.triangles.len()).map(|t| place.facet(mesh, t)));
        own.chain(placed)
    }

    /// Tells scenes apart: a hash over geometry, materials, pictures, lights, camera and film, in hexadecimal. The same
    /// on every machine and in every release.
    pub(crate) fn hash_text(&self) -> String {
        format!("{:016x}", self.hash)
    }

    /// As [`Self::hash_text`], camera and film left out: the same for all views of one scene.
    pub fn content_hash_text(&self) -> String {
        format!("{:016x}", self.content_hash)
    }

    /// Seconds that building the acceleration structure took.
    pub(crate) fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}
