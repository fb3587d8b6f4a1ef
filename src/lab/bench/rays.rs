//! How much of the time is Embree's: a render's own rays through Embree alone, beside the render.

use super::record::{Kind, Recorder, Recording};
use super::replay::{RayOrder, RaySet, Strand, arranged, as_rendered, count, replay};
use super::{median, settings, with_threads};
use crate::format::SceneFile;
use crate::guiding::settings::GuidingMethod;
use crate::render::{GuideIo, Rendering, Settings, Stop, render, render_watched};
use crate::scene::Scene;
use crate::stats::Median;
use crate::{Error, Result};
use serde::Serialize;

const WIDTHS: [usize; 3] = [1, 8, 16];

/// What an unguided render's rays cost, in it and alone. Rates are in millions of rays a second of all threads together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RaysReport {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) spp: u32,
    pub(crate) max_depth: u32,
    pub(crate) paths: u64,
    pub(crate) rays: u64,
    pub(crate) shadow_rays: u64,
    /// Shares of them that met something.
    pub(crate) hit_share: f64,
    pub(crate) occluded_share: f64,
    pub(crate) whole: Vec<WholeFigure>,
    pub(crate) replays: Vec<ReplayFigure>,
}

/// The whole renderer against Embree on the same rays in the same calls.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WholeFigure {
    pub(crate) threads: usize,
    /// All rays over the render's seconds, from its first ray to its last sample in the picture.
    pub(crate) renderer: Median,
    /// All rays over the seconds within Embree's calls, alone.
    pub(crate) embree: Median,
    /// The same within the render.
    pub(crate) stage: Median,
    /// `renderer` over `embree`: the share of the render's time that Embree alone would take.
    pub(crate) share: Median,
    /// `stage` over `embree`.
    pub(crate) stage_share: Median,
}

/// One set of rays, in one order, one width and so many threads.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ReplayFigure {
    pub(crate) set: RaySet,
    pub(crate) order: RayOrder,
    pub(crate) width: usize,
    pub(crate) threads: usize,
    pub(crate) rays: usize,
    pub(crate) mrays_per_second: Median,
    /// Against single rays as they come, with as many threads.
    pub(crate) ratio: Median,
}

/// Records an unguided render and measures it, `turns` times with one thread and with `threads`.
///
/// # Errors
/// Where nothing is hit, or threads cannot be started.
pub(crate) fn rays(scene: &Scene, description: &SceneFile, threads: usize, turns: usize) -> Result<RaysReport> {
    let settings = settings(description, GuidingMethod::None);
    let recorder = Recorder::default();
    let rendering = render_watched(scene, &settings, GuideIo::default(), &recorder, &Stop::new(), &mut |_| true);
    let recording = recorder.finish();
    let counts = if threads > 1 { vec![1, threads] } else { vec![1] };
    let whole = counts.iter().map(|&n| whole(scene, &settings, &recording, n, turns)).collect::<Result<Vec<_>>>()?;
    let mut replays = Vec::new();
    for set in RaySet::ALL {
        for &n in &counts {
            replays.extend(replay_set(scene, &recording, set, n, turns)?);
        }
    }
    Ok(RaysReport { whole, replays, ..summary(scene, &settings, &rendering, &recording) })
}

fn summary(scene: &Scene, settings: &Settings, rendering: &Rendering, recording: &Recording) -> RaysReport {
    let share = |kind: Kind| {
        let found: usize = recording.batches.iter().flatten().filter(|w| w.kind == kind).map(|w| w.found).sum();
        found as f64 / recording.rays(kind).max(1) as f64
    };
    RaysReport {
        width: scene.camera.width,
        height: scene.camera.height,
        spp: rendering.samples,
        max_depth: settings.integrator.max_depth,
        paths: rendering.iterations.iter().map(|i| i.counters.paths).sum(),
        rays: recording.rays(Kind::Closest) as u64,
        shadow_rays: recording.rays(Kind::Shadow) as u64,
        hit_share: share(Kind::Closest),
        occluded_share: share(Kind::Shadow),
        whole: Vec::new(),
        replays: Vec::new(),
    }
}

/// Rates of one turn.
struct Turn {
    renderer: f64,
    embree: f64,
    stage: f64,
}

fn whole(
    scene: &Scene,
    settings: &Settings,
    recording: &Recording,
    threads: usize,
    turns: usize,
) -> Result<WholeFigure> {
    let strands = as_rendered(recording);
    let turn = || turn(scene, settings, &strands, threads);
    let turns: Vec<Turn> = with_threads(threads, || (0..turns).map(|_| turn()).collect())?;
    let of = |figure: fn(&Turn) -> f64| median(&turns.iter().map(figure).collect::<Vec<_>>());
    Ok(WholeFigure {
        threads,
        renderer: of(|turn| turn.renderer)?,
        embree: of(|turn| turn.embree)?,
        stage: of(|turn| turn.stage)?,
        share: of(|turn| turn.renderer / turn.embree)?,
        stage_share: of(|turn| turn.stage / turn.embree)?,
    })
}

fn turn(scene: &Scene, settings: &Settings, strands: &[Strand], threads: usize) -> Turn {
    let rendering = render(scene, settings, &mut |_| true);
    let within: f64 = rendering.all_iterations().map(|i| i.counters.embree_wall.as_secs_f64()).sum();
    let (alone, _) = replay(scene.geometry(), strands, 16);
    let rays = count(strands) as f64 * 1e-6;
    let n = threads as f64;
    Turn { renderer: rays / rendering.wall_seconds, embree: n * rays / alone, stage: n * rays / within }
}

fn replay_set(
    scene: &Scene,
    recording: &Recording,
    set: RaySet,
    threads: usize,
    turns: usize,
) -> Result<Vec<ReplayFigure>> {
    let orders = RayOrder::ALL.map(|order| (order, arranged(recording, set, order)));
    let rays = count(&orders[0].1);
    if rays == 0 {
        return Ok(Vec::new());
    }
    // the first is what the others are compared with
    let variants: Vec<_> = orders.iter().flat_map(|order| WIDTHS.map(|width| (order, width))).collect();
    let take_turns = || -> Vec<Vec<(f64, usize)>> {
        let one = || variants.iter().map(|((_, strands), width)| replay(scene.geometry(), strands, *width)).collect();
        (0..turns).map(|_| one()).collect()
    };
    let measured = with_threads(threads, take_turns)?;
    if let Some(k) = (1..variants.len()).find(|&k| disagree(measured[0][k].1, measured[0][0].1, rays)) {
        let ((order, _), width) = variants[k];
        let text = format!("{} rays, {}, {width} wide, meet other things than single ones", set.name(), order.name());
        return Err(Error::Scene(text));
    }
    let figure = |(k, ((order, _), width)): (usize, &(&(RayOrder, Vec<Strand>), usize))| {
        let rates: Vec<f64> = measured.iter().map(|turn| threads as f64 * rays as f64 * 1e-6 / turn[k].0).collect();
        let ratios: Vec<f64> = measured.iter().map(|turn| turn[0].0 / turn[k].0).collect();
        let (mrays_per_second, ratio) = (median(&rates)?, median(&ratios)?);
        Ok(ReplayFigure { set, order: *order, width: *width, threads, rays, mrays_per_second, ratio })
    };
    variants.iter().enumerate().map(figure).collect()
}

/// Rays that graze an edge may be decided otherwise in a packet: a few in a million.
fn disagree(found: usize, expected: usize, rays: usize) -> bool {
    found.abs_diff(expected) as f64 > 1.0 + 1e-4 * rays as f64
}
