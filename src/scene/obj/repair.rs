//! What is to be done about values that are not finite.

use super::attributes::{Broken, BrokenValues};
use super::report::Reporter;
use super::source::{Failure, Fault};
use crate::geometry::Mesh;
use crate::geometry::mesh::Attribute;
use crate::scene::repair;
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
    if let Err(used) = repair::drop_positions(mesh, &indices(broken)) {
        let at = broken.iter().find(|(i, _)| *i == used).map_or(first_at, |&(_, at)| at);
        let message = format!("vertex {} is not finite or beyond 1e12, and a face uses it", used + 1);
        return Err(Failure::Fault(Fault { at, message }));
    }
    let count = broken.len();
    reporter.warn(first_at, format!("{count} vertices are not finite or beyond 1e12, but no face uses them"));
    Ok(())
}

fn repair_attribute<T>(
    attribute: &mut Option<Attribute<T>>,
    triangles: &[[u32; 3]],
    broken: &[Broken],
    what: &str,
    reporter: &mut Reporter,
) {
    let Some(found) = attribute else { return };
    if let Some(&(_, at)) = broken.first() {
        let (count, triangles) = (broken.len(), repair::drop_values(found, triangles, &indices(broken)));
        reporter.warn(at, format!("{count} {what}; {triangles} triangles go without"));
    }
    if repair::is_unused(found, triangles) {
        *attribute = None;
    }
}

fn indices(broken: &[Broken]) -> FxHashSet<u32> {
    broken.iter().map(|&(i, _)| i).collect()
}
