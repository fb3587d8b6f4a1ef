//! The figures of a render, for people and for programs.

use super::layers::layers;
use super::output::Denoised;
use crate::film::ExtraLayer;
use crate::film::accumulate::Estimate;
use crate::guiding::settings::GuidingMethod;
use crate::image::{Layer, NonFinite, Tone, ViewTransform};
use crate::inspect::Layers;
use crate::io::clock;
use crate::math::Rgb;
use crate::platform::Platform;
use crate::render::guide_file::GuideFingerprint;
use crate::render::{IterationReport, Rendering, Stop, Trial, Verdict};
use crate::scene::{Scene, why_dark};
use serde::Serialize;

/// Version of the JSON's shape; a change that breaks readers raises it.
const SCHEMA: u32 = 2;

/// What `--json` writes. Rates are per second of wall time.
#[derive(Serialize)]
pub(crate) struct Report {
    schema: u32,
    phototaxis: &'static str,
    platform: Platform,
    /// When it was written, in UTC.
    date: String,
    scene: String,
    scene_hash: String,
    seed: u64,
    threads: usize,
    width: u32,
    height: u32,
    triangles: usize,
    /// In the coordinates of the scene's files: what the picture's are counted from.
    origin: [f64; 3],
    embree_bytes: u64,
    exit: &'static str,
    /// Samples per pixel traced, and those that the picture holds.
    spp: u32,
    spp_kept: u32,
    /// Of the picture's pixels, which differ where rendering ended in the middle of a pass: the fewest samples, the most, and
    /// how many pixels have none and are black.
    spp_kept_least: u32,
    spp_kept_most: u32,
    blank_pixels: usize,
    /// Samples of the picture tile by tile, where noisy ones got more.
    adaptive: Option<TileCounts>,
    /// Estimated of the picture, where rendering was to end by it.
    relative_error: Option<f64>,
    load_wall_seconds: f64,
    build_wall_seconds: f64,
    render_wall_seconds: f64,
    /// Processor time of all threads together.
    render_cpu_seconds: f64,
    /// Wall time that learning took, on average over all threads; and their processor time together.
    learn_wall_seconds: f64,
    learn_cpu_seconds: f64,
    msamples_per_second: f64,
    mrays_per_second: f64,
    rays: u64,
    shadow_rays: u64,
    mean_path_length: f64,
    zero_contribution_share: f64,
    /// Share of the tiles' wall time in Embree's queries.
    embree_share: f64,
    /// Samples that count as black.
    non_finite_samples: u64,
    /// Pixels of the picture and its layers, and the first of them.
    non_finite_pixels: usize,
    first_non_finite_pixel: Option<NonFinite>,
    /// The likely reason, where all of the picture is black.
    black_picture: Option<&'static str>,
    /// Stops by which the PNG is brightened, whether they were found by what the picture shows, and its tone curve.
    exposure_stops: f32,
    exposure_auto: bool,
    tone: &'static str,
    /// By whom the picture was denoised, and how long that took, where that was asked for.
    denoiser: Option<String>,
    denoise_seconds: Option<f64>,
    guide: GuideReport,
    /// Iterations of the small picture on which the guide was trained; their samples are per pixel of it.
    training: Vec<Iteration>,
    iterations: Vec<Iteration>,
}

/// Numbers of samples per pixel that the picture holds.
#[derive(Serialize)]
struct TileCounts {
    /// Pixels along a tile; those at the right and below may be smaller.
    tile: u32,
    columns: u32,
    rows: u32,
    /// Row by row, from the upper left.
    samples: Vec<u32>,
}

impl TileCounts {
    fn new(estimate: &Estimate, tile: u32) -> TileCounts {
        let (columns, rows) = (estimate.width.div_ceil(tile), estimate.height.div_ceil(tile));
        let corner = |k: u32| ((k / columns * estimate.width + k % columns) * tile) as usize;
        TileCounts { tile, columns, rows, samples: (0..columns * rows).map(|k| estimate.count(corner(k))).collect() }
    }
}

#[derive(Serialize)]
struct GuideReport {
    method: &'static str,
    states: usize,
    bytes: usize,
    /// Share of vertices asked for where the guide knew an answer.
    hit_share: f64,
    /// Share of the directions drawn at surfaces with smooth lobes that the guide drew.
    drawn_share: f64,
    /// Whether the guide paid, where that was asked.
    verdict: Option<Verdict>,
}

