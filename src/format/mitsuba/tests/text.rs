//! What the text may say, and what is wrong with it.

use super::{companions, read};
use crate::bsdf::{BsdfDescription, DiffuseParameters};
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::texture::{ColorTexture, ScalarTexture};
use std::fs;

const SHAPE: &str = "<shape type=\"rectangle\"/>";

fn reflectance(bsdf: &BsdfDescription) -> Rgb {
    match bsdf {
        BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Constant(color) }) => *color,
        other => panic!("{other:?}"),
    }
}

#[test]
fn references_defaults_includes_and_old_names_are_understood() {
    let folder = companions();
    fs::create_dir(folder.path().join("parts")).unwrap();
    let part = "<scene version=\"0.6.0\"><bsdf type=\"diffuse\" id=\"red\"><rgb name=\"reflectance\" value=\"$r 0 0\"/></bsdf>\n\
                <shape type=\"ply\"><string name=\"filename\" value=\"../dome.ply\"/><ref id=\"late\"/></shape></scene>";
    fs::write(folder.path().join("parts/part.xml"), part).unwrap();
    let text = "<?xml version=\"1.0\"?>\n<scene version=\"0.6.0\">\n<default name=\"r\" value=\"0.25\"/><default name=\"r\" value=\"0.75\"/>\n\
        <integrator type=\"path\"><integer name=\"maxDepth\" value=\"$depth0\"/></integrator>\n\
        <include filename=\"parts/part.xml\"/>\n\
        <shape type=\"rectangle\"><ref id=\"red\"/><transform name=\"toWorld\"><scale value=\"2\"/><translate y=\"1\"/>\
        <rotate z=\"1\" angle=\"90\"/></transform></shape>\n\
        <bsdf type=\"twosided\" id=\"late\"><bsdf type=\"diffuse\"><srgb name=\"reflectance\" value=\"#ffffff\"/></bsdf></bsdf>\n</scene>";
    let text = text.replacen("<integrator", "<default name=\"depth\" value=\"1\"/><integrator", 1);
    let (file, warnings) = read(folder.path(), &text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(file.integrator.max_depth, 10, "`$depth0` is `$depth` and a 0");
    let [hill, square] = &file.scene.meshes[..] else { panic!("{:?}", file.scene.meshes) };
    assert_eq!(square.material.as_deref(), Some("red"));
    assert_eq!(reflectance(&file.scene.materials["red"].bsdf), Rgb::new(0.25, 0.0, 0.0));
    let late = &file.scene.materials[hill.material.as_ref().unwrap()];
    assert!(late.two_sided && reflectance(&late.bsdf) == Rgb::ONE, "{late:?}");
    let corner = square.transform.transform_point3(glam::DVec3::new(1.0, 1.0, 0.0));
    assert!((corner - glam::DVec3::new(-3.0, 2.0, 0.0)).length() < 1e-12, "scaled, moved, then turned: {corner}");
    file.load_scene(1).unwrap();
}

#[test]
fn files_are_looked_for_beside_the_file_that_names_them_then_in_the_folders_named() {
    let folder = companions();
    for name in ["scenes/parts", "common/meshes"] {
        fs::create_dir_all(folder.path().join(name)).unwrap();
    }
    fs::copy(folder.path().join("dome.ply"), folder.path().join("common/meshes/far.ply")).unwrap();
    fs::copy(folder.path().join("dome.ply"), folder.path().join("scenes/near.ply")).unwrap();
    let mesh = |name: &str| format!("<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/></shape>");
    let part = format!("<scene version=\"3.0.0\">{}{}</scene>", mesh("meshes/far.ply"), mesh("near.ply"));
    fs::write(folder.path().join("scenes/parts/part.xml"), part).unwrap();
    let read = |head: &str| {
        let text = format!("<scene version=\"3.0.0\">\n{head}\n<include filename=\"parts/part.xml\"/></scene>");
        super::read(&folder.path().join("scenes"), &text)
    };
    let (file, warnings) = read("<path value=\"../common\"/>").unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    file.load_scene(1).unwrap();
    let error = read("").unwrap().0.load_scene(1).err().unwrap().to_string();
    assert!(error.contains("parts/meshes/far.ply"), "{error}");
    let error = read("<path value=\"../other\"/>").unwrap_err().to_string();
    assert!(error.contains("scene.xml:2") && error.contains("no folder"), "{error}");
}

#[test]
fn things_may_stand_within_or_beside_what_uses_them() {
    let folder = companions();
    let scene = |body: &str| {
        let lamp = "<emitter type=\"area\" id=\"lamp\"><rgb name=\"radiance\" value=\"3 2 1\"/></emitter>";
        let within = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"2\"/></integrator>";
        let text = format!(
            "<scene version=\"3.0.0\"><integrator type=\"moment\">{within}</integrator>\n{lamp}\n\
             <bsdf type=\"normalmap\" id=\"flat\"><texture type=\"rawconstant\" name=\"normalmap\">\
             <vector name=\"value\" value=\"0.5 0.5 1\"/></texture><bsdf type=\"diffuse\"/></bsdf>\n\
             <shape type=\"rectangle\"><ref id=\"flat\"/>{body}</shape></scene>"
        );
        read(folder.path(), &text)
    };
    let (file, warnings) = scene("<ref id=\"lamp\"/>").unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(file.integrator.max_depth, 2, "that of the integrator within");
    let material = &file.scene.materials[file.scene.meshes[0].material.as_ref().unwrap()];
    assert_eq!(material.emission, Rgb::new(3.0, 2.0, 1.0));
    assert!(material.relief.is_some());
    file.load_scene(1).unwrap();
    let error = scene("").unwrap_err().to_string();
    assert!(error.contains("scene.xml:2") && error.contains("no shape refers"), "{error}");
}

#[test]
fn what_is_said_from_outside_holds_over_defaults() {
    let folder = companions();
    let text = "<scene version=\"3.0.0\"><default name=\"depth\" value=\"3\"/><default name=\"unused\" value=\"1\"/>\
        <integrator type=\"path\"><integer name=\"max_depth\" value=\"$depth\"/></integrator>\
        <sensor type=\"perspective\"><sampler type=\"independent\"><integer name=\"sample_count\" value=\"$spp\"/></sampler></sensor></scene>";
    fs::write(folder.path().join("scene.xml"), text).unwrap();
    let load = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|text| text.to_string()).collect();
        crate::format::load(&folder.path().join("scene.xml"), &overrides).map(|(file, _)| file)
    };
    let file = load(&["default.spp=64", "render.seed=9", "default.unused=2"]).unwrap();
    assert_eq!((file.render.spp, file.integrator.max_depth, file.render.seed), (64, 3, 9));
    let file = load(&["default.depth=5", "default.spp = \"7\"", "default.depth=6"]).unwrap();
    assert_eq!((file.render.spp, file.integrator.max_depth), (7, 6));
    for (overrides, wanted) in [
        (&[][..], "nothing says what `$spp` is: <default> or -D spp=VALUE does"),
        (
            &["default.spp=1", "default.dept=5"],
            "--set 'default.dept=5': the scene has no `$dept`: did you mean `depth`",
        ),
        (&["default.spp=1", "render.sed=5"], "--set 'render.sed=5'"),
        (&["default.spp"], "expected default.NAME=VALUE"),
        (&["default.spp=many"], "`many` is not a number"),
    ] {
        let message = load(overrides).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(wanted), "{message}\nis not\n{wanted}");
    }
    fs::write(folder.path().join("a.toml"), "[camera]\norigin = [0, 0, 1]\ntarget = [0, 0, 0]\n").unwrap();
    let message =
        crate::format::load(&folder.path().join("a.toml"), &["default.spp=1".into()]).err().unwrap().to_string();
    assert!(message.contains("the scene has no `$spp`"), "{message}");
}

