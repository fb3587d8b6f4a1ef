//! Triangles as OBJ files, one shape of Mitsuba's each.

use crate::geometry::Mesh;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Triangles of one material that all have normals at their corners, or all go without.
pub(crate) struct Part {
    pub(crate) material: u32,
    pub(crate) smooth: bool,
    /// Mesh and triangle.
    triangles: Vec<(usize, usize)>,
}

/// All triangles. Materials of which `flat` is true do without normals at corners.
pub(crate) fn parts(meshes: &[Mesh], flat: impl Fn(u32) -> bool) -> Vec<Part> {
    let mut sorted: BTreeMap<(u32, bool), Vec<(usize, usize)>> = BTreeMap::new();
    for (m, mesh) in meshes.iter().enumerate() {
        for (t, &material) in mesh.materials.iter().enumerate() {
            let smooth = !flat(material) && normals(mesh, t).is_some();
            sorted.entry((material, smooth)).or_default().push((m, t));
        }
    }
    let part = |((material, smooth), triangles)| Part { material, smooth, triangles };
    sorted.into_iter().map(part).collect()
}

fn normals(mesh: &Mesh, triangle: usize) -> Option<[[f32; 3]; 3]> {
    mesh.normals.as_ref()?.corners(&mesh.triangles, triangle)
}

/// Where all triangles have none of their own, texture coordinates are the barycentric weights that stand for them.
pub(crate) fn write(file: &mut dyn Write, meshes: &[Mesh], part: &Part, textured: bool) -> io::Result<()> {
    let (mut positions, mut uvs, mut directions) = (Pool::new("v"), Pool::new("vt"), Pool::new("vn"));
    for &(m, t) in &part.triangles {
        let mesh = &meshes[m];
        let normals = if part.smooth { normals(mesh, t) } else { None };
        let mut face = "f".to_owned();
        for (k, p) in mesh.corners(t).into_iter().enumerate() {
            let position = positions.number(file, p.to_array())?;
            let weights = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][k];
            let uv = textured.then(|| uvs.number(file, mesh.uv(t, weights[0], weights[1]))).transpose()?;
            let normal = normals.map(|n| directions.number(file, n[k])).transpose()?;
            let word = |number: Option<usize>| number.map_or(String::new(), |n| n.to_string());
            face.push_str(&match (uv, normal) {
                (None, None) => format!(" {position}"),
                (_, None) => format!(" {position}/{}", word(uv)),
                _ => format!(" {position}/{}/{}", word(uv), word(normal)),
            });
        }
        writeln!(file, "{face}")?;
    }
    Ok(())
}

/// Values of one kind, each written once; they are numbered from 1.
struct Pool<const N: usize> {
    keyword: &'static str,
    numbers: FxHashMap<[u32; N], usize>,
}

impl<const N: usize> Pool<N> {
    fn new(keyword: &'static str) -> Pool<N> {
        Pool { keyword, numbers: FxHashMap::default() }
    }

    /// As written, a number is the same to the last bit when it is read.
    fn number(&mut self, file: &mut dyn Write, value: [f32; N]) -> io::Result<usize> {
        let next = self.numbers.len() + 1;
        let number = *self.numbers.entry(value.map(f32::to_bits)).or_insert(next);
        if number == next {
            writeln!(file, "{} {}", self.keyword, value.map(|x| x.to_string()).join(" "))?;
        }
        Ok(number)
    }
}
