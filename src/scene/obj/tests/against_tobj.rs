//! Corner by corner against tobj, on every file that it can read.

use super::scenes;
use crate::geometry::mesh::Attribute;
use crate::lab::generate::large;
use crate::scene::model::Model;
use crate::scene::obj::load;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Faces there have indices of attributes that the file has none of, which tobj passes over in silence.
const REFUSED: [&str; 3] =
    ["box-missing-attributes.obj", "catmark_torus_creases0.obj", "smoothing-group-two-squares.obj"];

/// Files that tobj misreads. The fourth number of a vertex is the weight of a rational curve's control point (OBJ
/// specification, 1995), but tobj divides by it. An `l` of more than two vertices is a line, but tobj makes it a face.
const MISREAD: [&str; 2] = ["cube-vertex-w-component.obj", "line-prim.obj"];

#[derive(Debug, Default)]
struct Tally {
    files: usize,
    triangles: usize,
    quads: usize,
    others: usize,
    /// Triangles with texture coordinates, and with normals.
    attributes: [usize; 2],
    bare: [usize; 2],
}

/// A face as tobj reads it.
struct Face {
    points: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Whether the corners have texture coordinates, normals; `None` if only some do. tobj makes up what is missing.
    written: [Option<bool>; 2],
    /// Whether the file has smoothing groups, which tobj does not read: faces without normals may get some.
    smooth: bool,
}

#[test]
fn corners_agree_with_tobj() {
    let Some(folder) = scenes("corners_agree_with_tobj") else { return };
    let mut tally = Tally::default();
    for path in obj_files(&folder) {
        let Some(models) = tobj_models(&path) else {
            continue;
        };
        if MISREAD.iter().any(|name| path.ends_with(name)) {
            continue;
        }
        if REFUSED.iter().any(|name| path.ends_with(name)) {
            assert!(load(&path).is_err(), "{}", path.display());
            continue;
        }
        let obj = load(&path).unwrap_or_else(|e| panic!("tobj reads it: {e}"));
        compare_all(&obj, &faces(&models, &path), &mut tally, &path);
    }
    eprintln!("{tally:?}");
    assert!(tally.files > 60 && tally.triangles > 100_000 && tally.quads > 50_000);
    assert!(tally.others > 100);
    assert!(tally.attributes.iter().all(|&n| n > 100_000) && tally.bare.iter().all(|&n| n > 1000));
}

/// Generated scenes have many materials, texture coordinates and normals, and more than one block of text.
#[test]
fn generated_scenes_agree_with_tobj() {
    for (name, normals) in [("city", 0), ("terrain", 90_000), ("forest", 8_000)] {
        let folder = tempfile::tempdir().unwrap();
        large::generate(name, 100_000, folder.path()).unwrap();
        let mut tally = Tally::default();
        for path in obj_files(folder.path()) {
            let models = tobj_models(&path).expect("tobj reads it");
            compare_all(&load(&path).unwrap(), &faces(&models, &path), &mut tally, &path);
        }
        let everywhere = if name == "forest" { 10_000 } else { 90_000 };
        assert!(tally.attributes[0] > everywhere && tally.attributes[1] >= normals, "{name}: {tally:?}");
    }
}

/// Compares all faces of a file.
fn compare_all(obj: &Model, faces: &[Face], tally: &mut Tally, path: &Path) {
    tally.files += 1;
    let mut triangle = 0;
    for face in faces {
        let at = format!("{}: triangle {triangle}", path.display());
        triangle += compare(obj, face, triangle, tally, &at);
    }
    assert_eq!(triangle, obj.mesh.triangles.len(), "{}", path.display());
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
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let loaded = std::panic::catch_unwind(|| {
        tobj::load_obj_buf(&mut std::io::BufReader::new(std::fs::File::open(path).ok()?), &options, |_| {
            Err(tobj::LoadError::OpenFileFailed)
        })
        .ok()
    });
    loaded.ok().flatten().map(|(models, _)| models)
}

/// All faces in the order of the file.
fn faces(models: &[tobj::Model], path: &Path) -> Vec<Face> {
    let text = text(path);
    let mut written = written_attributes(&text).into_iter();
    let smooth = text.lines().any(|line| line.starts_with("s ") && !["s off", "s 0"].contains(&line.trim()));
    let mut faces = Vec::new();
    for mesh in models.iter().map(|model| &model.mesh) {
        let triples = vec![3; mesh.indices.len() / 3];
        let arities = if mesh.face_arities.is_empty() { &triples } else { &mesh.face_arities };
        let mut corner = 0;
        for &arity in arities {
            let corners = corner..corner + arity as usize;
            corner = corners.end;
            faces.push(Face {
                points: values(&mesh.positions, &mesh.indices, &corners),
                uvs: values(&mesh.texcoords, &mesh.texcoord_indices, &corners),
                normals: values(&mesh.normals, &mesh.normal_indices, &corners),
                written: written.next().unwrap_or_else(|| panic!("{}: fewer faces in the text", path.display())),
                smooth,
            });
        }
    }
    faces
}