#[test]
fn black_bodies_and_mixtures_of_old_versions_are_read() {
    let folder = companions();
    let text = "<scene version=\"0.6.0\"><emitter type=\"constant\"><blackbody name=\"radiance\" temperature=\"6500K\" scale=\"1e-4\"/></emitter>\
        <emitter type=\"point\"><spectrum name=\"intensity\" value=\"3, 2, 1\"/></emitter><emitter type=\"sun\"/>\
        <shape type=\"rectangle\"><bsdf type=\"mixturebsdf\"><string name=\"weights\" value=\"0.25, 0.75\"/>\
        <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 0 0\"/></bsdf><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0 1 0\"/></bsdf></bsdf></shape>\
        <shape type=\"rectangle\"><bsdf type=\"mixturebsdf\"><string name=\"weights\" value=\"0.3 0.4 0.3\"/><bsdf type=\"diffuse\"/><bsdf type=\"conductor\"/>\
        <bsdf type=\"diffuse\"/></bsdf></shape></scene>";
    let (file, warnings) = read(folder.path(), text).unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(matches!(&file.scene.lights[1], LightDescription::Point(p) if p.intensity == Rgb::new(3.0, 2.0, 1.0)));
    // in the west, 46° above the horizon
    assert!(matches!(&file.scene.lights[2], LightDescription::Sun(s) if s.direction.x > 0.69 && s.direction.y < -0.72));
    let LightDescription::Constant(light) = &file.scene.lights[0] else { panic!() };
    // Planck's law at 560 nm, where the eye sees best, is 4.23·10⁴ W/(sr·m²·nm), and nearly straight about it
    let seen = crate::math::luminance(light.radiance);
    assert!((seen / 4.23 - 1.0).abs() < 0.03 && light.radiance.x > light.radiance.y, "{seen} {light:?}");
    let mixed = &file.scene.materials[file.scene.meshes[0].material.as_ref().unwrap()].bsdf;
    assert_eq!(reflectance(mixed), Rgb::new(0.25, 0.75, 0.0));
    let three = file.scene.materials[file.scene.meshes[1].material.as_ref().unwrap()].blend.clone().unwrap();
    let (ScalarTexture::Constant(third), within) = (&three.weight, three.parts[0].material.blend.as_ref().unwrap())
    else {
        panic!()
    };
    let ScalarTexture::Constant(second) = within.weight else { panic!() };
    assert!((third - 0.3).abs() < 1e-6 && (second - 4.0 / 7.0).abs() < 1e-6, "{three:?}");
    assert!(matches!(within.parts[1].material.bsdf, BsdfDescription::Conductor(_)));
}

