//! Light on one side and shade on the other.

use super::{View, lamp, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, Cuboid, cuboid};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shape::Shape;
use glam::{DAffine3, DVec3};

/// Degrees that the door is turned about y and then leans.
const TURN: f64 = 29.0;
const LEAN: f64 = 7.0;

/// The paper's figure 3: a sheet without thickness, so that its sides cannot help being in the same cells.
pub(crate) fn turned_door() -> SceneFiles {
    let about = "A door without thickness, along no axis: its far side is lit by the lamp, the near one by what comes\n\
                 round it. A guide that tells its two sides not apart gives one of them the other's light.";
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.15, -0.6))
        * DAffine3::from_rotation_y(TURN.to_radians())
        * DAffine3::from_rotation_x(LEAN.to_radians());
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let door = Shape::quads(&[[p(-0.95, 0.0), p(0.95, 0.0), p(0.95, 1.9), p(-0.95, 1.9)]], "door");
    let lamp_box = cuboid([-0.6, 0.6, -2.0], [0.5, 1.6, -2.0]);
    let model = Model {
        about: "a room with a thin door before a lamp",
        objects: vec![("room", room(lamp_box)), ("door", door.transformed(&place))],
        materials: [materials(), vec![Material::diffuse("door", [0.7, 0.7, 0.72])]].concat(),
    };
    let view =
        View { eye: DVec3::new(0.25, 1.35, 1.9), target: DVec3::new(0.0, 1.05, -0.6), vfov: 58.0, exposure: -1.0 };
    with_mesh("turned-door", about, &view, model)
}

fn room(lamp: Cuboid) -> Shape {
    Blocks::in_rock()
        .carve(cuboid([-2.0, 0.0, -2.0], [2.0, 2.4, 2.0]))
        .cut(0, [lamp.min.x, lamp.max.x])
        .cut(1, [lamp.min.y, lamp.max.y])
        .surface(move |centre, normal| match normal {
            _ if lamp.contains(centre) => "lamp",
            n if n.y > 0.5 => "floor",
            _ => "plaster",
        })
}

/// A wall divides the picture: a lamp over its left half, and on the right what comes round.
pub(crate) fn two_rooms() -> SceneFiles {
    let about =
        "A bright room beside a dark one: on the left light is direct, on the right it has come round the wall.";
    let lamp = cuboid([-1.4, 2.4, -1.2], [-0.7, 2.4, -0.5]);
    let room = Blocks::in_rock()
        .carve(cuboid([-2.0, 0.0, -2.0], [2.0, 2.4, 2.4]))
        .fill(cuboid([-0.06, 0.0, -2.0], [0.06, 2.4, 0.7]))
        .cut(0, [lamp.min.x, lamp.max.x])
        .cut(2, [lamp.min.z, lamp.max.z])
        .surface(move |centre, normal| match normal {
            _ if lamp.contains(centre) => "lamp",
            n if n.y > 0.5 => "floor",
            _ => "plaster",
        });
    let model = Model {
        about: "a room cut in two by a wall, a lamp in the left half",
        objects: vec![("room", room)],
        materials: materials(),
    };
    let view = View { eye: DVec3::new(0.0, 1.5, 2.3), target: DVec3::new(0.05, 1.05, -0.5), vfov: 62.0, exposure: 0.0 };
    with_mesh("two-rooms", about, &view, model)
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("plaster", [0.72, 0.7, 0.66]),
        Material::diffuse("floor", [0.5, 0.42, 0.34]),
        lamp("lamp", [18.0, 17.0, 15.0]),
    ]
}
