//! The largest and the smallest scenes: within the range that the manual states they look as any other, beyond it they
//! are refused.

use crate::common::{Loaded, describe, load_written, written};
use phototaxis::film::Combine;
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::math::Rgb;
use phototaxis::render::Settings;

/// A box, open to the camera, with a lamp under its top and a tilted block in it.
const BOX: &str = "v -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\nv -1 0 1\nv 1 0 1\nv 1 2 1\nv -1 2 1\nusemtl wall\n\
    f 1 2 3 4\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 6 2\nf 4 3 7 8\nv -0.4 1.99 -0.4\nv 0.3 1.99 -0.4\nv 0.3 1.99 0.3\n\
    v -0.4 1.99 0.3\nusemtl lamp\nf 9 10 11 12\nv -0.6 0.1 -0.5\nv 0.4 0.3 -0.7\nv 0.1 0.2 0.4\nv 0 1.1 -0.1\n\
    usemtl block\nf 13 14 16\nf 14 15 16\nf 15 13 16\nf 13 15 14\n";

const MATERIALS: &str = "[material.wall]\ntype = 'diffuse'\nreflectance = [0.7, 0.5, 0.3]\n[material.block]\n\
    type = 'plastic'\nreflectance = [0.2, 0.4, 0.6]\nalpha = 0.3\n[material.lamp]\ntype = 'diffuse'\nreflectance = 0\n\
    emission = [9, 8, 7]\n";

/// How the box gets its size: in its file, by the mesh's transform, or by that of an instance.
#[derive(Clone, Copy, Debug)]
enum By {
    File,
    Mesh,
    Instance,
}

/// The box `s` times as large.
fn scaled(s: f32, by: By) -> Loaded {
    let number = |x: &str| x.parse::<f32>().map_or(x.into(), |x| format!("{:e}", x * s));
    let line =
        |l: &str| if l.starts_with('v') { l.split(' ').map(number).collect::<Vec<_>>().join(" ") } else { l.into() };
    let object = match by {
        By::File => BOX.lines().map(line).collect::<Vec<_>>().join("\n"),
        _ => BOX.into(),
    };
    let place = match by {
        By::File => "[[mesh]]\npath = 'box.obj'\n".into(),
        By::Mesh => format!("[[mesh]]\npath = 'box.obj'\nscale = {s:e}\n"),
        By::Instance => format!("[[mesh]]\npath = 'box.obj'\ngroup = 'a'\n[[instance]]\ngroup = 'a'\nscale = {s:e}\n"),
    };
    let (y, z) = (s, 4.5 * s);
    let camera = format!("[camera]\norigin = [0, {y:e}, {z:e}]\ntarget = [0, {y:e}, 0]\nvfov = 35\n");
    let film = "[film]\nwidth = 24\nheight = 24\n[render]\nspp = 16\n";
    load_written(&[("scene.toml", &format!("{camera}{film}{MATERIALS}{place}")), ("box.obj", &object)], &[])
}

fn settings(loaded: &Loaded, method: GuidingMethod) -> Settings {
    let mut settings = loaded.settings.clone();
    (settings.guiding.method, settings.render.combine) = (method, Combine::All);
    settings
}

/// Squares of lengths, cubes of them, areas: powers of two go through all of them without rounding, so that a picture that
/// is not the same to the last bit has met the end of a range, or a number that stands for a length.
#[test]
fn a_power_of_two_changes_no_bit_from_the_smallest_to_the_largest_scene() {
    for by in [By::File, By::Mesh, By::Instance] {
        let one = scaled(1.0, by);
        let picture = |loaded: &Loaded| loaded.estimate(&settings(loaded, GuidingMethod::None)).mean;
        let expected = picture(&one);
        assert!(expected.iter().filter(|p| **p != Rgb::ZERO).count() > 400);
        for k in [-32, -26, -20, -13, -6, 3, 7, 14, 20, 26, 30, 33, 35, 37] {
            let found = picture(&scaled(2f32.powi(k), by));
            let equal = found.iter().zip(&expected).filter(|(a, b)| a == b).count();
            println!("{by:?}, 2^{k}: {equal} of {} pixels are equal", expected.len());
            assert_eq!(equal, expected.len(), "{by:?}, 2^{k}");
        }
    }
}

/// The same with a guide and with sizes that round: what differs then is noise.
#[test]
fn powers_of_ten_change_no_mean() {
    let mean = |s: f32, by: By, method| {
        let loaded = scaled(s, by);
        let picture = loaded.estimate(&settings(&loaded, method)).mean;
        picture.iter().map(|p| p.y as f64).sum::<f64>() / picture.len() as f64
    };
    for (by, method) in [(By::File, GuidingMethod::Grid), (By::Instance, GuidingMethod::Adaptive)] {
        let expected = mean(1.0, by, method);
        for k in -9..=11 {
            let found = mean(10f32.powi(k), by, method);
            println!("{by:?}, {method:?}, 10^{k}: {found:.4}, {expected:.4} at 1");
            assert!((found / expected - 1.0).abs() < 0.05, "{by:?}, 10^{k}: {found}, not {expected}");
        }
    }
}

