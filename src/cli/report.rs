//! The figures of a render, for people and for programs.

use super::output::layers;
use crate::guiding::settings::GuidingMethod;
use crate::image::{Layer, NonFinite, ViewTransform};
use crate::inspect::Layers;
use crate::integrator::Counters;
use crate::platform::Platform;
use crate::render::guide_file::GuideFingerprint;
use crate::render::{IterationReport, Reason, Rendering, Trial, Verdict};
use crate::scene::Scene;
use serde::Serialize;

/// Version of the JSON's shape; a change that breaks readers raises it.
const SCHEMA: u32 = 1;

/// What `--json` writes. Times are in seconds.
#[derive(Serialize)]
pub struct Report {
    schema: u32,
    phototaxis: &'static str,
    platform: Platform,
    scene: String,
    scene_hash: String,
    seed: u64,
    threads: usize,
    width: u32,
    height: u32,
    triangles: usize,
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
    load_seconds: f64,
    build_seconds: f64,
    render_seconds: f64,
    learn_seconds: f64,
    msamples_per_second: f64,
    mrays_per_second: f64,
    rays: u64,
    shadow_rays: u64,
    mean_path_length: f64,
    zero_contribution_share: f64,
    /// Share of the tiles' processor time in Embree's queries.
    embree_share: f64,
    /// Samples that count as black.
    non_finite_samples: u64,
    /// Pixels of the picture and its layers, and the first of them.
    non_finite_pixels: usize,
    first_non_finite_pixel: Option<NonFinite>,
    /// Stops by which the PNG is brightened, whether they were found by what the picture shows, and its tone curve.
    exposure_stops: f32,
    exposure_auto: bool,
    tone: &'static str,
    guide: GuideReport,
    iterations: Vec<Iteration>,
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
    seconds: f64,
    learn_seconds: f64,
    mean_path_length: f64,
    zero_contribution_share: f64,
    usable_states: usize,
    guide_drawn_share: f64,
    transitions: u64,
}

/// What the report needs beside the render itself.
pub struct Context<'a> {
    pub scene: &'a Scene,
    pub name: String,
    pub seed: u64,
    pub interrupted: bool,
    pub load_seconds: f64,
    pub build_seconds: f64,
    pub subject: GuideFingerprint,
    /// How the picture is shown, and whether its exposure was found by what it shows.
    pub view: ViewTransform,
    pub exposure_auto: bool,
    /// Where they are asked for.
    pub guide_layers: Option<Layers>,
}

impl Report {
    pub fn new(context: &Context, rendering: &Rendering) -> Report {
        let total = total(&rendering.iterations);
        let seconds = rendering.seconds;
        let guide = rendering.guide.as_ref();
        let layers = layers(rendering, context.guide_layers.as_ref());
        let non_finite = Layer::non_finite(&layers, rendering.estimate.width as usize);
        let (least, most, blank) = rendering.estimate.spread();
        let all_rays = (total.rays + total.shadow_rays) as f64;
        Report {
            schema: SCHEMA,
            phototaxis: env!("CARGO_PKG_VERSION"),
            platform: Platform::of(context.scene.geometry().device()),
            scene: context.name.clone(),
            scene_hash: context.scene.hash_text(),
            seed: context.seed,
            threads: rayon::current_num_threads(),
            width: rendering.estimate.width,
            height: rendering.estimate.height,
            triangles: context.scene.triangles(),
            embree_bytes: context.scene.geometry().device().memory(),
            exit: if context.interrupted { "interrupted" } else { "done" },
            spp: rendering.samples,
            spp_kept: rendering.estimate.samples,
            spp_kept_least: least,
            spp_kept_most: most,
            blank_pixels: blank,
            load_seconds: context.load_seconds,
            build_seconds: context.build_seconds,
            render_seconds: seconds,
            learn_seconds: rendering.iterations.iter().map(|i| i.learn_seconds).sum(),
            msamples_per_second: total.paths as f64 / seconds * 1e-6,
            mrays_per_second: all_rays / seconds * 1e-6,
            rays: total.rays,
            shadow_rays: total.shadow_rays,
            mean_path_length: ratio(total.rays, total.paths),
            zero_contribution_share: ratio(total.zero_contribution, total.paths),
            embree_share: total.embree.as_secs_f64() / total.total.as_secs_f64().max(1e-9),
            non_finite_samples: total.non_finite,
            non_finite_pixels: non_finite.as_ref().map_or(0, |found| found.pixels),
            first_non_finite_pixel: non_finite,
            exposure_stops: context.view.stops,
            exposure_auto: context.exposure_auto,
            tone: context.view.tone.name(),
            guide: GuideReport {
                method: guide.map_or(GuidingMethod::None, |g| g.method()).name(),
                states: guide.map_or(0, |g| g.states()),
                bytes: guide.map_or(0, |g| g.bytes()),
                hit_share: ratio(total.guide_hits, total.guide_queries),
                drawn_share: ratio(total.guided_directions, total.directions),
                verdict: rendering.verdict,
            },
            iterations: rendering.iterations.iter().map(Iteration::new).collect(),
        }
    }

