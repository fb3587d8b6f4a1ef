//! The studio that really renders.

mod limits;
mod references;

use super::measure::{self, Reference, blocks};
use super::plan::{Plan, file_stem};
use super::record::{Iteration, Run};
use super::reference;
use super::scene_cache::{SceneCache, settings};
use super::schedule::{Executor, Slot};
use super::store::Store;
use super::{bias::ReferenceBlocks, memory};
use crate::image::exr::{self, Metadata, Window};
use crate::image::{Exposure, Image, Layer, Tone};
use crate::platform::Platform;
use crate::render::{self, GuideIo, IterationReport, Progress, Rendering, Settings, Stop};
use crate::scene::Scene;
use crate::{Error, Result};
use limits::Limits;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What it does, for those who wait; told so again and again.
pub(crate) enum Event<'a> {
    /// A pilot run of a method.
    Pilot {
        scene: &'a str,
        method: &'a str,
        progress: Progress,
    },
    /// A reference is made, whose relMSE must fall to `wanted`.
    Reference {
        scene: &'a str,
        wanted: f64,
        progress: Progress,
    },
    Run {
        scene: &'a str,
        method: &'a str,
        budget: &'a str,
        progress: Progress,
    },
}

pub(crate) type Listener<'a> = &'a mut dyn FnMut(Event);

/// Renders and measures the runs of a plan.
pub(crate) struct RenderExecutor<'a> {
    plan: &'a Plan,
    scene_cache: &'a SceneCache,
    folder: &'a Path,
    allow_noisy: bool,
    reference: Option<Reference>,
    stop: &'a Stop,
    listener: Listener<'a>,
    limits: Limits,
    /// Wall seconds for a sample per pixel of the pilot runs, by scene and method.
    pace: FxHashMap<(usize, usize), f64>,
    /// The largest error so far by method, of the scene that was made ready; only kept for a gallery.
    worst: Vec<Option<f64>>,
}

impl<'a> RenderExecutor<'a> {
    /// `folder` takes references and pictures. With `allow_noisy`, references are used whatever their noise. Once `stop` is
    /// asked for, the run under way is thrown away and no other begins.
    pub(crate) fn new(
        plan: &'a Plan,
        scene_cache: &'a SceneCache,
        folder: &'a Path,
        allow_noisy: bool,
        stop: &'a Stop,
        listener: Listener<'a>,
    ) -> RenderExecutor<'a> {
        RenderExecutor {
            plan,
            scene_cache,
            folder,
            allow_noisy,
            reference: None,
            stop,
            listener,
            limits: Limits::default(),
            pace: FxHashMap::default(),
            worst: Vec::new(),
        }
    }

    /// Renders; `None` where it was told to stop.
    fn render<'e>(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        event: impl Fn(Progress) -> Event<'e>,
    ) -> Option<Rendering> {
        let rendering = render::render_until(scene, settings, GuideIo::default(), self.stop, &mut |progress| {
            (self.listener)(event(*progress));
            true
        });
        (!self.stop.is_asked()).then_some(rendering)
    }

    /// Keeps a picture of a scene's method.
    fn write_picture(&self, slot: &Slot, rendering: &Rendering, path: &Path) -> Result<()> {
        let folder = self.folder.join("images");
        std::fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        let e = &rendering.estimate;
        let metadata = Metadata {
            scene_hash: self.scene_cache.plain(slot.scene).0.hash_text(),
            samples_per_pixel: e.samples,
            render_time_seconds: rendering.wall_seconds as f32,
            seed: slot.seed,
            extra: Platform::of(self.scene_cache.plain(slot.scene).0.geometry().device()).attributes(),
        };
        let window = Window::full(e.width as usize, e.height as usize);
        exr::write(path, &window, vec![Layer::color("", &e.mean), Layer::color("variance", &e.variance)], &metadata)
    }
}