/// What loading says of a scene file with these meshes and instances.
fn refused(text: &str, object: &str) -> String {
    let folder = written(&[("scene.toml", text), ("a.obj", object), ("floor.obj", BOX)]);
    let path = folder.path().join("scene.toml");
    let loaded = phototaxis::format::load(&path, &[]).and_then(|(description, _)| description.load_scene(0));
    let message = loaded.err().map_or_else(|| panic!("{text} was not refused"), |error| error.to_string());
    message.replace(&*folder.path().to_string_lossy(), "")
}

#[test]
fn what_is_beyond_the_range_is_refused_by_line() {
    let object = |s: &str| format!("v 0 0 0\nv {s} 0 0\nv 0 {s} 0\nf 1 2 3\n");
    let alone = "[[mesh]]\npath = 'a.obj'\n";
    for (text, size, expected) in [
        (alone, "1.1e12", "/a.obj:2:1: vertex 2 is not finite or beyond 1e12"),
        ("[[mesh]]\npath = 'a.obj'\nscale = 1e7\n", "1e6", "/scene.toml:3:9: this transform carries the mesh beyond"),
        (alone, "1e-11", "/scene.toml:1:1: the scene has an extent of 1e-11"),
        ("[[mesh]]\npath = 'a.obj'\nscale = 1e-18\n", "1", "/scene.toml:3:9: the scene has an extent of 1e-18"),
        ("[camera]\norigin = [0, 2e12, 0]\n", "1", "/scene.toml:2:14: `origin` must be between -1e12 and 1e12"),
    ] {
        let message = refused(text, &object(size));
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn instances_without_an_inverse_are_refused_by_line() {
    let head = "[[mesh]]\npath = 'floor.obj'\n[[mesh]]\npath = 'a.obj'\ngroup = 'a'\n[[instance]]\ngroup = 'a'\n";
    let object = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
    for place in [
        "scale = [1, 1, 1e-30]",
        "scale = [1e-20, 1, 1]",
        "scale = 1e-14",
        "scale = [1e18, 1e-18, 1e-18]",
        "matrix = [1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1.00001, 0]",
        "scale = 1e13",
    ] {
        let message = refused(&format!("{head}{place}\n"), object);
        assert!(message.starts_with("/scene.toml:8:") && message.contains("group `a`"), "{place}: {message}");
    }
}

/// One that is almost flat is seen as what is flat.
#[test]
fn flat_instances_are_rendered() {
    let picture = |place: &str, group: bool| {
        let mesh = "[[mesh]]\npath = 'a.obj'\nmaterial = 'wall'\n";
        let place = if group {
            format!("{mesh}group = 'a'\n[[instance]]\ngroup = 'a'\n{place}\n")
        } else {
            format!("{mesh}{place}\n")
        };
        let head = "[camera]\norigin = [0.2, 0.3, 2]\ntarget = [0.2, 0.2, 0]\nvfov = 60\n[film]\nwidth = 16\nheight = 16\n\
            [render]\nspp = 64\n[[light]]\ntype = 'constant'\nradiance = 1\n";
        let object = "v 0 0 0\nv 1 0 0\nv 0 1 0.5\nv 0.2 0.2 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
        let (wall, _) = MATERIALS.split_once("[material.block]").unwrap();
        let loaded = load_written(&[("scene.toml", &format!("{head}{wall}{place}")), ("a.obj", object)], &[]);
        let mean = loaded.estimate(&settings(&loaded, GuidingMethod::None)).mean;
        assert!(mean.iter().all(|p| p.is_finite()));
        mean
    };
    let expected = picture("scale = [1, 1, 1e-7]", false);
    for place in ["scale = [1, 1, 1e-7]", "scale = [1, 1, 1e-10]", "scale = [1, 1, 1e-14]", "scale = [1, 1, -1e-14]"] {
        let found = picture(place, true);
        let difference = found.iter().zip(&expected).map(|(a, b)| (*a - *b).abs().max_element()).sum::<f32>();
        println!("{place}: mean difference {:.4}", difference / expected.len() as f32);
        assert!(difference / (expected.len() as f32) < 0.02, "{place}");
    }
}

#[test]
fn locations_are_those_of_the_transform() {
    let folder =
        written(&[("scene.toml", "[[mesh]]\npath = 'a.obj'\n[[mesh]]\npath = 'a.obj'\ntranslate = [1, 2, 3]\n")]);
    let description = describe(&folder.path().join("scene.toml"), &[]);
    let places = description.scene.meshes.iter().map(|mesh| mesh.location.as_ref().map(|l| (l.line, l.column)));
    assert_eq!(places.collect::<Vec<_>>(), [Some((1, 1)), Some((5, 13))]);
}
