//! Training before the first guided sample: the guide learns from small pictures of the same view, of which nothing is kept.
//!
//! A guide refines its cells and directions between iterations, by a level at a time, and the shortest iteration that a picture
//! can show is one sample per pixel. In a large picture that is far more than a young guide can use, and its first iterations,
//! a good part of a short render, would come from cells that are hardly refined. So it takes its first steps on as many camera
//! paths as they need: 32 thousand, then twice as many each time.

use super::driver::Job;
use super::schedule::{Tiling, rounds};
use super::state::RenderState;
use super::{IterationReport, limits::Limits};
use crate::integrator::path::{GuideUse, PathIntegrator};
use crate::integrator::probe::Watch;
use crate::integrator::{Batch, BatchResult, Task};
use crate::io::clock::WallClock;
use crate::scene::Camera;
use rayon::prelude::*;

/// Pixels of the small picture, about: the camera paths of the first lesson.
const PIXELS: u64 = 1 << 15;

/// Share of the budget that training may take: where it gains nothing, no more is lost.
const SHARE: f64 = 1.0 / 16.0;

/// Camera paths for each thread that are traced together, and then learnt from in the order of their tasks.
const ROUND_PATHS: usize = 1 << 15;

/// What tells the random numbers of training from those of the picture.
const SEED: u64 = 0x7472_6169_6e69_6e67;

/// How many lessons a picture of so many pixels has, with a budget of so many samples per pixel. The last has at most half as
/// many paths as a pass over the picture: from then on passes teach as well.
pub(super) fn lessons(pixels: u64, budget: f64) -> u32 {
    let most = (SHARE * budget * pixels as f64) as u64;
    let fits = |k: u32| PIXELS << k <= pixels / 2 && (PIXELS << (k + 1)) - PIXELS <= most;
    (0..u64::BITS - PIXELS.ilog2() - 1).take_while(|&k| fits(k)).count() as u32
}

/// Teaches a guide that knows nothing. Under a limit of time no lesson begins that is expected to end beyond the share of it.
pub(super) fn train<W: Watch>(job: &Job<W>, limits: &Limits, state: &mut RenderState) {
    let count = lessons(state.pixels, f64::from(job.settings.render.spp));
    let camera = job.scene.camera.coarser(PIXELS);
    let mut first = 0;
    for k in 0..count {
        let newest = state.iterations.last().filter(|_| k > 0).map_or(0.0, |lesson| lesson.wall_seconds);
        let soon = limits.seconds.is_some_and(|limit| training_seconds(state) + 2.0 * newest > SHARE * limit);
        if soon || limits.stop.is_asked() {
            break;
        }
        let Some(report) = lesson(job, limits, state, &camera, first..first + (1 << k)) else { break };
        state.iterations.push(report);
        first += 1 << k;
    }
}

fn training_seconds(state: &RenderState) -> f64 {
    let lessons = state.iterations.iter().filter(|iteration| iteration.samples == 0);
    lessons.map(|lesson| lesson.wall_seconds).sum()
}

/// One lesson of these samples of the small picture; `None` where it was given up.
fn lesson<W: Watch>(
    job: &Job<W>,
    limits: &Limits,
    state: &mut RenderState,
    camera: &Camera,
    samples: std::ops::Range<u32>,
) -> Option<IterationReport> {
    let clock = WallClock::start();
    let tiling = Tiling::new(camera.width, camera.height);
    let passes = samples.clone().step_by(tiling.samples as usize);
    let pass = |first: u32| tiling.pass(first, tiling.samples.min(samples.end - first));
    let tasks: Vec<Task> = passes.flat_map(pass).collect();
    let seed = state.seed ^ SEED;
    let guide = state.guide.as_mut()?;
    let mut report = IterationReport { usable_states: guide.field().len(), ..IterationReport::default() };
    guide.begin_iteration(tasks.iter().map(|task| task.paths() as u64).sum());
    for round in rounds(&tasks, ROUND_PATHS * rayon::current_num_threads()) {
        let field = guide.field();
        let integrator = PathIntegrator {
            guide: Some(GuideUse { field, settings: &job.settings.guiding, learn: true, efficiency: None }),
            camera,
            sampler: job.settings.render.sampler,
            ..PathIntegrator::plain(job.scene, &job.settings.integrator, seed)
        };
        let trace = |batch: &mut Batch, task: &Task| {
            let mut probe = job.watch.begin(task);
            let result = integrator.render_probed(task, batch, &mut probe, limits.stop)?;
            job.watch.end(task, probe);
            Some(result)
        };
        let results: Vec<BatchResult> = round.par_iter().map_init(Batch::default, trace).collect::<Option<_>>()?;
        results.iter().for_each(|result| report.counters.add(&result.counters));
        let recorders: Vec<_> = results.iter().filter_map(|result| result.recorder.as_ref()).collect();
        report.add_learning(|| guide.learn(&recorders));
    }
    let paths = report.counters.paths;
    report.add_learning(|| guide.end_iteration(paths));
    report.wall_seconds = clock.elapsed().as_secs_f64();
    Some(report)
}
