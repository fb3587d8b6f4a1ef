//! Each thing by a value that is known, or by the same scene in the project's own form.

use crate::Result;
use crate::bsdf::BsdfDescription;
use crate::film::Filter;
use crate::film::tile::Tile;
use crate::format::{self, SceneFile};
use crate::image::Layer;
use crate::image::exr::{self, Metadata, Window};
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::{Rgb, luminance, rng::Rng};
use crate::texture::{ColorTexture, EmbeddedPicture, ScalarTexture};
use flate2::write::GzEncoder;
use image::{Rgb as Pixel, RgbImage};
use std::f32::consts::PI;
use std::fs;
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

/// A picture of four colours, and surroundings of which only the texels about +z and those about +x shine.
fn companions() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
    RgbImage::from_fn(2, 2, |x, y| Pixel(texels[(2 * y + x) as usize])).save(at("pic.png")).unwrap();
    let write = |name: &str, width: usize, pixels: Vec<Rgb>| {
        let window = Window::full(width, pixels.len() / width);
        exr::write(&at(name), &window, vec![Layer::color("", &pixels)], &Metadata::default()).unwrap();
    };
    let octahedral = |k: usize| {
        let (x, y) = (k % 16, k / 16);
        let red = (6..10).contains(&x) && (6..10).contains(&y);
        let green = x >= 10 && (4..12).contains(&y);
        Rgb::new(if red { 2.0 } else { 0.0 }, if green { 3.0 } else { 0.0 }, 0.0)
    };
    write("sky.exr", 16, (0..256).map(octahedral).collect());
    // longitude and latitude: red above, and green about longitude 0, where x is
    let long = |k: usize| {
        let (x, y) = (k % 32, k / 32);
        let green = !(4..28).contains(&x) && (6..10).contains(&y);
        Rgb::new(if y < 4 { 2.0 } else { 0.0 }, if green { 3.0 } else { 0.0 }, 0.0)
    };
    write("long.exr", 32, (0..512).map(long).collect());
    let quad = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                -1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n-1 1 0 0 1\n4 0 1 2 3\n";
    fs::write(at("quad.ply"), quad).unwrap();
    let mut packed = GzEncoder::new(fs::File::create(at("packed.ply.gz")).unwrap(), flate2::Compression::fast());
    packed.write_all(quad.as_bytes()).unwrap();
    packed.finish().unwrap();
    folder
}

fn read(folder: &Path, text: &str) -> Result<(SceneFile, Vec<String>)> {
    let path = folder.join("scene.pbrt");
    fs::write(&path, text).unwrap();
    format::load(&path, &[])
}

/// Read without a warning.
fn quiet(folder: &Path, text: &str) -> SceneFile {
    let (file, warnings) = read(folder, text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}\n{text}");
    file
}

/// All pixels, row by row from above.
fn pixels(file: &SceneFile, samples: u32) -> Vec<Rgb> {
    let scene = file.load_scene(1).unwrap().0;
    let (width, height) = (scene.camera.width, scene.camera.height);
    let task = Task { tile: Tile { x: 0, y: 0, width, height }, first_sample: 0, samples };
    let sums = PathIntegrator::plain(&scene, &file.integrator, 1).render(&task, &mut Batch::new()).samples.sum;
    sums.into_iter().map(|sum| sum * (scene.light_unit().value() as f32 / samples as f32)).collect()
}

fn mean(file: &SceneFile) -> Rgb {
    let all = pixels(file, 4096);
    all.iter().sum::<Rgb>() / all.len() as f32
}

/// A camera at z = 4 that sees [−0.35, 0.35]² of the plane z = 0 with y up and, as the world is left-handed there, x to the left.
const ABOVE: &str = "LookAt 0 0 4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 10\nPixelFilter \"box\"\n\
    Film \"rgb\" \"integer xresolution\" 2 \"integer yresolution\" [2]\nIntegrator \"path\" \"integer maxdepth\" 20\n";

const QUAD: &str = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \
    \"point2 uv\" [0 0 1 0 1 1 0 1]\n";

fn scene(world: &str) -> String {
    format!("{ABOVE}WorldBegin\n{world}")
}

/// Light from all around is sampled, with a deviation of about 0.6/√(4·4096) for white; all other light here is exact but for its
/// distance.
fn near(found: Rgb, wanted: Rgb, what: &str) {
    let off = (found - wanted).abs().max_element();
    let tolerance = if what.contains("infinite") { 0.025 } else { 4e-3 };
    assert!(off <= tolerance * wanted.max_element().max(0.01), "{what}: {found}, not {wanted}");
}

