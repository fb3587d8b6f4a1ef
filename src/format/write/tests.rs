use super::*;
use crate::format;
use crate::format::tests::blocks::{BLOCKS, bound, compare, runs};
use std::fs;
use tempfile::TempDir;

/// The scene as it comes back from a file that is written.
fn converted(file: &SceneFile) -> (TempDir, Result<SceneFile>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a scene.toml");
    let read = write(file, &path).and_then(|_| format::load(&path, &[]).map(|(file, _)| file));
    (folder, read)
}

/// Scenes that are compared, so that all their tests together have one probability of a false alarm.
const SCENES: usize = 7;

/// That the scene is the same after it has been written.
fn keeps(file: &SceneFile) {
    let (_folder, read) = converted(file);
    let read = read.unwrap();
    assert_eq!((&read.scene.film, &read.integrator), (&file.scene.film, &file.integrator));
    let before = runs(file, 1);
    let (t, mean) = compare(&runs(&read, 100), &before);
    assert!(before.iter().flatten().any(|&block| block > 0.0));
    assert!(t <= bound(BLOCKS * SCENES), "t {t}, mean {:+.2} %", 100.0 * mean);
}

#[test]
fn another_scene_is_told_apart() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let load = |more: &[&str]| {
        let set: Vec<String> = ["film.width=12", "film.height=9"].iter().chain(more).map(ToString::to_string).collect();
        runs(&format::load(&path, &set).unwrap().0, 1)
    };
    let name = "camera.vfov=41";
    assert!(compare(&load(&[name]), &load(&[])).0 > bound(BLOCKS * SCENES));
}

#[test]
fn scenes_of_this_repository_come_back_as_they_were() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in ["cornell.toml", "gallery/shiny.toml", "gallery/direct.toml"] {
        keeps(&format::load(&scenes.join(name), &["film.width=12".into(), "film.height=9".into()]).unwrap().0);
    }
}

#[test]
fn groups_lights_pictures_and_far_places_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(
        at("a.obj"),
        "v -1 0 -1\nv 1 0 -1 \nv 1 0 1\nv -1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 4/1 3/2 2/3\nusemtl b\nf 4 2 1\n",
    )
    .unwrap();
    image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([90 * x as u8, 200 - 90 * y as u8, 50]))
        .save(at("p.png"))
        .unwrap();
    let text = r#"
        [camera]
        origin = [5000000, 2.5, 4]
        target = [5000000, 0, 0]
        aperture_radius = 0.01
        [film]
        width = 12
        height = 9
        filter = "tent"
        [material.b]
        type = "principled"
        base_color = { texture = "p.png", scale = [2, 3], tint = [1, 0.5, 1] }
        roughness = { texture = "p.png", channel = "green" }
        emission = [0.1, 0, 0]
        [material.""]
        type = "conductor"
        eta = [0.2, 0.9, 1.1]
        k = [3.9, 2.4, 2.1]
        alpha = 0.3
        opacity = 0.75
        normal_map = { texture = "p.png", strength = 0.2 }
        [[mesh]]
        path = "a.obj"
        translate = [5000000, 0, 0]
        [[mesh]]
        path = "a.obj"
        group = "g"
        material = "b"
        [[instance]]
        group = "g"
        scale = 0.5
        translate = [5000001, 0.5, 0]
        [[light]]
        type = "spot"
        position = [5000000, 4, 2]
        direction = [0, -2, -1]
        intensity = 30
        cutoff_angle = 40
        beam_angle = 10
        [[light]]
        type = "sky"
        sun_direction = [0.3, 1, 0.2]
        scale = 0.01
    "#;
    fs::write(at("s.toml"), text).unwrap();
    keeps(&format::load(&at("s.toml"), &[]).unwrap().0);
}

#[test]
fn keys_of_a_camera_come_back() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let keys = "camera.key=[{frame=-1.5, origin=[1, 2, 3.1], target=[0, 0.1, 0]}, {frame=24, up=[0, 1, 0.5], vfov=20.3, \
        aperture_radius=0.1, focus_distance=2}]";
    let (file, _) = format::load(&path, &[keys.into(), "camera.interpolation=linear".into()]).unwrap();
    let read = converted(&file).1.unwrap();
    assert_eq!(read.scene.camera, file.scene.camera);
    assert_eq!(read.scene.camera.unwrap().keys.len(), 2);
}

#[test]
fn what_a_camera_does_not_say_is_as_in_its_first_keys() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let keys =
        "[[camera.key]]\nframe = 9\norigin = [1, 1, 9]\n[[camera.key]]\nframe = 2\norigin = [1, 1, 2]\nvfov = 20\n";
    fs::write(&path, format!("[camera]\nvfov = 30\n{keys}")).unwrap();
    let camera = format::load(&path, &[]).unwrap().0.scene.camera.unwrap();
    assert_eq!((camera.origin, camera.vfov), ([1.0, 1.0, 2.0].into(), 30.0));
    assert!(!camera.unsaid.origin && camera.unsaid.target);
    fs::write(&path, format!("[camera]\nprojection = 'panorama'\n{keys}")).unwrap();
    let error = format::load(&path, &[]).unwrap_err().to_string();
    assert!(error.contains("a.toml:9:") && error.contains("`vfov` in [[camera.key]] needs `projection"), "{error}");
}

