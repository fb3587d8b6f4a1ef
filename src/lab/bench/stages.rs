//! Whole renders: how fast, and what the time goes into, by method.
//!
//! Speeds are those of renders that nothing watches. A watched render of the same settings follows each; of it only the
//! proportions within batches are used ([`super::clock`]).

use super::clock::Clock;
use super::{median, settings};
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::probe::Stage;
use crate::render::{GuideIo, Rendering, Settings, Stop, render as render_scene, render_watched};
use crate::scene::Scene;
use crate::stats::Median;
use crate::{Error, Result};
use serde::Serialize;

/// What one method costs. Rates are per second of all threads together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MethodReport {
    pub(crate) method: &'static str,
    pub(crate) msamples_per_second: Median,
    pub(crate) mrays_per_second: Median,
    /// Per second of processor time, which other programs disturb less; `None` where that is too short to be seen.
    pub(crate) msamples_per_cpu_second: Option<Median>,
    pub(crate) rays_per_sample: f64,
    /// Means over the turns; they sum to 1.
    pub(crate) shares: Vec<Share>,
    /// What a stamp at a vertex cost; it is taken off the shares.
    pub(crate) stamp_nanoseconds: f64,
    /// How many times as long the watched render took; it is not in any figure.
    pub(crate) watching: f64,
}

/// Share of the threads' wall time.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Share {
    pub(crate) stage: &'static str,
    pub(crate) share: f64,
}

/// Stages of batches as in [`Stage::ALL`], then what happens between rounds of them.
pub(crate) const STAGES: [&str; 9] =
    ["generate", "intersect", "shade", "next event", "guide query", "record", "film", "learn", "rest"];

const FILM: usize = Stage::Film as usize;
const LEARN: usize = FILM + 1;
const REST: usize = FILM + 2;

/// Renders with each method in turns, with the threads of the current pool.
///
/// # Errors
/// Where there are too few samples to tell stages apart, or the system does not tell processor times.
pub(crate) fn render(
    scene: &Scene,
    description: &SceneFile,
    methods: &[GuidingMethod],
    turns: usize,
) -> Result<Vec<MethodReport>> {
    let mut runs: Vec<Vec<Run>> = methods.iter().map(|_| Vec::new()).collect();
    for _ in 0..turns {
        for (method, runs) in methods.iter().zip(&mut runs) {
            runs.push(run(scene, &settings(description, *method))?);
        }
    }
    methods.iter().zip(&runs).map(|(method, runs)| report(method.name(), runs)).collect()
}

struct Run {
    seconds: f64,
    cpu_seconds: f64,
    samples: u64,
    rays: u64,
    shares: [f64; STAGES.len()],
    stamp_nanoseconds: f64,
    watching: f64,
}

fn run(scene: &Scene, settings: &Settings) -> Result<Run> {
    let rendering = render_scene(scene, settings, &mut |_| true);
    let clock = Clock::default();
    let watched = render_watched(scene, settings, GuideIo::default(), &clock, &Stop::new(), &mut |_| true);
    let split = clock.split()?;
    let (counters, total) = (rendering.iterations.iter().map(|i| &i.counters), rendering.total());
    Ok(Run {
        seconds: rendering.wall_seconds,
        cpu_seconds: rendering.cpu.seconds(),
        samples: counters.map(|c| c.paths).sum(),
        rays: total.rays + total.shadow_rays,
        shares: shares(&rendering, &split.shares)?,
        stamp_nanoseconds: split.stamp_nanoseconds,
        watching: watched.wall_seconds / rendering.wall_seconds,
    })
}

/// The render's own account of its threads' wall time, batches divided as the watched render says. What the film and
/// learning took is an average over the threads.
fn shares(rendering: &Rendering, split: &[f64]) -> Result<[f64; STAGES.len()]> {
    let threads = rayon::current_num_threads() as f64;
    let sum = |of: fn(&crate::render::IterationReport) -> f64| rendering.all_iterations().map(of).sum::<f64>();
    let all = threads * rendering.wall_seconds;
    let batches = sum(|i| i.counters.wall.as_secs_f64()) / all;
    let mut shares = [0.0; STAGES.len()];
    shares.iter_mut().zip(split).for_each(|(share, part)| *share = batches * part);
    shares[FILM] += threads * sum(|i| i.film_wall_seconds) / all;
    shares[LEARN] = threads * sum(|i| i.learn_wall_seconds) / all;
    // the ends of rounds, where threads wait for the last batch; and what ends an iteration
    let rest = 1.0 - shares.iter().sum::<f64>();
    if rest < -1e-3 {
        return Err(Error::Scene(format!("stages take {:.3} of the time: clocks disagree", 1.0 - rest)));
    }
    shares[REST] = rest;
    Ok(shares)
}

fn report(method: &'static str, runs: &[Run]) -> Result<MethodReport> {
    let of = |figure: fn(&Run) -> f64| runs.iter().map(figure).collect::<Vec<f64>>();
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let share = |(k, stage): (usize, &&'static str)| Share {
        stage,
        share: mean(runs.iter().map(|run| run.shares[k]).collect()),
    };
    Ok(MethodReport {
        method,
        msamples_per_second: median(&of(|run| run.samples as f64 * 1e-6 / run.seconds))?,
        mrays_per_second: median(&of(|run| run.rays as f64 * 1e-6 / run.seconds))?,
        msamples_per_cpu_second: Median::of(&of(|run| run.samples as f64 * 1e-6 / run.cpu_seconds)),
        rays_per_sample: mean(of(|run| run.rays as f64 / run.samples as f64)),
        shares: STAGES.iter().enumerate().map(share).collect(),
        stamp_nanoseconds: mean(of(|run| run.stamp_nanoseconds)),
        watching: mean(of(|run| run.watching)),
    })
}
