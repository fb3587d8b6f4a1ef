//! Training before the first guided sample: a small picture of the same view is rendered, of which nothing is kept but what the
//! guide has learnt, and by what roulette may go.
//!
//! A guide refines its cells and directions between iterations, by a level at a time, and the shortest iteration that a picture
//! can show is one sample per pixel. In a large picture that is far more than a young guide can use: its first iterations, a
//! good part of a short render, would come from cells that are hardly refined, and of the picture no more would be known than a
//! few samples per pixel tell. A small picture of as many paths has taken several steps, and knows what it shows.

use super::GuideIo;
use super::driver::{Driver, Job};
use super::limits::Limits;
use super::state::RenderState;
use crate::integrator::RouletteNormalisation;
use crate::integrator::probe::Watch;
use crate::scene::Camera;

/// Pixels of the small picture, about.
const PIXELS: u64 = 1 << 15;

/// Share of the budget that training may take: where it gains nothing, no more is lost.
const SHARE: f64 = 1.0 / 16.0;

/// Samples per pixel of the small picture, at least: with fewer, nothing is refined.
const LEAST_SAMPLES: u32 = 3;

/// What tells the random numbers of training from those of the picture.
const SEED: u64 = 0x7472_6169_6e69_6e67;

/// Samples per pixel of the small picture that is rendered before one of so many pixels with a budget of so many samples of each;
/// 0 where there is none. They make whole iterations, 1, 3, 7, 15 …, and no more paths than a pass over the large picture: from
/// then on passes teach as much.
pub(super) fn samples(pixels: u64, budget: f64) -> u32 {
    let most = (SHARE * budget).min(1.0) * pixels as f64 / PIXELS as f64;
    if most < f64::from(LEAST_SAMPLES) { 0 } else { (1 << (most + 1.0).log2() as u32) - 1 }
}

/// Trains the guide of a render that is about to begin, or to take its first guided sample. Under a limit of time it takes its share
/// of that at most. `go_on` is asked before each pass.
pub(super) fn train<W: Watch>(job: &Job<W>, limits: &Limits, state: &mut RenderState, go_on: &mut dyn FnMut() -> bool) {
    go_on();
    let camera = job.camera.coarser(PIXELS);
    let mut settings = job.settings.clone();
    settings.render.spp = samples(state.pixels, f64::from(settings.render.spp));
    settings.render.seed = state.seed ^ SEED;
    (settings.render.time, settings.render.noise) = (None, None);
    settings.render.adaptive = false;
    settings.render.layers.clear();
    let share = limits.seconds.map(|seconds| SHARE * seconds);
    let small = Job { camera: &camera, settings: &settings, keep_guide: true, keeps_state: false, ..*job };
    let mut trained = RenderState::new(job.scene, &camera, &settings, GuideIo { from: None, keep: true });
    trained.guide = state.guide.take();
    let mut driver = Driver::new(small, trained, Limits::from_now(share, limits.stop));
    driver.run(&mut |_| go_on() && !limits.stop.is_asked(), &mut ());
    let trained = driver.into_state();
    (state.guide, state.learnt_samples) = (trained.guide, trained.learnt_samples);
    state.roulette = trained.roulette.map(|small| enlarged(&small, &camera, job.camera));
    state.training = trained.iterations;
}

/// The same for the pixels of a larger picture of the view.
fn enlarged(small: &RouletteNormalisation, from: &Camera, to: &Camera) -> RouletteNormalisation {
    let nearest = |k: u32, from: u32, to: u32| (u64::from(2 * k + 1) * u64::from(from) / u64::from(2 * to)) as usize;
    let row = |y: u32| {
        let row = nearest(y, from.height, to.height) * from.width as usize;
        (0..to.width).map(move |x| row + nearest(x, from.width, to.width))
    };
    let inverse_luminance = (0..to.height).flat_map(row).map(|k| small.inverse_luminance[k]).collect();
    RouletteNormalisation { inverse_luminance, scale: small.scale }
}

#[cfg(test)]
#[path = "training_tests.rs"]
mod tests;
