//! Each plug-in against Mitsuba itself, by tests of the means of blocks of pixels.

use super::{companions, plugins, read};
use crate::format::tests::blocks::{BLOCKS, RUNS, SPP, bound, compare, error_of_mean, runs, runs_of};
use crate::image::Layer;
use crate::image::exr::{self, Metadata, Window};
use crate::math::Rgb;
use crate::texture::ReliefKind;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The means of pictures may differ by so much: spheres of triangles, and relief by differences of texels.
const MEANS: f64 = 0.01;

/// The difference of means has to be known so well that this many of its standard errors are within them: noise alone passes the bound
/// with a probability of 6·10⁻⁵.
const KNOWN: f64 = 4.0;

/// Scenes whose means are not known so well get this many times the samples, at most.
const MOST_MORE: f64 = 64.0;

/// Renders scenes and prints, for each, the mean luminance of each block in each run.
const DRIVER: &str = r#"
import json, sys
import numpy as np
import mitsuba as mi
mi.set_variant("scalar_rgb")
runs, spp = int(sys.argv[1]), int(sys.argv[2])
answers = []
for path in sys.argv[3:]:
    scene = mi.load_file(path)
    of_scene = []
    for run in range(runs):
        image = np.array(mi.render(scene, spp=spp, seed=run + 1))[:, :, :3] @ np.array([0.212671, 0.715160, 0.072169])
        h, w = image.shape
        of_scene.append([float(image[y * h // 3:(y + 1) * h // 3, x * w // 4:(x + 1) * w // 4].mean()) for y in range(3) for x in range(4)])
    answers.append(of_scene)
print(json.dumps(answers))
"#;

/// A Python with Mitsuba; says so loudly where there is none.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("PHOTOTAXIS_PYTHON").map(PathBuf::from);
    let works = |python: &PathBuf| {
        let tried = Command::new(python).args(["-c", "import mitsuba, numpy"]).output();
        tried.is_ok_and(|output| output.status.success())
    };
    let found = python.filter(works);
    if found.is_none() {
        eprintln!("SKIPPED: scenes against Mitsuba: set PHOTOTAXIS_PYTHON to a Python with mitsuba and numpy");
    }
    found
}

/// By scene, run and block.
type Means = Vec<Vec<Vec<f64>>>;

fn theirs(python: &Path, files: &[PathBuf], spp: u32) -> Means {
    let (count, spp) = (RUNS.to_string(), spp.to_string());
    let output = Command::new(python).args(["-c", DRIVER, &count, &spp]).args(files).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let answer = said.lines().rfind(|line| line.starts_with('['));
    serde_json::from_str(answer.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&output.stderr)))).unwrap()
}

