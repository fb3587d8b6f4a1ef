use super::*;
use crate::bsdf::{BsdfDescription, ConductorParameters, DiffuseParameters, PlasticParameters};
use crate::film::Filter;
use crate::format::load;
use crate::light::{ConstantLight, EnvironmentLight, LightDescription};
use crate::scene::description::*;
use crate::texture::ColorTexture;
use glam::DVec3;
use proptest::prelude::*;
use std::path::PathBuf;

const SMALL: &str = r#"{
 "name": "small", "obj": "scene.obj", "extra": 1,
 "camera": {"origin": [0, 1, 5], "target": [0, 1, 4], "up": [0, 1, 0], "vfov_deg": 30,
            "width": 64, "height": 32, "mirrored_x": true},
 "materials": {
  "Wall": {"type": "diffuse", "reflectance": {"texture": "t/a.png", "filter": "nearest"}},
  "Lamp": {"type": "diffuse", "reflectance": 0, "emission": [1, 2, 3]},
  "Steel": {"type": "conductor", "specular_reflectance": [1, 1, 1]},
  "Shiny": {"type": "phong", "reflectance": [0.1, 0.2, 0.3], "exponent": 48},
  "Car": {"type": "principled", "base_color": 0.2, "alpha": 0.25, "anisotropic": 0.5}
 },
 "emitters": [
  {"type": "area", "object": "o", "material": "Lamp", "radiance": [1, 2, 4]},
  {"type": "envmap", "filename": "sky.exr"},
  {"type": "constant", "radiance": 2},
  {"type": "point", "position": [1, 2, 3], "intensity": [1, 1, 1]}
 ]
}"#;

fn small(from: &str, to: &str) -> Result<(SceneDescription, Vec<String>)> {
    assert!(SMALL.contains(from), "{from}");
    parse(&SMALL.replacen(from, to, 1), Path::new("dir/scene.json"))
}

#[test]
fn camera_and_lights_are_read() {
    let (scene, warnings) = small("", "").unwrap();
    assert_eq!(scene.meshes[0].source.path(), Some(Path::new("dir/scene.obj")));
    let camera = scene.camera.unwrap();
    assert_eq!((camera.target, camera.vfov), (DVec3::new(0.0, 1.0, 4.0), 30.0));
    assert!(camera.mirrored);
    assert_eq!((scene.film.width, scene.film.height, scene.film.filter), (64, 32, Filter::Box));
    let LightDescription::Environment(EnvironmentLight { path, .. }) = &scene.lights[0] else { panic!() };
    assert_eq!(path, Path::new("dir/sky.exr"));
    assert_eq!(scene.lights[1], LightDescription::Constant(ConstantLight { radiance: Rgb::splat(2.0) }));
    let expected = [
        "material `Car`: `anisotropic` is taken for 0",
        "material `Lamp` emits [1, 2, 3], but its emitter says [1, 2, 4]: the material counts",
        "the scene: `extra` is not known and means nothing",
    ];
    assert_eq!(warnings, expected);
}

#[test]
fn materials_are_read_as_mitsuba_means_them() {
    let (scene, _) = small("", "").unwrap();
    let wall = &scene.materials["Wall"];
    let BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Image(image) }) = &wall.bsdf else {
        panic!()
    };
    assert_eq!((image.path.as_path(), image.nearest), (Path::new("dir/t/a.png"), true));
    assert!(wall.two_sided);
    let lamp = &scene.materials["Lamp"];
    assert_eq!((lamp.emission, lamp.emission_two_sided), (Rgb::new(1.0, 2.0, 3.0), false));
    let BsdfDescription::Conductor(ConductorParameters { eta_k, .. }) = scene.materials["Steel"].bsdf else { panic!() };
    assert_eq!(eta_k, None);
    let BsdfDescription::Plastic(PlasticParameters { alpha, nonlinear, .. }) = scene.materials["Shiny"].bsdf else {
        panic!()
    };
    assert!((alpha - 0.2).abs() < 1e-6 && !nonlinear, "{alpha}");
}

