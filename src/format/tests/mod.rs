mod blends;
pub(crate) mod blocks;
mod faults;
mod names;
mod reference_page;

use super::*;
use crate::bsdf::{BsdfDescription, ConductorParameters, MirrorParameters, PlasticParameters};
use crate::film::{FilmSettings, Filter};
use crate::guiding::settings::GuidingSettings;
use crate::integrator::{IntegratorSettings, Roulette};
use crate::light::{DirectionalLight, EnvironmentLight, LightDescription};
use crate::math::Rgb;
use crate::scene::description::*;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};
use glam::{DVec3, Vec3};
use proptest::prelude::*;

fn parsed(text: &str, overrides: &[&str]) -> Result<SceneFile> {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    parse(text, Path::new("dir/s.toml"), &overrides).map(|(scene, _)| scene)
}

/// A file with something of everything.
const WHOLE: &str = r#"
[camera]
origin = [0, 1, 5]
target = [0, 1, 0]
vfov = 40
mirrored = true
[film]
width = 320
filter = "tent"
[[mesh]]
path = "a.obj"
scale = 2
rotate = { axis = [0, 0, 2], angle = 90 }
translate = [1, 0, 0]
material = "Floor"
[[mesh]]
path = "/b.obj"
matrix = [[0, -1, 0, 3], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
[material.Floor]
type = "plastic"
reflectance = { texture = "tex/wood.png", scale = 3, nearest = true }
alpha = 0.3
opacity = 0.5
[material.Gold]
type = "conductor"
eta = [0.2, 0.9, 1.1]
k = [3.9, 2.4, 2.1]
[material.Lamp]
type = "diffuse"
two_sided = false
emission = [10, 5, 1]
[[light]]
type = "environment"
path = "sky.exr"
rotate_y = 90
[[light]]
type = "directional"
direction = [0, -2, 0]
irradiance = 3
[integrator]
max_depth = 4
[guiding]
memory = "1.5 GiB"
[render]
time = 2.5
seed = 18446744073709551615
"#;

#[test]
fn the_whole_file_is_read() {
    let SceneFile { scene, integrator, guiding, render } = parsed(WHOLE, &[]).unwrap();
    let camera = scene.camera.unwrap();
    assert_eq!((camera.origin, camera.up, camera.vfov), (DVec3::new(0.0, 1.0, 5.0), Vec3::Y, 40.0));
    assert!(camera.mirrored);
    assert_eq!((scene.film.width, scene.film.height, scene.film.filter), (320, 720, Filter::Tent));
    assert_eq!(scene.meshes[0].source.path(), Some(Path::new("dir/a.obj")));
    assert_eq!(scene.meshes[0].material.as_deref(), Some("Floor"));
    // (1, 0, 0) · 2, a quarter turn about z, then one to the right.
    let moved = scene.meshes[0].transform.transform_point3(DVec3::X);
    assert!(moved.abs_diff_eq(DVec3::new(1.0, 2.0, 0.0), 1e-6), "{moved}");
    assert_eq!(scene.meshes[1].source.path(), Some(Path::new("/b.obj")));
    assert_eq!(scene.meshes[1].transform.transform_point3(DVec3::Y), DVec3::new(2.0, 0.0, 0.0));
    let LightDescription::Environment(EnvironmentLight { path, to_world, .. }) = &scene.lights[0] else { panic!() };
    assert_eq!(path, Path::new("dir/sky.exr"));
    assert!(to_world.transform_vector3(Vec3::X).abs_diff_eq(-Vec3::Z, 1e-6));
    let (direction, irradiance) = (-Vec3::Y, Rgb::splat(3.0));
    assert_eq!(scene.lights[1], LightDescription::Directional(DirectionalLight { direction, irradiance }));
    assert_eq!(integrator, IntegratorSettings { max_depth: 4, ..Default::default() });
    assert_eq!(guiding.memory, 3 << 29);
    assert_eq!((render.time, render.seed), (Some(2.5), u64::MAX));
}

#[test]
fn the_whole_file_s_materials_are_read() {
    let scene = parsed(WHOLE, &[]).unwrap().scene;
    let floor = &scene.materials["Floor"];
    assert_eq!(floor.opacity, Some(ScalarTexture::Constant(0.5)));
    let BsdfDescription::Plastic(PlasticParameters { reflectance, alpha, .. }) = &floor.bsdf else { panic!() };
    let path = Path::new("dir/tex/wood.png").to_path_buf();
    let (scale, offset, nearest, tint) = ([3.0; 2], [0.0; 2], true, Rgb::ONE);
    let image = ImageTexture { path, scale, offset, nearest, tint, clamp: false };
    assert_eq!((reflectance, *alpha), (&ColorTexture::Image(image), 0.3));
    let BsdfDescription::Conductor(ConductorParameters { eta_k, .. }) = scene.materials["Gold"].bsdf else { panic!() };
    assert_eq!(eta_k, Some((Rgb::new(0.2, 0.9, 1.1), Rgb::new(3.9, 2.4, 2.1))));
    let lamp = &scene.materials["Lamp"];
    assert_eq!((lamp.two_sided, lamp.emission), (false, Rgb::new(10.0, 5.0, 1.0)));
}

#[test]
fn overrides_change_what_they_name() {
    let overrides = [
        "film.width=640",
        "film.width = 641",
        "camera.origin=[0, 2, 9]",
        "integrator.roulette=none",
        "guiding.memory=64 MiB",
        "material.Floor.alpha=0.2",
        "material.Floor.reflectance.scale=[5, 6]",
        "material.Gold={type = 'mirror'}",
        "material.\"a=b c\".type=diffuse",
    ];
    let (changed, before) = (parsed(WHOLE, &overrides).unwrap(), parsed(WHOLE, &[]).unwrap());
    let scene = changed.scene;
    let camera = scene.camera.unwrap();
    assert_eq!((camera.origin, camera.vfov), (DVec3::new(0.0, 2.0, 9.0), 40.0));
    assert_eq!(scene.film, FilmSettings { width: 641, ..before.scene.film });
    assert_eq!(changed.integrator, IntegratorSettings { roulette: Roulette::None, ..before.integrator });
    assert_eq!(changed.guiding, GuidingSettings { memory: 64 << 20, ..before.guiding });
    let floor = scene.materials["Floor"].clone();
    let BsdfDescription::Plastic(PlasticParameters { reflectance, alpha, .. }) = floor.bsdf else { panic!() };
    let ColorTexture::Image(image) = reflectance else { panic!() };
    assert_eq!((alpha, image.scale, image.nearest), (0.2, [5.0, 6.0], true));
    assert_eq!(floor.opacity, Some(ScalarTexture::Constant(0.5)));
    assert_eq!(scene.materials["Gold"].bsdf, MirrorParameters::default().into(), "of its type's defaults");
    assert_eq!(scene.materials["Lamp"], before.scene.materials["Lamp"]);
    assert_eq!(scene.materials["a=b c"], MaterialDescription::default());
}

#[test]
fn overrides_that_are_wrong_name_themselves() {
    let cases = [
        ("film.widht=3", "unknown key `widht` in [film]: did you mean `width`?"),
        ("film.width=0", "`width` must be between 1 and 65536, found 0"),
        ("film.width=1.2.3", "`width` must be an integer, found a string"),
        ("flim.width=1", "unknown key `flim` in --set: did you mean `film`?"),
        (
            "mesh.path=a.obj",
            "unknown key `mesh` in --set: known are `camera`, `film`, `integrator`, `guiding`, \
             `render` and `material`",
        ),
        ("integrator.roulette=nine", "unknown roulette `nine` in [integrator]: did you mean `none`?"),
        ("camera.target=[0, 1, 5]", "`target` must differ from `origin`"),
        ("material.Floor.eta=1", "`eta` is not a key of type `plastic`, but of `conductor`"),
        ("film", "expected key=value, for example film.width=640"),
        ("film.width=", "expected key=value, for example film.width=640"),
        ("film.width=[1", "unclosed array, expected `]`"),
    ];
    for (text, expected) in cases {
        let error = parsed(WHOLE, &["render.spp=1", text]).unwrap_err().to_string();
        assert_eq!(error, format!("--set '{text}': {expected}"));
    }
}

#[test]
fn keys_of_a_camera_can_be_given_one_by_one() {
    let unsaid = |text: &str, overrides: &[&str]| parsed(text, overrides).unwrap().scene.camera.unwrap().unsaid;
    assert_eq!(unsaid("[camera]\norigin = [0, 0, 0]", &[]), Unsaid { origin: false, ..Unsaid::ALL });
    assert_eq!(unsaid("", &["camera.vfov=20"]), Unsaid { vfov: false, ..Unsaid::ALL });
    assert!(!unsaid("[camera]\ntarget = [1, 2, 3]", &["camera.up=[0, 0, 1]"]).up);
    // a camera with a place has the page's defaults
    let camera = parsed("[camera]\norigin = [0, 0, 0]", &["camera.target=[0, 0, 1]"]).unwrap().scene.camera.unwrap();
    assert!(!camera.unsaid.is_open() && !camera.unsaid.vfov && camera.vfov == 45.0);
}

#[test]
fn cameras_with_names_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let named = "origin = [1, 0, 0]\ntarget = [0, 0, 0]\n";
    let cameras = format!("[cameras.side]\n{named}vfov = 20\n[cameras.front]\n{named}vfov = 30\n");
    let json = r#"{"obj": "a.obj", "cameras": {
        "side": {"origin": [1, 0, 0], "target": [0, 0, 0], "vfov_deg": 20, "width": 64, "height": 48},
        "front": {"origin": [0, 0, 1], "target": [0, 0, 0], "vfov_deg": 30}}}"#;
    let texts = [("several.toml", &*cameras), ("with.toml", &format!("[camera]\n{named}vfov = 40\n{cameras}"))];
    for (name, text) in texts.into_iter().chain([("scene.json", json)]) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let seen_by = |file: &str, camera: Option<&str>, overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
        load_seen_by(&folder.path().join(file), camera, &overrides).map(|(file, _)| file.scene)
    };
    let vfov = |file, camera| seen_by(file, camera, &[]).unwrap().camera.unwrap().vfov;
    for file in ["several.toml", "scene.json"] {
        assert_eq!((vfov(file, Some("front")), vfov(file, Some("side")), vfov(file, None)), (30.0, 20.0, 20.0));
    }
    assert_eq!((vfov("with.toml", None), vfov("with.toml", Some("side"))), (40.0, 20.0));
    let film = seen_by("scene.json", Some("side"), &[]).unwrap().film;
    assert_eq!((film.width, film.height), (64, 48));
    assert_eq!(seen_by("scene.json", Some("front"), &[]).unwrap().film, FilmSettings::default());
    let changed = seen_by("several.toml", Some("front"), &["camera.vfov=5"]).unwrap().camera.unwrap();
    assert_eq!((changed.vfov, changed.origin.as_vec3()), (5.0, Vec3::X));

    let fault = |file, camera| seen_by(file, Some(camera), &[]).unwrap_err().to_string();
    assert!(fault("several.toml", "frnt").ends_with("there is no camera `frnt`: did you mean `front`?"));
    assert!(fault("scene.json", "top-down").ends_with("there is no camera `top-down`: known are `side` and `front`"));
    let none = load_seen_by(Path::new("dir/a.obj"), Some("front"), &[]).unwrap_err().to_string();
    assert_eq!(none, "dir/a.obj: there is no camera `front`, for no camera of this scene has a name");
}