#[derive(Serialize)]
struct Iteration {
    spp: u32,
    wall_seconds: f64,
    learn_wall_seconds: f64,
    learn_cpu_seconds: f64,
    mean_path_length: f64,
    zero_contribution_share: f64,
    usable_states: usize,
    guide_drawn_share: f64,
    transitions: u64,
}

/// What the report needs beside the render itself.
pub(crate) struct Context<'a> {
    pub(crate) scene: &'a Scene,
    /// Whoever has no time for packing says so.
    pub(crate) stop: &'a Stop,
    pub(crate) name: String,
    pub(crate) seed: u64,
    pub(crate) interrupted: bool,
    /// Wall time.
    pub(crate) load_seconds: f64,
    pub(crate) build_seconds: f64,
    pub(crate) subject: GuideFingerprint,
    /// How the picture is shown, and whether its exposure was found by what it shows.
    pub(crate) view: ViewTransform,
    pub(crate) exposure_auto: bool,
    /// Columns and rows of the whole film, of which a part may be rendered.
    pub(crate) whole: [u32; 2],
    pub(crate) extra_layers: Vec<ExtraLayer>,
    /// Where they are asked for.
    pub(crate) guide_layers: Option<Layers>,
    pub(crate) denoised: Option<Denoised>,
}

impl Report {
    pub(crate) fn new(context: &Context, rendering: &Rendering) -> Report {
        let total = rendering.total();
        let seconds = rendering.wall_seconds;
        let guide = rendering.guide.as_ref();
        let layers = layers(rendering, context);
        let non_finite = Layer::non_finite(&layers, rendering.estimate.width as usize);
        let (least, most, blank) = rendering.estimate.spread();
        let paths: u64 = rendering.iterations.iter().map(|i| i.counters.paths).sum();
        let all_rays = (total.rays + total.shadow_rays) as f64;
        Report {
            schema: SCHEMA,
            phototaxis: env!("CARGO_PKG_VERSION"),
            platform: Platform::of(context.scene.geometry().device()),
            date: clock::utc_now(),
            scene: context.name.clone(),
            scene_hash: context.scene.hash_text(),
            seed: context.seed,
            threads: rayon::current_num_threads(),
            width: rendering.estimate.width,
            height: rendering.estimate.height,
            triangles: context.scene.triangles(),
            origin: context.scene.origin().to_array(),
            embree_bytes: context.scene.geometry().device().memory(),
            exit: if context.interrupted { "interrupted" } else { "done" },
            spp: rendering.samples,
            spp_kept: rendering.estimate.samples,
            spp_kept_least: least,
            spp_kept_most: most,
            blank_pixels: blank,
            adaptive: rendering.adaptive_tiles.map(|tile| TileCounts::new(&rendering.estimate, tile)),
            relative_error: rendering.relative_error,
            load_wall_seconds: context.load_seconds,
            build_wall_seconds: context.build_seconds,
            render_wall_seconds: seconds,
            render_cpu_seconds: rendering.cpu.seconds(),
            learn_wall_seconds: rendering.all_iterations().map(|i| i.learn_wall_seconds).sum(),
            learn_cpu_seconds: rendering.all_iterations().map(|i| i.learn_cpu.seconds()).sum(),
            msamples_per_second: paths as f64 / seconds * 1e-6,
            mrays_per_second: all_rays / seconds * 1e-6,
            rays: total.rays,
            shadow_rays: total.shadow_rays,
            mean_path_length: ratio(total.rays, total.paths),
            zero_contribution_share: ratio(total.zero_contribution, total.paths),
            embree_share: total.embree_wall.as_secs_f64() / total.wall.as_secs_f64().max(1e-9),
            non_finite_samples: total.non_finite,
            non_finite_pixels: non_finite.as_ref().map_or(0, |found| found.pixels),
            first_non_finite_pixel: non_finite,
            black_picture: why_black(context.scene, &rendering.estimate),
            exposure_stops: context.view.stops,
            exposure_auto: context.exposure_auto,
            tone: context.view.tone.name(),
            denoiser: context.denoised.as_ref().map(|denoised| denoised.by.clone()),
            denoise_seconds: context.denoised.as_ref().map(|denoised| denoised.seconds),
            guide: GuideReport {
                method: guide.map_or(GuidingMethod::None, |g| g.method()).name(),
                states: guide.map_or(0, |g| g.states()),
                bytes: guide.map_or(0, |g| g.bytes()),
                hit_share: ratio(total.guide_hits, total.guide_queries),
                drawn_share: ratio(total.guided_directions, total.directions),
                verdict: rendering.verdict,
            },
            training: rendering.training.iter().map(Iteration::new).collect(),
            iterations: rendering.iterations.iter().map(Iteration::new).collect(),
        }
    }

