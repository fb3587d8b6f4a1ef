//! Holds the scenes to what their descriptions promise: files and geometry here, what rays meet in [`views`].

mod rays;
mod views;

use super::*;
use glam::{DVec3, Vec3Swizzles};
use rays::{Face, World, bounds};
use std::collections::{BTreeMap, BTreeSet};

fn world(name: &str) -> World {
    World::read(&make(name).unwrap().model)
}

fn settings(name: &str) -> toml::Table {
    make(name).unwrap().toml.parse().unwrap()
}

fn all_names() -> impl Iterator<Item = &'static str> {
    scenes().iter().map(|scene| scene.0)
}

#[test]
fn committed_scenes_are_what_is_generated() {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let dir = tempfile::tempdir().unwrap();
    for name in all_names() {
        for path in generate(name, dir.path()).unwrap() {
            let file = path.file_name().unwrap();
            let (made, kept) = (std::fs::read(&path), std::fs::read(committed.join(file)));
            assert!(
                made.unwrap() == kept.expect("every scene is committed"),
                "{file:?} in scenes/ differs: run phototaxis generate {name} --out scenes"
            );
        }
    }
    let left: Vec<_> = std::fs::read_dir(dir.path()).unwrap().collect();
    assert_eq!(left.len(), 3 * scenes().len(), "no temporary file is left");
}

#[test]
fn generating_again_replaces_files_and_makes_the_folder() {
    let dir = tempfile::tempdir().unwrap();
    let inner = dir.path().join("a/b");
    let paths = generate("furnace", &inner).unwrap();
    std::fs::write(&paths[1], "damaged").unwrap();
    assert_eq!(generate("furnace", &inner).unwrap(), paths);
    assert!(std::fs::read_to_string(&paths[1]).unwrap().contains("usemtl glow"));
}

#[test]
fn an_unknown_name_is_answered_with_the_known_ones() {
    let dir = tempfile::tempdir().unwrap();
    let message = generate("dor", dir.path()).unwrap_err().to_string();
    assert!(all_names().all(|name| message.contains(name)) && message.contains("\"dor\""));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error_with_its_path() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = generate("furnace", &file).unwrap_err();
    assert!(matches!(error, Error::Io { path, .. } if path == file));
}

#[test]
fn materials_are_used_and_defined() {
    for name in all_names() {
        let world = world(name);
        let used: BTreeSet<&str> = world.faces.iter().map(|face| face.material.as_str()).collect();
        let mtl = make(name).unwrap().model.mtl(name);
        let defined = mtl.lines().filter_map(|line| line.strip_prefix("newmtl "));
        assert_eq!(used, defined.collect(), "{name}");
        let settings = settings(name);
        if let Some(replaced) = settings.get("material") {
            let replaced = replaced.as_table().unwrap().keys();
            replaced.for_each(|material| assert!(used.contains(material.as_str()), "{material}"));
        }
    }
}

#[test]
fn diffuse_surfaces_lose_energy() {
    for name in all_names() {
        for material in make(name).unwrap().model.materials {
            let below_one = |albedo: &f64| (0.0..0.85).contains(albedo);
            assert!(material.diffuse.iter().all(below_one), "{name}: {}", material.name);
        }
    }
}

#[test]
fn triangles_have_area_and_their_normals_are_unit_and_on_their_side() {
    for name in all_names() {
        for face in &world(name).faces {
            let (object, cross) = (&face.object, face.cross());
            assert!(cross.length() > 1e-8, "{name}, {object}: {:?}", face.corners);
            for normal in face.normals.into_iter().flatten() {
                assert!((normal.length() - 1.0).abs() < 2e-5, "{name}, {object}: {normal}");
                assert!(normal.dot(cross) > 0.0, "{name}, {object}: {:?}", face.corners);
            }
        }
    }
}

/// Edges, as written, that are not met as often in one direction as in the other.
fn open_edges<'a>(faces: impl Iterator<Item = &'a Face>) -> usize {
    let key = |p: DVec3| (p * 1e5).round().to_array().map(|x| x as i64);
    let mut balance: BTreeMap<_, i32> = BTreeMap::new();
    for face in faces {
        for i in 0..3 {
            let (a, b) = (key(face.corners[i]), key(face.corners[(i + 1) % 3]));
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().filter(|count| **count != 0).count()
}

/// By the divergence theorem: positive for a closed surface whose faces look outward.
fn volume<'a>(faces: impl Iterator<Item = &'a Face>) -> f64 {
    faces.map(|face| face.corners[0].dot(face.cross()) / 6.0).sum()
}

#[test]
fn objects_are_closed_and_face_the_right_way() {
    for name in ["door", "wall", "furnace"] {
        let world = world(name);
        let objects: BTreeSet<&str> = world.faces.iter().map(|f| f.object.as_str()).collect();
        for object in objects {
            assert_eq!(open_edges(world.of_object(object)), 0, "{name}, {object}");
            assert!(open_edges(world.of_object(object).skip(1)) == 3, "the check can fail");
            let inward = ["building", "room", "sphere"].contains(&object);
            assert_eq!(volume(world.of_object(object)) < 0.0, inward, "{name}, {object}");
        }
    }
}

#[test]
fn the_cornell_box_is_open_only_in_front_and_below_its_blocks() {
    let world = world("cornell");
    assert_eq!(world.faces.len(), 38);
    assert_eq!(open_edges(world.of_object("room")), 4);
    assert_eq!(open_edges(world.of_object("tall_block")), 4);
    assert_eq!(open_edges(world.of_object("short_block")), 4);
    let centre = DVec3::new(0.0, 0.275, 0.0);
    let faces_centre = |f: &Face| f.cross().dot(centre - f.corners[0]) > 0.0;
    assert!(world.of_object("room").all(faces_centre));
}

#[test]
fn sizes_stay_small() {
    let faces = |name: &str| world(name).faces.len();
    assert!(faces("door") < 30_000 && faces("wall") < 30_000);
    for name in all_names() {
        assert!(make(name).unwrap().model.obj(name).len() < 1_500_000, "{name}");
    }
}

#[test]
fn table_objects_stand_on_the_table_and_apart() {
    let to_building = door::to_world().inverse();
    let mut world = world("door");
    for face in &mut world.faces {
        face.corners = face.corners.map(|p| to_building.transform_point3(p));
    }
    let table = bounds(world.of_object("table"));
    let objects = ["vase", "teapot", "pumpkin"].map(|name| bounds(world.of_object(name)));
    for (i, [low, high]) in objects.into_iter().enumerate() {
        assert!(low.xz().cmpgt(table[0].xz()).all() && high.xz().cmplt(table[1].xz()).all());
        assert!((low.y - table[1].y).abs() < 0.02);
        for other in &objects[i + 1..] {
            assert!(high.xz().cmplt(other[0].xz()).any() || other[1].xz().cmplt(low.xz()).any());
        }
    }
    let clearance = objects[0][0].y - table[1].y;
    assert!(clearance > 1e-4, "glass does not touch the table: {clearance}");
}
