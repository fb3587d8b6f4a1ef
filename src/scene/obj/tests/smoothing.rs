//! Normals of smoothing groups.

use super::{load_text, triples};
use crate::geometry::mesh::{ABSENT, Indices};
use crate::scene::model::Model;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

fn obj(text: &str) -> Model {
    let whole = load_text(text, 1 << 20).unwrap();
    let blocks = load_text(text, 20).unwrap();
    assert_eq!(format!("{:?}", whole.mesh), format!("{:?}", blocks.mesh), "the blocks decide nothing");
    whole
}

/// The normals at a triangle's corners, if it has them.
fn normals(obj: &Model, triangle: usize) -> Option<[Vec3; 3]> {
    let corners = obj.mesh.normals.as_ref()?.corners(&obj.mesh.triangles, triangle)?;
    Some(corners.map(Vec3::from))
}

/// A ball of radius 1 without normals, of rings of quadrilaterals. Every ring has a vertex twice at its seam, poles are `columns` vertices.
fn ball(columns: usize, header: &str) -> String {
    let rows = columns / 2;
    let mut text = String::new();
    for (i, j) in (0..=rows).flat_map(|i| (0..=columns).map(move |j| (i, j))) {
        let (theta, phi) = (i as f64 / rows as f64 * PI, (j % columns) as f64 / columns as f64 * TAU);
        let _ = writeln!(text, "v {:.6} {:.6} {:.6}", theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
    }
    text += header;
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let at = |i: usize, j: usize| i * (columns + 1) + j + 1;
        let _ = writeln!(text, "f {} {} {} {}", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
    text
}

#[test]
fn a_ball_in_one_group_has_the_normals_of_a_ball() {
    let obj = obj(&ball(24, "s 1\n"));
    let normals = obj.mesh.normals.as_ref().unwrap();
    assert_eq!(normals.indices, Indices::OfPositions, "one normal for each vertex");
    for (p, n) in obj.mesh.positions.iter().zip(&normals.values) {
        let cosine = Vec3::from(*p).normalize().dot(Vec3::from(*n));
        assert!(cosine > 1f32.to_radians().cos(), "{p:?}: {n:?}");
    }
}

#[test]
fn no_group_is_flat() {
    for header in ["", "s off\n", "s 0\n", "s\n", "s 1\ns off\n", "s 3\no name\ns 0\n"] {
        assert!(obj(&ball(8, header)).mesh.normals.is_none(), "{header:?}");
    }
    for header in ["s 1\n", "s on\n", "s 4294967296\n", "s off\ns 7 # note\n"] {
        assert!(obj(&ball(8, header)).mesh.normals.is_some(), "{header:?}");
    }
}

/// Two squares that meet at a right angle along the z axis: one faces +y, one faces +x.
const CORNER: &str = "v 0 0 0\nv 0 0 1\nv -1 0 1\nv -1 0 0\nv 0 -1 0\nv 0 -1 1\n";

#[test]
fn normals_are_averaged_within_a_group_and_an_object_alone() {
    let diagonal = Vec3::new(1.0, 1.0, 0.0).normalize();
    let smooth = obj(&format!("{CORNER}s 1\nf 1 4 3 2\nf 1 2 6 5\n"));
    let [a, b, _] = normals(&smooth, 0).unwrap();
    assert!((a - diagonal).length() < 1e-6, "{a}");
    assert!((b - -Vec3::Y).length() > 0.5, "{b}");
    for between in ["s 2\n", "o other\n", "s off\n"] {
        let apart = obj(&format!("{CORNER}s 1\nf 1 4 3 2\n{between}f 1 2 6 5\n"));
        for n in normals(&apart, 0).unwrap() {
            assert!(n.x.abs() < 1e-6, "{between}: {n}");
        }
    }
    // the group goes on after other ones, and the material has no part in it
    let again = obj(&format!("{CORNER}s 1\nf 1 4 3 2\ns 2\nusemtl a\ns 1\nf 1 2 6 5\n"));
    assert!((normals(&again, 2).unwrap()[0] - diagonal).length() < 1e-6);
}

/// The sum over a fan of eight thin triangles on one side of an edge, and one square on the other.
#[test]
fn faces_weigh_by_their_angle_and_not_by_their_number() {
    let mut text = String::from("v 0 0 0\nv 0 0 1\nv -1 0 1\nv -1 0 0\n");
    for i in 0..=8 {
        let angle = f64::from(i) / 8.0 * PI / 2.0;
        let _ = writeln!(text, "v 0 {:.7} {:.7}", -angle.sin(), angle.cos());
    }
    text += "s 1\nf 1 4 3 2\n";
    (0..8).for_each(|i| text += &format!("f 1 {} {}\n", 5 + i, 6 + i));
    let obj = obj(&text);
    let n = normals(&obj, 0).unwrap()[0];
    assert!(n.x.abs() > 0.5 && (n.x.abs() - n.y.abs()).abs() < 1e-5, "{n}");
}

#[test]
fn given_normals_stay_and_flat_faces_have_none() {
    let text = format!("{CORNER}vn 0 0 5\ns 1\nf 1//1 4//1 3//1\nf 1 3 2\ns off\nf 1 2 6 5\n");
    let obj = obj(&text);
    let own = triples(obj.mesh.normals.as_ref().unwrap(), &obj.mesh.triangles);
    assert_eq!(normals(&obj, 0).unwrap(), [Vec3::new(0.0, 0.0, 5.0); 3]);
    assert!(normals(&obj, 1).unwrap().iter().all(|n| (n.abs() - Vec3::Y).length() < 1e-6));
    assert_eq!(own[2..], [[ABSENT; 3]; 2]);
}

#[test]
fn both_sides_of_a_leaf_keep_their_own_normals() {
    let obj = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ns 1\nf 1 2 3\nf 3 2 1\nf 1 1 2\n");
    assert_eq!(normals(&obj, 0).unwrap(), [Vec3::Z; 3]);
    assert_eq!(normals(&obj, 1).unwrap(), [-Vec3::Z; 3]);
    assert_eq!(normals(&obj, 2), None, "a face without area has no normal");
}

/// Faces may be as small as coordinates can be told apart, and far away.
#[test]
fn sizes_and_places_make_no_difference() {
    for scale in [1e-12, 1e-3, 1e6] {
        let mut text = String::from("s 1\n");
        for p in
            [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, -1.0, 1.0]]
        {
            let p = DVec3::from(p) * scale;
            let _ = writeln!(text, "v {:e} {:e} {:e}", p.x, p.y, p.z);
        }
        let obj = obj(&(text + "f 1 4 3 2\nf 1 2 6 5\n"));
        let n = normals(&obj, 0).unwrap()[0];
        assert!((n - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6, "{scale}: {n}");
    }
}
