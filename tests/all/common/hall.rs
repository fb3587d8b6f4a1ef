//! A hall that is the same upside down, for large pictures: three lit niches, of which a camera in the middle sees only the
//! light that bounces out of them.

use super::{Loaded, load_written};

/// `up` is 1, or −1 for the picture turned upside down.
pub fn hall(up: i32, overrides: &[&str]) -> Loaded {
    let scene = SCENE.replace("UP", &up.to_string());
    load_written(&[("scene.toml", &scene), ("hall.obj", HALL)], overrides)
}

const SCENE: &str = r#"
[camera]
origin = [0, 0, 2.5]
target = [0, 0, 0]
up = [0, UP, 0]
vfov = 60

[[mesh]]
path = "hall.obj"

[material.wall]
type = "diffuse"
reflectance = [0.7, 0.6, 0.5]

[material.lamp]
type = "diffuse"
reflectance = 0
emission = [9, 8, 6]

[integrator]
max_depth = 5
"#;

/// A box about the origin, its lamps behind three screens that stand before the far wall.
const HALL: &str = "
v -3 -1.7 -3
v 3 -1.7 -3
v 3 1.7 -3
v -3 1.7 -3
v -3 -1.7 3
v 3 -1.7 3
v 3 1.7 3
v -3 1.7 3
v -2.4 -0.4 -2.6
v -1.2 -0.4 -2.6
v -1.2 0.4 -2.6
v -2.4 0.4 -2.6
v 1.2 -0.4 -2.6
v 2.4 -0.4 -2.6
v 2.4 0.4 -2.6
v 1.2 0.4 -2.6
v -0.5 -1.2 -2.6
v 0.5 -1.2 -2.6
v 0.5 1.2 -2.6
v -0.5 1.2 -2.6
v -2.3 -0.3 -2.65
v -1.3 -0.3 -2.65
v -1.3 0.3 -2.65
v -2.3 0.3 -2.65
v 1.3 -0.3 -2.65
v 2.3 -0.3 -2.65
v 2.3 0.3 -2.65
v 1.3 0.3 -2.65
v -0.4 -1.1 -2.65
v 0.4 -1.1 -2.65
v 0.4 1.1 -2.65
v -0.4 1.1 -2.65
usemtl wall
f 1 2 3 4
f 5 6 7 8
f 1 5 8 4
f 2 6 7 3
f 1 2 6 5
f 4 3 7 8
f 9 10 11 12
f 13 14 15 16
f 17 18 19 20
usemtl lamp
f 24 23 22 21
f 28 27 26 25
f 32 31 30 29
";
