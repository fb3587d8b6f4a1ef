//! The number that tells scenes apart: the same for the same content on every machine and in every release.
//!
//! What is hashed are canonical bytes, not a program's text or types. All numbers are little-endian, floats by their
//! bits; every list comes after its length, every choice after a number that it keeps for ever. Names of files,
//! materials and groups are left out: a material is what it says, a picture its texels, a group its place in the list.
//! A mesh is hashed as its file has it, with its transform beside it, so that no rounding of points has a part in the
//! hash. (A rotation by an angle is what the machine's sine makes of it.)
//!
//! The hash is XXH3 with 64 bits (<https://github.com/Cyan4973/xxHash>, a frozen format). It keeps nothing secret: who
//! wants two scenes with one hash can make them.

mod surface;
#[cfg(test)]
mod tests;

use super::description::{
    CameraDescription, FilmDescription, Filter, LightDescription, MaterialDescription, SceneDescription,
};
use crate::Result;
use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices};
use bytemuck::{NoUninit, cast_slice};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use std::path::Path;
use surface::Surface;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

/// Begins all that is hashed. Its version changes with what is hashed and how.
const SCENE: &[u8] = b"phototaxis scene 1\0";
const VIEW: &[u8] = b"phototaxis view 1\0";
const MESH: &[u8] = b"phototaxis mesh 1\0";
const TEXELS: &[u8] = b"phototaxis texels 1\0";

/// Bytes of an array that are hashed together; blocks are hashed by all threads. The hash depends on it.
const BLOCK: usize = 1 << 20;

// Arrays are hashed as they lie in memory.
const _: () = assert!(cfg!(target_endian = "little"));

/// Takes canonical bytes.
pub(super) struct Canon(Xxh3);

impl Canon {
    fn new(domain: &[u8]) -> Canon {
        let mut hasher = Xxh3::new();
        hasher.update(domain);
        Canon(hasher)
    }

    fn u32(&mut self, x: u32) {
        self.0.update(&x.to_le_bytes());
    }

    pub fn u64(&mut self, x: u64) {
        self.0.update(&x.to_le_bytes());
    }

    fn flag(&mut self, x: bool) {
        self.u32(u32::from(x));
    }

    fn floats<const N: usize>(&mut self, values: [f32; N]) {
        values.iter().for_each(|x| self.u32(x.to_bits()));
    }

    fn vector(&mut self, v: Vec3) {
        self.floats(v.to_array());
    }

    fn transform(&mut self, t: Affine3A) {
        self.floats(t.to_cols_array());
    }

    /// A long list of numbers: its length in bytes, then the hashes of its blocks.
    pub fn array<T: NoUninit>(&mut self, values: &[T]) {
        let bytes: &[u8] = cast_slice(values);
        self.u64(bytes.len() as u64);
        let blocks: Vec<u64> = bytes.par_chunks(BLOCK).map(xxh3_64).collect();
        blocks.into_iter().for_each(|block| self.u64(block));
    }

    fn finish(self) -> u64 {
        self.0.digest()
    }
}

/// Of a mesh as its file has it, its materials numbered as in the scene, and of where it is put.
pub(super) fn mesh(mesh: &Mesh, transform: Affine3A) -> u64 {
    let Mesh { positions, triangles, normals, uvs, materials } = mesh;
    let mut canon = Canon::new(MESH);
    canon.transform(transform);
    canon.array(positions);
    canon.array(triangles);
    canon.array(materials);
    attribute(&mut canon, normals.as_ref());
    attribute(&mut canon, uvs.as_ref());
    canon.finish()
}

fn attribute<T: NoUninit>(canon: &mut Canon, attribute: Option<&Attribute<T>>) {
    let Some(Attribute { values, indices }) = attribute else { return canon.u32(0) };
    match indices {
        Indices::OfPositions => canon.u32(1),
        Indices::Own(indices) => {
            canon.u32(2);
            canon.array(indices);
        }
    }
    canon.array(values);
}

