//! Meshes as binary PLY files, one for each material of each mesh.

use crate::Result;
use crate::geometry::{Mesh, MeshColors};
use crate::io::atomic::write_atomically;
use crate::scene::LoadedAssets;
use ::toml::{Table, Value};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

/// A name for each material: its own, with a number where another has it too.
pub(super) fn names(gathered: &LoadedAssets) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut name = |own: &String| {
        let own = if own.is_empty() { "unnamed" } else { own };
        let free = (1..).map(|k| if k == 1 { own.to_string() } else { format!("{own} {k}") });
        let found = free.into_iter().find(|name| taken.insert(name.clone()));
        found.unwrap_or_default()
    };
    gathered.names.iter().map(&mut name).collect()
}

/// Writes all meshes into `folder`, and says where they stand.
pub(super) fn write(gathered: &LoadedAssets, names: &[String], folder: &Path) -> Result<Vec<Value>> {
    let mut tables = Vec::new();
    let beside = folder.file_name().unwrap_or_default().to_string_lossy();
    for (k, (mesh, said)) in gathered.meshes.iter().zip(&gathered.description.meshes).enumerate() {
        let materials: BTreeSet<u32> = mesh.materials.iter().copied().collect();
        for material in materials {
            let file = format!("mesh-{k}-{material}.ply");
            write_atomically(&folder.join(&file), |out| ply(out, mesh, material))?;
            let mut t = Table::new();
            t.insert("path".into(), Value::String(format!("{beside}/{file}")));
            t.insert("material".into(), Value::String(names[material as usize].clone()));
            match &said.group {
                Some(group) => drop(t.insert("group".into(), Value::String(group.clone()))),
                None if gathered.origin != glam::DVec3::ZERO => {
                    t.insert("translate".into(), super::doubles(&gathered.origin.to_array()));
                }
                None => (),
            }
            tables.push(Value::Table(t));
        }
    }
    Ok(tables)
}

/// What a vertex of the file is told from others by: all of its numbers.
type Key = [u32; 11];

/// The triangles of one material.
fn ply(out: &mut dyn Write, mesh: &Mesh, material: u32) -> io::Result<()> {
    let mut numbers: FxHashMap<Key, u32> = FxHashMap::default();
    let (mut vertices, mut triangles) = (Vec::<u8>::new(), Vec::<u8>::new());
    let (mut count, mut faces) = (0u32, 0usize);
    let has = [mesh.normals.is_some(), mesh.uvs.is_some(), mesh.colors.is_some()];
    for t in (0..mesh.triangles.len()).filter(|&t| mesh.materials[t] == material) {
        triangles.push(3);
        faces += 1;
        for vertex in corners(mesh, t) {
            let number = *numbers.entry(vertex.map(f32::to_bits)).or_insert_with(|| {
                for (x, there) in vertex.iter().zip(present(has)) {
                    if there {
                        vertices.extend(x.to_le_bytes());
                    }
                }
                count += 1;
                count - 1
            });
            triangles.extend(number.to_le_bytes());
        }
    }
    let properties = ["x", "y", "z", "nx", "ny", "nz", "s", "t", "red", "green", "blue"];
    let lines = properties.iter().zip(present(has)).filter(|(_, there)| *there);
    let lines: String = lines.map(|(name, _)| format!("property float {name}\n")).collect();
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{lines}")?;
    write!(out, "element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n")?;
    out.write_all(&vertices)?;
    out.write_all(&triangles)
}

/// Which of a vertex' numbers are written.
fn present([normals, uvs, colors]: [bool; 3]) -> [bool; 11] {
    std::array::from_fn(|k| match k {
        0..3 => true,
        3..6 => normals,
        6..8 => uvs,
        _ => colors,
    })
}

/// The three vertices of a triangle. Where it has no normals beside others that have some it is flat, and so are those that are written.
fn corners(mesh: &Mesh, t: usize) -> [[f32; 11]; 3] {
    let [a, b, c] = mesh.corners(t);
    let flat = (b - a).cross(c - a).normalize_or(Vec3::Z).to_array();
    let normals = mesh.normals.as_ref().and_then(|normals| normals.corners(&mesh.triangles, t)).unwrap_or([flat; 3]);
    let uvs = mesh.uvs_of(t);
    [0, 1, 2].map(|k| {
        let index = mesh.triangles[t][k] as usize;
        let ([x, y, z], [nx, ny, nz], [u, v]) = (mesh.positions[index], normals[k], uvs[k]);
        let [r, g, b] = match &mesh.colors {
            Some(MeshColors::OfVertices(colors)) => colors[index],
            Some(MeshColors::OfFaces(colors)) => colors[t],
            None => [1.0; 3],
        };
        [x, y, z, nx, ny, nz, u, v, r, g, b]
    })
}