#[test]
fn lights_are_as_bright_as_pbrt_says() {
    let folder = companions();
    let floor = format!("Material \"diffuse\" \"rgb reflectance\" [0.8 0.4 0.2]\n{QUAD}");
    let lit = |light: &str| mean(&quiet(folder.path(), &scene(&format!("{floor}{light}"))));
    let albedo = Rgb::new(0.8, 0.4, 0.2);
    let far = "\"point3 from\" [0 0 100]";
    for (light, irradiance) in [
        (
            format!("LightSource \"distant\" {far} \"point3 to\" [0 0 0] \"rgb L\" [1 2 3] \"float scale\" 2"),
            Rgb::new(2.0, 4.0, 6.0),
        ),
        (
            format!("LightSource \"distant\" {far} \"rgb L\" [1 1 1] \"point3 to\" [0 0 0] \"float illuminance\" 5"),
            Rgb::splat(5.0),
        ),
        (format!("LightSource \"point\" {far} \"rgb I\" [20000 10000 5000]"), Rgb::new(2.0, 1.0, 0.5)),
        (format!("LightSource \"point\" {far} \"float power\" {}", 4e4 * PI), Rgb::ONE),
        ("AttributeBegin Translate 0 0 100 LightSource \"point\" \"float scale\" 10000 AttributeEnd".into(), Rgb::ONE),
        (format!("LightSource \"spot\" {far} \"point3 to\" [0 0 0] \"rgb I\" [1e4 1e4 1e4]"), Rgb::ONE),
        // half of the sphere is lit, and no cone is between
        (
            format!(
                "LightSource \"spot\" {far} \"point3 to\" [0 0 0] \"float coneangle\" 90 \"float conedeltaangle\" 0 \"float power\" {}",
                2e4 * PI
            ),
            Rgb::ONE,
        ),
        ("LightSource \"infinite\" \"rgb L\" [1 0.5 0.25]".into(), Rgb::new(1.0, 0.5, 0.25) * PI),
        ("LightSource \"infinite\" \"float illuminance\" 7".into(), Rgb::splat(7.0)),
        ("LightSource \"infinite\" \"spectrum L\" \"stdillum-D65\" \"float scale\" [ 3 ]".into(), Rgb::splat(3.0 * PI)),
    ] {
        near(lit(&light), albedo * irradiance / PI, &light);
    }
    // black bodies and spectra are as bright as white of 1
    for light in ["\"blackbody L\" 3000", "\"spectrum L\" [400 5 500 4 700 9]"] {
        let file = quiet(folder.path(), &scene(&format!("LightSource \"infinite\" {light}\n{QUAD}")));
        let crate::light::LightDescription::Constant(constant) = &file.scene.lights[0] else { panic!() };
        assert!((luminance(constant.radiance) - 1.0).abs() < 1e-5, "{light}: {constant:?}");
        assert!(constant.radiance.x > constant.radiance.z, "{light}: {constant:?}");
    }
}

#[test]
fn a_default_film_leaves_radiance_as_it_is_and_others_expose_it() {
    let folder = companions();
    let world = format!(
        "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [1 1 1]\n{QUAD}"
    );
    for (film, camera, wanted) in [
        ("", "", 1.0),
        ("\"float iso\" 200", "", 2.0),
        ("", "\"float shutterclose\" 0.5", 0.5),
        ("\"float iso\" 50", "\"float shutteropen\" 1 \"float shutterclose\" 4", 1.5),
    ] {
        let above = ABOVE.replace("\"float fov\" 10", &format!("\"float fov\" 10 {camera}"));
        let above = above.replace("Film \"rgb\"", &format!("Film \"rgb\" {film}"));
        near(mean(&quiet(folder.path(), &format!("{above}{world}"))), Rgb::splat(wanted), &format!("infinite {film}"));
    }
}

#[test]
fn area_lights_shine_where_pbrt_s_normals_look() {
    let folder = companions();
    let lamp = "AreaLightSource \"diffuse\" \"rgb L\" [3 2 1]\n";
    let seen = |world: String| mean(&quiet(folder.path(), &scene(&world)));
    let (on, off) = (Rgb::new(3.0, 2.0, 1.0), Rgb::ZERO);
    let normals =
        |z: i32| QUAD.replace("\"point2", &format!("\"normal N\" [0 0 {z} 0 0 {z} 0 0 {z} 0 0 {z}] \"point2"));
    for (world, wanted) in [
        (format!("{lamp}{QUAD}"), on),
        (format!("{lamp}ReverseOrientation {QUAD}"), off),
        (format!("{lamp}Scale 1 1 -1 {QUAD}"), off),
        (format!("{lamp}Scale -1 1 1 {QUAD}"), on),
        (format!("{lamp}{}", normals(-1)), off),
        (format!("{lamp}ReverseOrientation {}", normals(-1)), on),
        (format!("{lamp}ReverseOrientation Rotate 180 1 0 0 {}", normals(1)), on),
        (format!("AreaLightSource \"diffuse\" \"rgb L\" [3 2 1] \"bool twosided\" true ReverseOrientation {QUAD}"), on),
        (format!("{lamp}Shape \"plymesh\" \"string filename\" \"quad.ply\""), on),
        (format!("{lamp}Shape \"disk\" \"float radius\" 2"), on),
        (format!("{lamp}Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1"), off),
        (format!("{lamp}ReverseOrientation Shape \"disk\" \"float radius\" 2"), off),
        (format!("{lamp}Shape \"sphere\" \"float radius\" 2"), on),
        // seen from inside, and half of it comes back from all around
        (format!("{lamp}ReverseOrientation Shape \"sphere\" \"float radius\" 9"), on * 2.0),
        (format!("{lamp}Shape \"sphere\" \"float radius\" 9"), off),
        (format!("{lamp}Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]"), on),
        (format!("{lamp}Rotate 90 1 0 0 Shape \"cylinder\" \"float radius\" 1"), on),
        // a triangle of 2 square units has π·2·L
        (format!("AreaLightSource \"diffuse\" \"float power\" {} {QUAD}", 4.0 * PI), Rgb::splat(2.0)),
        (format!("AreaLightSource \"diffuse\" \"float power\" {} \"bool twosided\" true {QUAD}", 4.0 * PI), Rgb::ONE),
        (
            format!("AreaLightSource \"diffuse\" \"float power\" {} Shape \"disk\" \"float radius\" 1", 4.0 * PI * PI),
            Rgb::splat(4.0),
        ),
    ] {
        near(seen(world.clone()), wanted, &world);
    }
}