    /// What is not finite in the picture and its layers.
    pub(crate) fn non_finite(&self) -> Option<&NonFinite> {
        self.first_non_finite_pixel.as_ref()
    }

    /// That nothing can be seen, and the likely reason.
    pub(crate) fn blackness(&self) -> Option<String> {
        self.black_picture.map(|reason| format!("the picture is black; {reason}"))
    }

    /// The few lines that a person wants at the end.
    pub(crate) fn summary(&self) -> String {
        let mut lines = vec![format!(
            "{} samples per pixel in {:.1} s ({:.2} Msamples/s)",
            self.spp, self.render_wall_seconds, self.msamples_per_second
        )];
        if self.spp_kept_least < self.spp_kept_most {
            let (least, most) = (self.spp_kept_least, self.spp_kept_most);
            let why = if self.adaptive.is_some() { "adaptive" } else { "the last pass was cut" };
            lines.push(format!("{why}: pixels have {least} to {most} samples, see the layer samples.Y"));
        }
        if self.blank_pixels > 0 {
            let all = self.width as usize * self.height as usize;
            lines.push(format!("{} of {all} pixels have no samples, and are black", self.blank_pixels));
        }
        lines.extend(self.relative_error.map(|error| format!("the picture's relative error is about {error:.3}")));
        lines.extend(self.guide_in_words());
        if let (Some(by), Some(seconds)) = (&self.denoiser, self.denoise_seconds) {
            lines.push(format!("denoised in {seconds:.1} s by {by}"));
        }
        let chosen = if self.exposure_auto { ", chosen by what the picture shows" } else { "" };
        if self.exposure_auto || self.exposure_stops != 0.0 || self.tone != Tone::default().name() {
            let (stops, tone) = (self.exposure_stops, self.tone);
            lines.push(format!("the PNG is shown at {stops:+} stops{chosen}, tone curve {tone}"));
        }
        lines.extend(self.platform.advice());
        lines.join("\n")
    }

    /// What a guide did, where one was in use at the end.
    fn guide_in_words(&self) -> Vec<String> {
        let GuideReport { method, states, bytes, drawn_share, verdict, .. } = &self.guide;
        if *method == GuidingMethod::None.name() || *states == 0 || verdict.is_some_and(|v| !v.guided) {
            return Vec::new();
        }
        let mut lines = vec![format!(
            "the guide learnt for {:.1} s in {states} places ({:.1} MiB), and chose {:.0} % of the directions",
            self.learn_wall_seconds,
            *bytes as f64 / (1 << 20) as f64,
            100.0 * drawn_share,
        )];
        lines.extend(verdict.as_ref().map(reason));
        lines
    }
}

/// Why a picture has no light at all; `None` where it has, and where nothing was rendered.
fn why_black(scene: &Scene, estimate: &Estimate) -> Option<&'static str> {
    let rendered = estimate.spread().1 > 0;
    let black = rendered && estimate.mean.iter().all(|pixel| *pixel == Rgb::ZERO);
    black.then(|| why_dark(scene).reason())
}

impl Iteration {
    fn new(report: &IterationReport) -> Iteration {
        let c = &report.counters;
        Iteration {
            spp: report.samples,
            wall_seconds: report.wall_seconds,
            learn_wall_seconds: report.learn_wall_seconds,
            learn_cpu_seconds: report.learn_cpu.seconds(),
            mean_path_length: ratio(c.rays, c.paths),
            zero_contribution_share: ratio(c.zero_contribution, c.paths),
            usable_states: report.usable_states,
            guide_drawn_share: ratio(c.guided_directions, c.directions),
            transitions: c.transitions,
        }
    }
}

/// Why the guide is in use.
fn reason(verdict: &Verdict) -> String {
    match verdict.trial {
        Some(trial) => format!("{}: the guide is worth {:.1} times the samples", tried(&trial), trial.gain()),
        None => {
            let share = 100.0 * verdict.bounced / verdict.variance;
            format!("bounced light makes {share:.0} % of the noise: the guide is in use, and was not judged yet")
        }
    }
}

fn tried(Trial { variance_ratio, cost_ratio, .. }: &Trial) -> String {
    format!(
        "guided samples varied {variance_ratio:.2} times as much as unguided ones and cost {cost_ratio:.2} times as much"
    )
}

fn ratio(a: u64, b: u64) -> f64 {
    if b == 0 { 0.0 } else { a as f64 / b as f64 }
}
