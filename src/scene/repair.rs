//! What is to be done about values of a mesh that cannot be used, whatever format it comes in.

use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices};
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Replaces the positions with these indices by one that a triangle has, so that they have no part in what the mesh spans.
///
/// # Errors
/// The lowest of the indices that a triangle uses: such a triangle cannot be drawn.
pub(super) fn drop_positions(mesh: &mut Mesh, broken: &FxHashSet<u32>) -> Result<(), u32> {
    if let Some(used) = mesh.triangles.par_iter().flatten_iter().filter(|i| broken.contains(i)).min() {
        return Err(*used);
    }
    let harmless = mesh.triangles.first().map_or([0.0; 3], |t| mesh.positions[t[0] as usize]);
    broken.iter().for_each(|&i| mesh.positions[i as usize] = harmless);
    Ok(())
}

/// Takes the values with these indices away from all triangles that use one of them. Returns how many triangles then go without the
/// attribute.
pub(super) fn drop_values<T>(attribute: &mut Attribute<T>, triangles: &[[u32; 3]], broken: &FxHashSet<u32>) -> usize {
    let without = |t: &&mut [u32; 3]| t.iter().any(|i| broken.contains(i));
    own(&mut attribute.indices, triangles).par_iter_mut().filter(without).map(|t| *t = [ABSENT; 3]).count()
}

/// Whether no triangle has a value.
pub(super) fn is_unused<T>(attribute: &Attribute<T>, triangles: &[[u32; 3]]) -> bool {
    match &attribute.indices {
        Indices::OfPositions => triangles.is_empty(),
        Indices::Own(indices) => indices.par_iter().all(|t| *t == [ABSENT; 3]),
    }
}

/// The indices, which from here on can differ from those of positions.
fn own<'a>(indices: &'a mut Indices, triangles: &[[u32; 3]]) -> &'a mut Vec<[u32; 3]> {
    if *indices == Indices::OfPositions {
        *indices = Indices::Own(triangles.to_vec());
    }
    match indices {
        Indices::Own(own) => own,
        Indices::OfPositions => unreachable!("made its own above"),
    }
}

/// Puts vertices that no triangle uses to where one is, so that they have no part in what the model spans.
pub(super) fn drop_unused(mesh: &mut Mesh) {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    let Some(first) = used.iter().position(|&used| used) else { return };
    let harmless = mesh.positions[first];
    mesh.positions.iter_mut().zip(used).filter(|(_, used)| !used).for_each(|(p, _)| *p = harmless);
}
