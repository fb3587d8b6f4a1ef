//! `wall`: one closed room, a wall that nearly cuts it in two, a light in one half.

use super::SceneFiles;
use super::blocks::{Blocks, Cuboid, cuboid};
use super::head::head;
use super::obj_writer::{Material, Model};
use super::shape::Shape;
use super::shapes::cone;
use glam::{DAffine3, DVec3};

const TOML: &str = r#"# After the WALL scene of Tan, "Path Tracing with Reinforcement Learning": one closed room, cut in two by a wall
# that leaves a passage on the camera's side. The lamp hangs in the left half. What stands in the right half is
# lit only by what comes round the wall; on the left, direct light rules and a guide should not do harm.
[camera]
origin = [0.1, 2.15, 2.5]
target = [0.2, 0.85, 0]
up = [0, 1, 0]
vfov = 60.0

[film]
width = 512
height = 384
filter = "box"
exposure = 0.3

[[mesh]]
path = "wall.obj"

[integrator]
max_depth = 16
next_event = true
mis = true
rr_depth = 5

[render]
spp = 64
seed = 0
"#;

/// Half of the room's width and depth, and its height, in metres.
const HALF: f64 = 2.6;
const TOP: f64 = 2.7;
/// The wall's thickness, and where it ends; from there to the room's front (z = HALF) one can pass.
const THICKNESS: f64 = 0.12;
const WALL_END: f64 = 0.8;

pub(crate) fn scene() -> SceneFiles {
    let place = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    let face_camera = DAffine3::from_rotation_y((-14f64).to_radians())
        * DAffine3::from_rotation_x((-22f64).to_radians())
        * DAffine3::from_scale(DVec3::splat(0.5));
    let model = Model {
        about: "a room cut in two by a wall, a cone and a head in its dark half",
        objects: vec![
            ("room", room()),
            ("cone", cone(0.5, 1.5, 64, "white_cone").transformed(&place(1.75, 0.001, -0.9))),
            ("head", head(24, "red").transformed(&(place(0.95, 0.48, 0.25) * face_camera))),
        ],
        materials: materials(),
    };
    SceneFiles { toml: TOML.to_owned(), model }
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("plaster", [0.8, 0.79, 0.76]),
        Material::diffuse("floor", [0.58, 0.49, 0.39]),
        Material::diffuse("white_cone", [0.8, 0.8, 0.8]),
        Material::diffuse("red", [0.7, 0.1, 0.07]),
        Material { emission: [28.0, 26.0, 22.5], ..Material::diffuse("lamp", [0.0; 3]) },
    ]
}

fn lamp() -> Cuboid {
    cuboid([-1.8, TOP, -1.8], [-1.0, TOP, -1.0])
}

fn room() -> Shape {
    let lamp = lamp();
    let wall = cuboid([-THICKNESS / 2.0, 0.0, -HALF], [THICKNESS / 2.0, TOP, WALL_END]);
    Blocks::in_rock()
        .carve(cuboid([-HALF, 0.0, -HALF], [HALF, TOP, HALF]))
        .fill(wall)
        .cut(0, [lamp.min.x, lamp.max.x])
        .cut(2, [lamp.min.z, lamp.max.z])
        .surface(|centre, normal| match normal.y {
            _ if lamp.contains(centre) => "lamp",
            y if y > 0.0 => "floor",
            _ => "plaster",
        })
}