    /// What is not finite in the picture and its layers.
    pub fn non_finite(&self) -> Option<&NonFinite> {
        self.first_non_finite_pixel.as_ref()
    }

    /// The few lines that a person wants at the end.
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{} spp in {:.1} s: {:.2} Msamples/s, {:.1} Mrays/s, {:.0} % of the time in Embree, mean path {:.1} segments",
            self.spp,
            self.render_seconds,
            self.msamples_per_second,
            self.mrays_per_second,
            100.0 * self.embree_share,
            self.mean_path_length,
        );
        if self.spp_kept_least < self.spp_kept_most {
            let (least, most) = (self.spp_kept_least, self.spp_kept_most);
            text += &format!("\nthe last pass was cut: pixels have {least} to {most} samples, see the layer samples.Y");
        }
        if self.blank_pixels > 0 {
            let all = self.width as usize * self.height as usize;
            text += &format!("\n{} of {all} pixels have no samples, and are black", self.blank_pixels);
        }
        if self.guide.method != "none" {
            text += &format!(
                "\nguide: {} states, {:.1} MiB, drew {:.0} % of the directions, {:.1} s of learning",
                self.guide.states,
                self.guide.bytes as f64 / (1 << 20) as f64,
                100.0 * self.guide.drawn_share,
                self.learn_seconds,
            );
        }
        text += &self.guide.verdict.map_or(String::new(), |verdict| format!("\n{}", reason(&verdict)));
        text += &self.platform.advice().map_or(String::new(), |advice| format!("\n{advice}"));
        text
    }
}

impl Iteration {
    fn new(report: &IterationReport) -> Iteration {
        let c = &report.counters;
        Iteration {
            spp: report.samples,
            seconds: report.seconds,
            learn_seconds: report.learn_seconds,
            mean_path_length: ratio(c.rays, c.paths),
            zero_contribution_share: ratio(c.zero_contribution, c.paths),
            usable_states: report.usable_states,
            guide_drawn_share: ratio(c.guided_directions, c.directions),
            transitions: c.transitions,
        }
    }
}

/// Why the guide is in use, or not.
fn reason(verdict: &Verdict) -> String {
    let share = format!("bounced light makes {:.0} % of the noise", 100.0 * verdict.bounced / verdict.variance);
    let budget = format!("{:.0} samples per pixel", verdict.budget);
    match (verdict.reason, verdict.trial) {
        (Reason::Calm, _) => {
            let variance = format!("with a relative variance of {:.2} a sample", verdict.bounced);
            format!("{share}, {variance}, too little for a guide: this scene was rendered without one")
        }
        (Reason::Short, _) => format!("{budget} are too few to learn from: this scene was rendered without a guide"),
        (_, None) => format!("{share}: the guide is in use, and was not judged yet"),
        (Reason::Promising, Some(trial)) => {
            format!("{}: the guide is worth {:.1} times the samples", tried(&trial), trial.gain())
        }
        (Reason::Losing, Some(trial)) => {
            let lost = 100.0 * verdict.lost / verdict.budget;
            format!(
                "{}: this scene was rendered on without a guide, whose trial cost {lost:.0} % of the budget",
                tried(&trial)
            )
        }
    }
}

fn tried(Trial { variance_ratio, cost_ratio }: &Trial) -> String {
    format!(
        "guided samples varied {variance_ratio:.2} times as much as unguided ones and cost {cost_ratio:.2} times as much"
    )
}

/// Counters of all iterations together.
pub fn total(iterations: &[IterationReport]) -> Counters {
    let mut sum = Counters::default();
    iterations.iter().for_each(|i| sum.add(&i.counters));
    sum
}

fn ratio(a: u64, b: u64) -> f64 {
    if b == 0 { 0.0 } else { a as f64 / b as f64 }
}
