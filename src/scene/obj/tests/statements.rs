//! One statement at a time.

use super::super::source::Source;
use super::{load_text, triples};
use crate::error::Error;
use crate::geometry::mesh::ABSENT;
use crate::scene::model::Model;
use crate::scene::obj::load;
use std::path::Path;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn obj(text: &str) -> Model {
    load_text(text, 1 << 20).unwrap()
}

/// A triangle, and more.
fn with_triangle(text: &str) -> Model {
    obj(&format!("{TRIANGLE}{text}"))
}

fn refused(text: impl AsRef<[u8]>) -> (usize, usize, String) {
    match load_text(text, 1 << 20) {
        Err(Error::Parse { line, column, message, .. }) => (line, column, message),
        other => panic!("{other:?}"),
    }
}

fn warnings(obj: &Model) -> Vec<(usize, &str)> {
    obj.warnings.iter().map(|w| (w.line, &*w.message)).collect()
}

#[test]
fn nothing_gives_an_empty_mesh() {
    for text in ["", "\n", "# only a comment", "v 0 0 0\n", "f", "o name\ng\ns off\n"] {
        let obj = obj(text);
        assert!(obj.mesh.triangles.is_empty() && obj.mesh.materials.is_empty(), "{text}");
        assert!(obj.material_names.is_empty(), "{text}");
    }
}

#[test]
fn vertices_take_weights_and_colours() {
    let obj = obj("v 1 2 3 0.5\nv 4 5 6 1 0 0\n\tv\t7 8e0 +9. # note\nf 1 2 3# note\n");
    assert_eq!(obj.mesh.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
    assert_eq!(obj.mesh.triangles, [[0, 1, 2]]);
    assert!(obj.mesh.uvs.is_none() && obj.mesh.normals.is_none());
}

#[test]
fn texture_coordinates_have_one_to_three_numbers() {
    let obj = with_triangle("vt 0.1\nvt 0.2 0.3\nvt 0.4 0.5 0.6\nf 1/1 2/2 3/3\n");
    assert_eq!(obj.mesh.uvs.unwrap().values, [[0.1, 0.0], [0.2, 0.3], [0.4, 0.5]]);
}

#[test]
fn corners_may_leave_attributes_out() {
    let obj = with_triangle(
        "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 3//1\nf 1/1/ 2/1 3/1\nf 1 2/1 3//1\nf 1/ 2// 3\n",
    );
    let (some, none) = ([0; 3], [ABSENT; 3]);
    assert_eq!(triples(obj.mesh.uvs.as_ref().unwrap(), &obj.mesh.triangles), [some, none, some, none, none]);
    assert_eq!(triples(obj.mesh.normals.as_ref().unwrap(), &obj.mesh.triangles), [some, some, none, none, none]);
}

#[test]
fn attributes_that_no_face_has_are_none() {
    let obj = with_triangle("vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2 3\n");
    assert!(obj.mesh.uvs.is_none() && obj.mesh.normals.is_none());
}

#[test]
fn relative_indices_count_back_from_their_line() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf -3/-1 -2/-1 -1/-1\nv 5 5 5\nvt 1 1\nf -3/-2 -2/1 -1/2\n";
    for block in [1, 30, 1000] {
        let obj = load_text(text, block).unwrap();
        assert_eq!(obj.mesh.triangles, [[0, 1, 2], [1, 2, 3]]);
        assert_eq!(triples(obj.mesh.uvs.as_ref().unwrap(), &obj.mesh.triangles), [[0, 0, 0], [0, 0, 1]]);
    }
}

#[test]
fn faces_may_precede_their_vertices() {
    assert_eq!(obj(&format!("f 3 2 1\n{TRIANGLE}")).mesh.triangles, [[2, 1, 0]]);
}

