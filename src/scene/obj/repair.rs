//! What is to be done about values that are not finite.

use super::attributes::{Broken, BrokenValues};
use super::report::Reporter;
use super::source::{Failure, Fault};
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices};
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Takes broken normals and texture coordinates away from their triangles, and drops an attribute that no triangle has.
///
/// # Errors
/// A face at a broken position, named by the position's line: the face cannot be drawn, and Embree would not say so.
pub(super) fn repair(mesh: &mut Mesh, broken: &BrokenValues, reporter: &mut Reporter) -> Result<(), Failure> {
    repair_positions(mesh, &broken.positions, reporter)?;
    let triangles = &mesh.triangles;
    repair_attribute(&mut mesh.uvs, triangles, &broken.uvs, "texture coordinates are not finite", reporter);
    repair_attribute(&mut mesh.normals, triangles, &broken.normals, "normals have no direction", reporter);
    Ok(())
}

fn repair_positions(mesh: &mut Mesh, broken: &[Broken], reporter: &mut Reporter) -> Result<(), Failure> {
    let Some(&(_, first_at)) = broken.first() else { return Ok(()) };
    let indices: FxHashSet<u32> = broken.iter().map(|&(i, _)| i).collect();
    let used = mesh.triangles.par_iter().flatten_iter().filter(|i| indices.contains(i)).min();
    if let Some(used) = used {
        let at = broken.iter().find(|(i, _)| i == used).map_or(first_at, |&(_, at)| at);
        let message = format!("vertex {} is not finite or beyond 1e12, and a face uses it", used + 1);
        return Err(Failure::Fault(Fault { at, message }));
    }
    // Nothing refers to them: a value that another vertex has keeps bounds over all positions right.
    let harmless = mesh.triangles.first().map_or([0.0; 3], |t| mesh.positions[t[0] as usize]);
    broken.iter().for_each(|&(i, _)| mesh.positions[i as usize] = harmless);
    let count = broken.len();
    reporter.warn(first_at, format!("{count} vertices are not finite or beyond 1e12, but no face uses them"));
    Ok(())
}

fn repair_attribute<T: Send>(
    attribute: &mut Option<Attribute<T>>,
    triangles: &[[u32; 3]],
    broken: &[Broken],
    what: &str,
    reporter: &mut Reporter,
) {
    let Some(found) = attribute else { return };
    if let Some(&(_, at)) = broken.first() {
        let indices: FxHashSet<u32> = broken.iter().map(|&(i, _)| i).collect();
        let without = |t: &&mut [u32; 3]| t.iter().any(|i| indices.contains(i));
        let without = own(&mut found.indices, triangles).par_iter_mut().filter(without);
        let (count, triangles) = (broken.len(), without.map(|t| *t = [ABSENT; 3]).count());
        reporter.warn(at, format!("{count} {what}; {triangles} triangles go without"));
    }
    let none = match &found.indices {
        Indices::OfPositions => triangles.is_empty(),
        Indices::Own(indices) => indices.par_iter().all(|t| *t == [ABSENT; 3]),
    };
    if none {
        *attribute = None;
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
