//! Scenes in which a guide has nothing to find.

use super::{View, head, lamp, mesh, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, cuboid};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shape::Shape;
use glam::DVec3;

pub(crate) fn direct() -> SceneFiles {
    let about = "A floor, a black block and a lamp, nothing about them: all light is direct. A guide can only cost.";
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let floor = [p(-2.0, 0.0, -2.0), p(-2.0, 0.0, 2.0), p(2.0, 0.0, 2.0), p(2.0, 0.0, -2.0)];
    let lamp_quad = [p(-0.5, 2.0, -1.2), p(0.5, 2.0, -1.2), p(0.5, 2.0, -0.4), p(-0.5, 2.0, -0.4)];
    let block = Blocks::in_air().fill(cuboid([-0.35, 0.001, -0.5], [0.35, 0.8, 0.1])).surface(|_, _| "black");
    let model = Model {
        about: "a floor and a black block under a lamp",
        objects: vec![
            ("floor", Shape::quads(&[floor], "floor")),
            ("lamp", Shape::quads(&[lamp_quad], "lamp")),
            ("block", block),
        ],
        materials: vec![
            Material::diffuse("floor", [0.6, 0.58, 0.55]),
            Material::diffuse("black", [0.0; 3]),
            lamp("lamp", [12.0, 11.0, 10.0]),
        ],
    };
    let view = View { eye: DVec3::new(1.2, 1.6, 2.6), target: DVec3::new(0.0, 0.35, -0.3), vfov: 50.0, exposure: 0.0 };
    with_mesh("direct", about, &view, model)
}

pub(crate) fn triangle() -> SceneFiles {
    let about = "One triangle under an even sky: it reflects half of what the sky sends.";
    let corners = vec![DVec3::new(-1.0, -0.8, 0.0), DVec3::new(1.1, -0.6, 0.3), DVec3::new(0.1, 1.0, -0.2)];
    let model = Model {
        about: "one triangle",
        objects: vec![("triangle", Shape::new(corners, vec![[0, 1, 2]], "grey"))],
        materials: vec![Material::diffuse("grey", [0.5; 3])],
    };
    let view = View { eye: DVec3::new(0.0, 0.2, 3.0), target: DVec3::ZERO, vfov: 45.0, exposure: 0.0 };
    let sky = "\n[[light]]\ntype = \"constant\"\nradiance = [0.8, 0.9, 1.0]\n";
    SceneFiles { toml: head(about, &view) + &mesh("triangle") + sky, model }
}
