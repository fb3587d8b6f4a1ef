//! A small room with what the project's own scenes lack: a textured floor, glossy plastic and metal, a glass ball with
//! interpolated normals, a paper screen, a half transparent pane, a window to a bright sky.

use super::Loaded;
use phototaxis::format::SceneFile;
use std::f32::consts::PI;
use std::fmt::Write;
use tempfile::TempDir;

const SCENE: &str = r#"
[camera]
origin = [0, 1.4, 1.9]
target = [0, 0.7, -1]
vfov = 65

[film]
width = 32
height = 24

[[mesh]]
path = "room.obj"

[[light]]
type = "constant"
radiance = [0.25, 0.35, 0.5]

[material.wall]
type = "diffuse"
reflectance = [0.7, 0.6, 0.5]

[material.floor]
type = "diffuse"
reflectance = { texture = "tiles.png", scale = [3, 3] }

[material.lamp]
type = "diffuse"
reflectance = 0
emission = [9, 8, 6]

[material.copper]
type = "conductor"
alpha = 0.35
eta = [0.2, 0.924, 1.102]
k = [3.912, 2.452, 2.142]

[material.glaze]
type = "plastic"
reflectance = [0.1, 0.3, 0.6]
alpha = 0.15

[material.glass]
type = "dielectric"
int_ior = 1.5

[material.paper]
type = "diffuse_transmitter"
reflectance = 0.4
transmittance = 0.4

[material.pane]
type = "diffuse"
reflectance = 0.6
opacity = 0.5
"#;

/// The room, loaded.
pub fn still_life(overrides: &[&str]) -> Loaded {
    let (_folder, description) = describe(overrides);
    super::build(&description)
}

/// The room, and the folder that its files are in.
pub fn describe(overrides: &[&str]) -> (TempDir, SceneFile) {
    let folder = super::written(&[("scene.toml", SCENE), ("room.obj", &room())]);
    let tile =
        |x: u32, y: u32| image::Rgb(if (x / 2 + y / 2).is_multiple_of(2) { [230, 220, 200] } else { [60, 40, 90] });
    image::RgbImage::from_fn(4, 4, tile).save(folder.path().join("tiles.png")).unwrap();
    let description = super::describe(&folder.path().join("scene.toml"), overrides);
    (folder, description)
}

fn room() -> String {
    let mut obj = Obj::default();
    let (low, high) = ([-2.0, 0.0, -2.0], [2.0, 2.5, 2.0]);
    obj.side(low, high, 1, 0, "floor");
    obj.side(low, high, 1, 1, "wall");
    obj.side(low, high, 0, 0, "wall");
    // the wall on the right ends at a window, the one behind the camera is there
    obj.side(low, [2.0, 2.5, 0.8], 0, 1, "wall");
    obj.side(low, high, 2, 0, "wall");
    obj.side(low, high, 2, 1, "wall");
    // a lamp that shines upwards, on a shelf
    obj.side([-1.8, 1.8, -1.6], [-1.0, 1.8, -0.8], 1, 0, "lamp");
    obj.block([-1.9, 1.7, -1.7], [-0.9, 1.78, -0.7], "wall");
    obj.block([-1.3, 0.0, -1.4], [-0.7, 0.8, -0.9], "copper");
    obj.block([0.6, 0.0, -1.5], [1.2, 1.0, -1.0], "glaze");
    obj.side([-0.6, 0.0, -1.5], [0.3, 1.2, -1.5], 2, 0, "paper");
    obj.side([0.9, 0.0, -0.4], [1.7, 0.9, -0.4], 2, 0, "pane");
    obj.ball([0.1, 0.4, -0.5], 0.4, "glass");
    obj.text
}

/// Text of an OBJ file, as it grows.
#[derive(Default)]
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    /// The side of a box on which coordinate `axis` is at its lower (0) or upper (1) end; its winding faces inwards
    /// below and outwards above.
    fn side(&mut self, low: [f32; 3], high: [f32; 3], axis: usize, end: usize, material: &str) {
        let corner = |b: usize, c: usize| {
            let mut p = low;
            p[axis] = [low, high][end][axis];
            p[(axis + 1) % 3] = [low, high][b][(axis + 1) % 3];
            p[(axis + 2) % 3] = [low, high][c][(axis + 2) % 3];
            p
        };
        writeln!(self.text, "usemtl {material}").unwrap();
        for (b, c) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            let [x, y, z] = corner(b, c);
            writeln!(self.text, "v {x} {y} {z}\nvt {b} {c}").unwrap();
        }
        let n = self.vertices;
        writeln!(self.text, "f {0}/{0} {1}/{1} {2}/{2} {3}/{3}", n + 1, n + 2, n + 3, n + 4).unwrap();
        self.vertices += 4;
    }

    fn block(&mut self, low: [f32; 3], high: [f32; 3], material: &str) {
        for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            self.side(low, high, axis, end, material);
        }
    }

    fn ball(&mut self, centre: [f32; 3], radius: f32, material: &str) {
        const RINGS: usize = 10;
        const SECTORS: usize = 16;
        writeln!(self.text, "usemtl {material}").unwrap();
        for (i, j) in (0..=RINGS).flat_map(|i| (0..SECTORS).map(move |j| (i, j))) {
            let (theta, phi) = (PI * i as f32 / RINGS as f32, 2.0 * PI * j as f32 / SECTORS as f32);
            let n = [theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()];
            let p = [0, 1, 2].map(|k| centre[k] + radius * n[k]);
            writeln!(self.text, "v {} {} {}\nvt 0 0\nvn {} {} {}", p[0], p[1], p[2], n[0], n[1], n[2]).unwrap();
        }
        let at = |i: usize, j: usize| self.vertices + 1 + i * SECTORS + j % SECTORS;
        let normal = |i: usize, j: usize| 1 + i * SECTORS + j % SECTORS;
        for (i, j) in (0..RINGS).flat_map(|i| (0..SECTORS).map(move |j| (i, j))) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let corner = |(i, j): (usize, usize)| format!("{0}/{0}/{1}", at(i, j), normal(i, j));
            writeln!(self.text, "f {}", corners.map(corner).join(" ")).unwrap();
        }
        self.vertices += (RINGS + 1) * SECTORS;
    }
}