#[test]
fn pictures_stand_upright_in_a_left_handed_world() {
    let folder = companions();
    let lamp = "AreaLightSource \"diffuse\" \"string filename\" \"pic.png\"\n";
    let quad = |shape: &str| {
        let text = scene(&format!("{lamp}Scale 0.35 0.35 1 {shape}"));
        pixels(&quiet(folder.path(), &text), 64)
    };
    // seen from +z, x goes to the left
    let wanted = [Rgb::Y, Rgb::X, Rgb::ONE, Rgb::Z];
    for shape in [
        QUAD,
        "Shape \"plymesh\" \"string filename\" [ \"quad.ply\" ]",
        "Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]",
    ] {
        for (found, wanted) in quad(shape).iter().zip(wanted) {
            // pictures are bilinear: each colour is in its quarter most of all
            let largest = wanted.max_element();
            assert!((*found - wanted).abs().max_element() < 0.5 * largest, "{shape}: {found}, not {wanted}");
        }
    }
    // looking along +z, x goes to the right, unless the camera is mirrored
    let sees = |before: &str, wanted: usize| {
        let above = ABOVE.replace("LookAt 0 0 4  0 0 0  0 1 0", before);
        let text =
            format!("{above}WorldBegin AreaLightSource \"diffuse\" \"bool twosided\" true Translate 1 0 0 {QUAD}");
        let all = pixels(&quiet(folder.path(), &text), 4);
        let lit: Vec<bool> = all.iter().map(|pixel| pixel.x > 0.0).collect();
        assert_eq!(lit, [wanted == 0, wanted == 1, wanted == 0, wanted == 1], "{before}");
    };
    sees("LookAt 0 0 -4  0 0 0  0 1 0", 1);
    sees("Scale -1 1 1 LookAt 0 0 -4  0 0 0  0 1 0", 0);
    sees("Translate 0 0 4", 1);
}

#[test]
fn surroundings_are_turned_as_pbrt_turns_them() {
    let folder = companions();
    // along an axis, with y or z up
    let look = |axis: &str, up: &str, turn: &str, file: &str, old: bool| {
        let above = ABOVE.replace("LookAt 0 0 4  0 0 0  0 1 0", &format!("LookAt 0 0 0  {axis}  {up}"));
        let light = if old { "mapname" } else { "filename" };
        let end = if old { "\nWorldEnd" } else { "" };
        let text = format!(
            "{above}WorldBegin\n{turn} LightSource \"infinite\" \"string {light}\" \"{file}\"\nTranslate 0 0 -900 {QUAD}{end}"
        );
        mean(&quiet(folder.path(), &text))
    };
    let (red, green) = (Rgb::X * 2.0, Rgb::Y * 3.0);
    for (file, old) in [("sky.exr", false), ("long.exr", true)] {
        near(look("0 0 1", "0 1 0", "", file, old), red, file);
        near(look("1 0 0", "0 1 0", "", file, old), green, file);
        near(look("0 1 0", "0 0 1", "", file, old), Rgb::ZERO, file);
        near(look("-1 0 0", "0 0 1", "", file, old), Rgb::ZERO, file);
        // about z by 90°: what is at +x comes to +y
        near(look("0 1 0", "0 0 1", "Rotate 90 0 0 1", file, old), green, file);
        // z up becomes y up
        near(look("0 1 0", "0 0 1", "Rotate -90 1 0 0", file, old), red, file);
    }
    // the illuminance of a patch that looks along +z
    let text = scene(&format!(
        "LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float illuminance\" 10\nMaterial \"diffuse\" \"rgb reflectance\" [1 1 1]\n{QUAD}"
    ));
    let found = luminance(mean(&quiet(folder.path(), &text))) * PI;
    assert!((found / 10.0 - 1.0).abs() < 0.05, "{found}");
}

