//! What is written for Mitsuba.

use super::*;
use crate::film::Filter;
use crate::scene::obj;

fn written(more: &str) -> Result<(TempDir, String, Translation)> {
    let (room, description) = room(more);
    let translation = Translation::write(&description, 5, room.path())?;
    let text = fs::read_to_string(&translation.file).unwrap();
    Ok((room, text, translation))
}

#[test]
fn camera_film_and_integrator_are_the_scenes() {
    let (_room, text, translation) = written("combine = \"last\"\n").unwrap();
    for line in [
        "<integer name=\"max_depth\" value=\"4\"/>",
        "<integer name=\"rr_depth\" value=\"3\"/>",
        "<float name=\"fov\" value=\"40\"/>",
        "<string name=\"fov_axis\" value=\"y\"/>",
        "<lookat origin=\"0, 1.2, 4.5\" target=\"0, 0.6, 0\" up=\"0, 1, 0\"/>",
        "<integer name=\"width\" value=\"32\"/>",
        "<rfilter type=\"box\"/>",
        "<emitter type=\"area\">",
        "<rgb name=\"radiance\" value=\"8, 7, 5\"/>",
    ] {
        assert!(text.contains(line), "{line} is missing in:\n{text}");
    }
    let d = &translation.description;
    assert_eq!((d.render.spp, d.guiding.method, d.scene.film.filter), (5, GuidingMethod::None, Filter::Box));
}

#[test]
fn meshes_come_back_as_they_were() {
    let (room, text, _) = written("").unwrap();
    assert_eq!(text.matches("<shape type=\"obj\">").count(), 2);
    let before = obj::load(&room.path().join("room.obj")).unwrap().mesh;
    let after = ["part-0.obj", "part-1.obj"].map(|name| obj::load(&room.path().join(name)).unwrap().mesh);
    let corners = |mesh: &crate::geometry::Mesh| (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect::<Vec<_>>();
    let all: Vec<_> = after.iter().flat_map(corners).collect();
    assert_eq!(all.len(), 4);
    assert!(corners(&before).iter().all(|facet| all.contains(facet)), "{all:?}");
}

#[test]
fn texture_coordinates_and_normals_are_kept_where_they_matter() {
    let texture = "[material.floor]\ntype = \"diffuse\"\n\
        reflectance = { texture = \"a & b.png\", scale = [3, 2], offset = [0.25, 0.5] }\n";
    let (room, text, _) = written(texture).unwrap();
    assert!(text.contains("a &amp; b.png\"/>") && text.contains("<scale x=\"3\" y=\"2\"/>"), "{text}");
    // 1 − (2·(1 − v′) + ½) = 2v′ − 1½
    assert!(text.contains("<translate x=\"0.25\" y=\"-1.5\"/>"), "{text}");
    let floor = ["part-0.obj", "part-1.obj"].map(|name| fs::read_to_string(room.path().join(name)).unwrap());
    assert!(floor.iter().any(|text| text.contains("vt 1 1") && text.contains("f 1/1 2/2 3/3")), "{floor:?}");
    assert!(floor.iter().any(|text| !text.contains("vt")), "the lamp has no texture: {floor:?}");
    assert_eq!(text.matches("name=\"face_normals\" value=\"true\"").count(), 2);
}

#[test]
fn what_mitsuba_does_not_have_is_refused_by_name() {
    let floor = |rest: &str| format!("[material.floor]\n{rest}\n");
    for (more, word) in [
        (floor("type = \"diffuse\"\nopacity = 0.5"), "material `floor`: opacity"),
        (floor("type = \"diffuse_transmitter\""), "material `floor`: the type `diffuse_transmitter`"),
        (floor("type = \"diffuse\"\nemission = 1\nemission_two_sided = true"), "emission on both sides"),
        (floor("type = \"diffuse\"\nreflectance = { texture = \"a.png\", tint = 0.5 }"), "a tinted texture"),
        ("[[light]]\ntype = \"constant\"\nradiance = 1\n".repeat(2), "two lights that surround"),
        ("[[light]]\ntype = \"environment\"\npath = \"sky.exr\"\nscale = [1, 2, 1]\n".to_owned(), "a coloured scale"),
        ("[[mesh]]\npath = \"room.obj\"\ngroup = \"g\"\n[[instance]]\ngroup = \"g\"\n".to_owned(), "instances"),
    ] {
        let error = written(&more).err().expect(word).to_string();
        assert!(error.starts_with("Mitsuba has no counterpart") && error.contains(word), "{error}");
    }
    let (folder, mut description) = room("");
    description.integrator.mis = false;
    let error = Translation::write(&description, 5, folder.path()).err().unwrap().to_string();
    assert!(error.contains("integrator.mis"), "{error}");
}

/// The sphere of unit radius, with normals and texture coordinates.
fn sphere() -> String {
    const ROWS: usize = 24;
    let mut text = String::new();
    for i in 0..=ROWS {
        for j in 0..=2 * ROWS {
            let (u, v) = (j as f64 / (2 * ROWS) as f64, i as f64 / ROWS as f64);
            let (theta, phi) = (std::f64::consts::PI * v, std::f64::consts::TAU * u);
            let (x, y, z) = (theta.sin() * phi.sin(), -theta.cos(), theta.sin() * phi.cos());
            text += &format!("v {x} {y} {z}\nvn {x} {y} {z}\nvt {u} {v}\n");
        }
    }
    let mut face = |corners: [usize; 3]| text += &format!("f {}\n", corners.map(|c| format!("{c}/{c}/{c}")).join(" "));
    for i in 0..ROWS {
        for j in 0..2 * ROWS {
            let a = 1 + i * (2 * ROWS + 1) + j;
            let (b, c, d) = (a + 1, a + 2 * ROWS + 2, a + 2 * ROWS + 1);
            face([a, b, c]);
            face([a, c, d]);
        }
    }
    text
}

/// Every kind of material that is translated, on spheres of 0.35.
const MATERIALS: [&str; 12] = [
    "type = \"diffuse\"\nreflectance = { texture = \"dots.exr\", scale = [5, 3], offset = [0.2, 0.4] }",
    "type = \"diffuse\"\nreflectance = { texture = \"dots.exr\", scale = [2, 2], nearest = true }",
    "type = \"mirror\"\nspecular_reflectance = [0.9, 0.8, 0.7]",
    "type = \"conductor\"\neta = [0.2, 0.924, 1.102]\nk = [3.912, 2.452, 2.142]",
    "type = \"conductor\"\neta = [0.2, 0.924, 1.102]\nk = [3.912, 2.452, 2.142]\nalpha = 0.2\ndistribution = \"beckmann\"",
    "type = \"dielectric\"\nint_ior = 1.5\nspecular_transmittance = [0.8, 0.9, 1]",
    "type = \"dielectric\"\nint_ior = 1.4\nalpha = 0.2",
    "type = \"dielectric\"\nthin = true",
    "type = \"plastic\"\nreflectance = [0.2, 0.4, 0.7]\nnonlinear = true",
    "type = \"plastic\"\nreflectance = [0.7, 0.4, 0.2]\nalpha = 0.15",
    "type = \"principled\"\nbase_color = [0.7, 0.3, 0.3]\nmetallic = 0.3\nroughness = 0.4\nclearcoat = 0.5\nsheen = 0.4",
    "type = \"null\"",
];

/// The room with a sphere of each material in three rows, under these lights.
fn gallery(lights: &str) -> (TempDir, SceneFile) {
    let mut more = "spp = 1\n".to_owned();
    for (k, material) in MATERIALS.iter().enumerate() {
        let (x, z) = (0.9 * (k % 4) as f32 - 1.35, 0.9 * (k / 4) as f32 - 1.2);
        more += &format!("[material.m{k}]\n{material}\n");
        more += &format!(
            "[[mesh]]\npath = \"sphere.obj\"\nscale = 0.35\ntranslate = [{x}, 0.4, {z}]\nmaterial = \"m{k}\"\n"
        );
    }
    let (folder, mut description) = room(&(more + lights));
    fs::write(folder.path().join("sphere.obj"), sphere()).unwrap();
    let dots: Vec<crate::math::Rgb> = (0..64)
        .map(|i| crate::math::Rgb::new((i % 8) as f32 / 8.0, (i / 8) as f32 / 8.0, (i % 3) as f32 / 3.0))
        .collect();
    let (window, layer) = (Window::full(8, 8), Layer::color("", &dots));
    exr::write(&folder.path().join("dots.exr"), &window, vec![layer], &Metadata::default()).unwrap();
    (description.scene.film.width, description.scene.film.height, description.integrator.max_depth) = (96, 72, 8);
    (folder, description)
}

/// Python with Mitsuba, where `PHOTOTAXIS_PYTHON` names one.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("PHOTOTAXIS_PYTHON").map(PathBuf::from);
    if python.is_none() {
        eprintln!("SKIPPED: PHOTOTAXIS_PYTHON names no Python that has Mitsuba");
    }
    python
}

