//! Files from other loaders' test suites, against what tinyobjloader reads from them.

use super::super::lines;
use super::super::scan::{self, Census, Smoothing};
use super::scenes;
use crate::error::Error;
use crate::scene::model::Model;
use crate::scene::obj::load;
use std::path::Path;

/// Files that are refused, and the line named. tinyobjloader refuses the first three too, warns of indices out of range
/// without leaving out the corner, and takes `nan` for a coordinate, with which a triangle would vanish unseen.
const REFUSED: [(&str, usize); 11] = [
    ("./tinyobjloader/invalid-relative-texture-index.obj", 2),
    ("./tinyobjloader/invalid-relative-vertex-index.obj", 1),
    ("./tinyobjloader/issue-140-zero-face-idx.obj", 16),
    ("./tinyobjloader/test-nan.obj", 12),
    ("./tinyobjloader/catmark_torus_creases0.obj", 62),
    ("./tinyobjloader/smoothing-group-two-squares.obj", 21),
    ("./tobj/invalid_index.obj", 12),
    ("./obj2gltf/box-incomplete-attributes/box-incomplete-normals.obj", 32),
    ("./obj2gltf/box-incomplete-attributes/box-incomplete-positions.obj", 29),
    ("./obj2gltf/box-incomplete-attributes/box-incomplete-uvs.obj", 17),
    ("./obj2gltf/box-missing-attributes/box-missing-attributes.obj", 15),
];

/// Files whose libraries hold more for us: materials here, and why.
const MORE_MATERIALS: [(&str, usize); 3] = [
    // Both libraries of two statements count.
    ("./obj2gltf/box-mtllib/box-mtllib.obj", 3),
    // Blanks in file names.
    ("./obj2gltf/box-mtllib-spaces/box mtllib.obj", 3),
    // A backslash between folders.
    ("./obj2gltf/box-windows-paths/box-windows-paths.obj", 1),
];

fn lookup(table: &[(&str, usize)], file: &str) -> Option<usize> {
    table.iter().find(|(name, _)| *name == file).map(|&(_, n)| n)
}

#[test]
fn fixtures_load_as_expected() {
    let Some(folder) = scenes("fixtures_load_as_expected").map(|scenes| scenes.join("nasty")) else {
        return;
    };
    let expected = std::fs::read_to_string(folder.join("EXPECTED.tsv")).unwrap();
    let mut rows = 0;
    for row in expected.lines().skip(1).map(|line| line.split('\t').collect::<Vec<_>>()) {
        rows += 1;
        let file = row[0];
        match (load(&folder.join(file)), lookup(&REFUSED, file)) {
            (Err(Error::Parse { line, .. }), Some(wanted)) => assert_eq!(line, wanted, "{file}"),
            (Ok(obj), None) => compare(&obj, &folder.join(file), &row),
            (result, _) => panic!("{file}: {:?}", result.map(|obj| obj.warnings)),
        }
    }
    assert!(rows > 90, "only {rows} fixtures");
}

fn compare(obj: &Model, path: &Path, row: &[&str]) {
    let file = row[0];
    let number = |column: usize| row[column].parse::<usize>().unwrap();
    let census = census(path);
    assert_eq!(row[1], "1", "{file} was meant to be refused");
    assert_eq!(obj.mesh.positions.len(), number(2), "{file}: v");
    assert_eq!(census.counts.uvs, number(3), "{file}: vt");
    assert_eq!(census.counts.normals, number(4), "{file}: vn");
    assert_eq!(obj.mesh.triangles.len(), number(7), "{file}: triangles");
    assert_eq!(obj.mesh.materials.len(), number(7), "{file}: materials of triangles");
    assert_eq!(census.strokes.is_some(), number(9) + number(10) > 0, "{file}: lines, points");
    let materials = lookup(&MORE_MATERIALS, file).unwrap_or(number(11));
    assert_eq!(obj.materials.len(), materials, "{file}: materials");
    let uvs = obj.mesh.uvs.as_ref();
    assert!(uvs.is_none_or(|uvs| uvs.values.len() == number(3)), "{file}: uvs");
    let normals = obj.mesh.normals.as_ref();
    // smoothing groups add some
    let smooth = census.smoothing.iter().any(|(_, s)| matches!(s, Smoothing::Group(1..)));
    let fits = |count: usize| count == number(4) || smooth && count > number(4);
    assert!(normals.is_none_or(|normals| fits(normals.values.len())), "{file}: normals");
}

fn census(path: &Path) -> Census {
    let mut text = std::fs::read(path).unwrap();
    lines::join_continuations(&mut text);
    scan::scan(&text)
}