/// Materials of the project's own form, by name.
fn own(folder: &Path, text: &str) -> SceneFile {
    format::parse(text, &folder.join("own.toml"), &[]).unwrap().0
}

#[test]
fn materials_are_those_of_our_own_scenes() {
    let folder = companions();
    let copper = "eta = [0.201, 0.9237, 1.1022]\nk = [3.9133, 2.453, 2.1421]";
    let gold = "eta = [0.143, 0.3753, 1.442]\nk = [3.983, 2.3856, 1.6034]";
    let pairs = [
        ("\"diffuse\"", "type = \"diffuse\"\nreflectance = 0.5".to_string()),
        (
            "\"diffuse\" \"texture reflectance\" \"t\"",
            "type = \"diffuse\"\nreflectance = { texture = \"pic.png\", scale = [2, 3], offset = [0.5, 0.25], tint = 0.5 }".into(),
        ),
        (
            "\"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float roughness\" 0.09 \"float eta\" 1.4",
            "type = \"plastic\"\nreflectance = [0.1, 0.2, 0.3]\nalpha = 0.3\nint_ior = 1.4\nnonlinear = true".into(),
        ),
        ("\"coateddiffuse\"", "type = \"plastic\"\nreflectance = 0.5\nnonlinear = true".into()),
        ("\"conductor\"", format!("type = \"conductor\"\n{copper}")),
        (
            "\"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" [\"metal-Au-k\"] \"float roughness\" 0.25 \"bool remaproughness\" false",
            format!("type = \"conductor\"\n{gold}\nalpha = 0.25"),
        ),
        ("\"conductor\" \"rgb reflectance\" [0.5 0.5 0.5]", "type = \"conductor\"\neta = [1, 1, 1]\nk = [2, 2, 2]".into()),
        ("\"dielectric\"", "type = \"dielectric\"".into()),
        ("\"dielectric\" \"spectrum eta\" \"glass-BK7\" \"float roughness\" 0.01", "type = \"dielectric\"\nint_ior = 1.5168\nalpha = 0.1".into()),
        ("\"thindielectric\" \"float eta\" 1.3", "type = \"dielectric\"\nint_ior = 1.3\nthin = true".into()),
        (
            "\"diffusetransmission\" \"rgb reflectance\" [.2 .2 .2] \"float scale\" 2",
            "type = \"diffuse_transmitter\"\nreflectance = 0.4\ntransmittance = 0.5".into(),
        ),
        ("\"interface\"", "type = \"null\"".into()),
        (
            "\"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.25",
            "type = \"diffuse\"\nreflectance = [0.75, 0.25, 0]".into(),
        ),
    ];
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]\n\
        MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 1 0]\n\
        Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"pic.png\" \"float uscale\" 2 \"float vscale\" 3 \"float udelta\" .5 \"float vdelta\" .25\n\
        Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"i\" \"float scale\" 0.5\n";
    for (theirs, ours) in &pairs {
        let file = quiet(folder.path(), &scene(&format!("{named}Material {theirs}\n{QUAD}")));
        let own = own(folder.path(), &format!("[material.m]\n{ours}\n"));
        let name = file.scene.meshes[0].material.as_ref().unwrap();
        alike(&file.scene.materials[name].bsdf, &own.scene.materials["m"].bsdf, theirs);
        file.load_scene(1).unwrap();
    }
}

#[test]
fn of_two_roughnesses_the_mean_of_their_alphas_is_taken_and_said() {
    let folder = companions();
    let metal = "Material \"conductor\" \"float uroughness\" 0.04 \"float vroughness\" 0.16";
    let (file, warnings) = read(folder.path(), &scene(&format!("{metal}\n{QUAD}"))).unwrap();
    let own = own(
        folder.path(),
        "[material.m]\ntype = \"conductor\"\neta = [0.201, 0.9237, 1.1022]\nk = [3.9133, 2.453, 2.1421]\nalpha = 0.3\n",
    );
    let name = file.scene.meshes[0].material.as_ref().unwrap();
    alike(&file.scene.materials[name].bsdf, &own.scene.materials["m"].bsdf, metal);
    let wanted = "α of 0.2 along u and of 0.4 along v has no counterpart: the mean, ";
    assert!(warnings.len() == 1 && warnings[0].contains(wanted), "{warnings:?}");
}

/// The same but for the last bits of numbers.
fn alike(found: &BsdfDescription, wanted: &BsdfDescription, what: &str) {
    let rounded = |bsdf: &BsdfDescription| {
        let text = format!("{bsdf:?}");
        let mut parts = Vec::new();
        for word in text.split([' ', ',', '(', ')', '[', ']']) {
            parts.push(word.parse::<f32>().map_or(word.to_string(), |number| format!("{number:.4}")));
        }
        parts.join(" ")
    };
    assert_eq!(rounded(found), rounded(wanted), "{what}");
}