#[test]
fn an_obj_alone_is_a_scene() {
    let (file, _) = load(Path::new("dir/a.OBJ"), &["render.spp=7".to_string()]).unwrap();
    assert_eq!(file.scene.meshes[0].source.path(), Some(Path::new("dir/a.OBJ")));
    assert_eq!((file.scene.camera, file.render.spp), (None, 7));
    let error = load(Path::new("a.blend"), &[]).unwrap_err().to_string();
    assert_eq!(
        error,
        "a.blend: not a scene: its name must end in .toml, .json, .obj, .ply, .xml, .gltf, .glb or .pbrt"
    );
    let error = parse("", Path::new("s.toml"), &[]).unwrap().1;
    assert_eq!(error, ["the scene has no [[mesh]]: only its background will be seen"]);
}

#[test]
fn bytes_of_files_are_judged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, b"[film]\n# \xC3\xA9 \xFF").unwrap();
    let error = load(&path, &[]).unwrap_err().to_string();
    assert!(error.ends_with("s.toml:2:5: this byte is not UTF-8"), "{error}");
    std::fs::write(&path, "\u{feff}film = 1").unwrap();
    let error = load(&path, &[]).unwrap_err().to_string();
    assert!(error.ends_with("s.toml:1:8: [film] must be a table, found an integer"), "{error}");
    let missing = load(&folder.path().join("missing.toml"), &[]).unwrap_err();
    assert!(matches!(missing, Error::Io { .. }), "{missing}");
}

