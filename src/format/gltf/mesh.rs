//! Primitives as meshes.

use super::Warnings;
use super::buffers::Buffers;
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices, MeshColors};
use crate::scene::model::Model;
use crate::{Error, Result};
use glam::Vec3;
use gltf::Primitive;
use gltf::mesh::Mode;
use std::sync::Arc;

/// What a primitive is made of: `uv_set` is the set of texture coordinates that its material asks for, and `colored` whether it takes the
/// colours of vertices. `None` where there are no triangles.
pub(super) fn model(
    primitive: &Primitive,
    (uv_set, colored): (u32, bool),
    name: &str,
    buffers: &Buffers,
    warnings: &mut Warnings,
) -> Result<Option<Arc<Model>>> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        warnings.add(format!("{name}: points and lines are not seen"));
        return Ok(None);
    }
    for (_, accessor) in primitive.attributes() {
        buffers.check(&accessor)?;
    }
    if let Some(accessor) = primitive.indices() {
        buffers.check(&accessor)?;
    }
    if primitive.morph_targets().len() > 0 {
        warnings.add(format!("{name}: morph targets mean nothing here"));
    }
    let reader = primitive.reader(|buffer| buffers.of(buffer));
    let fault = |message: String| Error::file(buffers.path, format!("{name}: {message}"));
    let positions: Vec<[f32; 3]> = match reader.read_positions() {
        Some(positions) => positions.collect(),
        None => return Err(fault("a primitive has no positions".into())),
    };
    let count = positions.len();
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..count as u32).collect(),
    };
    if let Some(wrong) = indices.iter().find(|&&index| index as usize >= count) {
        return Err(fault(format!("a triangle has the vertex {wrong}, of {count}")));
    }
    let triangles = triangles(&indices, mode);
    if triangles.is_empty() {
        return Ok(None);
    }
    let fits = |length: usize| length == count;
    let normals: Option<Vec<[f32; 3]>> =
        reader.read_normals().map(Iterator::collect).filter(|n: &Vec<_>| fits(n.len()));
    let uvs = reader.read_tex_coords(uv_set).map(|uvs| uvs.into_f32().map(|[u, v]| [u, 1.0 - v]).collect::<Vec<_>>());
    let colors = reader.read_colors(0).filter(|_| colored).map(|colors| colors.into_rgb_f32().collect::<Vec<_>>());
    let finite = |uvs: &Vec<[f32; 2]>| fits(uvs.len()) && uvs.iter().flatten().all(|x| x.is_finite());
    let clamped = |color: &[f32; 3]| color.map(|x| if x >= 0.0 { x.min(1.0) } else { 0.0 });
    let mesh = Mesh {
        materials: vec![0; triangles.len()],
        normals: normals.map(|values| with_directions(values, &triangles)),
        uvs: uvs.filter(finite).map(|values| Attribute { values, indices: Indices::OfPositions }),
        colors: colors
            .filter(|colors| fits(colors.len()))
            .map(|colors| MeshColors::OfVertices(colors.iter().map(clamped).collect())),
        positions,
        triangles,
    };
    Ok(Some(Arc::new(Model { mesh, material_names: vec![String::new()], ..Model::default() })))
}

fn triangles(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(k, w): (usize, &[u32])| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let rest = indices.get(1..).unwrap_or_default();
            rest.windows(2).map(|w| [indices[0], w[0], w[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

/// Triangles with a normal that has no direction go without.
fn with_directions(mut values: Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Attribute<[f32; 3]> {
    let usable = |n: &[f32; 3]| {
        let square = Vec3::from(*n).length_squared();
        square >= f32::MIN_POSITIVE && square.is_finite()
    };
    if values.iter().all(usable) {
        return Attribute { values, indices: Indices::OfPositions };
    }
    let there: Vec<bool> = values.iter().map(usable).collect();
    let own = |t: &[u32; 3]| if t.iter().all(|&i| there[i as usize]) { *t } else { [ABSENT; 3] };
    let indices = Indices::Own(triangles.iter().map(own).collect());
    values.iter_mut().zip(&there).filter(|(_, there)| !**there).for_each(|(n, _)| *n = [0.0, 0.0, 1.0]);
    Attribute { values, indices }
}
