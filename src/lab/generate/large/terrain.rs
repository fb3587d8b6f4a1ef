//! `terrain`: mountains of noise under a low sun, one smooth sheet of triangles.

use super::noise::Noise;
use super::stream::ObjStream;
use super::{LargeScene, Model};
use crate::lab::generate::obj_writer::Material;
use glam::DVec3;
use std::io;

/// Side of the square, in metres; it is centred on the origin.
pub(crate) const SIDE: f64 = 1000.0;
/// Width of the coarsest hills, and their height at the far end.
const HILLS: f64 = 320.0;
const HEIGHT: f64 = 230.0;

/// A landscape of about `triangles` triangles. Its shape does not depend on their number: finer ones follow it closer.
pub(crate) fn scene(triangles: u64) -> LargeScene {
    let cells = cells(triangles);
    LargeScene {
        toml: toml(),
        about: "mountains of noise",
        materials: materials(),
        models: vec![Model::new("terrain.obj", move |obj| write(obj, &Sheet { cells, side: SIDE, height, ground }))],
    }
}

/// Squares along each side, two triangles to each.
pub(crate) fn cells(triangles: u64) -> u64 {
    (triangles as f64 / 2.0).sqrt().round() as u64
}

/// Height of the ground: a valley in front (z > 0) that rises to mountains behind.
pub(crate) fn height(x: f64, z: f64) -> f64 {
    let rise = (0.5 - z / SIDE).clamp(0.0, 1.0);
    let share = 0.12 + 0.88 * rise * rise * (3.0 - 2.0 * rise);
    let noise = Noise { seed: 11 };
    let hills = noise.fractal(x / HILLS + 0.37, z / HILLS + 0.61, 9, 0.43);
    HEIGHT * share * (hills + 0.25)
}

/// What covers a place of this height: by a slow noise, so that borders wander.
fn ground(p: DVec3) -> &'static str {
    let wander = 18.0 * Noise { seed: 5 }.at(p.x / 60.0, p.z / 60.0);
    match p.y + wander {
        y if y > 100.0 => "snow",
        y if y > 38.0 => "rock",
        _ => "meadow",
    }
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("meadow", [0.16, 0.24, 0.08]),
        Material::diffuse("rock", [0.32, 0.29, 0.26]),
        Material::diffuse("snow", [0.8, 0.81, 0.83]),
    ]
}

/// A square sheet of ground about the origin.
pub(crate) struct Sheet {
    /// Squares along each side.
    pub(crate) cells: u64,
    pub(crate) side: f64,
    pub(crate) height: fn(f64, f64) -> f64,
    pub(crate) ground: fn(DVec3) -> &'static str,
}

impl Sheet {
    fn place(&self, i: i64) -> f64 {
        self.side * (i as f64 / self.cells as f64 - 0.5)
    }

    /// Heights of row `j`, with one more point at either end for the slopes there.
    fn row(&self, j: i64) -> Vec<f64> {
        let z = self.place(j);
        (-1..=self.cells as i64 + 1).map(|i| (self.height)(self.place(i), z)).collect()
    }
}

/// Writes the sheet row by row, with normals by central differences. Three rows of heights are kept.
pub(crate) fn write(obj: &mut ObjStream, sheet: &Sheet) -> io::Result<()> {
    let columns = sheet.cells as usize + 1;
    let step = sheet.side / sheet.cells as f64;
    let mut rows = [sheet.row(-1), sheet.row(0), sheet.row(1)];
    let mut above = 0;
    for j in 0..columns as i64 {
        let [before, row, after] = &rows;
        let mut first = 0;
        for i in 0..columns {
            let (x, z) = (sheet.place(i as i64), sheet.place(j));
            let slope = [row[i + 2] - row[i], after[i + 1] - before[i + 1]].map(|d| d / (2.0 * step));
            let normal = DVec3::new(-slope[0], 1.0, -slope[1]).normalize();
            let index = obj.smooth_vertex(DVec3::new(x, row[i + 1], z), [x / 10.0, -z / 10.0], normal)?;
            first = if i == 0 { index } else { first };
        }
        if j > 0 {
            strip(obj, sheet, j, &rows, [above, first])?;
        }
        above = first;
        rows.rotate_left(1);
        rows[2] = sheet.row(j + 2);
    }
    Ok(())
}

/// The squares between row `j` − 1, whose vertices begin at `first[0]`, and row `j`.
fn strip(obj: &mut ObjStream, sheet: &Sheet, j: i64, rows: &[Vec<f64>; 3], first: [u64; 2]) -> io::Result<()> {
    for i in 0..sheet.cells {
        let (x, z) = (sheet.place(i as i64) + 0.5 * sheet.side / sheet.cells as f64, sheet.place(j));
        let k = i as usize + 1;
        let y = 0.25 * (rows[0][k] + rows[0][k + 1] + rows[1][k] + rows[1][k + 1]);
        obj.material((sheet.ground)(DVec3::new(x, y, z)))?;
        let [a, b] = first.map(|first| first + i);
        obj.triangle([a, b, b + 1])?;
        obj.triangle([a, b + 1, a + 1])?;
    }
    Ok(())
}

fn toml() -> String {
    let (x, z) = (-40.0, 430.0);
    let eye = height(x, z) + 22.0;
    format!(
        r#"# Mountains of noise, displaced by up to 300 m over a square kilometre, under a low sun and a blue sky. The shape
# does not depend on the number of triangles.
[camera]
origin = [{x}, {eye:.3}, {z}]
target = [20, {:.3}, 0]
vfov = 42.0

[film]
width = 960
height = 540
exposure = -0.6

[[mesh]]
path = "terrain.obj"

[[light]]
type = "directional"
direction = [-0.72, -0.42, -0.35]
irradiance = [9.5, 8.2, 6.4]

[[light]]
type = "constant"
radiance = [0.42, 0.6, 0.95]

[render]
spp = 64
"#,
        eye + 14.0
    )
}
