//! Corner by corner against tobj, on every file that it can read.

use super::scenes;
use crate::geometry::mesh::Attribute;
use crate::scene::obj::{Obj, load};
use std::path::{Path, PathBuf};

#[derive(Default)]
struct Tally {
    files: usize,
    triangles: usize,
    quads: usize,
    others: usize,
    uvs: usize,
    normals: usize,
    /// Models where some faces lack an attribute: tobj's indices do not tell which.
    misaligned: usize,
}

#[test]
fn corners_agree_with_tobj() {
    let Some(folder) = scenes("corners_agree_with_tobj") else { return };
    let mut tally = Tally::default();
    for path in obj_files(&folder) {
        let Some(models) = tobj_models(&path) else { continue };
        match load(&path) {
            Ok(obj) => compare(&obj, &models, &mut tally, &path),
            Err(error) => panic!("tobj reads {}: {error}", path.display()),
        }
    }
    let Tally { files, triangles, quads, others, uvs, normals, misaligned } = tally;
    eprintln!(
        "{files} files, {triangles} triangles, {quads} convex quads, {others} other faces, {uvs} faces with uvs, {normals} with normals, {misaligned} misaligned"
    );
    assert!(files > 60 && triangles > 100_000 && quads > 50_000 && others > 100);
    assert!(uvs > 100_000 && normals > 100_000);
}

fn obj_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.append(&mut obj_files(&path));
        } else if path.extension().is_some_and(|e| e == "obj") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// `None` where tobj refuses or panics.
fn tobj_models(path: &Path) -> Option<Vec<tobj::Model>> {
    let options =
        tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let loaded = std::panic::catch_unwind(|| {
        tobj::load_obj_buf(
            &mut std::io::BufReader::new(std::fs::File::open(path).ok()?),
            &options,
            |_| Err(tobj::LoadError::OpenFileFailed),
        )
        .ok()
    });
    loaded.ok().flatten().map(|(models, _)| models)
}

fn compare(obj: &Obj, models: &[tobj::Model], tally: &mut Tally, path: &Path) {
    tally.files += 1;
    let mut triangle = 0;
    for mesh in models.iter().map(|model| &model.mesh) {
        let triples = vec![3; mesh.indices.len() / 3];
        let arities = if mesh.face_arities.is_empty() { &triples } else { &mesh.face_arities };
        let uvs = aligned(&mesh.texcoord_indices, mesh, tally);
        let normals = aligned(&mesh.normal_indices, mesh, tally);
        let mut corner = 0;
        for &arity in arities {
            let arity = arity as usize;
            let face = corner..corner + arity;
            let at = format!("{}: triangle {triangle}", path.display());
            let points: Vec<[f32; 3]> =
                mesh.indices[face.clone()].iter().map(|&i| value(&mesh.positions, i)).collect();
            let fan = arity == 3 || arity == 4 && is_convex(&points);
            for k in 0..arity - 2 {
                let ours = obj.mesh.triangles[triangle + k].map(|i| obj.mesh.positions[i as usize]);
                if fan {
                    assert_eq!(ours, [points[0], points[k + 1], points[k + 2]], "{at}");
                } else {
                    assert!(ours.iter().all(|p| points.contains(p)), "{at}");
                }
            }
            if fan {
                tally.uvs +=
                    compare_attribute(&obj.mesh.uvs, triangle, uvs, &mesh.texcoords, &face, &at);
                tally.normals += compare_attribute(
                    &obj.mesh.normals,
                    triangle,
                    normals,
                    &mesh.normals,
                    &face,
                    &at,
                );
            }
            *match (arity, fan) {
                (3, _) => &mut tally.triangles,
                (_, true) => &mut tally.quads,
                _ => &mut tally.others,
            } += 1;
            triangle += arity - 2;
            corner += arity;
        }
    }
    assert_eq!(triangle, obj.mesh.triangles.len(), "{}", path.display());
}

/// What tobj's indices of an attribute say: they are meaningful if all faces have it, or none.
fn aligned<'a>(indices: &'a [u32], mesh: &tobj::Mesh, tally: &mut Tally) -> Option<&'a [u32]> {
    let aligned = indices.is_empty() || indices.len() == mesh.indices.len();
    tally.misaligned += usize::from(!aligned);
    aligned.then_some(indices)
}

/// Compares a fan's corners; returns whether there was anything to compare.
fn compare_attribute<const N: usize>(
    ours: &Option<Attribute<[f32; N]>>,
    triangle: usize,
    indices: Option<&[u32]>,
    values: &[f32],
    face: &std::ops::Range<usize>,
    at: &str,
) -> usize {
    let Some(indices) = indices else { return 0 };
    let corners = |t: usize| ours.as_ref().and_then(|attribute| attribute.corners(t));
    for k in 0..face.len() - 2 {
        let theirs =
            [0, k + 1, k + 2].map(|c| indices.get(face.start + c).map(|&i| value(values, i)));
        match corners(triangle + k) {
            Some(found) => assert_eq!(found.map(Some), theirs, "{at}"),
            // A normal of length zero is taken away.
            None => assert!(theirs.iter().any(|c| c.is_none_or(|c| c == [0.0; N])), "{at}"),
        }
    }
    usize::from(!indices.is_empty())
}

fn value<const N: usize>(values: &[f32], index: u32) -> [f32; N] {
    std::array::from_fn(|k| values[N * index as usize + k])
}

/// Clearly convex: all turns go the same way as their sum.
fn is_convex(points: &[[f32; 3]]) -> bool {
    let points: Vec<glam::DVec3> = points.iter().map(|&p| glam::Vec3::from(p).as_dvec3()).collect();
    let n = points.len();
    let turns: Vec<_> = (0..n)
        .map(|i| (points[(i + 1) % n] - points[i]).cross(points[(i + 2) % n] - points[(i + 1) % n]))
        .collect();
    let normal = turns.iter().sum::<glam::DVec3>();
    turns.iter().all(|turn| turn.dot(normal) > 1e-6 * normal.length_squared())
}
