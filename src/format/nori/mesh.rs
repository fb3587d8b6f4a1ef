//! Meshes, where they stand, and what they are made of.

use super::material;
use crate::Result;
use crate::format::mitsuba::bsdf::Materials;
use crate::format::xml::object::Object;
use crate::format::{SceneFile, tessellate, xml};
use crate::math::Rgb;
use crate::scene::adaptation::Adaptation;
use crate::scene::description::{MaterialDescription, MeshDescription};
use crate::scene::model::MeshSource;
use glam::{DAffine3, DMat3, DVec3};
use std::rc::Rc;

pub(super) fn read(mesh: &Rc<Object>, materials: &Materials, file: &mut SceneFile) -> Result<()> {
    let objects = materials.objects;
    let to_world = mesh.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    xml::transform::check_regular(mesh, &to_world)?;
    let (source, own) = source(mesh, &to_world)?;
    let material = self::material(mesh, materials)?;
    let name = name(mesh, &material, file);
    file.scene.materials.insert(name.clone(), material);
    if let Some(medium) = objects.child(mesh, "medium")? {
        objects.warn(&medium.at, "nothing scatters light between surfaces here");
    }
    objects.finish(mesh);
    file.scene.meshes.push(MeshDescription {
        source,
        transform: to_world * own,
        material: Some(name),
        material_location: Some(mesh.at.clone()),
        group: None,
        location: Some(mesh.at.clone()),
    });
    Ok(())
}

/// The mesh, and where it stands in its own space.
fn source(mesh: &Object, to_world: &DAffine3) -> Result<(MeshSource, DAffine3)> {
    match mesh.kind.as_str() {
        "obj" => {
            let path = mesh.file()?.to_path_buf();
            // faces without normals look where their corners, already placed, say
            let flip_bare = to_world.matrix3.determinant() < 0.0;
            let adaptation = Adaptation { by_normals: true, flip_bare, ..Adaptation::default() };
            Ok((MeshSource::Adapted(path, adaptation), DAffine3::IDENTITY))
        }
        "sphere" => {
            let centre = mesh.vector("center")?.unwrap_or(DVec3::ZERO);
            let linear = DMat3::from_diagonal(DVec3::splat(mesh.number("radius", 1.0)?));
            let own = DAffine3 { matrix3: linear, translation: centre };
            xml::transform::check_regular(mesh, &own)?;
            Ok((MeshSource::Memory(tessellate::sphere()), own))
        }
        kind => Err(mesh.error(format!("the mesh `{kind}` has no counterpart"))),
    }
}

/// A mesh of which nothing is said is diffuse, and so are lamps.
fn material(mesh: &Object, materials: &Materials) -> Result<MaterialDescription> {
    let objects = materials.objects;
    let mut material = match objects.child(mesh, "bsdf")? {
        Some(bsdf) => material::material(materials, &bsdf)?,
        None => Materials::default_material(false),
    };
    if let Some(emitter) = objects.child(mesh, "emitter")? {
        if emitter.kind != "area" {
            return Err(emitter.error(format!("a mesh cannot be the emitter `{}`", emitter.kind)));
        }
        (material.emission, material.emission_map) = materials.textures.radiance(&emitter, "radiance")?;
        if material.emission == Rgb::ZERO {
            material.emission_map = None;
        }
        objects.finish(&emitter);
    }
    Ok(material)
}

/// What no other material of the scene is called: nori's have no names.
fn name(mesh: &Object, material: &MaterialDescription, file: &SceneFile) -> String {
    let name = format!("mesh in line {}", mesh.at.line);
    let known = &file.scene.materials;
    let usable = |name: &String| known.get(name).is_none_or(|known| known == material);
    (1..).map(|k| if k == 1 { name.clone() } else { format!("{name} ({k})") }).find(usable).unwrap_or_default()
}
