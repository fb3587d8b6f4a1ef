//! Mitsuba 3 on the same work: its path tracer, in its scalar and its vectorised variant.
//!
//! The scene is written as files of Mitsuba's ([`Translation`]), or refused where Mitsuba has no counterpart of
//! something in it. One Python process for each variant loads it once, and renders whenever its turn comes.
//! `docs/performance.md` says what is not the same.

mod agreement;
mod process;
#[cfg(test)]
mod tests;

pub(crate) use agreement::Agreement;

use super::own::{OurFigures, Own};
use super::{median, settings};
use crate::film::accumulate::Estimate;
use crate::format::SceneFile;
use crate::format::mitsuba::export::Translation;
use crate::guiding::settings::GuidingMethod;
use crate::image::exr::{self, Metadata, Window, read_rgb};
use crate::image::{Image, Layer, ViewTransform, png};
use crate::scene::Scene;
use crate::stats::Median;
use crate::{Error, Result};
use agreement::{Mean, agreement};
use process::{Process, Started, Timing};
use serde::Serialize;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The variants that are measured.
pub(crate) const VARIANTS: [&str; 2] = ["scalar_rgb", "llvm_ad_rgb"];

/// What all do.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct MitsubaPlan {
    /// Samples per pixel of each render.
    pub(crate) spp: u32,
    pub(crate) threads: usize,
}

/// A variant that cannot run here, and why.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Missing {
    pub(crate) variant: &'static str,
    pub(crate) reason: String,
}

/// All renderers' figures.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MitsubaReport {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) triangles: usize,
    pub(crate) max_depth: u32,
    pub(crate) plan: MitsubaPlan,
    pub(crate) phototaxis: OurFigures,
    pub(crate) mitsuba: Vec<MitsubaFigures>,
    pub(crate) missing: Vec<Missing>,
}

/// Of one variant. Rates are of all threads together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MitsubaFigures {
    pub(crate) variant: &'static str,
    pub(crate) version: String,
    pub(crate) msamples_per_second: Median,
    pub(crate) msamples_per_cpu_second: Option<Median>,
    /// Phototaxis' figures over these, turn by turn.
    pub(crate) ratio: Median,
    pub(crate) cpu_ratio: Option<Median>,
    pub(crate) agreement: Agreement,
}

/// All renderers, each with the scene loaded.
pub(crate) struct Mitsuba {
    plan: MitsubaPlan,
    translation: Translation,
    scene: Scene,
    processes: Vec<Process>,
    missing: Vec<Missing>,
    warnings: Vec<String>,
    folder: PathBuf,
    /// Deletes the folder where it is not to be kept.
    temporary: Option<TempDir>,
}

impl Mitsuba {
    /// Writes the scene, into `keep` if it is named, and starts the interpreter `python` for each variant.
    ///
    /// # Errors
    /// [`Error::Scene`] names what Mitsuba has no counterpart of; and where a process fails to load the scene.
    pub(crate) fn start(
        description: &SceneFile,
        plan: MitsubaPlan,
        python: &Path,
        keep: Option<&Path>,
    ) -> Result<Mitsuba> {
        let temporary = match keep {
            None => Some(TempDir::with_prefix("phototaxis-bench-").map_err(Error::io(std::env::temp_dir()))?),
            Some(folder) => std::fs::create_dir_all(folder).map(|()| None).map_err(Error::io(folder))?,
        };
        let folder = temporary.as_ref().map_or_else(|| keep.unwrap_or(Path::new(".")), TempDir::path).to_owned();
        let translation = Translation::write(description, plan.spp, &folder)?;
        let (scene, warnings) =
            Scene::load(&translation.description.scene, plan.threads, translation.description.render.build)?;
        let (mut processes, mut missing) = (Vec::new(), Vec::new());
        for variant in VARIANTS {
            match Process::start(python, variant, &translation.file, plan.threads)? {
                Started::Ready(process) => processes.push(process),
                Started::Missing(reason) => missing.push(Missing { variant, reason }),
            }
        }
        Ok(Mitsuba { plan, translation, scene, processes, missing, warnings, folder, temporary })
    }

    /// The variants that will not be measured.
    pub(crate) fn missing(&self) -> &[Missing] {
        &self.missing
    }

