//! Each thing by a value that is known, or by the same scene in the project's own form.

use crate::Result;
use crate::bsdf::BsdfDescription;
use crate::film::tile::Tile;
use crate::format::tests::blocks::{BLOCKS, bound, compare, runs};
use crate::format::{self, SceneFile};
use crate::guiding::settings::{DirectionTable, GuidingMethod, Rate};
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::Rgb;
use crate::math::rng::Rng;
use std::f32::consts::PI;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// [−1, 1]² in the plane z = 0: seen from +z, with normals that say so, and with normals that say the contrary.
fn companions() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), format!("{corners}{text}")).unwrap();
    write("quad.obj", "f 1 2 3 4\n");
    write("up.obj", "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n");
    write("down.obj", "vn 0 0 -1\nf 1//1 2//1 3//1 4//1\n");
    // a box about the camera, seen from inside
    let furnace =
        "v -1 -1 2\nv 1 -1 2\nv 1 1 2\nv -1 1 2\nf 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 7 8 4 3\nf 6 7 3 2\nf 8 5 1 4\n";
    fs::write(folder.path().join("furnace.obj"), format!("{corners}{furnace}").replace("1 0\n", "1 -2\n")).unwrap();
    folder
}

fn read(folder: &Path, text: &str) -> Result<(SceneFile, Vec<String>)> {
    let path = folder.join("scene.xml");
    fs::write(&path, text).unwrap();
    format::load(&path, &[])
}

