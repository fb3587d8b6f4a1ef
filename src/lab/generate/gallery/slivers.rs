//! A mesh as exporters leave it behind.

use super::{View, lamp, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, cuboid};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shape::{Shape, Triangle};
use glam::DVec3;
use std::f64::consts::TAU;

const BLADES: u32 = 180;
const RADIUS: f64 = 0.9;

pub(crate) fn slivers() -> SceneFiles {
    let about = "A disk of blades two degrees wide, each there twice and cut once more along its edge into slivers of\n\
                 0.1 mm, and triangles without any area, on the lamp too.";
    let lamp_quad = cuboid([-2.0, 0.7, -0.7], [-2.0, 1.6, 0.3]);
    let room = Blocks::in_rock()
        .carve(cuboid([-2.0, 0.0, -2.0], [2.0, 2.4, 2.0]))
        .fill(cuboid([-1.1, 0.0, -2.0], [-1.0, 2.0, 1.0]))
        .cut(1, [lamp_quad.min.y, lamp_quad.max.y])
        .cut(2, [lamp_quad.min.z, lamp_quad.max.z])
        .surface(move |centre, _| if lamp_quad.contains(centre) { "lamp" } else { "plaster" });
    let model = Model {
        about: "a disk of slivers, duplicates and triangles without area",
        objects: vec![("room", with_empty(room, "lamp")), ("disk", with_empty(twice(disk()), "disk"))],
        materials: vec![
            Material::diffuse("plaster", [0.74, 0.73, 0.7]),
            Material::diffuse("disk", [0.65, 0.4, 0.3]),
            lamp("lamp", [40.0, 37.0, 32.0]),
        ],
    };
    let view = View { eye: DVec3::new(1.1, 1.7, 1.9), target: DVec3::new(0.2, 0.8, -0.5), vfov: 60.0, exposure: 0.0 };
    with_mesh("slivers", about, &view, model)
}

/// A disk that leans towards the camera: from each blade's leading edge a sliver is cut off.
fn disk() -> Shape {
    let centre = DVec3::new(0.5, 0.95, -0.7);
    let (u, v) = (DVec3::X, DVec3::new(0.0, 0.8, -0.6));
    let rim = |angle: f64| centre + (u * angle.cos() + v * angle.sin()) * RADIUS;
    let blade = |k: u32| {
        let (from, to) = (TAU * f64::from(k) / f64::from(BLADES), TAU * f64::from(k + 1) / f64::from(BLADES));
        let cut = to - 1e-4 / RADIUS;
        Shape::new(vec![centre, rim(from), rim(cut), rim(to)], vec![[0, 1, 2], [0, 2, 3]], "disk")
    };
    (1..BLADES).map(blade).fold(blade(0), Shape::with)
}

fn twice(mut shape: Shape) -> Shape {
    shape.triangles = shape.triangles.repeat(2);
    shape
}

/// Adds triangles of one point, of two, and of three in a line, at the corners of one that is there.
fn with_empty(mut shape: Shape, material: &'static str) -> Shape {
    let found = shape.triangles.iter().find(|t| t.material == material).copied();
    let Some(Triangle { corners: [a, b, _], .. }) = found else { return shape };
    let middle = (shape.positions[a as usize] + shape.positions[b as usize]) / 2.0;
    let m = shape.positions.len() as u32;
    shape.positions.push(middle);
    shape.triangles.extend([[a, a, a], [a, b, b], [a, m, b]].map(|corners| Triangle { corners, material }));
    shape
}
