//! Instances may save memory, never change the picture.

use crate::common::{Loaded, Runs, load_written, welch};
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::math::Rgb;
use phototaxis::stats::sidak;

/// A tetrahedron; the face at its back glows.
const STONE: &str = "mtllib stone.mtl\nv 0 0 0\nv 1 0 0\nv 0.4 0.9 0.1\nv 0.5 0.2 0.8\n\
    usemtl grey\nf 1 2 4\nf 2 3 4\nf 3 1 4\nusemtl glow\nf 1 3 2\n";
const LIBRARY: &str = "newmtl grey\nKd 0.6 0.5 0.4\nnewmtl glow\nKd 0 0 0\nKe 4 3 2\n";
const FLOOR: &str = "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nf 4 3 2 1\n";
const HEAD: &str = "[camera]\norigin = [0.5, 3, 6]\ntarget = [0, 0.4, 0]\n[film]\nwidth = 48\nheight = 32\n\
    [render]\nspp = 32\ncombine = 'all'\n[[mesh]]\npath = 'floor.obj'\n";
const PLACES: [&str; 4] = [
    "translate = [-1.5, 0.1, 0]",
    "scale = [1.2, 0.5, 2]\nrotate = { axis = [0, 1, 0.2], angle = 130 }\ntranslate = [0.4, 0.3, 0.5]",
    "scale = [-1, 1.5, 1]\ntranslate = [2.2, 0.05, 0.2]",
    "scale = [-1.5, -1, -1]\nrotate = { axis = [1, 0, 0], angle = 75 }\ntranslate = [-0.3, 0.9, -1.4]",
];

fn load(instanced: bool) -> Loaded {
    let mut text = HEAD.to_string();
    if instanced {
        text += "[[mesh]]\npath = 'stone.obj'\ngroup = 'stone'\n";
        PLACES.iter().for_each(|place| text += &format!("[[instance]]\ngroup = 'stone'\n{place}\n"));
    } else {
        PLACES.iter().for_each(|place| text += &format!("[[mesh]]\npath = 'stone.obj'\n{place}\n"));
    }
    let files = [("scene.toml", &*text), ("stone.obj", STONE), ("stone.mtl", LIBRARY), ("floor.obj", FLOOR)];
    load_written(&files, &[])
}

/// Welch's test of the picture's mean and its 4 × 4 blocks, all together a false alarm with probability 10⁻⁴ (Šidák).
fn agree(some: &Runs, others: &Runs) -> bool {
    let level = sidak(1e-4, 17);
    (0..17).all(|k| welch(&some.summary(k), &others.summary(k)).1 > level)
}

#[test]
fn pictures_with_instances_are_those_with_copies() {
    let (one, other) = (load(true), load(false));
    for method in [GuidingMethod::None, GuidingMethod::Adaptive] {
        let settings = |loaded: &Loaded| {
            let mut settings = loaded.settings.clone();
            settings.guiding.method = method;
            settings
        };
        let (a, b) = (one.runs(&settings(&one), 48, 1), other.runs(&settings(&other), 48, 1001));
        assert!(agree(&a, &b), "{method:?}");
        assert!(!agree(&a.scaled(1.05), &b), "five per cent would be found");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let loaded = load(true);
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let estimate = pool.install(|| loaded.estimate(&loaded.settings));
        let bits = |p: &Rgb| p.to_array().map(f32::to_bits);
        estimate.mean.iter().map(bits).collect::<Vec<_>>()
    };
    let one = picture(1);
    assert!(one.iter().any(|p| *p != one[0]), "something is seen");
    assert!([2, 3].into_iter().all(|threads| picture(threads) == one));
}