/// Read without a warning.
fn quiet(folder: &Path, text: &str) -> SceneFile {
    let (file, warnings) = read(folder, text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    file
}

/// The mean of all pixels.
fn mean(file: &SceneFile) -> Rgb {
    let scene = file.load_scene(1).unwrap().0;
    let (width, height) = (scene.camera.width, scene.camera.height);
    let task = Task { tile: Tile { x: 0, y: 0, width, height }, first_sample: 0, samples: 512 };
    let sums = PathIntegrator::plain(&scene, &file.integrator, 1).render(&task, &mut Batch::new()).samples.sum;
    let all: Rgb = sums.iter().sum();
    all * (scene.light_unit().value() as f32 / (512 * width * height) as f32)
}

/// A camera above that sees the middle of the plane z = 0, and a mesh there.
fn above(mesh: &str) -> String {
    format!(
        "<scene><integrator type=\"path_mis\"/><camera type=\"perspective\"><float name=\"fov\" value=\"10\"/>\
         <integer name=\"width\" value=\"2\"/><integer name=\"height\" value=\"2\"/><transform name=\"toWorld\">\
         <lookat origin=\"0,0,4\" target=\"0,0,0\" up=\"0,1,0\"/></transform><rfilter type=\"box\"/></camera>{mesh}</scene>"
    )
}

fn mesh(file: &str, more: &str) -> String {
    format!("<mesh type=\"obj\"><string name=\"filename\" value=\"{file}\"/>{more}</mesh>")
}

const LAMP: &str = "<emitter type=\"area\"><color name=\"radiance\" value=\"3, 2, 1\"/></emitter>";

#[test]
fn a_furnace_is_as_bright_as_its_series_says() {
    let folder = companions();
    for (albedo, wanted) in [(0.5, 2.0), (0.8, 5.0)] {
        for way in ["mats", "ems", "mis"] {
            let walls = format!(
                "<bsdf type=\"diffuse\"><color name=\"albedo\" value=\"{albedo} {albedo} {albedo}\"/></bsdf>\
                 <emitter type=\"area\"><color name=\"radiance\" value=\"1, 1, 1\"/></emitter>"
            );
            let text = format!(
                "<scene><integrator type=\"path_{way}\"/><camera type=\"perspective\"><float name=\"fov\" value=\"10\"/>\
                 <integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/></camera>{}</scene>",
                mesh("furnace.obj", &walls)
            );
            let file = quiet(folder.path(), &text);
            assert_eq!((file.integrator.next_event, file.integrator.mis), (way != "mats", way != "ems"));
            let found = mean(&file).x;
            assert!((found / wanted - 1.0).abs() < 0.03, "{albedo} {way}: {found}, not {wanted}");
        }
    }
}

#[test]
fn lamps_shine_where_normals_look_and_the_camera_has_its_left_on_the_left() {
    let folder = companions();
    let seen = |mesh: String| mean(&quiet(folder.path(), &above(&mesh)));
    let turned = "<transform name=\"toWorld\"><scale value=\"1,1,-1\"/></transform>";
    let bright = Rgb::new(3.0, 2.0, 1.0);
    // a mirroring along z turns normals over, and changes nothing of corners at z = 0, by which faces without normals look
    for (file, transform, wanted) in [
        ("quad.obj", "", bright),
        ("quad.obj", turned, bright),
        ("up.obj", "", bright),
        ("up.obj", turned, Rgb::ZERO),
        ("down.obj", "", Rgb::ZERO),
        ("down.obj", turned, bright),
    ] {
        let found = seen(mesh(file, &format!("{LAMP}{transform}")));
        assert!((found - wanted).abs().max_element() < 1e-4, "{file} {transform}: {found}");
    }
    // a lamp over the half with x < 0 is on the left of a camera that looks down with y up
    let left = "<transform name=\"toWorld\"><translate value=\"-1,0,0\"/></transform>";
    let file = quiet(folder.path(), &above(&mesh("quad.obj", &format!("{LAMP}{left}"))));
    let scene = file.load_scene(1).unwrap().0;
    let task = Task { tile: Tile { x: 0, y: 0, width: 2, height: 2 }, first_sample: 0, samples: 4 };
    let sums = PathIntegrator::plain(&scene, &file.integrator, 1).render(&task, &mut Batch::new()).samples.sum;
    assert!(sums[0].x > 0.0 && sums[2].x > 0.0 && sums[1].x == 0.0 && sums[3].x == 0.0, "{sums:?}");
}

#[test]
fn power_is_that_of_the_sphere_and_fov_is_across() {
    let folder = companions();
    let floor = mesh("quad.obj", "<bsdf type=\"diffuse\"><color name=\"albedo\" value=\"0.8,0.4,0.2\"/></bsdf>");
    let lit = |light: &str| mean(&quiet(folder.path(), &above(&format!("{floor}{light}"))));
    let point = |key: &str, value: f32| {
        format!(
            "<emitter type=\"point\"><point name=\"position\" value=\"0,0,100\"/><color name=\"{key}\" \
             value=\"{value} {value} {value}\"/></emitter>"
        )
    };
    let wanted = Rgb::new(0.8, 0.4, 0.2) / PI;
    for light in [
        point("power", 4.0 * PI * 1e4),
        point("intensity", 1e4),
        "<emitter type=\"directional\"><vector name=\"direction\" value=\"0,0,-1\"/><color name=\"irradiance\" \
         value=\"1 1 1\"/></emitter>"
            .into(),
    ] {
        let found = lit(&light);
        assert!((found / wanted - Rgb::ONE).abs().max_element() < 2e-3, "{light}: {found}");
    }
    let camera = "<scene><camera type=\"perspective\"><float name=\"fov\" value=\"60\"/><integer name=\"width\" \
                  value=\"20\"/><integer name=\"height\" value=\"10\"/></camera></scene>";
    let camera = quiet(folder.path(), camera).scene.camera.unwrap();
    let tangent = (0.5 * camera.vfov.to_radians()).tan() * 2.0;
    assert!((tangent - 30f32.to_radians().tan()).abs() < 1e-6, "{}", camera.vfov);
}

#[test]
fn the_first_exercises_are_lights() {
    let folder = companions();
    let with = |integrator: &str, more: &str| {
        let white = "<bsdf type=\"diffuse\"><color name=\"albedo\" value=\"1 1 1\"/></bsdf>";
        let text = above(&mesh("quad.obj", white)).replace("<integrator type=\"path_mis\"/>", integrator);
        read(folder.path(), &text.replace("</scene>", &format!("{more}</scene>"))).unwrap()
    };
    // L = Φ/(4π²)·cosθ/d²
    let (file, warnings) = with(
        "<integrator type=\"simple\"><point name=\"position\" value=\"0,0,50\"/><color name=\"energy\" \
         value=\"1e5 2e5 3e5\"/></integrator>",
        "",
    );
    assert!(warnings[0].contains("`simple` has no counterpart"), "{warnings:?}");
    let wanted = Rgb::new(1e5, 2e5, 3e5) / (4.0 * PI * PI * 2500.0);
    assert!((mean(&file) / wanted - Rgb::ONE).abs().max_element() < 2e-3, "{}", mean(&file));
    let (file, _) = with("<integrator type=\"ao\"/>", "");
    assert!((mean(&file).x - 1.0).abs() < 0.01, "{}", mean(&file));
}

/// A floor, something above it, and a lamp above that.
fn room(bsdf: &str) -> String {
    let placed =
        |steps: &str, more: &str| mesh("quad.obj", &format!("<transform name=\"toWorld\">{steps}</transform>{more}"));
    format!(
        "<scene><sampler type=\"independent\"><integer name=\"sampleCount\" value=\"16\"/></sampler><integrator type=\"path_mis\"/>\
         <camera type=\"perspective\"><float name=\"fov\" value=\"50\"/><integer name=\"width\" value=\"12\"/><integer name=\"height\" value=\"9\"/>\
         <transform name=\"toWorld\"><lookat origin=\"0,-5,2\" target=\"0,0,0.8\" up=\"0,0,1\"/></transform><rfilter type=\"box\"/></camera>\
         {}{}{}</scene>",
        placed("<scale value=\"3,3,3\"/>", ""),
        placed("<rotate axis=\"1,0,0\" angle=\"30\"/><translate value=\"0,0,1\"/>", bsdf),
        placed("<rotate axis=\"1 0 0\" angle=\"180\"/><translate value=\"1,0,4\"/>", LAMP)
    )
}

/// The same in the project's own form.
fn own_room(bsdf: &str) -> String {
    format!(
        "[camera]\norigin = [0, -5, 2]\ntarget = [0, 0, 0.8]\nup = [0, 0, 1]\nvfov = {}\n[film]\nwidth = 12\nheight = 9\n\
         [integrator]\nmax_depth = 1000\n\
         [[mesh]]\npath = \"quad.obj\"\nscale = 3\nmaterial = \"grey\"\n\
         [[mesh]]\npath = \"quad.obj\"\nrotate = {{ axis = [1, 0, 0], angle = 30 }}\ntranslate = [0, 0, 1]\nmaterial = \"thing\"\n\
         [[mesh]]\npath = \"quad.obj\"\nrotate = {{ axis = [1, 0, 0], angle = 180 }}\ntranslate = [1, 0, 4]\nmaterial = \"lamp\"\n\
         [material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\ntwo_sided = false\n\
         [material.lamp]\ntype = \"diffuse\"\nreflectance = 0.5\ntwo_sided = false\nemission = [3, 2, 1]\n\
         [material.thing]\n{bsdf}\n",
        2.0 * (25f64.to_radians().tan() * 0.75).atan().to_degrees()
    )
}

#[test]
fn materials_are_those_of_our_own_scenes() {
    let folder = companions();
    let highlight = "type = \"plastic\"\nint_ior = 1.7\next_ior = 1.000277\nalpha = 0.28\ndistribution = \"beckmann\"\n\
                     specular_reflectance = 0.6\nreflectance = [0.2, 0.2, 0.4]\nadditive = true\ntwo_sided = false";
    let pairs = [
        (
            "<bsdf type=\"diffuse\"><color name=\"albedo\" value=\".8,.4,.2\"/></bsdf>",
            "type = \"diffuse\"\nreflectance = [0.8, 0.4, 0.2]\ntwo_sided = false",
        ),
        ("<bsdf type=\"mirror\"/>", "type = \"mirror\"\ntwo_sided = false"),
        ("<bsdf type=\"dielectric\"/>", "type = \"dielectric\"\nint_ior = 1.5046\next_ior = 1.000277"),
        (
            "<bsdf type=\"microfacet\"><float name=\"intIOR\" value=\"1.7\"/><color name=\"kd\" value=\"0.2 0.2 0.4\"/>\
             <float name=\"alpha\" value=\"0.28\"/></bsdf>",
            highlight,
        ),
    ];
    let bound = bound(BLOCKS * pairs.len());
    for (theirs, ours) in pairs {
        let file = quiet(folder.path(), &room(theirs));
        assert_eq!(file.render.spp, 16);
        let own = format::parse(&own_room(ours), &folder.path().join("own.toml"), &[]).unwrap().0;
        let own = runs(&own, 100);
        let (t, _) = compare(&runs(&file, 1), &own);
        assert!(t <= bound, "{theirs}: t {t} of {bound}");
        if theirs.contains("microfacet") {
            let other = quiet(folder.path(), &room(&theirs.replace("0.2 0.2 0.4", "0.3 0.3 0.4")));
            assert!(compare(&runs(&other, 1), &own).0 > bound, "another colour must be seen");
        }
    }
}

#[test]
fn what_others_add_is_read_as_far_as_it_is_known() {
    let folder = companions();
    let bsdf = |text: &str| {
        let (file, warnings) = read(folder.path(), &above(&mesh("quad.obj", text))).unwrap();
        (file.scene.materials.into_values().next().unwrap().bsdf, warnings)
    };
    let (phong, warnings) = bsdf(
        "<bsdf type=\"phong\"><color name=\"kd\" value=\"0.4 0.4 0.4\"/><color name=\"ks\" value=\"0.25 0.25 0.25\"/>\
         <float name=\"n\" value=\"48\"/></bsdf>",
    );
    let BsdfDescription::Plastic(phong) = phong else { panic!("{phong:?}") };
    assert!(phong.additive && (phong.alpha - 0.2).abs() < 1e-6 && (phong.int_ior - 3.0).abs() < 1e-5, "{phong:?}");
    assert!(
        warnings.len() == 1 && warnings[0].contains("scene.xml:1: the bsdf `phong` has no counterpart"),
        "{warnings:?}"
    );
    let disney = "<bsdf type=\"disney\"><color name=\"baseColor\" value=\"0.4 0.4 0.4\"/><float name=\"specularTint\" value=\"0.5\"/></bsdf>";
    let BsdfDescription::Principled(disney) = bsdf(disney).0 else { panic!() };
    assert_eq!((disney.spec_tint, disney.specular), (0.5, 0.5));
    assert!(matches!(bsdf("<bsdf type=\"roughconductor\"/>").0, BsdfDescription::Conductor(_)));

    let guided = |guider: &str| {
        let text = above(&mesh("quad.obj", "")).replace(
            "<integrator type=\"path_mis\"/>",
            &format!("<integrator type=\"path_guided\">{guider}</integrator>"),
        );
        read(folder.path(), &text).unwrap()
    };
    let (file, warnings) = guided(
        "<guider type=\"qtable_sphere\"><integer name=\"sceneResolution\" value=\"40\"/><integer name=\"angleResolution\" \
         value=\"9\"/><float name=\"alpha\" value=\"0.1\"/><float name=\"colour\" value=\"1\"/></guider>",
    );
    let guiding = &file.guiding;
    assert_eq!((guiding.method, guiding.table), (GuidingMethod::Grid, DirectionTable::Sphere));
    assert_eq!((guiding.resolution, guiding.strata, guiding.rate), (40, 9, Rate::Constant(0.1)));
    assert!(warnings.len() == 1 && warnings[0].contains("`colour` of the guider"), "{warnings:?}");
    assert_eq!(guided("<guider type=\"none\"/>").0.guiding.method, GuidingMethod::None);
}

#[test]
fn faults_have_lines_and_damage_never_panics() {
    let folder = companions();
    let scene = |body: &str| format!("<scene>\n{body}\n</scene>");
    for (text, wanted) in [
        (scene("<mesh type=\"teapot\"/>"), ":2:1: the mesh `teapot` has no counterpart"),
        (scene("<mesh type=\"obj\"/>"), "needs `filename`"),
        (scene(&mesh("quad.obj", "<bsdf type=\"velvet\"/>")), "the bsdf `velvet` has no counterpart"),
        (scene(&mesh("quad.obj", "<transform name=\"toWorld\"><scale value=\"1,1,0\"/></transform>")), "flattens it"),
        (scene("<emitter type=\"laser\"/>"), "the emitter `laser` has no counterpart"),
        (scene("<camera type=\"fisheye\"/>"), "the camera `fisheye` has no counterpart"),
        (scene("<camera type=\"perspective\"><float name=\"fov\" value=\"180\"/></camera>"), "`fov` must be"),
        (scene("<wheel/>"), "<wheel> is not known"),
        ("<test type=\"ttest\"/>".into(), "`test` is no scene"),
    ] {
        let message = read(folder.path(), &text).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(wanted), "{message}\nis not\n{wanted}");
    }
    let whole = room("<bsdf type=\"microfacet\"/>");
    let mut rng = Rng::new(5);
    for _ in 0..300 {
        let mut bytes = whole.clone().into_bytes();
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
