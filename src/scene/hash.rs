//! The number that tells scenes apart: the same for the same content on every machine and in every release.
//!
//! What is hashed are canonical bytes, not a program's text or types. All numbers are little-endian, floats by their
//! bits; every list comes after its length, every choice after a number that it keeps for ever. Names of files,
//! materials and groups are left out: a material is what it says, a picture its texels, a group its place in the list.
//! A mesh is hashed as its file has it, with its transform beside it, so that no rounding of points has a part in the
//! hash. (A rotation by an angle is what the machine's sine makes of it.)

use super::description::{CameraDescription, MaterialDescription, Projection, SceneDescription, Unsaid};
use crate::Result;
use crate::fields::Fields;
use crate::film::{FilmSettings, Filter};
use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices, MeshColors};
use crate::io::canon::Canon;
mod fields;

use bytemuck::NoUninit;
use fields::CanonicalFields;
use glam::{Affine3A, DVec3, Vec3};
use std::path::Path;

/// Begins all that is hashed. Its version changes with what is hashed and how.
const SCENE: &[u8] = b"phototaxis scene 1\0";
const VIEW: &[u8] = b"phototaxis view 1\0";
const MESH: &[u8] = b"phototaxis mesh 1\0";

/// Of a mesh as its file has it, its materials numbered as in the scene, and of where it is put.
pub(super) fn mesh(mesh: &Mesh, transform: Affine3A) -> u64 {
    let Mesh { positions, triangles, normals, uvs, colors, materials } = mesh;
    let mut canon = Canon::new(MESH);
    canon.transform(transform);
    canon.array(positions);
    canon.array(triangles);
    canon.array(materials);
    attribute(&mut canon, normals.as_ref());
    attribute(&mut canon, uvs.as_ref());
    // nothing where there are none, as before there were any
    match colors {
        None => (),
        Some(MeshColors::OfVertices(colors)) => canon.array(colors),
        Some(MeshColors::OfFaces(colors)) => {
            canon.u32(1);
            canon.array(colors);
        }
    }
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

/// What of a scene is not in its description.
pub(super) struct Content<'a> {
    /// Of [`mesh`], by mesh of the description.
    pub(crate) meshes: &'a [u64],
    /// All that meshes have, by number.
    pub(crate) materials: &'a [MaterialDescription],
    /// Hash of a picture's texels.
    pub(crate) picture: &'a mut dyn FnMut(&Path) -> Result<u64>,
    /// Of the pictures of the surroundings, in the order of the description's lights.
    pub(crate) environments: &'a [u64],
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
        canon.transform(instance.transform.as_affine3a());
    }
    canon.u64(materials.len() as u64);
    materials.iter().try_for_each(|m| CanonicalFields { canon: &mut canon, picture }.material(m))?;
    canon.u64(description.lights.len() as u64);
    let mut environments = environments.iter();
    for light in &description.lights {
        canon.u32(light.number());
        let picture = &mut |_: &Path| Ok(*environments.next().expect("each picture of a light has been loaded"));
        light.clone().fields(&mut CanonicalFields { canon: &mut canon, picture })?;
    }
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
pub(super) fn view(camera: Option<&CameraDescription>, film: &FilmSettings, content: u64) -> u64 {
    let FilmSettings { width, height, filter, crop, exposure: _, tone: _ } = film;
    let mut canon = Canon::new(VIEW);
    canon.u64(content);
    let whole = camera.filter(|camera| !camera.unsaid.is_open());
    canon.flag(whole.is_some());
    match whole {
        Some(camera) => add_camera(camera, &mut canon),
        None => camera.iter().for_each(|camera| add_open_camera(camera, &mut canon)),
    }
    canon.u32(*width);
    canon.u32(*height);
    crop.iter().flatten().for_each(|side| canon.u32(*side));
    canon.u32(match filter {
        Filter::Box => 0,
        Filter::Tent => 1,
        Filter::Gaussian => 2,
    });
    canon.finish()
}

/// Pinholes add what they always did, so that their scenes keep their hashes.
fn add_camera(camera: &CameraDescription, canon: &mut Canon) {
    let CameraDescription { origin, target, up, vfov, mirrored, .. } = camera;
    [origin.as_vec3(), target.as_vec3(), *up].into_iter().for_each(|v| canon.vector(v));
    canon.floats([*vfov]);
    canon.flag(*mirrored);
    add_projection(camera, canon);
}

fn add_projection(camera: &CameraDescription, canon: &mut Canon) {
    let CameraDescription { projection, view_height, aperture_radius, focus_distance, .. } = camera;
    match projection {
        Projection::Perspective => {}
        Projection::Orthographic => {
            canon.u32(1);
            canon.floats([*view_height]);
        }
        Projection::Panorama => canon.u32(2),
    }
    if *aperture_radius > 0.0 {
        canon.u32(3);
        canon.floats([*aperture_radius, focus_distance.unwrap_or(0.0)]);
    }
}

/// One that has to be found.
fn add_open_camera(camera: &CameraDescription, canon: &mut Canon) {
    let Unsaid { origin, target, up, vfov, view_height } = camera.unsaid;
    [origin, target, up, vfov, view_height].into_iter().for_each(|unsaid| canon.flag(!unsaid));
    let said = CameraDescription {
        origin: if origin { DVec3::ZERO } else { camera.origin },
        target: if target { DVec3::ZERO } else { camera.target },
        up: if up { Vec3::ZERO } else { camera.up },
        vfov: if vfov { 0.0 } else { camera.vfov },
        view_height: if view_height { 0.0 } else { camera.view_height },
        ..camera.clone()
    };
    add_camera(&said, canon);
}

#[cfg(test)]
mod tests;
