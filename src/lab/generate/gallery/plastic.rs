//! The rooms of `door`, painted and varnished as modelling programs export it: plastics, not Lambert's law.

use super::{View, with_mesh};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::{SceneFiles, door};

/// What Blender writes of a material with its default roughness of one half: a coat of alpha 0.25 over a diffuse base.
const VARNISH: &[&str] = &["Ks 0.5 0.5 0.5", "Ns 250", "Ni 1.5", "illum 2"];

/// All but lamps.
fn varnished(material: Material) -> Material {
    if material.emission == [0.0; 3] { Material { more: VARNISH, ..material } } else { material }
}

pub(crate) fn plastic_door() -> SceneFiles {
    let about = "The rooms and furniture of the scene `door`, all of plastic: a coat of alpha 0.25 over a diffuse base. A guide\n\
                 can help with the base alone, by which nearly all light is reflected.";
    let objects = door::rooms();
    let used = |material: &Material| {
        objects.iter().flat_map(|(_, shape)| &shape.triangles).any(|triangle| triangle.material == material.name)
    };
    let materials = door::materials().into_iter().filter(used).map(varnished).collect();
    let [eye, target] = [door::EYE, door::TARGET].map(|p| door::to_world().transform_point3(p));
    let view = View { eye, target, vfov: 40.0, exposure: 0.0 };
    let model = Model { about: "two rooms of plastic, a lamp in the far one, a door ajar", objects, materials };
    with_mesh("plastic-door", about, &view, model)
}
