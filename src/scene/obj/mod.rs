//! Wavefront OBJ with its MTL libraries.
//!
//! The file is read block by block in three passes, each on all cores: count, then vertices, then faces. The counts
//! give every block its places in the mesh's arrays before a number is parsed, so blocks do not wait for each other,
//! relative indices resolve, and nothing is copied or held twice. Peak memory is the mesh plus one block per thread.
//!
//! Understood: `v vt vn f s o usemtl mtllib`, with `\` continuations, comments at line ends, relative indices and any
//! number of corners. `o`, or `g` where there is no `o`, names objects; `o` also ends
//! smoothing at its place. Points, lines and everything else is counted in a warning.

mod attributes;
mod colors;
mod faces;
mod lines;
mod mtl;
mod repair;
mod report;
mod scan;
mod smooth;
mod source;

#[cfg(test)]
mod tests;

use crate::Result;
use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices, MeshColors};
use crate::io::memory;
use crate::scene::description::MaterialDescription;
use crate::scene::model::{Model, Warning};
use crate::scene::origin::Bounds;
use colors::Colors;
use glam::DVec3;
use rayon::prelude::*;
use report::Reporter;
use scan::{Census, Counts};
use source::{Failure, Fault, Source};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Bytes that a thread reads at a time: fits into a core's cache, and is long against the cost of opening the file.
const BLOCK: u64 = 1 << 20;

/// Loads an OBJ file and the MTL libraries it names.
///
/// In the model positions and normals are as in the file: not transformed, normals not normalised. Positions far from 0 are counted
/// from an origin near them. Faces without normals that are
/// in a smoothing group get them, averaged over the group's faces at the same place. Faces before any `usemtl`
/// have the material "", or the only one of the libraries where there is no `usemtl` at all. Faces become triangles, ears being cut off concave ones; those with fewer than three corners are dropped. A file
/// without faces gives an empty mesh.
///
/// # Errors
/// With file, line and column: numbers and corners that are none, indices out of range, faces at vertices that are not
/// finite, anything malformed in a library. Without: what cannot be read, or exceeds 2³² − 1 elements. A library that
/// is missing is a warning.
pub fn load(path: &Path) -> Result<Model> {
    load_in_blocks(&Source::open(path)?, BLOCK)
}

/// `block`: bytes per block, which decide nothing but speed, and how unknown statements are counted once there are more
/// kinds of them than are told apart.
fn load_in_blocks(source: &Source, block: u64) -> Result<Model> {
    let blocks = source.blocks(block).map_err(crate::Error::io(source.path()))?;
    let mut reporter = Reporter::new(source, &blocks);
    let loaded = load_parts(source, &blocks, &mut reporter);
    let (mesh, origin, census) = loaded.map_err(|failure| reporter.error(failure))?;
    let (mut materials, mut library_warnings) = mtl::load_libraries(&mut reporter, &census.libraries)?;
    if mesh.colors.is_some() {
        materials.values_mut().for_each(MaterialDescription::multiply_vertex_colors);
    }
    reporter.unknown_materials(&census, &materials);
    let only = reporter.unnamed_material(&census, &materials);
    let mut warnings = reporter.finish()?;
    warnings.append(&mut library_warnings);
    let (mut material_names, mesh) = assign_materials(mesh, &census);
    material_names.iter_mut().filter(|name| name.is_empty()).zip(only).for_each(|(name, only)| *name = only);
    Ok(Model { mesh, origin, material_names, materials, parts: census.parts(), warnings })
}

