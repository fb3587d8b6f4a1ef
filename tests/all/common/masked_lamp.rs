//! A box lit by lamps that are seen through in part: a half transparent pane, a pattern, and the pattern again in
//! mirrored places of a group.

use super::Loaded;

const SCENE: &str = r#"
[camera]
origin = [0, 1, 2.9]
target = [0, 1, 0]
vfov = 55

[film]
width = 24
height = 18

[[mesh]]
path = "box.obj"

[[mesh]]
path = "pane.obj"

[[mesh]]
path = "pattern.obj"

[[mesh]]
path = "pattern.obj"
group = "pattern"

[[instance]]
group = "pattern"
scale = [-0.5, 0.5, 0.5]
translate = [0.6, 0.9, -0.3]

[[instance]]
group = "pattern"
scale = 0.6
rotate = { axis = [0, 0, 1], angle = 160 }
translate = [-0.2, 1.3, 0.6]

[material.wall]
type = "diffuse"
reflectance = [0.7, 0.6, 0.5]

[material.pane]
type = "diffuse"
reflectance = 0.3
opacity = 0.5
emission = [4, 3, 2]

[material.pattern]
type = "diffuse"
reflectance = 0.2
opacity = { texture = "pattern.png", channel = "luminance" }
emission = [3, 3, 4]
emission_two_sided = true
"#;

const BOX: &str = "v -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\nv -1 0 3\nv 1 0 3\nv 1 2 3\nv -1 2 3\nusemtl wall\n\
    f 1 2 3 4\nf 5 8 7 6\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 6 2\nf 4 3 7 8\n";
const PANE: &str = "v -0.8 1.8 -0.8\nv 0 1.8 -0.8\nv 0 1.8 0\nv -0.8 1.8 0\nusemtl pane\nf 1 2 3 4\n";
const PATTERN: &str = "v -0.4 0 -0.4\nv 0.4 0 -0.4\nv 0.4 0.2 0.4\nv -0.4 0.2 0.4\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl pattern\nf 1/1 2/2 3/3 4/4\n";

/// The box, loaded.
pub fn masked_lamp(overrides: &[&str]) -> Loaded {
    let files = [("scene.toml", SCENE), ("box.obj", BOX), ("pane.obj", PANE), ("pattern.obj", PATTERN)];
    let folder = super::written(&files);
    let grey = |x: u32, y: u32| image::Luma([[[255u8, 20, 90], [0, 200, 130]][y as usize][x as usize]]);
    image::GrayImage::from_fn(3, 2, grey).save(folder.path().join("pattern.png")).unwrap();
    super::load(&folder.path().join("scene.toml"), overrides)
}