#[test]
fn materials_of_version_3_are_those_of_our_own_scenes() {
    let folder = companions();
    for (theirs, ours) in [
        ("\"matte\" \"rgb Kd\" [.3 .2 .1]", "type = \"diffuse\"\nreflectance = [0.3, 0.2, 0.1]"),
        (
            "\"plastic\" \"rgb Ks\" [.5 .5 .5] \"float roughness\" .2 \"bool remaproughness\" [\"false\"]",
            "type = \"plastic\"\nreflectance = 0.25\nspecular_reflectance = 0.5\nalpha = 0.2\nadditive = true",
        ),
        // the polynomial of ln 0.1
        (
            "\"metal\" \"rgb eta\" [1 1 1] \"rgb k\" [3 3 3] \"float roughness\" 0.1",
            "type = \"conductor\"\neta = [1, 1, 1]\nk = [3, 3, 3]\nalpha = 0.4618",
        ),
        ("\"mirror\"", "type = \"mirror\"\nspecular_reflectance = 0.9"),
        (
            "\"glass\" \"float index\" 1.33 \"rgb Kt\" [1 1 .5]",
            "type = \"dielectric\"\nint_ior = 1.33\nspecular_transmittance = [1, 1, 0.5]",
        ),
        ("\"uber\" \"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [0 0 0]", "type = \"diffuse\"\nreflectance = [0.1, 0.2, 0.3]"),
        (
            "\"disney\" \"rgb color\" [.1 .2 .3] \"float metallic\" .5",
            "type = \"principled\"\nbase_color = [0.1, 0.2, 0.3]\nmetallic = 0.5\nspecular = 0.5\nclearcoat_gloss = 1\nsheen_tint = 0.5",
        ),
        ("\"\"", "type = \"null\""),
    ] {
        let text = scene(&format!("Material {theirs}\n{QUAD}WorldEnd\n"));
        let (file, warnings) = read(folder.path(), &text).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let own = own(folder.path(), &format!("[material.m]\n{ours}\n"));
        let name = file.scene.meshes[0].material.as_ref().unwrap();
        alike(&file.scene.materials[name].bsdf, &own.scene.materials["m"].bsdf, theirs);
    }
    // what has no counterpart is said; the share of a mixture is the first one's
    let text = scene(&format!(
        "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [1 0 0]\nMakeNamedMaterial \"b\" \"string type\" \"matte\" \"rgb Kd\" [0 1 0]\n\
         Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.75 .75 .75]\n{QUAD}\
         Material \"substrate\"\n{QUAD}WorldEnd"
    ));
    let (file, warnings) = read(folder.path(), &text).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("scene.pbrt:11: the material \"substrate\""), "{warnings:?}");
    let mixed = &file.scene.materials["material in line 9"].bsdf;
    assert!(
        matches!(mixed, BsdfDescription::Diffuse(d) if d.reflectance == ColorTexture::Constant(Rgb::new(0.75, 0.25, 0.0))),
        "{mixed:?}"
    );
    assert_eq!(
        (file.scene.film.filter, quiet(folder.path(), "WorldBegin").scene.film.filter),
        (Filter::Box, Filter::Gaussian)
    );
}

#[test]
fn mixtures_of_unlike_materials_keep_both() {
    let folder = companions();
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"b\" \"string type\" \"conductor\"\n\
        Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"pic.png\"\n";
    let mix = |amount: &str| {
        let text = scene(&format!("{named}Material \"mix\" \"string materials\" [\"a\" \"b\"] {amount}\n{QUAD}"));
        let file = quiet(folder.path(), &text);
        file.load_scene(1).unwrap();
        let material = &file.scene.materials[file.scene.meshes[0].material.as_ref().unwrap()];
        material.blend.clone().unwrap()
    };
    let constant = mix("\"float amount\" 0.25");
    assert_eq!(constant.weight, ScalarTexture::Constant(0.25));
    assert!(matches!(constant.parts[0].material.bsdf, BsdfDescription::Diffuse(_)));
    assert!(matches!(constant.parts[1].material.bsdf, BsdfDescription::Conductor(_)));
    assert!(matches!(mix("\"texture amount\" \"t\"").weight, ScalarTexture::Image(_)));
}

#[test]
fn checkers_have_their_first_colour_where_coordinates_begin() {
    let folder = companions();
    let text = scene(&format!(
        "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"float uscale\" 4 \"float vscale\" 4\n\
         Material \"diffuse\" \"texture reflectance\" \"c\"\n{QUAD}"
    ));
    let file = quiet(folder.path(), &text);
    let BsdfDescription::Diffuse(diffuse) = &file.scene.materials.values().next().unwrap().bsdf else { panic!() };
    let ColorTexture::Image(image) = &diffuse.reflectance else { panic!() };
    assert_eq!((image.scale, image.offset, image.nearest), ([2.0; 2], [0.0; 2], true));
    let EmbeddedPicture::Decoded(picture) = &*file.scene.pictures[&image.path] else { panic!() };
    // the lower row is the last
    assert_eq!(picture.colors(), [Rgb::Z, Rgb::X, Rgb::X, Rgb::Z]);
}

