//! A box with a ball, whose material the rows of the gallery change.

use super::{View, lamp, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, cuboid};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shapes::displaced_sphere;
use glam::{DAffine3, DVec3};

pub(crate) const BOX_TOP: f64 = 2.0;

pub(crate) const VIEW: View =
    View { eye: DVec3::new(0.0, 1.1, 0.96), target: DVec3::new(0.0, 0.8, -1.0), vfov: 80.0, exposure: 0.0 };

pub(crate) fn shiny() -> SceneFiles {
    let about = "A ball in a closed box under a lamp. The gallery makes it of mirror, metal and glass.";
    let light = cuboid([-0.2, BOX_TOP, -0.5], [0.2, BOX_TOP, -0.1]);
    let room = Blocks::in_rock()
        .carve(cuboid([-1.0, 0.0, -1.0], [1.0, BOX_TOP, 1.0]))
        .cut(0, [light.min.x, light.max.x])
        .cut(2, [light.min.z, light.max.z])
        .surface(move |centre, normal| match normal {
            _ if light.contains(centre) => "lamp",
            n if n.x > 0.5 => "red",
            n if n.x < -0.5 => "green",
            _ => "white",
        });
    let ball = displaced_sphere(6, "ball", |_| 0.45);
    let ball = ball.transformed(&DAffine3::from_translation(DVec3::new(0.1, 0.6, -0.35)));
    let model = Model {
        about: "a ball in a box with a lamp in its ceiling",
        objects: vec![("box", room), ("ball", ball)],
        materials: vec![
            Material::diffuse("white", [0.73, 0.73, 0.73]),
            Material::diffuse("red", [0.63, 0.06, 0.05]),
            Material::diffuse("green", [0.14, 0.45, 0.09]),
            Material::diffuse("ball", [0.7, 0.7, 0.7]),
            lamp("lamp", [26.0, 24.0, 20.0]),
        ],
    };
    with_mesh("shiny", about, &VIEW, model)
}