/// The mesh without its materials, and what its positions are counted from.
fn load_parts(
    source: &Source,
    blocks: &[Range<u64>],
    reporter: &mut Reporter,
) -> Result<(Mesh, DVec3, Census), Failure> {
    let tasks = blocks.iter().map(|range| (range.clone(), ())).collect();
    let parts = source.each_block(tasks, |(), text| Ok(scan::scan(text)))?;
    let census = scan::merge(blocks.iter().map(|range| range.start).zip(&parts));
    check_limits(&census)?;
    reporter.census(&census);
    let mut mesh = Mesh {
        positions: vec![[0.0; 3]; census.counts.positions],
        triangles: vec![[0; 3]; census.triangles],
        normals: attribute(census.counts.normals),
        uvs: attribute(census.counts.uvs),
        colors: None,
        materials: Vec::new(),
    };
    let (broken, colors) = read_attributes(source, blocks, &parts, &mut mesh)?;
    mesh.colors = colors::merge(colors, census.counts.positions)?.map(MeshColors::OfVertices);
    let mut origin = Bounds::of(&mesh.positions).origin();
    if origin != DVec3::ZERO {
        read_positions(source, blocks, &parts, &mut mesh.positions, origin)?;
    }
    read_faces(source, blocks, &parts, &mut mesh)?;
    let used = Bounds::of_used(&mesh.positions, &mesh.triangles).map_or(DVec3::ZERO, Bounds::origin);
    if used != DVec3::ZERO {
        origin += used;
        read_positions(source, blocks, &parts, &mut mesh.positions, origin)?;
        read_faces(source, blocks, &parts, &mut mesh)?;
        crate::scene::repair::drop_unused(&mut mesh);
    }
    repair::repair(&mut mesh, &broken, reporter)?;
    smooth::smooth(&mut mesh, &census.smoothing)?;
    Ok((mesh, origin, census))
}

/// Indices are `u32`, of which the largest means "absent".
fn check_limits(census: &Census) -> Result<(), Failure> {
    let Counts { positions, uvs, normals } = census.counts;
    match [positions, uvs, normals, census.triangles].iter().max() {
        Some(&most) if most > u32::MAX as usize => {
            let message = format!("the file has {most} elements of one kind, at most {} are supported", u32::MAX);
            Err(Failure::Fault(Fault::new(0, message)))
        }
        _ => check_memory(census),
    }
}

/// That the mesh can be held: the arrays are as long as the statements in the file are many.
fn check_memory(census: &Census) -> Result<(), Failure> {
    let Counts { positions, uvs, normals } = census.counts;
    let own_indices = usize::from(uvs > 0) + usize::from(normals > 0);
    // a triangle has three corners of four bytes, once more for each attribute, and a material
    let bytes = 12 * (positions + normals) + 8 * uvs + (12 * (1 + own_indices) + 4) * census.triangles;
    memory::check(bytes as u64).map_err(|shortage| {
        let message = format!("{positions} vertices and {} triangles {shortage}", census.triangles);
        Failure::Fault(Fault::new(0, message))
    })
}

fn attribute<const N: usize>(values: usize) -> Option<Attribute<[f32; N]>> {
    (values > 0).then(|| Attribute { values: vec![[0.0; N]; values], indices: Indices::OfPositions })
}

/// Cuts the front off a slice; a missing slice stays empty.
fn cut<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(rest.len());
    let (front, back) = std::mem::take(rest).split_at_mut(count);
    *rest = back;
    front
}

fn read_attributes(
    source: &Source,
    blocks: &[Range<u64>],
    parts: &[Census],
    mesh: &mut Mesh,
) -> Result<(attributes::BrokenValues, Vec<(usize, Colors)>), Failure> {
    let mut positions = &mut mesh.positions[..];
    let mut uvs = mesh.uvs.as_mut().map_or(&mut [][..], |a| &mut a.values);
    let mut normals = mesh.normals.as_mut().map_or(&mut [][..], |a| &mut a.values);
    let mut tasks = Vec::new();
    let mut starts = Vec::new();
    let mut before = Counts::default();
    for (range, part) in blocks.iter().zip(parts) {
        let slots = attributes::Slots {
            positions: cut(&mut positions, part.counts.positions),
            uvs: cut(&mut uvs, part.counts.uvs),
            normals: cut(&mut normals, part.counts.normals),
        };
        if part.counts != Counts::default() {
            tasks.push((range.clone(), slots));
            starts.push((before, range.start));
        }
        before = before.plus(part.counts);
    }
    let (broken, colors): (Vec<_>, Vec<_>) = source.each_block(tasks, attributes::read)?.into_iter().unzip();
    let colors = starts.iter().map(|(before, _)| before.positions).zip(colors).collect();
    Ok((attributes::BrokenValues::merge(starts.into_iter().zip(broken)), colors))
}

