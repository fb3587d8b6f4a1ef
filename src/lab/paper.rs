//! The pictures of Tan, "Implementation of Ray Tracing with Reinforced Learning" (2017), as settings of the project's own
//! scenes; what came of them is told in docs/paper.md.
//!
//! The captions of the figures name no settings: what each letter stands for is read from the text (§5.1, §5.2).

use glam::{DAffine3, DVec3};

use crate::scene::description::SceneDescription;

/// What a picture shows, and how it is cut in two for error figures.
pub struct View {
    pub(crate) name: &'static str,
    /// One of [`crate::lab::generate::scenes`].
    pub scene: &'static str,
    /// Pixels at scale 1.
    pub(crate) size: [u32; 2],
    /// Overrides of the scene's camera and exposure.
    pub(crate) camera: &'static [&'static str],
    pub(crate) parts: [&'static str; 2],
    /// Whether a place in [0, 1]², from the upper left corner, lies in the first part.
    pub(crate) in_first: fn(f64, f64) -> bool,
    /// Samples per pixel; `None`: as the command says.
    pub(crate) spp: Option<u32>,
}

/// §5.1. Blocks are rendered from the centre outwards, so that it is rendered with the least learnt.
static DOOR: View = View {
    name: "door",
    scene: "door",
    size: [256, 144],
    camera: &[],
    parts: ["centre", "edge"],
    in_first: |x, y| (x - 0.5).abs() < 0.25 && (y - 0.5).abs() < 0.25,
    spp: None,
};

/// §5.2. The wall stands in the middle of the picture, the lamp hangs on its left.
static WALL: View = View {
    name: "wall",
    scene: "wall",
    size: [256, 192],
    camera: &[],
    parts: ["bright", "dark"],
    in_first: |x, _| x < 0.5,
    spp: Some(32),
};

/// Figure 3: the door itself, which lies along no axis.
static LEAF: View = View {
    name: "leaf",
    scene: "door",
    size: [192, 192],
    camera: &["camera.target=[0.97, 1.15, -0.25]", "camera.vfov=22", "film.exposure=1"],
    parts: ["leaf", "rest"],
    in_first: |x, _| x > 0.3,
    spp: Some(32),
};

