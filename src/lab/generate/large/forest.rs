//! `forest`: two kinds of trees and a lantern, each one mesh that stands in many places, on rolling ground.

use super::noise::Noise;
use super::stream::ObjStream;
use super::terrain::{self, Sheet};
use super::tree::{self, BROADLEAF, CONIFER};
use super::{LargeScene, Model};
use crate::lab::generate::obj_writer::{Material, toml_vector};
use crate::math::rng::Rng;
use glam::DVec3;
use std::fmt::Write as _;
use std::io;

/// Metres from tree to tree, and the clearing about the camera's end of the path.
const SPACING: f64 = 6.5;
const MARGIN: f64 = 14.0;
const LANTERNS: u64 = 9;
/// Of one lantern: its post and its head.
const LANTERN: u64 = 8 + 12;

/// A forest of about `triangles` triangles, those of all instances together: the more, the more trees of the more leaves.
pub(crate) fn scene(triangles: u64) -> LargeScene {
    let plan = Plan::new(triangles);
    let (cells, side, leaves) = (plan.cells, plan.side(), plan.triangles_per_tree);
    LargeScene {
        toml: plan.toml(),
        about: "instanced trees and lanterns",
        materials: materials(),
        models: vec![
            Model::new("forest.obj", move |obj| terrain::write(obj, &Sheet { cells, side, height, ground })),
            Model::new("forest-conifer.obj", move |obj| tree::write(obj, &CONIFER, leaves)),
            Model::new("forest-broadleaf.obj", move |obj| tree::write(obj, &BROADLEAF, leaves)),
            Model::new("forest-lantern.obj", lantern),
        ],
    }
}

struct Plan {
    /// Of the ground.
    cells: u64,
    trees: u64,
    triangles_per_tree: u64,
}

impl Plan {
    /// A tenth for the ground, the rest for trees, whose number grows with the square root.
    fn new(triangles: u64) -> Plan {
        let cells = terrain::cells(triangles / 10);
        let trees = ((triangles as f64).sqrt() / 4.0).round() as u64;
        let rest = triangles - 2 * cells * cells - LANTERNS * LANTERN;
        Plan { cells, trees, triangles_per_tree: rest / trees }
    }

    /// Places along each side of the wood.
    fn places(&self) -> u64 {
        (self.trees as f64).sqrt().ceil() as u64
    }

    fn side(&self) -> f64 {
        self.places() as f64 * SPACING + 2.0 * MARGIN
    }

    /// Where the wood ends in front.
    fn front(&self) -> f64 {
        0.5 * self.places() as f64 * SPACING
    }

    fn toml(&self) -> String {
        let z = self.front();
        let eye = on_ground(path(z + 6.0), z + 6.0) + DVec3::Y * 1.9;
        let ahead = on_ground(path(z - 12.0), z - 12.0) + DVec3::Y * 2.6;
        let mut text = HEAD.replace("ORIGIN", &toml_vector(eye)).replace("TARGET", &toml_vector(ahead));
        self.stand_trees(&mut text);
        for k in 0..LANTERNS {
            let z = z + 1.0 - 6.0 * k as f64;
            let side = if k % 2 == 0 { 1.7 } else { -1.7 };
            let p = on_ground(path(z) + side, z);
            let _ = writeln!(text, "\n[[instance]]\ngroup = \"lantern\"\ntranslate = {}", toml_vector(p));
        }
        text
    }