/// Reads the positions anew, in double precision and from `origin` on.
fn read_positions(
    source: &Source,
    blocks: &[Range<u64>],
    parts: &[Census],
    mut positions: &mut [[f32; 3]],
    origin: DVec3,
) -> Result<(), Failure> {
    let parts = blocks.iter().zip(parts).filter(|(_, part)| part.counts.positions > 0);
    let tasks = parts.map(|(range, part)| (range.clone(), cut(&mut positions, part.counts.positions))).collect();
    source.each_block(tasks, |slots, text| attributes::read_positions(slots, text, origin)).map(drop)
}

fn read_faces(source: &Source, blocks: &[Range<u64>], parts: &[Census], mesh: &mut Mesh) -> Result<(), Failure> {
    let totals = parts.iter().fold(Counts::default(), |sum, part| sum.plus(part.counts));
    let (count, positions) = (mesh.triangles.len(), &mesh.positions[..]);
    let zeros = |there: bool| vec![[0; 3]; if there { count } else { 0 }];
    let (mut uvs, mut normals) = (zeros(mesh.uvs.is_some()), zeros(mesh.normals.is_some()));
    let tasks = face_tasks(blocks, parts, [&mut mesh.triangles, &mut uvs, &mut normals]);
    let differ = source.each_block(tasks, |slots, text| faces::read(slots, positions, totals, text))?;
    let own = |k: usize, differences| differ.iter().any(|d| d[k]).then(|| own_indices(differences, &mesh.triangles));
    let (uvs, normals) = (own(0, uvs), own(1, normals));
    mesh.uvs.iter_mut().zip(uvs).for_each(|(a, indices)| a.indices = indices);
    mesh.normals.iter_mut().zip(normals).for_each(|(a, indices)| a.indices = indices);
    Ok(())
}

/// The blocks that hold faces, each with its parts of the arrays: indices of positions, texture coordinates and normals.
fn face_tasks<'a>(
    blocks: &[Range<u64>],
    parts: &[Census],
    [mut triangles, mut uvs, mut normals]: [&'a mut [[u32; 3]]; 3],
) -> Vec<(Range<u64>, faces::Slots<'a>)> {
    let mut tasks = Vec::new();
    let mut before = Counts::default();
    for (range, part) in blocks.iter().zip(parts) {
        let slots = faces::Slots {
            triangles: cut(&mut triangles, part.triangles),
            uvs: cut(&mut uvs, part.triangles),
            normals: cut(&mut normals, part.triangles),
            before,
        };
        if part.triangles > 0 || part.slivers.is_some() {
            tasks.push((range.clone(), slots));
        }
        before = before.plus(part.counts);
    }
    tasks
}

/// Indices of an attribute from how they differ from those of positions.
fn own_indices(mut differences: Vec<[u32; 3]>, triangles: &[[u32; 3]]) -> Indices {
    differences.par_iter_mut().zip(triangles).for_each(|(d, t)| *d = [0, 1, 2].map(|k| d[k] ^ t[k]));
    Indices::Own(differences)
}

/// Names in order of first use, and each triangle's index into them.
fn assign_materials(mut mesh: Mesh, census: &Census) -> (Vec<String>, Mesh) {
    let mut names: Vec<String> = Vec::new();
    let mut known: BTreeMap<&str, u32> = BTreeMap::new();
    mesh.materials.reserve_exact(census.triangles);
    for (name, range, _) in census.runs() {
        let index = *known.entry(name).or_insert_with(|| {
            names.push(name.to_string());
            names.len() as u32 - 1
        });
        mesh.materials.resize(range.end, index);
    }
    (names, mesh)
}
