//! A square that fills the picture under a white sky of radiance 1, so that a Lambertian surface of albedo a is seen as a.

use super::{Loaded, load, mean_color, written};
use tempfile::TempDir;

const SCENE: &str = "[camera]\norigin = [0, 0, 2]\ntarget = [0, 0, 0]\nvfov = 40\n[film]\nwidth = 8\nheight = 8\n\
    [integrator]\nmax_depth = 3\nnext_event = false\n[guiding]\nmethod = 'none'\n[render]\nspp = 64\n[[mesh]]\npath = 'model.obj'\n";
pub const SKY: &str = "[[light]]\ntype = 'constant'\nradiance = 1\n";
const SQUARE: &str = "mtllib model.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3 4/4\n";

pub fn square(scene: &str, library: &str) -> TempDir {
    let scene = format!("{SCENE}{scene}");
    written(&[("scene.toml", &scene), ("model.obj", SQUARE), ("model.mtl", &format!("newmtl a\n{library}"))])
}

pub fn loaded(folder: &TempDir) -> Loaded {
    load(&folder.path().join("scene.toml"), &[])
}

/// Mean colours of the upper and of the lower half of the picture.
pub fn halves(loaded: &Loaded) -> [[f64; 3]; 2] {
    let picture = loaded.estimate(&loaded.settings);
    let (upper, lower) = picture.mean.split_at(picture.mean.len() / 2);
    [mean_color(upper), mean_color(lower)]
}

/// The sky is the same everywhere, so that each path that reaches it brings the albedo, and nothing is left to chance but rounding.
pub fn assert_near(found: [f64; 3], wanted: [f64; 3]) {
    let near = found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.003);
    assert!(near, "{found:?} is not {wanted:?}");
}