#[test]
fn blends_of_unlike_materials_keep_both() {
    let folder = companions();
    let shape = |bsdf: &str| {
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"rectangle\">{bsdf}<emitter type=\"area\"/></shape></scene>"
        );
        let (file, warnings) = read(folder.path(), &text).unwrap();
        let material = file.scene.materials.values().next().unwrap().clone();
        file.load_scene(1).unwrap();
        (material, warnings)
    };
    let inner = "<bsdf type=\"blendbsdf\"><texture type=\"bitmap\" name=\"weight\"><string name=\"filename\" value=\"mask.png\"/>\
        <boolean name=\"raw\" value=\"true\"/></texture><bsdf type=\"diffuse\"/><bsdf type=\"plastic\"/></bsdf>";
    let (both, warnings) = shape(&format!("<bsdf type=\"twosided\">{inner}</bsdf>"));
    assert!(warnings.is_empty(), "{warnings:?}");
    let parts = &both.blend.as_ref().unwrap().parts;
    assert!(parts.iter().all(|part| part.material.two_sided && part.material.emission == Rgb::ZERO));
    assert_eq!(both.emission, Rgb::ONE);
    assert!(matches!(&both.blend.unwrap().weight, ScalarTexture::Luminance(image) if image.path.ends_with("mask.png")));
    let (one_sided, _) = shape(inner);
    assert!(one_sided.blend.unwrap().parts.iter().all(|part| !part.material.two_sided));
    let (masked, _) = shape(&format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/>{inner}</bsdf>"));
    assert_eq!(masked.opacity, Some(ScalarTexture::Constant(0.25)));
    let transmissive = "<bsdf type=\"principled\"><float name=\"spec_trans\" value=\"0.3\"/><float name=\"metallic\" value=\"0.2\"/></bsdf>";
    let (transmissive, warnings) = shape(transmissive);
    assert!(warnings.is_empty(), "{warnings:?}");
    let metallic = transmissive.blend.unwrap();
    let within = metallic.parts[0].material.blend.as_ref().unwrap();
    assert_eq!([&metallic.weight, &within.weight], [&ScalarTexture::Constant(0.2), &ScalarTexture::Constant(0.3)]);
    assert!(matches!(&within.parts[1].material.bsdf, BsdfDescription::Dielectric(glass) if glass.alpha == 0.25));
}