#[test]
fn pictures_are_decoded_as_the_scene_says() {
    let folder = companions();
    RgbImage::from_pixel(2, 2, Pixel([128, 64, 255])).save(folder.path().join("flat.png")).unwrap();
    let texels = |kind: &str, more: &str, used: &str| {
        let text = scene(&format!(
            "Texture \"t\" \"{kind}\" \"imagemap\" \"string filename\" \"flat.png\" {more}\n{used}{QUAD}"
        ));
        let file = quiet(folder.path(), &text);
        file.load_scene(1).unwrap();
        let material = file.scene.materials.values().next().unwrap().clone();
        let path = match (&material.bsdf, &material.opacity) {
            (_, Some(crate::texture::ScalarTexture::Image(image))) => image.path.clone(),
            (BsdfDescription::Diffuse(d), None) => match &d.reflectance {
                ColorTexture::Image(image) => image.path.clone(),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        };
        match file.scene.pictures.get(&path).map(|picture| &**picture) {
            Some(EmbeddedPicture::Decoded(picture)) => picture.colors()[0],
            _ => Rgb::NAN,
        }
    };
    let diffuse = "Material \"diffuse\" \"texture reflectance\" \"t\" ";
    let stored = Rgb::new(128.0, 64.0, 255.0) / 255.0;
    let decoded = Rgb::from(stored.to_array().map(crate::image::srgb::decode));
    let near = |found: Rgb, wanted: Rgb| assert!((found - wanted).abs().max_element() < 1e-5, "{found}, not {wanted}");
    assert!(texels("spectrum", "", diffuse).is_nan(), "a plain picture is that of the file");
    near(texels("spectrum", "\"string encoding\" \"linear\"", diffuse), stored);
    near(texels("spectrum", "\"bool invert\" true", diffuse), Rgb::ONE - decoded);
    let alpha = "Attribute \"shape\" \"texture alpha\" \"t\" ";
    near(texels("float", "", alpha), Rgb::splat(decoded.element_sum() / 3.0));
    near(texels("float", "\"bool invert\" true", alpha), Rgb::splat(1.0 - decoded.element_sum() / 3.0));
    assert!(texels("float", "\"string encoding\" \"linear\"", alpha).is_nan());
}

#[test]
fn blocks_keep_the_state_and_objects_stand_where_they_are_named() {
    let folder = companions();
    fs::write(folder.path().join("part.pbrt"), format!("Material \"diffuse\" \"rgb reflectance\" [1 0 0]\n{QUAD}"))
        .unwrap();
    let world = format!(
        "Attribute \"shape\" \"float alpha\" 0.5\nAttributeBegin Translate 1 2 3 CoordinateSystem \"here\"\nAttribute \"material\" \"rgb reflectance\" [0 1 0]\n\
         Material \"diffuse\" ReverseOrientation Include \"part.pbrt\" AttributeEnd\n{QUAD}\
         CoordSysTransform \"here\" ConcatTransform [2 0 0 0 0 2 0 0 0 0 2 0 5 0 0 1] {QUAD}Identity\n\
         ObjectBegin \"o\" Translate 0 0 1 {QUAD} ObjectEnd ObjectBegin \"empty\" ObjectEnd\n\
         Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 7 0 1] ObjectInstance \"o\" Scale 2 2 2 ObjectInstance \"o\" ObjectInstance \"empty\""
    );
    let file = quiet(folder.path(), &scene(&world));
    let [included, plain, moved, object] = &file.scene.meshes[..] else { panic!("{:?}", file.scene.meshes) };
    let at = |mesh: &crate::scene::description::MeshDescription| mesh.transform.transform_point3(glam::DVec3::X);
    assert_eq!(
        [at(included), at(plain), at(moved)],
        [glam::DVec3::new(2.0, 2.0, 3.0), glam::DVec3::X, glam::DVec3::new(8.0, 2.0, 3.0)]
    );
    assert_eq!((object.group.as_deref(), at(object)), (Some("o"), glam::DVec3::new(1.0, 0.0, 1.0)));
    let places: Vec<_> = file.scene.instances.iter().map(|i| i.transform.transform_point3(glam::DVec3::Y)).collect();
    assert_eq!(places, [glam::DVec3::Y * 8.0, glam::DVec3::Y * 9.0]);
    let material =
        |mesh: &crate::scene::description::MeshDescription| &file.scene.materials[mesh.material.as_ref().unwrap()];
    assert!(
        matches!(&material(included).bsdf, BsdfDescription::Diffuse(d) if d.reflectance == ColorTexture::Constant(Rgb::X))
    );
    assert!(matches!(&material(plain).bsdf, BsdfDescription::Diffuse(d) if d.reflectance == ColorTexture::grey(0.5)));
    assert_eq!(material(plain).opacity, Some(crate::texture::ScalarTexture::Constant(0.5)));
    assert_eq!(file.load_scene(1).unwrap().0.triangles(), 2 * 5);
    // version 3 keeps more than the transform where version 4 does not
    let block = format!("TransformBegin Translate 0 0 9 Material \"matte\" \"rgb Kd\" [1 0 0] TransformEnd {QUAD}");
    let old = quiet(folder.path(), &scene(&format!("{block}WorldEnd")));
    let red = |file: &SceneFile| {
        assert_eq!(at(&file.scene.meshes[0]), glam::DVec3::X);
        let name = file.scene.meshes[0].material.as_ref().unwrap();
        matches!(&file.scene.materials[name].bsdf, BsdfDescription::Diffuse(d) if d.reflectance == ColorTexture::Constant(Rgb::X))
    };
    assert!(red(&old) && !red(&quiet(folder.path(), &scene(&block))));
}

#[test]
fn cameras_samples_and_paths_are_counted_as_pbrt_counts() {
    let folder = companions();
    let file = |before: &str| quiet(folder.path(), &format!("{before}\nWorldBegin\n{QUAD}"));
    let wide = "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 20 \"float cropwindow\" [0 0.5 0.25 1]";
    let camera = |text: &str| file(text).scene.camera.unwrap();
    let tangent = |vfov: f32| (0.5 * vfov.to_radians()).tan();
    assert!((tangent(camera(&format!("{wide} Camera \"perspective\"")).vfov) - 1.0).abs() < 1e-6);
    let high = "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 40";
    assert!((tangent(camera(&format!("{high} Camera \"perspective\"")).vfov) - 2.0).abs() < 1e-6);
    let lens = camera(&format!(
        "{wide} Scale 0.5 0.5 0.5 Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" 3"
    ));
    assert!((lens.aperture_radius - 0.2).abs() < 1e-6 && (lens.focus_distance.unwrap() - 6.0).abs() < 1e-5, "{lens:?}");
    let window = camera(&format!("{wide} Camera \"perspective\" \"float screenwindow\" [-1 1 -0.5 0.5]"));
    assert!((tangent(window.vfov) - 0.5).abs() < 1e-6);
    let ortho = camera(&format!("{wide} Camera \"orthographic\" \"float screenwindow\" [-4 4 -2 2]"));
    assert_eq!(ortho.view_height, 4.0);
    let read = file(&format!(
        "{wide} Sampler \"halton\" \"integer pixelsamples\" 99 Integrator \"path\" \"integer maxdepth\" [7]"
    ));
    assert_eq!((read.render.spp, read.integrator.max_depth, read.scene.film.crop), (99, 8, Some([0, 5, 20, 15])));
    assert_eq!((file("").render.spp, file("").integrator.max_depth), (crate::render::RenderSettings::default().spp, 6));
}

#[test]
fn packed_meshes_are_meshes() {
    let folder = companions();
    let hash = |name: &str| {
        let file = quiet(folder.path(), &scene(&format!("Shape \"plymesh\" \"string filename\" \"{name}\"")));
        file.load_scene(1).unwrap().0.hash_text()
    };
    assert_eq!(hash("quad.ply"), hash("packed.ply.gz"));
    fs::write(folder.path().join("bad.ply.gz"), b"\x1f\x8bnothing").unwrap();
    let text = scene("Shape \"plymesh\" \"string filename\" \"bad.ply.gz\"");
    let error = quiet(folder.path(), &text).load_scene(1).err().unwrap().to_string();
    assert!(error.contains("not compressed by gzip, or damaged"), "{error}");
}

#[test]
fn faults_and_what_means_nothing_have_their_lines() {
    let folder = companions();
    fs::write(folder.path().join("loop.pbrt"), "Include \"loop.pbrt\"").unwrap();
    for (world, wanted) in [
        ("Shape \"teapot\"", "scene.pbrt:7:1: the shape \"teapot\" has no counterpart"),
        ("Shape \"loopsubdiv\"", "subdivision surfaces"),
        ("\n Sphere", ":8:2: `Sphere` is no directive"),
        ("\"diffuse\"", ":7:1: a directive belongs here"),
        ("Include \"loop.pbrt\"", "loop.pbrt:1:1: too many files are included"),
        ("Include \"none.pbrt\"", "none.pbrt"),
        ("AttributeBegin", ":7:1: nothing ends what begins here"),
        ("AttributeEnd", ":7:1: nothing begins what ends here"),
        ("AttributeBegin\nObjectEnd", ":8:1: what ends here is not what begins in line 7"),
        ("ObjectInstance \"x\"", "there is no object \"x\""),
        ("Shape \"sphere\" \"float radius\" [1 2]", ":7:16: `radius` of Shape \"sphere\" must be one number"),
        ("Shape \"sphere\" \"float radius\" big", ":7:31: `big` in `radius` is not a number"),
        ("Shape \"sphere\" \"float radius\" [1", "the file ends where `]` of `radius` is missing"),
        ("Shape \"sphere\" \"radius\" 1", "is not a type and a name"),
        ("Shape \"sphere\" \"float phimax\" 90", "a part of a sphere is not read"),
        ("Translate 1 2", "the file ends where a number is missing"),
        ("Rotate 10 0 0 0", "the axis of a rotation is not zero"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "these three span no view"),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2]", "the last row"),
        ("NamedMaterial \"x\" Shape \"sphere\"", ":7:1: there is no material \"x\""),
        ("Material \"hair\" Shape \"sphere\"", ":7:1: the material \"hair\" has no counterpart"),
        ("Material \"diffuse\" \"texture reflectance\" \"x\" Shape \"sphere\"", "there is no texture \"x\""),
        ("Material \"diffuse\" \"rgb reflectance\" [1 2] Shape \"sphere\"", "must be three numbers"),
        (
            "Material \"conductor\" \"spectrum eta\" \"metal-Ux-eta\" Shape \"sphere\"",
            "which no spectrum here is called",
        ),
        (
            "Texture \"t\" \"float\" \"scale\" \"texture tex\" \"t\" Material \"diffuse\" \"texture displacement\" \"t\" Shape \"sphere\"",
            "within itself",
        ),
        (
            "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"] NamedMaterial \"m\" Shape \"sphere\"",
            "within itself",
        ),
        ("Texture \"t\" \"float\" \"constant\" Texture \"t\" \"float\" \"constant\"", "two textures \"t\""),
        (
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "names the vertex 3, of 3",
        ),
        ("Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]", "`N` is of 1 vertices"),
        ("LightSource \"projection\"", "the light \"projection\" has no counterpart"),
    ] {
        let message = read(folder.path(), &scene(world)).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(wanted), "{message}\nis not\n{wanted}\nof\n{world}");
    }
    let (_, warnings) = read(
        folder.path(),
        &scene(
            "Shape \"sphere\" \"float colour\" 3\nMaterial \"diffuse\" \"rgb reflectance\" [2 0 0]\nMakeNamedMedium \"fog\"\n\
             MediumInterface \"fog\" \"\"\nShape \"sphere\"\nScale 1 1 0 Shape \"sphere\"\n",
        ),
    )
    .unwrap();
    let wanted = [
        ":7: `colour` of Shape \"sphere\" means nothing here",
        ":10: nothing scatters light between surfaces here",
        ":12: the transform flattens this sphere",
        ":8: `reflectance` of Material \"diffuse\" is above 1",
    ];
    assert_eq!(warnings.len(), wanted.len(), "{warnings:#?}");
    for (warning, wanted) in warnings.iter().zip(wanted) {
        assert!(warning.contains(wanted), "{warning}\nis not\n{wanted}");
    }
}

