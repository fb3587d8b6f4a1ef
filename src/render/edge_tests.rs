//! Dark pixels beside a bright half of the picture get as many paths as those far from it, and are no noisier.

use super::driver::{Driver, Job};
use super::limits::Limits;
use super::state::RenderState;
use super::{GuideIo, Settings, Stop};
use crate::film::tile::Tile;
use crate::format;
use crate::integrator::path::{GuideUse, PathIntegrator};
use crate::integrator::{Batch, Task};
use crate::math::luminance;
use crate::scene::Scene;
use std::fmt::Write;

/// Columns and rows of the picture; its right half is bright. The rows about the middle are looked at.
const SIZE: [u32; 2] = [48, 32];
const ROWS: [u32; 2] = [8, 24];

/// A closed room, seen from the front. Its back wall has two halves, of the materials `left` and `right`.
struct Room {
    left: &'static str,
    right: &'static str,
    /// A lamp under the ceiling.
    lamp: Option<[f32; 2]>,
    /// A sheet that stands between the halves, edge on: the lamp is behind it.
    parted: bool,
}

const EMISSION: Room = Room { left: "Kd 0.5 0.5 0.5", right: "Kd 0 0 0\nKe 4 4 4", lamp: None, parted: false };
const ALBEDO: Room = Room { left: "Kd 0.02 0.02 0.02", right: "Kd 0.9 0.9 0.9", lamp: Some([0.0, 2.0]), parted: false };
const SHADOW: Room = Room { left: "Kd 0.5 0.5 0.5", right: "Kd 0.5 0.5 0.5", lamp: Some([1.0, 0.8]), parted: true };

impl Room {
    fn load(&self) -> (Scene, Settings) {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        put("room.obj", &self.model());
        let Room { left, right, .. } = self;
        put(
            "room.mtl",
            &format!(
                "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe 20 20 20\nnewmtl left\n{left}\nnewmtl right\n{right}\n"
            ),
        );
        let [width, height] = SIZE;
        let camera = "[camera]\norigin = [0, 1, 3.5]\ntarget = [0, 1, 0]\nvfov = 32\n";
        let film = format!("[film]\nwidth = {width}\nheight = {height}\n");
        let rest = "[[mesh]]\npath = 'room.obj'\n[guiding]\nmethod = 'adaptive'\n[render]\nspp = 127\n";
        put("room.toml", &format!("{camera}{film}{rest}"));
        let (description, _) = format::load(&folder.path().join("room.toml"), &[]).unwrap();
        let (scene, _) = description.load_scene(1).unwrap();
        let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
        (scene, Settings { integrator, guiding, render })
    }

    fn model(&self) -> String {
        let mut text = "mtllib room.mtl\n".to_owned();
        let mut quad = |material: &str, corners: [[f32; 3]; 4]| {
            corners.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
            writeln!(text, "usemtl {material}\nf -4 -3 -2 -1").unwrap();
        };
        quad("left", [[-2., 0., 0.], [0., 0., 0.], [0., 2., 0.], [-2., 2., 0.]]);
        quad("right", [[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.]]);
        for x in [-2., 2.] {
            quad("wall", [[x, 0., 0.], [x, 0., 4.], [x, 2., 4.], [x, 2., 0.]]);
        }
        for y in [0., 2.] {
            quad("wall", [[-2., y, 0.], [2., y, 0.], [2., y, 4.], [-2., y, 4.]]);
        }
        quad("wall", [[-2., 0., 4.], [2., 0., 4.], [2., 2., 4.], [-2., 2., 4.]]);
        if let Some([x, z]) = self.lamp {
            let (a, b, c, d) = (x - 0.2, x + 0.2, z - 0.2, z + 0.2);
            quad("lamp", [[a, 1.98, c], [b, 1.98, c], [b, 1.98, d], [a, 1.98, d]]);
        }
        if self.parted {
            quad("wall", [[0., 0., 0.], [0., 0., 2.], [0., 2., 2.], [0., 2., 0.]]);
        }
        text
    }
}

/// What is found in some columns of the picture.
#[derive(Debug)]
struct Found {
    mean: f64,
    /// Rays of a camera path.
    rays: f64,
    /// Variance of a sample over the square of its mean.
    variance: f64,
}

/// Renders with a guide that has learnt, as the next iteration would.
fn look(scene: &Scene, settings: &Settings, state: &RenderState, columns: [u32; 2]) -> Found {
    let tile = Tile { x: columns[0], y: ROWS[0], width: columns[1] - columns[0], height: ROWS[1] - ROWS[0] };
    let guide = state.guide.as_ref().expect("there is a guide");
    let efficiency = state.roulette.as_ref();
    assert!(efficiency.is_some(), "roulette goes by the picture");
    let guide = GuideUse { field: guide.field(), settings: &settings.guiding, learn: false, efficiency };
    let integrator = PathIntegrator { guide: Some(guide), ..PathIntegrator::plain(scene, &settings.integrator, 1) };
    const SAMPLES: u32 = 2048;
    let result = integrator.render(&Task { tile, first_sample: 1 << 20, samples: SAMPLES }, &mut Batch::new());
    let pixels = tile.pixels() as f64;
    let n = SAMPLES as f64;
    let mean = |i: usize| luminance(result.samples.sum[i]) as f64 / n;
    let variance = |i: usize| luminance(result.samples.sum_squares[i]) as f64 / n / mean(i).powi(2) - 1.0;
    let average = |of: &dyn Fn(usize) -> f64| (0..tile.pixels()).map(of).sum::<f64>() / pixels;
    let rays = result.counters.rays as f64 / result.counters.paths as f64;
    Found { mean: average(&mean), rays, variance: average(&variance) }
}

/// The dark pixels within three of the edge, dark ones farther away, and bright ones.
fn halves(room: &Room) -> [Found; 3] {
    let (scene, settings) = room.load();
    let (stop, job) = (
        Stop::default(),
        Job {
            scene: &scene,
            camera: &scene.camera,
            settings: &settings,
            watch: &(),
            keep_guide: false,
            keeps_state: false,
        },
    );
    let state = RenderState::new(&scene, &scene.camera, &settings, GuideIo::default());
    let mut driver = Driver::new(job, state, Limits::from_now(None, &stop));
    driver.run(&mut |_| true, &mut ());
    let state = driver.into_state();
    let edge = SIZE[0] / 2;
    [[edge - 3, edge], [edge - 9, edge - 6], [edge + 6, edge + 9]]
        .map(|columns| look(&scene, &settings, &state, columns))
}

#[test]
fn pixels_beside_a_bright_half_are_rendered_as_others() {
    for (what, room) in [("emission", EMISSION), ("albedo", ALBEDO), ("shadow", SHADOW)] {
        let [near, far, bright] = halves(&room);
        println!("{what}: {near:?} near, {far:?} far, {bright:?} bright");
        assert!(bright.mean > 8.0 * near.mean && (0.7..1.4).contains(&(near.mean / far.mean)), "{what}: no such edge");
        assert!((0.8..1.25).contains(&(near.rays / far.rays)), "{what}: {} rays and {}", near.rays, far.rays);
        assert!((0.7..1.4).contains(&(near.variance / far.variance)), "{what}: {near:?} and {far:?}");
    }
}