fn values<const N: usize>(values: &[f32], indices: &[u32], corners: &Range<usize>) -> Vec<[f32; N]> {
    let found = indices.get(corners.clone()).unwrap_or_default();
    found.iter().map(|&i| std::array::from_fn(|k| values[N * i as usize + k])).collect()
}

fn text(path: &Path) -> String {
    String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned()
}

/// Which attributes the corners of each face have, from the text alone.
fn written_attributes(text: &str) -> Vec<[Option<bool>; 2]> {
    let words = |line: &str| line.split_whitespace().map(str::to_string).collect();
    let faces = text.lines().map(words).filter(|words: &Vec<String>| words.len() > 3 && words[0] == "f");
    let has = |corner: &String, k: usize| corner.split('/').nth(k).is_some_and(|i| !i.is_empty());
    let attribute = |face: &[String], k: usize| match face.iter().filter(|c| has(c, k)).count() {
        0 => Some(false),
        n if n == face.len() => Some(true),
        _ => None,
    };
    faces.map(|face| [1, 2].map(|k| attribute(&face[1..], k))).collect()
}

/// As it is in the file.
fn position(obj: &Model, index: u32) -> [f32; 3] {
    let moved = glam::Vec3::from(obj.mesh.positions[index as usize]).as_dvec3() + obj.origin;
    moved.as_vec3().to_array()
}

/// Compares a face with the triangles from `triangle` on; returns how many it has become.
fn compare(obj: &Model, face: &Face, triangle: usize, tally: &mut Tally, at: &str) -> usize {
    let points = &face.points;
    let count = points.len() - 2;
    let fan = count == 1 || count == 2 && is_convex(points);
    let kind = if count == 1 { &mut tally.triangles } else { &mut tally.quads };
    *(if fan { kind } else { &mut tally.others }) += 1;
    for k in 0..count {
        let ours = obj.mesh.triangles[triangle + k].map(|i| position(obj, i));
        if !fan {
            assert!(ours.iter().all(|p| points.contains(p)), "{at}");
            continue;
        }
        assert_eq!(ours, [points[0], points[k + 1], points[k + 2]], "{at}");
        let uvs =
            compare_attribute(&obj.mesh.uvs, &obj.mesh.triangles, triangle + k, &face.uvs, k, face.written[0], at);
        let smoothed = face.smooth && face.written[1] != Some(true);
        let normals = !smoothed
            && compare_attribute(
                &obj.mesh.normals,
                &obj.mesh.triangles,
                triangle + k,
                &face.normals,
                k,
                face.written[1],
                at,
            );
        for (i, found) in [uvs, normals].into_iter().enumerate() {
            *(if found { &mut tally.attributes[i] } else { &mut tally.bare[i] }) += 1;
        }
    }
    count
}

/// Compares triangle `k` of a fan; returns whether it has the attribute.
fn compare_attribute<const N: usize>(
    ours: &Option<Attribute<[f32; N]>>,
    triangles: &[[u32; 3]],
    triangle: usize,
    theirs: &[[f32; N]],
    k: usize,
    written: Option<bool>,
    at: &str,
) -> bool {
    let ours = ours.as_ref().and_then(|attribute| attribute.corners(triangles, triangle));
    match ours {
        Some(found) => assert_eq!(found, [0, k + 1, k + 2].map(|c| theirs[c]), "{at}"),
        // A normal of length zero is taken away.
        None => assert!(written != Some(true) || theirs.contains(&[0.0; N]), "{at}"),
    }
    assert!(ours.is_none() || written != Some(false), "{at}: made up");
    ours.is_some()
}

/// Clearly convex: all turns go the same way as their sum.
fn is_convex(points: &[[f32; 3]]) -> bool {
    let points: Vec<glam::DVec3> = points.iter().map(|&p| glam::Vec3::from(p).as_dvec3()).collect();
    let n = points.len();
    let turns: Vec<_> =
        (0..n).map(|i| (points[(i + 1) % n] - points[i]).cross(points[(i + 2) % n] - points[(i + 1) % n])).collect();
    let normal = turns.iter().sum::<glam::DVec3>();
    turns.iter().all(|turn| turn.dot(normal) > 1e-6 * normal.length_squared())
}
