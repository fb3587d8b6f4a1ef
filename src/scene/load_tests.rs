use crate::format;

#[test]
fn texture_coordinates_are_kept_for_pictures_alone() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::new(2, 2).save(at("p.png")).unwrap();
    std::fs::write(
        at("a.obj"),
        "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n",
    )
    .unwrap();
    for (color, kept) in [("Kd 1 1 1", false), ("map_Kd p.png", true)] {
        std::fs::write(at("a.mtl"), format!("newmtl m\n{color}\n")).unwrap();
        let (scene, _) = format::load(&at("a.obj"), &[]).unwrap().0.load_scene(1).unwrap();
        assert_eq!(scene.meshes()[0].uvs.is_some(), kept, "{color}");
    }
}
