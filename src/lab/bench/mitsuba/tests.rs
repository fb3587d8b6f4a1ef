use super::*;
use crate::format;
use std::fs;

mod imposter;
mod translated;

const SCENE: &str = "[camera]\norigin = [0, 1.2, 4.5]\ntarget = [0, 0.6, 0]\nvfov = 40\n\
    [film]\nwidth = 32\nheight = 24\n[[mesh]]\npath = \"room.obj\"\n\
    [integrator]\nmax_depth = 4\nroulette = \"throughput\"\nrr_depth = 3\n[render]\nseed = 3\n";

/// A floor and, above, a lamp that faces down.
const ROOM: &str = "mtllib room.mtl\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl floor\nf 4/4 3/3 2/2 1/1\n\
    v -0.5 2 -0.5\nv 0.5 2 -0.5\nv 0.5 2 0.5\nv -0.5 2 0.5\nusemtl lamp\nf 5 6 7 8\n";
const LIBRARY: &str = "newmtl floor\nKd 0.6 0.5 0.4\nnewmtl lamp\nKd 0 0 0\nKe 8 7 5\n";

const PLAN: MitsubaPlan = MitsubaPlan { spp: 64, threads: 1 };

/// The files of a scene, and what it says.
fn room(more: &str) -> (TempDir, SceneFile) {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{more}");
    for (name, text) in [("scene.toml", &text[..]), ("room.obj", ROOM), ("room.mtl", LIBRARY)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let (description, _) = format::load(&folder.path().join("scene.toml"), &[]).unwrap();
    (folder, description)
}
