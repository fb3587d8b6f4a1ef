//! `cornell`: a box after the one measured at Cornell University, with round numbers.

use super::SceneFiles;
use super::blocks::{Blocks, cuboid};
use super::obj_writer::{Material, Model};
use super::shape::Shape;
use glam::{DAffine3, DVec3};

const TOML: &str = r#"# A Cornell box, open towards the camera: a large light, short paths, half of all light direct.
# Here a guide can gain little; it shows what guiding costs where it is not needed.
[camera]
origin = [0, 0.275, 1.08]
target = [0, 0.275, 0]
up = [0, 1, 0]
vfov = 39.0

[film]
width = 256
height = 256
filter = "box"
exposure = 0.0

[[mesh]]
path = "cornell.obj"

[integrator]
max_depth = 16
next_event = true
mis = true
rr_depth = 5

[guiding]
method = "grid"

[render]
spp = 64
seed = 0
"#;

/// Half of the room's width and depth, and its height, in metres.
const HALF: f64 = 0.275;
const TOP: f64 = 0.55;
/// Half of the light's width and depth.
const LIGHT: [f64; 2] = [0.065, 0.0525];

pub(crate) fn scene() -> SceneFiles {
    let model = Model {
        about: "an open box with two blocks and a light in its ceiling",
        objects: vec![
            ("room", room()),
            ("tall_block", block([0.165, 0.33, 0.165], [-0.09, -0.08], 17.0)),
            ("short_block", block([0.165, 0.165, 0.165], [0.09, 0.105], -17.0)),
        ],
        materials: vec![
            Material::diffuse("white", [0.73, 0.73, 0.73]),
            Material::diffuse("red", [0.63, 0.06, 0.05]),
            Material::diffuse("green", [0.14, 0.45, 0.09]),
            Material { emission: [32.0, 25.0, 16.0], ..Material::diffuse("light", [0.0; 3]) },
        ],
    };
    SceneFiles { toml: TOML.to_owned(), model }
}

/// Floor, back, sides, a light, and the ceiling as four trapezia about it: no edge ends in the middle of another.
fn room() -> Shape {
    let (near, far) = (HALF, -HALF);
    let p = DVec3::new;
    let floor = [p(far, 0., far), p(far, 0., near), p(near, 0., near), p(near, 0., far)];
    let ceiling = floor.map(|corner| corner + DVec3::Y * TOP);
    let light =
        [(-1., -1.), (-1., 1.), (1., 1.), (1., -1.)].map(|(x, z): (f64, f64)| p(x * LIGHT[0], TOP, z * LIGHT[1]));
    let wall = |i: usize, j: usize| [floor[i], floor[j], ceiling[j], ceiling[i]];
    let trapezia = [0, 1, 2, 3].map(|i| {
        let j = (i + 1) % 4;
        [ceiling[j], ceiling[i], light[i], light[j]]
    });
    let [a, b, c, d] = light;
    Shape::quads(&[floor, wall(0, 3)], "white")
        .with(Shape::quads(&trapezia, "white"))
        .with(Shape::quads(&[wall(1, 0)], "red"))
        .with(Shape::quads(&[wall(3, 2)], "green"))
        .with(Shape::quads(&[[d, c, b, a]], "light"))
}

/// A block without its base, which lies on the floor; `degrees` turn it about the y axis.
fn block(size: [f64; 3], at: [f64; 2], degrees: f64) -> Shape {
    let [x, y, z] = size;
    let mut block = Blocks::in_air()
        .fill(cuboid([-x / 2.0, 0.0, -z / 2.0], [x / 2.0, y, z / 2.0]))
        .surface(|_, normal| if normal.y < 0.0 { "base" } else { "white" });
    block.triangles.retain(|triangle| triangle.material != "base");
    let turned = DAffine3::from_rotation_y(degrees.to_radians());
    let moved = DAffine3::from_translation(DVec3::new(at[0], 0.0, at[1]));
    block.transformed(&(moved * turned))
}
