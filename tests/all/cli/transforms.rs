//! Transforms of any size and flatness: a picture, or a message by line, and never an abort. Embree ends the process where
//! it is handed rays that are not finite, so each is loaded and rendered in a process of its own.

use super::{folder, phototaxis, stderr};
use phototaxis::math::rng::Rng;

const STONE: &str = "v 0 0 0\nv 1 0 0\nv 0.4 0.9 0.1\nv 0.5 0.2 0.8\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\n\
    f 1//1 2//2 4//3\nf 2//1 3//1 4//1\nf 3//2 1//2 4//2\nf 1//3 3//2 2//1\n";
const FLOOR: &str = "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nf 4 3 2 1\n";
const HEAD: &str = "[camera]\norigin = [0.5, 3, 6]\ntarget = [0, 0.4, 0]\n[film]\nwidth = 12\nheight = 8\n[render]\nspp = 2\n\
    [[light]]\ntype = 'point'\nposition = [1, 3, 2]\nintensity = 9\n[[light]]\ntype = 'constant'\nradiance = 1\n\
    [[mesh]]\npath = 'floor.obj'\n[[mesh]]\npath = 'stone.obj'\n";

const CASES: u32 = 120;

/// A power of ten with an exponent between −`range` and `range`.
fn size(rng: &mut Rng, range: f32) -> f32 {
    10f32.powf(range * (2.0 * rng.f32() - 1.0))
}

/// Every axis by itself between 10⁻³⁰ and 10³⁰; one axis of an ordinary object; an object as a whole; columns that almost
/// depend on each other.
fn transform(kind: u32, rng: &mut Rng) -> String {
    let [a, b, c, d] = [(); 4].map(|()| size(rng, 1.0));
    let turn = format!("rotate = {{ axis = [{a}, {b}, {c}], angle = 50 }}\ntranslate = [{d}, 0, {a}]");
    match kind {
        0 => format!("scale = [{:e}, {:e}, {:e}]", size(rng, 30.0), size(rng, 30.0), size(rng, 30.0)),
        1 => format!("scale = [{a}, {:e}, {b}]", size(rng, 18.0)),
        2 => format!("scale = [{a}, {b}, {:e}]\n{turn}", size(rng, 18.0)),
        3 => format!("scale = {:e}\n{turn}", size(rng, 18.0)),
        _ => {
            let other = c * (1.0 + 10f32.powf(-7.0 * rng.f32()));
            format!("matrix = [[{a}, {c}, {c}, 0], [{b}, {d}, {d}, 0], [{d}, {c}, {other}, 0]]")
        }
    }
}

#[test]
fn every_transform_is_rendered_or_refused() {
    let (mut rng, mut rendered, mut refused) = (Rng::new(11), [0; 2], [0; 2]);
    for case in 0..CASES {
        let instance = case % 2;
        let text = transform(case / 2 % 5, &mut rng);
        let group = ["", "group = 'a'\n[[instance]]\ngroup = 'a'\n"][instance as usize];
        let here = folder();
        let scene = format!("{HEAD}{group}{text}\n");
        for (name, text) in [("scene.toml", &*scene), ("stone.obj", STONE), ("floor.obj", FLOOR)] {
            std::fs::write(here.path().join(name), text).unwrap();
        }
        let output = phototaxis(here.path()).args(["render", "scene.toml", "-q", "-o", "a.exr"]).output().unwrap();
        match output.status.code() {
            Some(0) => {
                let picture = phototaxis::image::exr::read_rgb(&here.path().join("a.exr")).unwrap();
                assert!(picture.data.iter().all(|p| p.is_finite()), "{text}");
                rendered[instance as usize] += 1;
            }
            Some(1) => {
                // the head has no transform: the message is of a line behind it
                let message = stderr(&output);
                let line = message.strip_prefix("error: scene.toml:").and_then(|rest| rest.split(':').next());
                let line: usize =
                    line.and_then(|line| line.parse().ok()).unwrap_or_else(|| panic!("{text}: {message}"));
                assert!(line > HEAD.lines().count(), "{text}: {message}");
                refused[instance as usize] += 1;
            }
            _ => panic!("{text}: {:?}\n{}", output.status, stderr(&output)),
        }
    }
    println!("meshes and instances: {rendered:?} rendered, {refused:?} refused");
    assert!(rendered.iter().chain(&refused).all(|&n| n > 10), "{rendered:?} {refused:?}");
}