#[test]
fn groups_stand_where_their_instances_do() {
    let folder = companions();
    let text = "<scene version=\"3.0.0\"><shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/>\
        <shape type=\"disk\"><emitter type=\"area\"/></shape></shape>\
        <shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"5\"/></transform></shape>\
        <shape type=\"instance\"><ref id=\"g\"/></shape></scene>";
    let (file, warnings) = read(folder.path(), text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(file.scene.instances.len(), 2);
    assert!(file.scene.meshes.iter().all(|mesh| mesh.group.as_deref() == Some("g")));
    let scene = file.load_scene(1).unwrap().0;
    assert_eq!(scene.triangles(), 2 * (12 + 96));
    assert!(scene.bounds().1.x > 5.9);
}

#[test]
fn what_means_nothing_is_named_with_its_line() {
    let folder = companions();
    let text = "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/>\n\
        <float name=\"colour\" value=\"1\"/></sensor>\n<sensor type=\"perspective\"/>\n<shape type=\"sphere\">\n\
        <bsdf type=\"oren_nayar\"><rgb name=\"reflectance\" value=\"2 0 0\"/></bsdf></shape>\n\
        <emitter type=\"constant\"/>\n<integrator type=\"ptracer\"/></scene>";
    let (file, warnings) = read(folder.path(), text).unwrap();
    let wanted = [
        ":8: the integrator `ptracer` has no counterpart",
        ":4: only the first sensor counts",
        ":3: `colour` of the sensor `perspective` means nothing here",
        ":6: the bsdf `oren_nayar` has no counterpart: `diffuse`",
        ":6: `reflectance` of the bsdf `oren_nayar` is above 1",
    ];
    assert_eq!(warnings.len(), wanted.len(), "{warnings:#?}");
    for (warning, wanted) in warnings.iter().zip(wanted) {
        assert!(warning.contains(wanted), "{warning}\nis not\n{wanted}");
    }
    assert!(matches!(file.scene.lights[..], [LightDescription::Constant(_)]));
}

#[test]
fn faults_are_named_with_their_line() {
    let folder = companions();
    fs::write(folder.path().join("loop.xml"), "<scene version=\"3.0.0\"><include filename=\"loop.xml\"/></scene>")
        .unwrap();
    let bomb = "<!DOCTYPE s [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]><scene version=\"3.0.0\">&b;</scene>";
    let scene = |body: &str| format!("<scene version=\"3.0.0\">\n{body}\n</scene>");
    let shape = |inner: &str| scene(&format!("<shape type=\"sphere\">{inner}</shape>"));
    let cases = [
        ("<scene version=\"3.0.0\">".to_string(), "scene.xml:1:"),
        ("<bsdf/>".to_string(), ":1:1: `bsdf` is no scene"),
        (bomb.to_string(), "not XML"),
        (scene("<include filename=\"loop.xml\"/>"), "loop.xml:1:24: too many files are included"),
        (scene("<include filename=\"none.xml\"/>"), "none.xml"),
        (scene("<shape type=\"sphere\"><ref id=\"x\"/></shape>"), ":2:22: nothing has the id `x`"),
        (scene("<shape type=\"teapot\"/>"), ":2:1: the shape `teapot` has no counterpart"),
        (scene("<shape type=\"ply\"/>"), "needs `filename`"),
        (shape("<bsdf type=\"hair\"/>"), "the bsdf `hair` has no counterpart"),
        (shape("<bsdf type=\"mask\"/>"), "the bsdf `mask` needs another bsdf"),
        (shape("<bsdf type=\"conductor\"><string name=\"material\" value=\"Ux\"/></bsdf>"), "unknown metal `Ux`"),
        (shape("<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"watr\"/></bsdf>"), "did you mean `water`"),
        (shape("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1 2\"/></bsdf>"), "`1 2` is not a colour"),
        (shape("<float name=\"radius\" value=\"big\"/>"), "`big` is not a number"),
        (shape("<float name=\"radius\" value=\"$big\"/>"), "nothing says what `$big` is"),
        (shape("<float name=\"radius\" value=\"0\"/>"), "its transform flattens it"),
        (shape("<string name=\"radius\" value=\"1\"/>"), "`radius` of the shape `sphere` must be a number"),
        (shape("<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/>"), "two objects with the id `a`"),
        (scene("<emitter type=\"projector\"/>"), "the emitter `projector` has no counterpart"),
        (
            scene(
                "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf><shape type=\"sphere\"><ref id=\"a\"/></shape>",
            ),
            "within itself",
        ),
        (scene("<wheel/>"), "<wheel> is not known"),
    ];
    for (text, wanted) in cases {
        let message = read(folder.path(), &text).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(wanted), "{message}\nis not\n{wanted}\nof\n{text}");
    }
    let deep =
        format!("<scene version=\"3.0.0\">{}{}</scene>", "<bsdf type=\"mask\">".repeat(3000), "</bsdf>".repeat(3000));
    assert!(read(folder.path(), &deep).is_err());
    let wide = scene(&SHAPE.repeat(500));
    assert_eq!(read(folder.path(), &wide).unwrap().0.scene.meshes.len(), 500);
}