    /// One tree to each place of a jittered grid, moved off the path.
    fn stand_trees(&self, text: &mut String) {
        let mut rng = Rng::new(3);
        for k in 0..self.trees {
            let mut place = |i: u64| (i as f64 + 0.5 + 0.7 * (rng.f64() - 0.5)) * SPACING - self.front();
            let (mut x, z) = (place(k % self.places()), place(k / self.places()));
            let off = x - path(z);
            if off.abs() < 3.2 {
                x = path(z) + 3.2f64.copysign(off);
            }
            let group = if rng.f64() < 0.6 { "conifer" } else { "broadleaf" };
            let (angle, size) = ((360.0 * rng.f64()).round(), 0.75 + 0.5 * rng.f64());
            let scale = toml_vector(DVec3::new(size, size * (0.85 + 0.4 * rng.f64()), size));
            let foot = toml_vector(on_ground(x, z) - DVec3::Y * 0.1);
            let _ = writeln!(
                text,
                "\n[[instance]]\ngroup = \"{group}\"\nscale = {scale}\nrotate = {{ axis = [0, 1, 0], angle = {angle} }}\n\
                 translate = {foot}"
            );
        }
    }
}

fn height(x: f64, z: f64) -> f64 {
    4.0 * Noise { seed: 21 }.fractal(x / 45.0 + 0.3, z / 45.0 + 0.7, 6, 0.4)
}

fn on_ground(x: f64, z: f64) -> DVec3 {
    DVec3::new(x, height(x, z), z)
}

/// The path's middle.
fn path(z: f64) -> f64 {
    5.0 * Noise { seed: 31 }.at(z / 30.0, 0.5)
}

fn ground(p: DVec3) -> &'static str {
    let edge = 1.2 + 0.5 * Noise { seed: 41 }.at(p.x, p.z);
    if (p.x - path(p.z)).abs() < edge { "path" } else { "moss" }
}

/// A post with a glowing head.
fn lantern(obj: &mut ObjStream) -> io::Result<()> {
    obj.material("bark")?;
    let post = |y: f64| [[-0.05, 0.05], [0.05, 0.05], [0.05, -0.05], [-0.05, -0.05]].map(|[x, z]| DVec3::new(x, y, z));
    let (low, high) = (post(-0.2), post(1.1));
    for k in 0..4 {
        let next = (k + 1) % 4;
        obj.quad([low[k], low[next], high[next], high[k]])?;
    }
    obj.material("glow")?;
    let (low, high) =
        (post(1.12).map(|p| p * DVec3::new(2.6, 1.0, 2.6)), post(1.42).map(|p| p * DVec3::new(2.6, 1.0, 2.6)));
    for k in 0..4 {
        let next = (k + 1) % 4;
        obj.quad([low[k], low[next], high[next], high[k]])?;
    }
    obj.quad(high)?;
    obj.quad([low[3], low[2], low[1], low[0]])
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("moss", [0.13, 0.17, 0.07]),
        Material::diffuse("path", [0.3, 0.24, 0.17]),
        Material::diffuse("bark", [0.16, 0.11, 0.08]),
        Material::diffuse("needles", [0.07, 0.15, 0.07]),
        Material::diffuse("leaves", [0.2, 0.27, 0.07]),
        Material { emission: [55.0, 32.0, 12.0], ..Material::diffuse("glow", [0.0; 3]) },
    ]
}

const HEAD: &str = r#"# A wood at dusk: two kinds of trees and a lantern, each one mesh that stands in many places. Light is what the sky lets
# through the crowns, and the lanterns along the path.
[camera]
origin = ORIGIN
target = TARGET
vfov = 52.0

[film]
width = 960
height = 540
exposure = 1.3

[[mesh]]
path = "forest.obj"

[[mesh]]
path = "forest-conifer.obj"
group = "conifer"

[[mesh]]
path = "forest-broadleaf.obj"
group = "broadleaf"

[[mesh]]
path = "forest-lantern.obj"
group = "lantern"

[material.needles]
type = "diffuse_transmitter"
reflectance = [0.07, 0.15, 0.07]
transmittance = [0.03, 0.07, 0.02]

[material.leaves]
type = "diffuse_transmitter"
reflectance = [0.17, 0.24, 0.06]
transmittance = [0.12, 0.2, 0.03]

[[light]]
type = "constant"
radiance = [0.2, 0.27, 0.42]

[render]
spp = 64
"#;
