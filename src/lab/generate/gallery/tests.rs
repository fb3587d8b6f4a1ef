use super::*;
use crate::lab::compare::file;
use std::collections::BTreeSet;

fn committed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/gallery")
}

fn listing(dir: &Path) -> BTreeSet<String> {
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    std::fs::read_dir(dir).unwrap().map(name).collect()
}

#[test]
fn committed_files_are_what_is_generated() {
    let dir = tempfile::tempdir().unwrap();
    let paths = generate(dir.path()).unwrap();
    assert_eq!(listing(dir.path()), listing(&committed()), "run phototaxis generate --gallery --out scenes/gallery");
    assert_eq!(paths.len(), listing(dir.path()).len(), "all that is written is told, and nothing is left beside it");
    let mut bytes = 0;
    for path in paths {
        let file = path.file_name().unwrap();
        let (made, kept) = (std::fs::read(&path).unwrap(), std::fs::read(committed().join(file)).unwrap());
        assert!(made == kept, "{file:?} differs: run phototaxis generate --gallery --out scenes/gallery");
        bytes += made.len();
    }
    assert!(bytes < 500_000, "{bytes} bytes");
}

#[test]
fn one_scene_can_be_had_by_its_name() {
    let dir = tempfile::tempdir().unwrap();
    super::super::generate("far-away", dir.path()).unwrap();
    assert_eq!(listing(dir.path()), BTreeSet::from(["far-away.toml".to_owned()]), "it has the mesh of another");
    super::super::generate("corners", dir.path()).unwrap();
    assert_eq!(listing(dir.path()).len(), 4);
}

/// The plan's rows as they are rendered, loaded.
#[test]
fn every_row_loads_and_every_scene_is_in_a_row() {
    let plan = file::read(&committed().join(PLAN_NAME)).unwrap().finish().unwrap();
    let mut used = BTreeSet::new();
    for entry in &plan.scenes {
        let own = [&entry.path].into_iter().chain(&entry.reference_scene);
        used.extend(own.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()));
        for method in &plan.methods {
            let (description, _) = plan.describe(entry, Some(method)).unwrap();
            assert_eq!((description.scene.film.width, description.scene.film.height), (64, 48), "{}", entry.name());
        }
        let (description, _) = plan.describe(entry, None).unwrap();
        let (scene, _) = description.load_scene(1).unwrap();
        assert!(scene.triangles() > 0, "{}", entry.name());
    }
    assert_eq!(used, names().map(str::to_owned).collect());
}

#[test]
fn there_are_ten_thousand_lights() {
    let path = committed().join("many-lights.toml");
    let (description, _) = crate::format::load(&path, &[]).unwrap();
    let copies = description.scene.meshes.len() - 1;
    let each = make("many-lights").unwrap().model.objects[0].1.triangles.len();
    assert_eq!(copies * each, 10_000);
}

#[test]
fn the_sliver_mesh_has_what_it_promises() {
    let model = make("slivers").unwrap().model;
    let shape = &model.objects[1].1;
    let area = |corners: [DVec3; 3]| (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / 2.0;
    let areas: Vec<f64> = shape.triangles.iter().map(|t| area(shape.corners(t))).collect();
    assert_eq!(areas.iter().filter(|a| **a < 1e-12).count(), 3, "without area");
    assert!(areas.iter().filter(|a| **a > 0.0 && **a < 1e-4).count() >= 360, "slivers");
    let distinct: BTreeSet<[u32; 3]> = shape.triangles.iter().map(|t| t.corners).collect();
    assert_eq!(shape.triangles.len() - distinct.len(), 360, "duplicates");
}