fn start(description: &SceneFile, python: &Path) -> Mitsuba {
    let plan = MitsubaPlan { spp: 128, threads: 2 };
    let started = Mitsuba::start(description, plan, python, None).unwrap();
    assert!(started.missing().is_empty(), "{:?}", started.missing());
    started
}

/// Of what is tolerated, about five standard errors of a region in [`gallery`] (false alarm below 10⁻⁴ for all tests).
const NEAR: f64 = 0.3;

#[test]
fn every_material_and_light_is_the_same_in_mitsuba() {
    let Some(python) = python() else { return };
    let far = "[[light]]\ntype = \"point\"\nposition = [1, 2, 2]\nintensity = [1, 2, 3]\n\
        [[light]]\ntype = \"directional\"\ndirection = [1, -2, -1]\nirradiance = [1, 0.8, 0.6]\n\
        [[light]]\ntype = \"constant\"\nradiance = [0.2, 0.3, 0.4]\n";
    let sky = "[[light]]\ntype = \"environment\"\npath = \"dots.exr\"\nscale = 0.5\nrotate_y = 70\n";
    for lights in [far, sky] {
        let (_folder, mut description) = gallery(lights);
        for mirrored in [false, true] {
            description.scene.camera.as_mut().unwrap().mirrored = mirrored;
            for m in start(&description, &python).measure(2).unwrap().mitsuba {
                assert!(m.agreement.worst < NEAR, "{lights}: {m:?}");
            }
        }
    }
}

#[test]
fn one_sphere_of_another_material_is_not_the_same() {
    let Some(python) = python() else { return };
    let (_folder, description) = gallery("");
    let mut started = start(&description, &python);
    let mut other = started.translation.description.clone();
    other.scene.materials.insert("m8".into(), crate::scene::description::MaterialDescription::default());
    started.scene = other.load_scene(1).unwrap().0;
    match started.measure(2) {
        Ok(report) => assert!(report.mitsuba.iter().all(|m| m.agreement.worst > NEAR), "{report:?}"),
        Err(error) => assert!(error.to_string().contains("another picture"), "{error}"),
    }
}