/// Of a picture of `[width, height]` texels, `write` adding how they are stored and what they are.
pub(super) fn texels([width, height]: [usize; 2], write: impl FnOnce(&mut Canon)) -> u64 {
    let mut canon = Canon::new(TEXELS);
    canon.u64(width as u64);
    canon.u64(height as u64);
    write(&mut canon);
    canon.finish()
}

/// What of a scene is not in its description.
pub(super) struct Content<'a> {
    /// Of [`mesh`], by mesh of the description.
    pub meshes: &'a [u64],
    /// All that meshes have, by number.
    pub materials: &'a [MaterialDescription],
    /// Hash of a picture's texels.
    pub picture: &'a mut dyn FnMut(&Path) -> Result<u64>,
    /// Of the pictures of the surroundings, in the order of the description's lights.
    pub environments: &'a [u64],
}

/// Over what light does in the scene, whoever looks at it: geometry, materials and lights.
///
/// # Errors
/// Those of `picture`.
pub(super) fn content(description: &SceneDescription, content: Content) -> Result<u64> {
    let Content { meshes, materials, picture, environments } = content;
    let mut canon = Canon::new(SCENE);
    let mut groups: Vec<&str> = Vec::new();
    canon.u64(meshes.len() as u64);
    for (&mesh, said) in meshes.iter().zip(&description.meshes) {
        canon.u64(mesh);
        canon.u64(said.group.as_deref().map_or(0, |name| 1 + number(&mut groups, name)));
    }
    canon.u64(description.instances.len() as u64);
    for instance in &description.instances {
        canon.u64(1 + number(&mut groups, &instance.group));
        canon.transform(instance.transform);
    }
    canon.u64(materials.len() as u64);
    materials.iter().try_for_each(|m| Surface { canon: &mut canon, picture }.material(m))?;
    canon.u64(description.lights.len() as u64);
    let mut environments = environments.iter();
    description.lights.iter().for_each(|l| light(&mut canon, l, &mut environments));
    Ok(canon.finish())
}

/// Of `name` in the order in which names come.
fn number<'a>(names: &mut Vec<&'a str>, name: &'a str) -> u64 {
    let known = names.iter().position(|n| *n == name);
    known.unwrap_or_else(|| {
        names.push(name);
        names.len() - 1
    }) as u64
}

/// Over all that decides what the picture shows: the hash of the content, camera and film. Settings that only decide how
/// fast the picture is found are left out.
pub(super) fn view(camera: Option<&CameraDescription>, film: &FilmDescription, content: u64) -> u64 {
    let FilmDescription { width, height, filter, exposure: _ } = film;
    let mut canon = Canon::new(VIEW);
    canon.u64(content);
    canon.flag(camera.is_some());
    if let Some(CameraDescription { origin, target, up, vfov, mirrored }) = camera {
        [origin, target, up].into_iter().for_each(|v| canon.vector(*v));
        canon.floats([*vfov]);
        canon.flag(*mirrored);
    }
    canon.u32(*width);
    canon.u32(*height);
    canon.u32(match filter {
        Filter::Box => 0,
        Filter::Tent => 1,
        Filter::Gaussian => 2,
    });
    canon.finish()
}

fn light<'a>(canon: &mut Canon, light: &LightDescription, environments: &mut impl Iterator<Item = &'a u64>) {
    match light {
        LightDescription::Environment { path: _, scale, to_world } => {
            canon.u32(1);
            canon.u64(*environments.next().expect("each picture of the surroundings has been loaded"));
            canon.vector(*scale);
            canon.transform(*to_world);
        }
        LightDescription::Constant { radiance } => {
            canon.u32(2);
            canon.vector(*radiance);
        }
        LightDescription::Point { position, intensity } => {
            canon.u32(3);
            canon.vector(*position);
            canon.vector(*intensity);
        }
        LightDescription::Directional { direction, irradiance } => {
            canon.u32(4);
            canon.vector(*direction);
            canon.vector(*irradiance);
        }
    }
}
