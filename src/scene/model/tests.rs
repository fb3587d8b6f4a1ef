use super::*;
use crate::film::tile::Tile;
use crate::format::{self, SceneFile};
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::Rgb;

/// The Cornell box as its files have it, and again from memory.
fn boxes() -> [SceneFile; 2] {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let set = ["film.width=24", "film.height=24"].map(String::from);
    let file = format::load(&path, &set).unwrap().0;
    let mut memory = file.clone();
    for mesh in &mut memory.scene.meshes {
        mesh.source = MeshSource::Memory(Arc::new(mesh.source.load().unwrap().into_owned()));
    }
    [file, memory]
}

fn picture(file: &SceneFile) -> (Vec<Rgb>, String) {
    let scene = file.load_scene(1).unwrap().0;
    let (settings, guide) = (&file.integrator, None);
    let integrator = PathIntegrator { guide, ..PathIntegrator::plain(&scene, settings, 1) };
    let task = Task { tile: Tile { x: 0, y: 0, width: 24, height: 24 }, first_sample: 0, samples: 2 };
    (integrator.render(&task, &mut Batch::new()).samples.sum, scene.hash_text())
}

#[test]
fn a_mesh_in_memory_is_what_it_is_in_its_file() {
    let [file, mut memory] = boxes();
    let expected = picture(&file);
    assert!(expected.0.iter().any(|&light| light != Rgb::ZERO));
    assert_eq!(picture(&memory), expected);
    // what the model says of its materials has a part in it
    for mesh in &mut memory.scene.meshes {
        let MeshSource::Memory(model) = &mut mesh.source else { panic!("{mesh:?}") };
        Arc::make_mut(model).material_names.reverse();
    }
    assert_ne!(picture(&memory), expected);
}

#[test]
fn meshes_in_memory_that_contradict_themselves_are_refused() {
    type Change = fn(&mut Model);
    let own = |t: [u32; 3]| Some(Attribute { values: vec![[0.0, 0.0, 1.0]], indices: Indices::Own(vec![t]) });
    let good = Model {
        mesh: Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            normals: own([ABSENT; 3]),
            uvs: Some(Attribute { values: vec![[0.0; 2]; 3], indices: Indices::OfPositions }),
            colors: Some(MeshColors::OfVertices(vec![[0.5; 3]; 3])),
            materials: vec![0],
        },
        material_names: vec!["grey".into()],
        ..Model::default()
    };
    let loaded = |model: Model| MeshSource::Memory(Arc::new(model)).load().map(drop);
    assert!(loaded(good.clone()).is_ok());
    let faults: [(&str, Change); 11] = [
        ("colours as vertices", |m| m.mesh.colors = Some(MeshColors::OfVertices(vec![[0.5; 3]; 2]))),
        ("colours as triangles", |m| m.mesh.colors = Some(MeshColors::OfFaces(vec![[0.5; 3]; 3]))),
        ("colour", |m| m.mesh.colors = Some(MeshColors::OfVertices(vec![[0.5, 1.5, 0.5]; 3]))),
        ("coordinate", |m| m.mesh.positions[1][2] = f32::NAN),
        ("vertex", |m| m.mesh.triangles[0][1] = 3),
        ("materials for 2", |m| m.mesh.materials.push(0)),
        ("material that is not there", |m| m.mesh.materials[0] = 1),
        ("normals that do not fit", |m| m.mesh.normals.as_mut().unwrap().indices = Indices::Own(vec![[0, 0, 1]])),
        ("direction", |m| m.mesh.normals.as_mut().unwrap().values[0] = [0.0; 3]),
        ("coordinates that do not fit", |m| _ = m.mesh.uvs.as_mut().unwrap().values.pop()),
        ("not finite", |m| m.mesh.uvs.as_mut().unwrap().values[0][1] = f32::INFINITY),
    ];
    for (part, change) in faults {
        let mut model = good.clone();
        change(&mut model);
        let message = loaded(model).unwrap_err().to_string();
        assert!(message.starts_with("a mesh in memory: ") && message.contains(part), "{message}");
    }
}

#[test]
fn a_file_that_no_reader_is_for_is_refused_by_name() {
    let message = MeshSource::File("a.stl".into()).load().unwrap_err().to_string();
    assert_eq!(message, "a.stl: not a mesh: its name must end in .obj, .ply or .ply.gz");
}