#[test]
fn every_plugin_is_mitsubas() {
    let Some(python) = python() else { return };
    let folder = companions();
    let scenes = plugins::scenes();
    let write = |(name, text): &(String, String)| {
        let path = folder.path().join(format!("{name}.xml"));
        fs::write(&path, text).unwrap();
        path
    };
    let files: Vec<PathBuf> = scenes.iter().map(write).collect();
    let all = theirs(&python, &files, SPP);
    let bound = bound(BLOCKS * scenes.len());
    let mut wrong = Vec::new();
    for (((name, text), path), theirs) in scenes.iter().zip(&files).zip(&all) {
        let file = read(folder.path(), text).unwrap_or_else(|error| panic!("{name}: {error}")).0;
        let ours = runs(&file, 1);
        let (t, mut mean) = compare(&ours, theirs);
        let error = error_of_mean(&ours).hypot(error_of_mean(theirs));
        let more = (error * KNOWN / MEANS).powi(2).min(MOST_MORE);
        if more > 1.0 {
            let spp = (f64::from(SPP) * more).ceil() as u32;
            let theirs = self::theirs(&python, std::slice::from_ref(path), spp);
            mean = compare(&runs_of(&file, 1, spp), &theirs[0]).1;
        }
        println!("{name}: t {t:.2} of {bound:.2}, mean {:+.2} %", 100.0 * mean);
        let (bound, means) = match name.as_str() {
            // the same model of a sky by another table
            "sky" | "sunsky" | "sun" => (f64::INFINITY, 0.1),
            // what would be reflected below the surface is folded upwards here (the test below), and heights are interpolated otherwise
            "normalmap" | "bumpmap" => (3.0 * bound, 2.0 * MEANS),
            _ => (bound, MEANS),
        };
        if !(t <= bound && mean.abs() <= means) {
            wrong.push(format!("{name}: t {t:.2} of {bound:.2}, mean {:+.2} %", 100.0 * mean));
        }
        if name == "normalmap" {
            let mut other = file.clone();
            let reliefs = other.scene.materials.values_mut().filter_map(|material| material.relief.as_mut());
            reliefs.for_each(|relief| relief.kind = ReliefKind::Normals);
            assert!(compare(&runs(&other, 1), theirs).0 > bound, "green that points the other way must be seen");
        }
        if name == "diffuse" {
            let other = text.replace("0.7 0.3 0.2", "0.7 0.36 0.2");
            let other = runs(&read(folder.path(), &other).unwrap().0, 1);
            assert!(compare(&other, theirs).0 > bound, "another reflectance must be seen");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Of the normal in `tilted_plane`, to the surface's.
const TILT: f64 = 30.0;

/// A plane whose normal is tilted towards x, seen from above, of reflectance 1.
fn tilted_plane(folder: &Path, light: &str) -> String {
    let (sin, cos) = TILT.to_radians().sin_cos();
    let stored = Rgb::new(0.5 + 0.5 * sin as f32, 0.5, 0.5 + 0.5 * cos as f32);
    let layers = vec![Layer::color("", &[stored; 4])];
    exr::write(&folder.join("tilt.exr"), &Window::full(2, 2), layers, &Metadata::default()).unwrap();
    format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="2"/></integrator>
<sensor type="perspective"><float name="fov" value="20"/><transform name="to_world">
<lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/></transform><film type="hdrfilm">
<integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>
<shape type="rectangle"><bsdf type="normalmap"><boolean name="use_shadowing_function" value="false"/>
<texture type="bitmap" name="normalmap"><boolean name="raw" value="true"/><string name="filename" value="tilt.exr"/></texture>
<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></bsdf></shape>{light}</scene>"#
    )
}

/// A light of irradiance π from so many degrees off the surface's normal, towards x.
fn from_the_side(degrees: f64) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    format!(
        r#"<emitter type="directional"><vector name="direction" x="{}" y="0" z="{}"/>
<rgb name="irradiance" value="3.14159265"/></emitter>"#,
        -sin, -cos
    )
}

/// Why reliefs are brighter here: what the tilted surface would reflect below the real one is lost there, and leaves upwards here.
/// Both are held to closed forms.
#[test]
fn only_what_is_folded_upwards_makes_reliefs_brighter_than_mitsubas() {
    let Some(python) = python() else { return };
    let folder = companions();
    let cosine = |degrees: f64| degrees.to_radians().cos().max(0.0);
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#.to_string();
    let cases = [
        ("sky", sky, 1.0, 0.5 * (1.0 + cosine(TILT))),
        ("40 degrees", from_the_side(40.0), cosine(40.0 - TILT), cosine(40.0 - TILT)),
        // seen in the mirror of the surface, that light is 75° from the tilted normal
        ("75 degrees", from_the_side(75.0), cosine(75.0 - TILT) + cosine(180.0 - 75.0 - TILT), cosine(75.0 - TILT)),
    ];
    for (name, light, ours, theirs) in cases {
        let text = tilted_plane(folder.path(), &light);
        let (file, path) = (read(folder.path(), &text).unwrap().0, folder.path().join("scene.xml"));
        let seen = [runs(&file, 1), self::theirs(&python, &[path], SPP).remove(0)];
        for (runs, expected) in seen.iter().zip([ours, theirs]) {
            let mean = runs.iter().flatten().sum::<f64>() / (RUNS * BLOCKS) as f64;
            let off = (mean / expected - 1.0).abs();
            assert!(off < 1e-4 + 5.0 * error_of_mean(runs), "{name}: {mean}, not {expected}");
        }
    }
}