#[test]
fn damaged_scenes_never_panic() {
    let folder = companions();
    let mut rng = crate::math::rng::Rng::new(5);
    for (_, text) in super::plugins::scenes() {
        for _ in 0..20 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..1 + rng.next_u32() % 3 {
                let at = rng.next_u32() as usize % bytes.len().max(1);
                match rng.next_u32() % 3 {
                    0 if !bytes.is_empty() => bytes[at] = rng.next_u32() as u8,
                    1 => drop(bytes.drain(at..(at + 7).min(bytes.len()))),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            if let Ok(text) = String::from_utf8(bytes) {
                _ = read(folder.path(), &text).map(drop);
            }
        }
    }
}

#[test]
fn attributes_of_meshes_are_found_or_missed_with_their_place() {
    let folder = companions();
    let load = |kind: &str, file: &str, bsdf: &str| {
        let text = format!("<scene version=\"3.0.0\">\n<shape type=\"{kind}\">{file}\n{bsdf}</shape></scene>");
        read(folder.path(), &text).and_then(|(file, _)| file.load_scene(1))
    };
    let (painted, dome) =
        ("<string name=\"filename\" value=\"painted.ply\"/>", "<string name=\"filename\" value=\"dome.ply\"/>");
    let texture = |slot: &str, name: &str| {
        format!("<texture type=\"mesh_attribute\" name=\"{slot}\"><string name=\"name\" value=\"{name}\"/></texture>")
    };
    let diffuse = |name: &str| format!("<bsdf type=\"diffuse\">{}</bsdf>", texture("reflectance", name));
    for name in ["face_color", "face_tone_color", "vertex_heat"] {
        load("ply", painted, &diffuse(name)).unwrap();
    }
    let blend = format!("<bsdf type=\"blendbsdf\">{}{}</bsdf>", diffuse("face_color"), diffuse("face_tone_color"));
    let rough = format!("<bsdf type=\"principled\">{}</bsdf>", texture("roughness", "face_tone_color"));
    for (kind, file, bsdf, wanted) in [
        (
            "ply",
            painted,
            diffuse("face_heat"),
            "painted.ply: there is no attribute `face_heat` of three numbers or of one",
        ),
        ("ply", dome, diffuse("face_color"), "dome.ply: there is no attribute `face_color`"),
        ("rectangle", "", diffuse("face_color"), "scene.xml:2:1: the shape `rectangle` has no attribute `face_color`"),
        (
            "rectangle",
            "",
            diffuse("vertex_color"),
            "scene.xml:2:1: the shape `rectangle` has no attribute `vertex_color`",
        ),
        (
            "ply",
            painted,
            diffuse("color"),
            "scene.xml:3:22: the `name` of an attribute begins with `vertex_` or `face_`",
        ),
        ("ply", painted, blend, "`face_tone_color` beside `face_color`: a mesh has one attribute here"),
        ("ply", painted, rough, "scene.xml:3:25: a number of a mesh's attribute is not read"),
    ] {
        let message = load(kind, file, &bsdf).map(drop).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}: not {wanted}");
    }
}

#[test]
fn of_two_roughnesses_the_mean_is_taken_and_said() {
    let folder = companions();
    for (alphas, alpha, said) in [((0.1, 0.4), 0.25, true), ((0.3, 0.3), 0.3, false)] {
        let (u, v) = alphas;
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"sphere\">\n<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"{u}\"/>\
             <float name=\"alpha_v\" value=\"{v}\"/></bsdf></shape></scene>"
        );
        let (file, warnings) = read(folder.path(), &text).unwrap();
        let BsdfDescription::Conductor(metal) = &file.scene.materials.values().next().unwrap().bsdf else { panic!() };
        assert_eq!(metal.alpha, alpha);
        let message = "scene.xml:2: α of 0.1 along u and of 0.4 along v has no counterpart: the mean, 0.25, is taken";
        let expected = if said { vec![message] } else { vec![] };
        assert!(warnings.len() == expected.len() && warnings.iter().all(|w| w.ends_with(message)), "{warnings:?}");
    }
}
