mod against_mitsuba;
mod plugins;
mod text;

use crate::Result;
use crate::format::{self, SceneFile};
use crate::image::Layer;
use crate::image::exr::{self, Metadata, Window};
use crate::math::Rgb;
use image::{GrayImage, Luma, Rgb as Pixel, RgbImage};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Writes the pictures and meshes that scenes of these tests name.
fn companions() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let quad = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 4/4 3/3 2/2 1/1\n";
    fs::write(at("quad.obj"), quad).unwrap();
    fs::write(at("dome.ply"), dome()).unwrap();
    fs::write(at("painted.ply"), painted()).unwrap();
    let corner = |x: u32, y: u32| if x < 3 && y < 3 { 200 } else { 60 };
    RgbImage::from_fn(8, 8, |x, y| Pixel([30 + 25 * x as u8, 250 - 25 * y as u8, corner(x, y)]))
        .save(at("pic.png"))
        .unwrap();
    let mask = |x: u32, y: u32| if x < 4 || (x > 4 && y < 3) { 255 } else { 0 };
    GrayImage::from_fn(8, 8, |x, y| Luma([mask(x, y)])).save(at("mask.png")).unwrap();
    let normal = |x: u32, y: u32| {
        let n = glam::Vec3::new(0.5 * (0.8 * x as f32).sin(), 0.4 * (0.8 * y as f32).cos(), 1.0).normalize();
        Pixel((n * 127.5 + 127.5).to_array().map(|x| x.round() as u8))
    };
    RgbImage::from_fn(8, 8, normal).save(at("normal.png")).unwrap();
    let turn = |x: u32, period: f32| (x as f32 + 0.5) * std::f32::consts::PI / period;
    let height = |x: u32, y: u32| 127.5 + 127.5 * turn(x, 16.0).sin() * turn(y, 32.0).cos();
    GrayImage::from_fn(64, 64, |x, y| Luma([height(x, y) as u8])).save(at("height.png")).unwrap();
    let sky = |k: usize| {
        let (x, y) = (k % 32, k / 32);
        let sun = (3..5).contains(&y) && (6..9).contains(&x);
        let above = if y < 8 { 0.8 } else { 0.3 };
        if sun {
            Rgb::new(20.0, 15.0, 10.0)
        } else {
            Rgb::new(0.2 + x as f32 / 32.0, above, 0.5 + 0.5 * (x as f32).sin())
        }
    };
    let sky: Vec<Rgb> = (0..16 * 32).map(sky).collect();
    exr::write(&at("env.exr"), &Window::full(32, 16), vec![Layer::color("", &sky)], &Metadata::default()).unwrap();
    folder
}

/// A hill with texture coordinates and without normals, as a binary PLY.
fn dome() -> Vec<u8> {
    const SIDE: usize = 12;
    let count = (SIDE + 1) * (SIDE + 1);
    let lines: String = ["x", "y", "z", "s", "t"].iter().map(|name| format!("property float {name}\n")).collect();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{lines}element face {}\nproperty list uchar int \
         vertex_indices\nend_header\n",
        2 * SIDE * SIDE
    )
    .into_bytes();
    for k in 0..count {
        let [u, v] = [k % (SIDE + 1), k / (SIDE + 1)].map(|i| i as f32 / SIDE as f32);
        let arch = |x: f32| (std::f32::consts::PI * x).sin();
        for x in [2.0 * u - 1.0, 2.0 * v - 1.0, 0.5 * arch(u) * arch(v), u, v] {
            bytes.extend(x.to_le_bytes());
        }
    }
    for cell in 0..SIDE * SIDE {
        let a = (cell / SIDE * (SIDE + 1) + cell % SIDE) as i32;
        let above = a + SIDE as i32 + 1;
        for corners in [[a, a + 1, above + 1], [a, above + 1, above]] {
            bytes.push(3);
            corners.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        }
    }
    bytes
}

/// A tent of four sides, in text: sides have a colour and a tone of three numbers each, corners a heat of one.
fn painted() -> String {
    let corners = ["-1 0 -1 0.1", "1 0 -1 0.3", "1 0 1 0.9", "-1 0 1 0.6", "0 0.7 0 0.2"];
    let sides = [
        "1 0 4 1 0.1 0.1 0.9 0.2 0.1",
        "2 1 4 0.1 0.8 0.3 0.1 0.8 0.3",
        "3 2 4 0.2 0.3 1 0.2 0.3 0.9",
        "0 3 4 0.7 0.7 0.1 0.7 0.7 0.1",
    ];
    let lines =
        |kind: &str, names: &[&str]| names.iter().map(|name| format!("property {kind} {name}\n")).collect::<String>();
    let (vertices, faces) = (lines("float", &["x", "y", "z", "heat_x"]), lines("float", &["red", "green", "blue"]));
    let tones = lines("float", &["tone_r", "tone_g", "tone_b"]);
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex 5\n{vertices}element face 4\n");
    text += &format!("property list uchar int vertex_indices\n{faces}{tones}end_header\n");
    corners.iter().for_each(|corner| text += &format!("{corner}\n"));
    sides.iter().for_each(|side| text += &format!("3 {side}\n"));
    text
}

/// Reads the text as a scene that stands in `folder`.
fn read(folder: &Path, text: &str) -> Result<(SceneFile, Vec<String>)> {
    let path = folder.join("scene.xml");
    fs::write(&path, text).unwrap();
    format::load(&path, &[])
}
