//! Quantised normals: the faces of a cube, each cut into square bins.

use crate::simd::truncate;
use glam::Vec3;

/// Each face of the normals' cube is cut into `FACE`² bins; an odd number keeps an axis at a bin's centre.
pub const FACE: i32 = 3;
pub const NORMALS: usize = 6 * (FACE * FACE) as usize;

/// The face of the cube that `n` points through, and the part of that face.
#[inline(always)]
pub fn normal_bin(n: Vec3) -> usize {
    let a = n.abs();
    // choices of single numbers, which run in vectors
    let is_x = (a.x >= a.y) & (a.x >= a.z);
    let is_z = !is_x & (a.y < a.z);
    let along = |x: f32, y: f32, z: f32| {
        if is_x {
            x
        } else if is_z {
            z
        } else {
            y
        }
    };
    let axis = if is_x {
        0
    } else if is_z {
        4
    } else {
        2
    };
    let face = axis + (along(n.x, n.y, n.z) < 0.0) as i32;
    let (major, x, y) = (along(a.x, a.y, a.z), if is_x { n.y } else { n.x }, if is_z { n.y } else { n.z });
    let part = |v: f32| (truncate((v / major + 1.0) * (0.5 * FACE as f32)) as i32).min(FACE - 1);
    ((face * FACE + part(x)) * FACE + part(y)) as usize
}

/// Unit vector through the centre of a bin.
pub fn bin_normal(bin: usize) -> Vec3 {
    let (face, x, y) = (bin as i32 / (FACE * FACE), bin as i32 / FACE % FACE, bin as i32 % FACE);
    let centre = |i: i32| (2 * i + 1) as f32 / FACE as f32 - 1.0;
    let (x, y, sign) = (centre(x), centre(y), if face % 2 == 0 { 1.0 } else { -1.0 });
    match face / 2 {
        0 => Vec3::new(sign, x, y),
        1 => Vec3::new(x, sign, y),
        _ => Vec3::new(x, y, sign),
    }
    .normalize()
}