/// A picture of the paper, or one that a sentence of it speaks of.
pub struct Preset {
    pub name: &'static str,
    pub(crate) about: &'static str,
    pub view: &'static View,
    /// Degrees by which the whole scene is turned about +y.
    pub(crate) turn: f32,
    /// Where Q is drawn beside what is traced, in [0, 1]² from the upper left corner of the picture.
    pub(crate) shown: Option<[f64; 2]>,
    settings: &'static [&'static [&'static str]],
}

/// "The simplest form of path tracer": light is found by chance alone.
const SIMPLE: &[&str] = &["integrator.next_event=false", "integrator.mis=false", "integrator.roulette=none"];
/// "Path reusing, russian roulette and multiple importance sampling".
const FULL: &[&str] = &["integrator.next_event=true", "integrator.mis=true", "integrator.roulette=throughput"];

/// The paper's grid and table, learning on-line; a small share for the BSDF keeps strata that rounding left empty
/// possible.
const LEARNING: &[&str] = &[
    "guiding.method=grid",
    "guiding.resolution=64",
    "guiding.normals=false",
    "guiding.jitter=false",
    "guiding.table=hemisphere",
    "guiding.strata=12",
    "guiding.rule=expected-sarsa",
    "guiding.rate=vanishing",
    "guiding.updates=online",
    "guiding.sampling=q",
    "guiding.bsdf_fraction=0.05",
    "guiding.learned_fraction=false",
    "guiding.smoothing=0",
    "guiding.memory=1 GiB",
];
/// Cosine-weighted directions: all of the scenes' large surfaces are Lambertian.
const NO_LEARNING: &[&str] = &["guiding.method=none"];

/// "Exponentially increase the sample count per pixel and only keep the last rendered image."
const PROGRESSIVE: &[&str] = &["render.order=progressive", "render.combine=last"];
const ONE_GO: &[&str] = &["render.order=blocks"];

const NORMALS: &[&str] = &["guiding.normals=true"];
const SPHERE: &[&str] = &["guiding.table=sphere"];
const CONSTANT: &[&str] = &["guiding.rate=constant", "guiding.alpha=0.1"];

const fn preset(
    name: &'static str,
    about: &'static str,
    view: &'static View,
    settings: &'static [&'static [&'static str]],
) -> Preset {
    Preset { name, about, view, turn: 0.0, shown: None, settings }
}

/// Degrees that lay the scene `door` along the axes.
const ALIGNED: f32 = -17.0;

/// On the floor in front of the gap, and on that of the half without a lamp: where little of what arrives is worth a ray.
const DOOR_FLOOR: [f64; 2] = [0.62, 0.9];
const WALL_FLOOR: [f64; 2] = [0.75, 0.85];

static PRESETS: [Preset; 22] = [
    preset("fig1a", "learning, simple, progressive", &DOOR, &[SIMPLE, LEARNING, PROGRESSIVE]),
    preset("fig1b", "learning, full, progressive", &DOOR, &[FULL, LEARNING, PROGRESSIVE]),
    preset("fig1c", "learning, simple, in one go", &DOOR, &[SIMPLE, LEARNING, ONE_GO]),
    preset("fig1d", "cosine, simple, in one go", &DOOR, &[SIMPLE, NO_LEARNING, ONE_GO]),
    preset("fig1e", "cosine, full, in one go", &DOOR, &[FULL, NO_LEARNING, ONE_GO]),
    preset("fig1e-progressive", "cosine, full, progressive", &DOOR, &[FULL, NO_LEARNING, PROGRESSIVE]),
    preset("fig1a-sphere", "fig1a with the sphere's table", &DOOR, &[SIMPLE, LEARNING, PROGRESSIVE, SPHERE]),
    preset("fig1a-constant", "fig1a with a rate of 0.1", &DOOR, &[SIMPLE, LEARNING, PROGRESSIVE, CONSTANT]),
    preset("fig1a-normals", "fig1a, cells told apart by normals", &DOOR, &[SIMPLE, LEARNING, PROGRESSIVE, NORMALS]),
    Preset {
        shown: Some(DOOR_FLOOR),
        ..preset("fig1f", "fig1a, and Q before the door", &DOOR, &[SIMPLE, LEARNING, PROGRESSIVE])
    },
    preset("fig2a", "learning, simple, progressive", &WALL, &[SIMPLE, LEARNING, PROGRESSIVE]),
    preset("fig2b", "learning, full, progressive", &WALL, &[FULL, LEARNING, PROGRESSIVE]),
    preset("fig2c", "learning, simple, in one go", &WALL, &[SIMPLE, LEARNING, ONE_GO]),
    preset("fig2d", "cosine, simple, in one go", &WALL, &[SIMPLE, NO_LEARNING, ONE_GO]),
    preset("fig2e", "cosine, full, in one go", &WALL, &[FULL, NO_LEARNING, ONE_GO]),
    preset("fig2a-sphere", "fig2a with the sphere's table", &WALL, &[SIMPLE, LEARNING, PROGRESSIVE, SPHERE]),
    preset("fig2a-constant", "fig2a with a rate of 0.1", &WALL, &[SIMPLE, LEARNING, PROGRESSIVE, CONSTANT]),
    Preset {
        shown: Some(WALL_FLOOR),
        ..preset("fig2f", "fig2a, and Q in the dark half", &WALL, &[SIMPLE, LEARNING, PROGRESSIVE])
    },
    preset("fig3", "the door's leaf, sphere, no normals", &LEAF, &[SIMPLE, LEARNING, ONE_GO, SPHERE]),
    preset("fig3-hemisphere", "the same, hemisphere", &LEAF, &[SIMPLE, LEARNING, ONE_GO]),
    preset("fig3-normals", "fig3, cells told apart by normals", &LEAF, &[SIMPLE, LEARNING, ONE_GO, SPHERE, NORMALS]),
    Preset {
        turn: ALIGNED,
        ..preset("fig3-aligned", "fig3, the scene along the axes", &LEAF, &[SIMPLE, LEARNING, ONE_GO, SPHERE])
    },
];

/// All of them, figure by figure; the first of a figure is what the others are timed against.
pub fn presets() -> &'static [Preset] {
    &PRESETS
}

impl Preset {
    /// Overrides of the scene file, as of `--set`.
    pub fn overrides(&self) -> impl Iterator<Item = &'static str> {
        self.view.camera.iter().copied().chain(self.settings.iter().copied().flatten().copied())
    }

    /// Name of the figure's first preset.
    pub(crate) fn compared_with(&self) -> &'static str {
        let first = PRESETS.iter().find(|other| std::ptr::eq(other.view, self.view));
        first.expect("it is itself one of them").name
    }

    /// Turns meshes and camera, where the preset asks for it.
    pub(crate) fn place(&self, scene: &mut SceneDescription) {
        let turn = DAffine3::from_rotation_y(f64::from(self.turn).to_radians());
        scene.meshes.iter_mut().for_each(|mesh| mesh.transform = turn * mesh.transform);
        if let Some(camera) = &mut scene.camera {
            let moved = |p: DVec3| turn.transform_point3(p);
            (camera.origin, camera.target) = (moved(camera.origin), moved(camera.target));
            camera.up = moved(camera.up.as_dvec3()).as_vec3();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn what_every_preset_sets_can_be_set_together() {
        for preset in presets() {
            let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/wall.toml");
            let settings: Vec<String> = preset.overrides().map(String::from).collect();
            let read = crate::format::load(&scene, &settings);
            assert!(read.is_ok(), "{}: {}", preset.name, read.err().map_or(String::new(), |e| e.to_string()));
        }
    }

    #[test]
    fn names_are_told_apart_and_timed_against_the_first_of_their_figure() {
        let names: BTreeSet<&str> = presets().iter().map(|p| p.name).collect();
        assert_eq!(names.len(), presets().len());
        for preset in presets() {
            assert_eq!(preset.compared_with()[..4], preset.name[..4], "{}", preset.name);
        }
    }
}