#[test]
fn faults_have_a_place() {
    let cases = [
        ("\"obj\": \"scene.obj\",", "", "1:1: the scene needs `obj`"),
        ("30,", "30", "4:13: expected `,` or `}`"),
        ("30,", "190,", "3:84: `vfov_deg` must be greater than 0 and less than 180, found 190"),
        ("0.2, 0.3]", "1.2, 0.3]", "9:51: `reflectance` must be between 0 and 1, found 1.2"),
        ("\"exponent\": 48", "\"exponent\": -1", "9:74: `exponent` must be 0 or more, found -1"),
        (", \"exponent\": 48", "", "9:21: material `Shiny` is of type `phong` and needs `exponent`"),
        ("\"phong\"", "\"ward\"", "9:21: unknown type `ward` in material `Shiny`"),
        ("\"nearest\"", "\"none\"", "6:79: unknown filter `none`"),
        ("\"Lamp\":", "\"Wall\":", "7:3: duplicate key `Wall`"),
        ("\"envmap\"", "\"neon\"", "14:12: unknown type `neon` in emitter: known are `constant`, `environment`"),
        ("\"anisotropic\"", "\"spec_trans\"", "10:81: material `Car` transmits light"),
        ("\"target\": [0, 1, 4]", "\"target\": null", "3:44: `target` must be an array of 3 numbers"),
    ];
    for (from, to, expected) in cases {
        let error = small(from, to).unwrap_err().to_string();
        let expected = format!("dir/scene.json:{expected}");
        assert!(error.starts_with(&expected), "{error}\n{expected}");
    }
    let deep = parse(&"[".repeat(100_000), Path::new("a.json")).unwrap_err().to_string();
    assert!(deep.contains("recursion limit"), "{deep}");
}

/// The folder of the shared scenes, if it is there.
fn scenes() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("PHOTOTAXIS_SCENES").map_or_else(beside, PathBuf::from);
    if !folder.is_dir() {
        eprintln!("SKIPPED: no scenes in {} (set PHOTOTAXIS_SCENES)", folder.display());
        return None;
    }
    Some(folder)
}

fn assert_files_exist(scene: &SceneDescription) {
    let mesh = scene.meshes[0].source.path().unwrap();
    assert!(mesh.is_file(), "{}", mesh.display());
    for material in scene.materials.values() {
        if let BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Image(image) }) = &material.bsdf
        {
            assert!(image.path.is_file(), "{}", image.path.display());
        }
    }
    for light in &scene.lights {
        let LightDescription::Environment(EnvironmentLight { path, .. }) = light else { panic!("{light:?}") };
        assert!(path.is_file(), "{}", path.display());
    }
}

#[test]
fn the_shared_scenes_are_read() {
    let Some(folder) = scenes() else { return };
    // Name, materials, materials that emit, lights that are no surfaces.
    let expected = [
        ("cornell-box", 8, 1, 0),
        ("living-room", 19, 0, 1),
        ("lumen-occluded", 6, 1, 0),
        ("lumen-occluded2", 6, 1, 0),
        ("staircase2", 21, 13, 0),
        ("veach-ajar", 13, 1, 0),
        ("veach-bidir", 6, 2, 0),
        ("veach-mis", 8, 3, 0),
    ];
    for (name, materials, emitting, lights) in expected {
        let path = folder.join(name).join("scene.json");
        let (SceneFile { scene, integrator, .. }, warnings) = load(&path, &["film.width=99".to_string()]).unwrap();
        assert_eq!(integrator.max_depth, 16, "the form says nothing of it");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        let emit = scene.materials.values().filter(|m| m.emission != Rgb::ZERO).count();
        assert_eq!((scene.materials.len(), emit, scene.lights.len()), (materials, emitting, lights));
        assert!(scene.materials.values().all(|m| m.two_sided), "{name}");
        assert!(scene.camera.is_some() && scene.film.width == 99 && scene.film.height >= 720);
        assert_files_exist(&scene);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn mutations_never_panic(at in any::<usize>(), length in 0..8usize, scrap in "[\\[\\]{}:,\"0-9e\\\\é-]{0,3}") {
        let mut chars: Vec<char> = SMALL.chars().collect();
        let at = at % chars.len();
        let end = (at + length).min(chars.len());
        chars.splice(at..end, scrap.chars());
        let text: String = chars.into_iter().collect();
        match parse(&text, Path::new("a.json")) {
            Err(crate::Error::Parse { line, column, .. }) => {
                prop_assert!(column >= 1 && line >= 1 && line <= text.matches('\n').count() + 1);
            }
            Err(e) => prop_assert!(false, "{e}"),
            Ok((scene, _)) => {
                let shown = format!("{scene:?}");
                prop_assert!(!shown.contains("NaN") && !shown.contains(": inf"), "{shown}");
            }
        }
    }
}