impl Executor for RenderExecutor<'_> {
    fn reference(&mut self, scene: usize, store: &mut Store) -> Result<bool> {
        let entry = &self.plan.scenes[scene];
        let name = entry.name();
        if store.reference(&name).is_some() {
            return Ok(true);
        }
        if let Some(path) = &entry.reference {
            return self.take(scene, path, store);
        }
        let place = &self.plan.references;
        let folder = self.folder.join(place);
        std::fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        let (loaded, description) = self.scene_cache.reference(scene);
        let file = reference::file_name(&file_stem(&name), loaded, description);
        self.make(scene, &place.join(file), store)
    }

    fn pace(&self, scene: usize, method: usize) -> Option<f64> {
        self.pace.get(&(scene, method)).copied()
    }

    fn prepare(&mut self, scene: usize, store: &mut Store) -> Result<bool> {
        let name = self.plan.scenes[scene].name();
        if self.plan.gallery.is_some() {
            self.look_at_gallery(scene, store)?;
        }
        if self.stop.is_asked() {
            return Ok(false);
        }
        let Some(known) = store.reference(&name) else {
            return Err(Error::Scene(format!("{name}: there is no reference to compare with")));
        };
        self.reference = Some(reference::read(&known.file(self.folder), self.scene_cache.plain(scene).0)?);
        Ok(true)
    }

    fn run(&mut self, slot: &Slot) -> Result<Option<Run>> {
        let (plan, scene_cache) = (self.plan, self.scene_cache);
        let (scene, description) = scene_cache.with_method(slot.scene, slot.method);
        let budget = plan.budgets[slot.budget];
        let (scene_name, budget_name) = (plan.scenes[slot.scene].name(), budget.name());
        let method = &plan.methods[slot.method].name;
        let mut settings = settings(description);
        settings.render.seed = slot.seed;
        self.limits.set((slot.scene, slot.method), scene, &mut settings, budget, plan.scenes[slot.scene].samples);
        let known = memory::reset_peak();
        let event = |progress| Event::Run { scene: &scene_name, method, budget: &budget_name, progress };
        let Some(rendering) = self.render(scene, &settings, event) else { return Ok(None) };
        let peak_bytes = known.then(memory::peak).flatten();
        let Some(reference) = &self.reference else {
            return Err(Error::Scene(format!("{scene_name}: there is no reference to compare with")));
        };
        let mut run = measured(&rendering, reference, description.scene.film.exposure)?;
        (run.scene, run.method, run.budget) = (scene_name, method.clone(), budget_name);
        (run.seed, run.peak_bytes) = (slot.seed, peak_bytes);
        if slot.budget == plan.budgets.len() - 1 {
            let path = picture_path(self.folder, plan, slot.scene, slot.method);
            // the last, where machines make them in any order
            if slot.run + 1 == plan.runs || !path.is_file() {
                self.write_picture(slot, &rendering, &path)?;
            }
            self.keep_worst(slot, &rendering, run.badness())?;
        }
        Ok(Some(run))
    }
}

/// Where the last picture of a method at the largest budget is kept.
pub(crate) fn picture_path(folder: &Path, plan: &Plan, scene: usize, method: usize) -> PathBuf {
    image_path(folder, plan, scene, method, "")
}

/// Where a gallery keeps the picture of a method's worst run.
pub(crate) fn worst_path(folder: &Path, plan: &Plan, scene: usize, method: usize) -> PathBuf {
    image_path(folder, plan, scene, method, "_worst")
}

fn image_path(folder: &Path, plan: &Plan, scene: usize, method: usize, end: &str) -> PathBuf {
    let (scene, method) = (plan.scenes[scene].name(), &plan.methods[method].name);
    folder.join("images").join(format!("{}_{}{end}.exr", file_stem(&scene), file_stem(method)))
}

/// Blocks of the references of all scenes that have one with its variance.
///
/// # Errors
/// A reference that can no longer be read.
pub(crate) fn reference_blocks(
    plan: &Plan,
    scene_cache: &SceneCache,
    store: &Store,
    folder: &Path,
) -> Result<BTreeMap<String, ReferenceBlocks>> {
    let mut all = BTreeMap::new();
    for (index, entry) in plan.scenes.iter().enumerate() {
        let Some(known) = store.reference(&entry.name()) else { continue };
        let reference = reference::read(&known.file(folder), scene_cache.plain(index).0)?;
        all.extend(reference.blocks().map(|blocks| (entry.name(), blocks)));
    }
    Ok(all)
}

fn picture(rendering: &Rendering) -> Image {
    let e = &rendering.estimate;
    Image { width: e.width as usize, height: e.height as usize, data: e.mean.clone() }
}

/// The figures of a render; which run it was is not among them.
fn measured(rendering: &Rendering, reference: &Reference, exposure: Exposure) -> Result<Run> {
    let image = picture(rendering);
    let total = rendering.total();
    Ok(Run {
        scene: String::new(),
        method: String::new(),
        budget: String::new(),
        seed: 0,
        samples: rendering.samples,
        wall_seconds: rendering.wall_seconds,
        cpu_seconds: rendering.cpu.seconds(),
        learn_wall_seconds: rendering.all_iterations().map(|i| i.learn_wall_seconds).sum(),
        film_wall_seconds: rendering.film_wall_seconds,
        errors: measure::errors(&image, reference, exposure.stops(&reference.image, Tone::Srgb))?,
        mean: measure::mean(&image),
        non_finite: total.non_finite,
        broken_pixels: image.data.iter().filter(|c| !c.is_finite()).count() as u64,
        negative_pixels: image.data.iter().filter(|c| c.min_element() < 0.0).count() as u64,
        rays: total.rays,
        shadow_rays: total.shadow_rays,
        paths: total.paths,
        mean_path_length: ratio(total.rays, total.paths),
        zero_share: ratio(total.zero_contribution, total.paths),
        guide_bytes: rendering.guide.as_ref().map_or(0, |g| g.bytes() as u64),
        guide_states: rendering.guide.as_ref().map_or(0, |g| g.states() as u64),
        peak_bytes: None,
        iterations: rendering.iterations.iter().map(iteration).collect(),
        blocks: blocks(&image),
    })
}

fn iteration(report: &IterationReport) -> Iteration {
    let c = &report.counters;
    Iteration {
        samples: report.samples,
        wall_seconds: report.wall_seconds,
        learn_wall_seconds: report.learn_wall_seconds,
        mean_path_length: ratio(c.rays, c.paths),
        zero_share: ratio(c.zero_contribution, c.paths),
        guide_hit_share: ratio(c.guide_hits, c.guide_queries),
    }
}

fn ratio(a: u64, b: u64) -> f64 {
    if b == 0 { 0.0 } else { a as f64 / b as f64 }
}