#[test]
fn lines_continue_after_a_backslash_but_not_in_comments() {
    let obj = obj("v 0 \\\n 0 0\nv 1 0\\\r\n0\n# C:\\folder\\\nv 0 1 0 # C:\\\nf 1 2\\\n 3\n");
    assert_eq!(obj.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(obj.mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn line_ends_and_byte_order_marks_of_all_systems() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("\u{feff}{TRIANGLE}usemtl a b \nf 1 2 3\n").replace('\n', end);
        let obj = obj(&text);
        assert_eq!(obj.mesh.triangles, [[0, 1, 2]], "{end:?}");
        assert_eq!(obj.material_names, ["a b"], "{end:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.obj");
    std::fs::write(&path, b"\xff\xfev\x00 \x00").unwrap();
    assert!(load(&path).unwrap_err().to_string().contains("UTF-16"));
}

#[test]
fn names_are_lossy_and_keep_blanks_and_number_signs() {
    let names = ["Material #25", "two  words", "caf\u{fffd}", ""];
    let text = b"v 0 0 0\nusemtl Material #25\nf 1 1 1\nusemtl two  words\t# note\nf 1 1 1\nusemtl caf\xe9\nf 1 1 1\nusemtl\nf 1 1 1\nusemtl Material #25\nf 1 1 1\n";
    let obj = load_text(text, 1 << 20).unwrap();
    assert_eq!(obj.material_names, names);
    assert_eq!(obj.mesh.materials, [0, 1, 2, 3, 0]);
}

#[test]
fn only_used_names_are_listed() {
    let obj = with_triangle("f 1 2 3\nusemtl unused\nusemtl b\nf 1 2 3 1\nusemtl a\nf 1 2 3\nusemtl c\n");
    assert_eq!(obj.material_names, ["", "b", "a"]);
    assert_eq!(obj.mesh.materials, [0, 1, 1, 2]);
    assert_eq!(warnings(&obj), [(6, "2 material names are in no MTL file: `a`, `b`")]);
}

#[test]
fn what_is_left_out_is_counted_once() {
    let obj = with_triangle("vp 1\nl 1 2\nvp 2\np 1\nf 1 2\nf 1 2 3\nf 1\nf\nbevel on\n");
    assert_eq!(
        warnings(&obj),
        [
            (4, "statement `vp` is ignored (2 times, here first)"),
            (5, "points and lines are left out (2 times, here first)"),
            (8, "a face with fewer than three corners is left out (3 times, here first)"),
            (12, "statement `bevel` is ignored (1 times, here first)"),
        ]
    );
    assert_eq!(obj.mesh.triangles.len(), 1);
}

#[test]
fn warnings_are_few_however_odd_the_file() {
    let text: String = (0..500).map(|i| format!("odd{i} 1\n")).collect();
    for block in [10, 1 << 20] {
        assert!(load_text(&text, block).unwrap().warnings.len() <= 17);
    }
}

#[test]
fn faults_name_line_and_column() {
    let at = |text: &str| {
        let (line, column, _) = refused(format!("{TRIANGLE}{text}"));
        (line, column)
    };
    assert_eq!(at("f 1 2 0\n"), (4, 7));
    assert_eq!(at("f 1 2 4\n"), (4, 7));
    assert_eq!(at("\n# \\\n  f 1 2 \\\n -4\n"), (7, 2));
    assert_eq!(at("f 1 2 9999999999999999999999\n"), (4, 7));
    assert_eq!(at("f 1 2 -9223372036854775808\n"), (4, 7));
    assert_eq!(at("f 1 2 x"), (4, 7));
    assert_eq!(at("f 1 2 3.0"), (4, 7));
    assert_eq!(at("f 1/1/1/1 2 3"), (4, 3));
    assert_eq!(at("vt 0\nf 1/2 2 3"), (5, 3));
    assert_eq!(at("vn 0 0 1\nf 1//1 2//2 3"), (5, 8));
    assert_eq!(at("v 0 0\n"), (4, 6));
    assert_eq!(at("v 0 0 zero\n"), (4, 7));
    assert_eq!(at("v 0 0 0x1\n"), (4, 7));
    assert_eq!(at("v 0 0 0 red\n"), (4, 9));
    assert_eq!(at("vt\n"), (4, 3));
    assert_eq!(at("vn 1 2\n"), (4, 7));
}

#[test]
fn the_first_fault_counts_whatever_the_blocks() {
    let text = format!("{TRIANGLE}f 1 2 7\nf 1 2 8\nf 1 2 9\n");
    for block in [1, 5, 1 << 20] {
        let error = load_text(&text, block).unwrap_err();
        assert_eq!(error.to_string(), "test.obj:4:7: vertex index 7 is out of range: the file has 3");
    }
}

#[test]
fn faces_need_finite_vertices() {
    for bad in ["nan", "inf", "-Infinity", "1e39", "2e12", "1.#IND", "-1.#INF", "1.#QNAN"] {
        let text = format!("{TRIANGLE}v 0 {bad} 0\n");
        let (line, column, message) = refused(format!("{text}f 1 2 4\n"));
        assert_eq!((line, column), (4, 1), "{bad}");
        assert!(message.starts_with("vertex 4 is not finite"), "{message}");
        let unused = obj(&format!("{text}f 2 1 3\n"));
        assert_eq!(unused.mesh.positions[3], unused.mesh.positions[1], "{bad}");
        assert_eq!(unused.warnings[0].line, 4);
    }
    assert_eq!(obj("v 1e12 0 0\nf 1 1 1\n").mesh.positions, [[1e12, 0.0, 0.0]]);
}

#[test]
fn triangles_go_without_broken_attributes() {
    for bad in ["vn 0 0 0", "vn nan 0 1", "vn 1e30 0 0", "vn 1e-30 0 0"] {
        let obj = with_triangle(&format!("vn 0 0 1\n{bad}\nf 1//1 2//1 3//1\nf 1//1 2//1 3//2\n"));
        assert_eq!(triples(obj.mesh.normals.as_ref().unwrap(), &obj.mesh.triangles), [[0; 3], [ABSENT; 3]], "{bad}");
        assert_eq!(warnings(&obj), [(5, "1 normals have no direction; 1 triangles go without")]);
    }
    let obj = with_triangle("vt nan\nf 1/1 2/1 3/1\n");
    assert!(obj.mesh.uvs.is_none());
    assert_eq!(warnings(&obj), [(4, "1 texture coordinates are not finite; 1 triangles go without")]);
}

#[test]
fn a_missing_library_is_a_warning() {
    let obj = with_triangle("mtllib /no/such.mtl\nf 1 2 3\n");
    assert_eq!(obj.warnings.len(), 1);
    assert!(obj.warnings[0].to_string().starts_with("test.obj:4: material library `/no/such.mtl`: "));
}

#[test]
fn a_missing_or_unreadable_file_is_an_error() {
    assert!(matches!(load(Path::new("no such file.obj")), Err(Error::Io { .. })));
    assert!(matches!(load(tempfile::tempdir().unwrap().path()), Err(Error::Io { .. })));
}

#[test]
fn blocks_are_whole_logical_lines() {
    let text = "v 0 \\\n 0 0\r\nv 1 \\\r\n0 0\n\n# end \\\nf 1 1 1";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lines.obj");
    std::fs::write(&path, text).unwrap();
    for source in [Source::open(&path).unwrap(), Source::memory(&path, text.into())] {
        let blocks = source.blocks(1).unwrap();
        let parts: Vec<&str> = blocks.iter().map(|b| &text[b.start as usize..b.end as usize]).collect();
        let expected = ["v 0 \\\n 0 0\r\n", "v 1 \\\r\n0 0\n", "\n", "# end \\\nf 1 1 1"];
        assert_eq!(parts, expected);
    }
}

#[test]
fn long_lines_and_files_load_from_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.obj");
    let blanks = " ".repeat(20_000);
    let text = format!("v 0 0{blanks}0\nv 1 0 0\nv 0 1{blanks}0\nf 1 2{blanks}3\n");
    std::fs::write(&path, &text).unwrap();
    let source = Source::open(&path).unwrap();
    for block in [1, 3000, 1 << 20] {
        let obj = super::super::load_in_blocks(&source, block).unwrap();
        assert_eq!(obj.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(obj.mesh.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn a_file_that_shrinks_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shrinks.obj");
    std::fs::write(&path, format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    let source = Source::open(&path).unwrap();
    std::fs::write(&path, TRIANGLE).unwrap();
    assert!(matches!(super::super::load_in_blocks(&source, 1 << 20), Err(Error::Io { .. })));
}

#[test]
fn objects_are_named_by_o_and_else_by_g() {
    let named = |parts: &[(u32, &str)]| parts.iter().map(|(t, name)| (*t, name.to_string())).collect::<Vec<_>>();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let cases = [
        ("f 1 2 3\no chair leg # note\nf 1 2 3 4\ng back\no\nf 1 2 3\n", named(&[(1, "chair leg"), (3, "")])),
        ("g a b\nf 1 2 3\ng c\ng d\nf 1 2 3 4\ng d\nf 1 2 3\n", named(&[(0, "a b"), (1, "d")])),
        ("f 1 2 3\no last\n", Vec::new()),
    ];
    for (text, wanted) in cases {
        for block in [1 << 20, 1, 9, 17] {
            let found = load_text(format!("{square}{text}"), block).unwrap().parts;
            assert_eq!(found, wanted, "{text:?} in blocks of {block}");
        }
    }
}