#[test]
fn damaged_scenes_never_panic() {
    let folder = companions();
    let whole = format!(
        "{}Attribute \"shape\" \"float alpha\" .5\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"pic.png\"\n\
         AttributeBegin AreaLightSource \"diffuse\" \"blackbody L\" [3000] \"float power\" 3 Translate 1 2 3 {QUAD} AttributeEnd\n\
         MakeNamedMaterial \"m\" \"string type\" \"coateddiffuse\" \"texture reflectance\" \"t\" \"float roughness\" .2\nNamedMaterial \"m\"\n\
         ObjectBegin \"o\" Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 1] ObjectEnd ObjectInstance \"o\"\n\
         Shape \"plymesh\" \"string filename\" \"packed.ply.gz\" Shape \"disk\" \"float innerradius\" .5 Shape \"cylinder\"\n\
         LightSource \"spot\" LightSource \"infinite\" \"spectrum L\" [400 1 500 2]\n",
        scene("")
    );
    quiet(folder.path(), &whole).load_scene(1).unwrap();
    let mut rng = Rng::new(7);
    for k in 0..1500 {
        let mut bytes = whole.clone().into_bytes();
        for _ in 0..1 + rng.next_u32() % 3 {
            let at = rng.next_u32() as usize % bytes.len().max(1);
            match rng.next_u32() % 4 {
                _ if bytes.is_empty() => (),
                0 => bytes[at] = rng.next_u32() as u8,
                1 => drop(bytes.drain(at..(at + 7).min(bytes.len()))),
                2 => bytes[at] = b"\"[]#-\n 9e"[rng.next_u32() as usize % 9],
                _ => bytes.truncate(at),
            }
        }
        let path = folder.path().join("scene.pbrt");
        fs::write(&path, &bytes).unwrap();
        if let Ok((file, _)) = format::load(&path, &[])
            && k % 30 == 0
        {
            _ = file.load_scene(1).map(drop);
        }
    }
}