/// What a mutation puts in: parts of the language, and numbers that break programs.
const SCRAPS: &[&str] = &[
    "",
    "=",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "\"",
    "'",
    "\n",
    ".",
    ",",
    "#",
    "-",
    "nan",
    "inf",
    "1e999",
    "-0.0",
    "0",
    "[]",
    "{}",
    "\u{0}",
    "é",
    "\u{feff}",
    "99999999999999999999",
    "true",
    "1979-05-27",
    "[film]\n",
    "[[light]]\n",
    "type",
    "texture",
    "\\u00e9",
];

/// Replaces a stretch of characters, wherever it falls.
fn mutated(text: &str, edits: &[(usize, usize, usize)]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for (at, length, scrap) in edits {
        let at = at % (chars.len() + 1);
        let end = (at + length).min(chars.len());
        chars.splice(at..end, SCRAPS[scrap % SCRAPS.len()].chars());
    }
    chars.into_iter().collect()
}

fn edits() -> impl Strategy<Value = Vec<(usize, usize, usize)>> {
    proptest::collection::vec((any::<usize>(), 0..12usize, any::<usize>()), 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is written: an error with a place in the file, or a scene of finite numbers.
    #[test]
    fn mutations_never_panic(edits in edits()) {
        let text = mutated(WHOLE, &edits);
        match parsed(&text, &[]) {
            Err(Error::Parse { line, column, .. }) => {
                prop_assert!(column >= 1 && line >= 1 && line <= text.matches('\n').count() + 1);
            }
            Err(e) => prop_assert!(false, "{e}"),
            Ok(scene) => {
                let shown = format!("{scene:?}");
                prop_assert!(!shown.contains("NaN") && !shown.contains(": inf"), "{shown}");
            }
        }
    }

    #[test]
    fn overrides_never_panic(edits in edits(), which in 0..3usize) {
        let text = ["camera.origin=[0,1,2]", "material.Floor.alpha=0.2", "film.filter=box"][which];
        let text = mutated(text, &edits);
        if let Err(e) = parsed(WHOLE, &[&text]) {
            prop_assert!(e.to_string().starts_with("--set '"), "{e}");
        }
    }
}

#[test]
fn an_sd_tree_is_not_updated_on_line() {
    let fault = |text: &str| parse(text, Path::new("s.toml"), &[]).unwrap_err().to_string();
    let message = fault("[guiding]\nmethod = \"sdtree\"\nupdates = \"online\"\n");
    assert!(message.contains("s.toml:3") && message.contains("`updates`") && message.contains("frozen"), "{message}");
    assert!(parse("[guiding]\nmethod = \"grid\"\nupdates = \"online\"\n", Path::new("s.toml"), &[]).is_ok());
}
