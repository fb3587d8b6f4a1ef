//! A room with stairs under a hidden lamp, and what stands or lies in it.

use super::{View, head, lamp, mesh, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, Cuboid, cuboid};
use crate::lab::generate::obj_writer::{Material, Model, number, toml_vector};
use crate::lab::generate::shape::Shape;
use crate::lab::generate::shapes::displaced_sphere;
use glam::{DAffine3, DVec3};

const VIEW: View =
    View { eye: DVec3::new(-0.3, 1.5, 1.9), target: DVec3::new(0.25, 0.95, -0.6), vfov: 62.0, exposure: 0.0 };

/// Scale and place of `far-away`: neighbouring numbers of 32 bits are 1/16 apart there, 1/16 000 of the room.
const FAR_SCALE: f64 = 256.0;
const FAR: DVec3 = DVec3::new(1_000_000.0, 1_000_000.0, -1_000_000.0);

pub(crate) fn corners() -> SceneFiles {
    let about = "Stairs, a shelf and pillars: cells of any guide hold several surfaces that face elsewhere.\n\
                 The lamp lies on the shelf and shines at the ceiling: what is seen has no direct light.";
    let model = Model {
        about: "a room with stairs and pillars, its lamp on a shelf, facing up",
        objects: vec![("room", room(true))],
        materials: materials(),
    };
    with_mesh("corners", about, &VIEW, model)
}

pub(crate) fn bumps() -> SceneFiles {
    let about = "A bumpy ball with shading normals in a room without direct light.";
    let bumpy = |d: DVec3| 0.62 * (1.0 + 0.14 * (9.0 * d.x).sin() * (9.0 * d.y).sin() * (9.0 * d.z).cos());
    let ball = displaced_sphere(6, "ball", bumpy).transformed(&DAffine3::from_translation(DVec3::new(0.3, 0.8, -0.5)));
    let model = Model {
        about: "a bumpy ball in a room whose lamp faces up",
        objects: vec![("room", room(false)), ("ball", ball)],
        materials: [materials(), vec![Material::diffuse("ball", [0.7, 0.45, 0.25])]].concat(),
    };
    with_mesh("bumps", about, &VIEW, model)
}

pub(crate) fn far_away() -> SceneFiles {
    let about = "The room `corners`, a kilometre wide and a thousand kilometres from the origin.";
    let moved = |p: DVec3| p * FAR_SCALE + FAR;
    let view = View { eye: moved(VIEW.eye), target: moved(VIEW.target), ..VIEW };
    let place = format!("scale = {}\ntranslate = {}\n", number(FAR_SCALE), toml_vector(FAR));
    SceneFiles { toml: head(about, &view) + &mesh("corners") + &place, model: Model::default() }
}

fn shelf() -> Cuboid {
    cuboid([-2.0, 1.85, -2.0], [-1.45, 1.95, 2.0])
}

fn room(stairs: bool) -> Shape {
    let mut room =
        Blocks::in_rock().carve(cuboid([-2.0, 0.0, -2.0], [2.0, 2.4, 2.0])).fill(shelf()).cut(2, [-1.6, -0.4]);
    for step in 0..if stairs { 5 } else { 0 } {
        let (x, top) = (0.2 + 0.3 * f64::from(step), 0.24 * f64::from(step + 1));
        room = room.fill(cuboid([x, 0.0, -2.0], [2.0, top, -0.3]));
    }
    if stairs {
        room = room.fill(cuboid([-0.9, 0.0, -1.5], [-0.75, 2.4, -1.35]));
        room = room.fill(cuboid([-0.45, 0.0, -1.1], [-0.3, 2.4, -0.95]));
    }
    room.surface(material)
}

fn material(centre: DVec3, normal: DVec3) -> &'static str {
    let lit = centre.z > -1.6 && centre.z < -0.4;
    match normal.y {
        y if y > 0.5 && shelf().contains(centre) && lit => "lamp",
        y if y > 0.5 => "floor",
        _ if centre.x == 2.0 => "green",
        _ => "plaster",
    }
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("plaster", [0.75, 0.74, 0.7]),
        Material::diffuse("floor", [0.6, 0.48, 0.36]),
        Material::diffuse("green", [0.3, 0.55, 0.35]),
        lamp("lamp", [40.0, 36.0, 30.0]),
    ]
}
