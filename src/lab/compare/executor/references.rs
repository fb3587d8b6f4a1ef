//! How good a reference must be, and seeing that it is.

use super::{Event, RenderExecutor, picture};
use crate::integrator::SamplerKind;
use crate::lab::compare::likeness::unlike;
use crate::lab::compare::measure;
use crate::lab::compare::plan::Budget;
use crate::lab::compare::reference::{self, Growing, Growth, SEEDS};
use crate::lab::compare::scene_cache::settings;
use crate::lab::compare::store::Store;
use crate::render::{Progress, Rendering};
use crate::{Error, Result};
use std::path::Path;

/// Seeds of pilot runs, far from those of all others.
const PILOT_SEEDS: u64 = 1 << 61;

/// Share of the largest budget that a pilot run takes, and its samples per pixel at least: fewer say little of the noise.
const PILOT_SHARE: f64 = 0.125;
const PILOT_SAMPLES: u32 = 8;

/// How many times the time that a reference may take it must seem to need, to be refused before that time is over.
const PATIENCE: f64 = 2.0;

/// Even samples have less noise than they tell one by one. By this factor less was measured with 64 samples per pixel.
const EVEN: f64 = 0.5;

/// A guide has learnt more at the end of the budget than in a pilot run: errors may fall this much below what
/// that promises.
const LEARNT: f64 = 0.5;

impl RenderExecutor<'_> {
    /// Makes a scene's reference, or makes the one that is there better; `false` where it was told to stop. `file` is its
    /// place, within the folder of the comparison where it is relative.
    pub(super) fn make(&mut self, scene: usize, file: &Path, store: &mut Store) -> Result<bool> {
        let Some(smallest) = self.smallest_error(scene) else { return Ok(false) };
        let (name, wanted) = (self.plan.scenes[scene].name(), self.plan.reference_noise * smallest);
        let (loaded, description) = self.scene_cache.reference(scene);
        let path = self.folder.join(file);
        let found = Growing::find(&path, loaded)?;
        let mut observer =
            |progress: &Progress| (self.listener)(Event::Reference { scene: &name, wanted, progress: *progress });
        let time = self.plan.reference_time;
        let patience = (!self.allow_noisy).then_some(PATIENCE * time);
        let growth = Growth { wanted, time, patience, stop: self.stop, observer: &mut observer };
        let Some(grown) = Growing::grow(found, loaded, description, growth) else { return Ok(false) };
        grown.write(&path, loaded, SEEDS)?;
        if self.stop.is_asked() {
            return Ok(false);
        }
        if grown.noise() > wanted && !self.allow_noisy {
            return Err(self.too_noisy(&name, grown.noise(), wanted, Some(grown.seconds_for(wanted))));
        }
        store.add_reference(&name, &grown.record(file))?;
        Ok(true)
    }

    /// Takes a file as reference; `false` where it was told to stop.
    pub(super) fn take(&mut self, scene: usize, path: &Path, store: &mut Store) -> Result<bool> {
        let reference = reference::read(path, self.scene_cache.plain(scene).0)?;
        let name = self.plan.scenes[scene].name();
        let Some((_, pilot)) = self.pilot(scene, self.plan.baseline) else { return Ok(false) };
        if let Some(why) = unlike(&reference.image, &picture(&pilot), &pilot.estimate.variance) {
            return Err(Error::file(path, format!("this is no reference of {name}: {why}")));
        }
        if let Some(noise) = reference.noise().filter(|_| !self.allow_noisy) {
            let Some(smallest) = self.smallest_error(scene) else { return Ok(false) };
            let wanted = self.plan.reference_noise * smallest;
            if noise > wanted {
                return Err(self.too_noisy(&name, noise, wanted, None));
            }
        }
        store.add_reference(&name, &reference::record_of_file(path, &reference))?;
        Ok(true)
    }

    fn too_noisy(&self, name: &str, noise: f64, wanted: f64, seconds: Option<f64>) -> Error {
        let share = self.plan.reference_noise;
        let more = seconds.map_or(String::new(), |s| format!(" --reference-time {:.0} or so,", s.ceil()));
        Error::Scene(format!(
            "{name}: the reference has a relMSE of {noise:.2e} of its own, and {share} of the smallest error that is \
             expected are {wanted:.2e}: ask for{more} a larger --reference-noise or --allow-noisy-reference"
        ))
    }

    /// The smallest relMSE to be expected at the largest budget, by short runs of all methods and the variance of their
    /// own samples; `None` where it was told to stop. A method whose few samples were all alike says nothing; 0 if all do.
    fn smallest_error(&mut self, scene: usize) -> Option<f64> {
        let mut smallest = f64::INFINITY;
        for method in 0..self.plan.methods.len() {
            let (error, _) = self.pilot(scene, method)?;
            smallest = if error > 0.0 { smallest.min(error) } else { smallest };
        }
        Some(if smallest.is_finite() { smallest } else { 0.0 })
    }

    /// What a short run promises for the largest budget, and the run.
    fn pilot(&mut self, scene: usize, method: usize) -> Option<(f64, Rendering)> {
        let (plan, scene_cache) = (self.plan, self.scene_cache);
        let (loaded, description) = scene_cache.with_method(scene, method);
        let largest = plan.budgets[plan.budgets.len() - 1];
        let (name, of) = (plan.scenes[scene].name(), &plan.methods[method].name);
        let event = |progress| Event::Pilot { scene: &name, method: of, progress };
        let mut settings = settings(description);
        settings.render.seed = PILOT_SEEDS + method as u64;
        let short = match largest {
            Budget::Seconds(seconds) => Budget::Seconds(seconds * PILOT_SHARE),
            Budget::Samples(spp) => Budget::Samples(((f64::from(spp) * PILOT_SHARE) as u32).max(PILOT_SAMPLES)),
        };
        let cap = plan.scenes[scene].samples;
        self.limits.set((scene, method), loaded, &mut settings, short, cap);
        let mut rendering = self.render(loaded, &settings, event)?;
        if rendering.samples < PILOT_SAMPLES {
            self.limits.set((scene, method), loaded, &mut settings, Budget::Samples(PILOT_SAMPLES), None);
            rendering = self.render(loaded, &settings, event)?;
        }
        self.pace.insert((scene, method), rendering.wall_seconds / f64::from(rendering.samples.max(1)));
        let share = match (cap, largest) {
            (Some(cap), _) => f64::from(rendering.samples) / f64::from(cap),
            (None, Budget::Seconds(seconds)) => rendering.wall_seconds / seconds,
            (None, Budget::Samples(spp)) => f64::from(rendering.samples) / f64::from(spp),
        };
        let learnt = if rendering.guide.is_some() { LEARNT } else { 1.0 };
        let even = if settings.render.sampler == SamplerKind::Independent { 1.0 } else { EVEN };
        let noise = measure::relative_noise(&picture(&rendering), &rendering.estimate.variance);
        Some((even * learnt * share * noise, rendering))
    }
}