#[test]
fn pictures_in_no_file_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><transform name=\"to_world\">\
        <lookat origin=\"0,0,4\" target=\"0,0,0\" up=\"0,1,0\"/></transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"12\"/>\
        <integer name=\"height\" value=\"9\"/></film></sensor><shape type=\"rectangle\"><bsdf type=\"diffuse\">\
        <texture name=\"reflectance\" type=\"checkerboard\"/></bsdf></shape><emitter type=\"constant\"/></scene>";
    let path = folder.path().join("s.xml");
    fs::write(&path, text).unwrap();
    let (file, _) = format::load(&path, &[]).unwrap();
    keeps(&file);
    let (out, _) = converted(&file);
    assert!(out.path().join("a scene files/picture-0.exr").is_file());
}

#[test]
fn what_a_scene_file_cannot_say_is_an_error_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.mtl"), "newmtl m\nKd 1 1 1\nmap_Bump p.png\n").unwrap();
    fs::write(at("a.obj"), "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    image::RgbImage::new(2, 2).save(at("p.png")).unwrap();
    let (file, _) = format::load(&at("a.obj"), &[]).unwrap();
    let message = converted(&file).1.unwrap_err().to_string();
    assert!(message.starts_with("a scene file cannot say of material `m`: heights in widths of a texel"), "{message}");
}

#[test]
fn a_scene_of_mitsuba_comes_back_from_what_is_written_for_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let (file, _) = format::load(&path, &["film.width=12".into(), "film.height=9".into()]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("box.xml");
    format::mitsuba::export::Translation::write_as(&file, 7, &out, "").unwrap();
    let (read, warnings) = format::load(&out, &[]).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(read.render.spp, 7);
    let t = compare(&runs(&read, 100), &runs(&file, 1)).0;
    assert!(t <= bound(BLOCKS * SCENES), "t {t}");
}

#[test]
fn blends_come_back_from_both_forms() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(
        at("a.obj"),
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n",
    )
    .unwrap();
    image::GrayImage::from_fn(2, 2, |x, y| image::Luma([20 + 100 * x as u8 + 90 * y as u8])).save(at("w.png")).unwrap();
    let text = r#"
        [camera]
        origin = [0, 0, 3]
        target = [0, 0, 0]
        [film]
        width = 12
        height = 9
        [[mesh]]
        path = "a.obj"
        [material.a]
        type = "blend"
        materials = ["within", "b"]
        weight = { texture = "w.png" }
        emission = [0.1, 0.2, 0]
        [material.within]
        type = "blend"
        materials = ["b", "c"]
        weight = 0.25
        [material.b]
        type = "diffuse"
        reflectance = [0.8, 0.1, 0.1]
        [material.c]
        type = "conductor"
        eta = [0.2, 0.9, 1.1]
        k = [3.9, 2.4, 2.1]
        alpha = 0.3
        [[light]]
        type = "constant"
        radiance = [0.5, 0.6, 1]
        [[light]]
        type = "directional"
        direction = [0, -0.4, -1]
        irradiance = 1
    "#;
    fs::write(at("s.toml"), text).unwrap();
    let (file, _) = format::load(&at("s.toml"), &[]).unwrap();
    keeps(&file);
    let out = at("out.xml");
    format::mitsuba::export::Translation::write_as(&file, 7, &out, "").unwrap();
    let (read, warnings) = format::load(&out, &[]).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let t = compare(&runs(&read, 100), &runs(&file, 1)).0;
    assert!(t <= bound(BLOCKS * SCENES), "t {t}");
    let (other, _) = format::load(&at("s.toml"), &["material.within.weight=0.5".into()]).unwrap();
    assert!(compare(&runs(&other, 100), &runs(&file, 1)).0 > bound(BLOCKS * SCENES), "another weight must be seen");
}

/// Colours of faces become those of vertices, of which there is one for each colour.
#[test]
fn colours_of_faces_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
               property list uchar int vertex_indices\nproperty float red\nproperty float green\nproperty float blue\nend_header\n\
               0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 0.75 0.25 0\n3 0 2 3 0 0.25 0.75\n";
    fs::write(folder.path().join("m.ply"), ply).unwrap();
    let path = folder.path().join("s.toml");
    let camera = "[camera]\norigin = [0.5, 0.5, 3]\ntarget = [0.5, 0.5, 0]\n";
    fs::write(&path, format!("{camera}[[mesh]]\npath = \"m.ply\"\n[[light]]\ntype = \"constant\"\nradiance = 1\n"))
        .unwrap();
    let (written, read) = converted(&format::load(&path, &[]).unwrap().0);
    read.unwrap().load_scene(1).unwrap();
    let mesh = crate::scene::ply::load(&written.path().join("a scene files/mesh-0-0.ply")).unwrap().mesh;
    let colors = [0, 1].map(|triangle| mesh.color(triangle, 0.25, 0.5).to_array());
    assert_eq!((colors, mesh.positions.len()), ([[0.75, 0.25, 0.0], [0.0, 0.25, 0.75]], 6));
}