    /// What loading the scene has to say.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Measures all in turns, after one that does not count: Mitsuba compiles its kernels in it.
    ///
    /// # Errors
    /// A process that fails, and pictures that are not the same but for noise.
    pub(crate) fn measure(mut self, turns: usize) -> Result<MitsubaReport> {
        let (width, height) = (self.scene.camera.width as usize, self.scene.camera.height as usize);
        let mut taken = Vec::new();
        let mut pictures = vec![Mean::new(width, height); 1 + self.processes.len()];
        for turn in 0..=turns {
            let Turn { own, estimate, theirs } = self.turn(turn as u64)?;
            if turn == 0 {
                continue;
            }
            pictures[0].add_estimate(&estimate);
            for (mean, (_, picture)) in pictures[1..].iter_mut().zip(&theirs) {
                mean.add(&picture.data);
            }
            taken.push((own, theirs.into_iter().map(|(timing, _)| timing).collect::<Vec<Timing>>()));
        }
        self.keep_pictures(&pictures)?;
        self.report(&taken, &pictures)
    }

    /// Each renders once.
    fn turn(&mut self, turn: u64) -> Result<Turn> {
        let mut settings = settings(&self.translation.description, GuidingMethod::None);
        settings.render.seed = settings.render.seed.wrapping_add(turn);
        let (own, estimate) = Own::render(&self.scene, &settings)?;
        let mut theirs = Vec::new();
        for process in &mut self.processes {
            let path = self.folder.join(format!("{}.exr", process.variant));
            // Mitsuba's seeds have 32 bits
            let timing = process.render(self.plan.spp, settings.render.seed as u32, &path)?;
            theirs.push((timing, picture(&path, estimate.width as usize, estimate.height as usize)?));
        }
        Ok(Turn { own, estimate, theirs })
    }

    fn keep_pictures(&self, pictures: &[Mean]) -> Result<()> {
        if self.temporary.is_some() {
            return Ok(());
        }
        let names = std::iter::once("phototaxis").chain(self.processes.iter().map(|process| process.variant));
        for (name, Mean { image, .. }) in names.zip(pictures) {
            let path = self.folder.join(name);
            let film = &self.translation.description.scene.film;
            let view = ViewTransform::of(film.exposure, film.tone, image);
            png::write(&path.with_extension("png"), image, &view, &[])?;
            let (window, layer) = (Window::full(image.width, image.height), Layer::color("", &image.data));
            exr::write(&path.with_extension("exr"), &window, vec![layer], &Metadata::default())?;
        }
        Ok(())
    }

    fn report(&self, taken: &[(Own, Vec<Timing>)], pictures: &[Mean]) -> Result<MitsubaReport> {
        let figures = |(k, process): (usize, &Process)| {
            let agreement = agreement(&pictures[0], &pictures[k + 1].image)?;
            if agreement.worst > 1.0 {
                return Err(differ(process.variant, &agreement));
            }
            figures(process, agreement, taken.iter().map(|(own, others)| (own, &others[k])))
        };
        Ok(MitsubaReport {
            width: self.scene.camera.width,
            height: self.scene.camera.height,
            triangles: self.scene.triangles(),
            max_depth: self.translation.description.integrator.max_depth,
            plan: self.plan,
            phototaxis: OurFigures::of(taken.iter().map(|(own, _)| own))?,
            mitsuba: self.processes.iter().enumerate().map(figures).collect::<Result<_>>()?,
            missing: self.missing.clone(),
        })
    }
}

/// Phototaxis' render, and each process'.
struct Turn {
    own: Own,
    estimate: Estimate,
    theirs: Vec<(Timing, Image)>,
}

/// A picture that must have this size.
fn picture(path: &Path, width: usize, height: usize) -> Result<Image> {
    let picture = read_rgb(path)?;
    if (picture.width, picture.height) == (width, height) {
        return Ok(picture);
    }
    let message = format!("{} × {} pixels, not {width} × {height}", picture.width, picture.height);
    Err(Error::file(path, message))
}

fn differ(variant: &str, agreement: &Agreement) -> Error {
    Error::Scene(format!(
        "Mitsuba's {variant} renders another picture: Phototaxis' is {:.3} ± {:.3} times as bright, and a part of it \
         differs by {:.1} times what is tolerated (--keep shows both)",
        agreement.brightness, agreement.noise, agreement.worst
    ))
}

fn figures<'a>(
    process: &Process,
    agreement: Agreement,
    taken: impl Iterator<Item = (&'a Own, &'a Timing)> + Clone,
) -> Result<MitsubaFigures> {
    let of = |figure: fn(&Own, &Timing) -> f64| taken.clone().map(|(o, t)| figure(o, t)).collect::<Vec<f64>>();
    Ok(MitsubaFigures {
        variant: process.variant,
        version: process.version.clone(),
        msamples_per_second: median(&of(|o, t| o.samples * 1e-6 / t.seconds))?,
        msamples_per_cpu_second: Median::of(&of(|o, t| o.samples * 1e-6 / t.cpu_seconds)),
        ratio: median(&of(|o, t| t.seconds / o.seconds))?,
        cpu_ratio: Median::of(&of(|o, t| t.cpu_seconds / o.cpu_seconds)),
        agreement,
    })
}
