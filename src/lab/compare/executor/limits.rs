//! Where a run ends, and what a gallery looks at beside its runs.

use super::{RenderExecutor, worst_path};
use crate::film::accumulate::Estimate;
use crate::lab::compare::plan::Budget;
use crate::lab::compare::scene_cache::settings;
use crate::lab::compare::schedule::Slot;
use crate::lab::compare::store::Store;
use crate::render::{self, GuideIo, Order, Rendering, Settings};
use crate::scene::Scene;
use crate::{Error, Result};
use rustc_hash::FxHashMap;

/// Samples per pixel by which the speed of a render that takes no limit of time is found.
const TRIED: u32 = 8;

/// Seed of the renders that are repeated, far from those of all others.
const REPEATED_SEED: u64 = 3 << 60;

/// Wall seconds for a sample per pixel of what takes no limit of time, by scene and method.
#[derive(Default)]
pub(crate) struct Limits {
    pace: FxHashMap<(usize, usize), f64>,
}

impl Limits {
    /// Sets the end of a run: the budget, and no more than `cap` samples per pixel. A render block by block has all samples
    /// of a block before the next: instead of the time it is given as many as a short trial says the time is worth.
    pub(crate) fn set(
        &mut self,
        (at, method): (usize, usize),
        scene: &Scene,
        settings: &mut Settings,
        budget: Budget,
        cap: Option<u32>,
    ) {
        let (spp, time) = match budget {
            Budget::Samples(spp) => (spp, None),
            Budget::Seconds(seconds) if settings.render.order == Order::Blocks => {
                let pace = *self.pace.entry((at, method)).or_insert_with(|| pace(scene, settings));
                ((seconds / pace).round().clamp(1.0, f64::from(i32::MAX)) as u32, None)
            }
            Budget::Seconds(seconds) => (i32::MAX as u32, Some(seconds)),
        };
        (settings.render.spp, settings.render.time) = (cap.map_or(spp, |cap| spp.min(cap)), time);
    }
}

fn pace(scene: &Scene, settings: &Settings) -> f64 {
    let mut settings = settings.clone();
    (settings.render.spp, settings.render.time) = (TRIED, None);
    render::render(scene, &settings, &mut |_| true).wall_seconds / f64::from(TRIED)
}

impl RenderExecutor<'_> {
    /// Whether each method gives the same picture twice, once by all threads and once by one; and which runs of the scene
    /// were the worst so far.
    pub(super) fn look_at_gallery(&mut self, scene: usize, store: &mut Store) -> Result<()> {
        let (plan, name) = (self.plan, self.plan.scenes[scene].name());
        let (Some(gallery), Some(budget)) = (&plan.gallery, plan.budgets.last()) else { return Ok(()) };
        let spp = gallery.bounds.repeat;
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let one_thread = one_thread.map_err(|e| Error::Scene(format!("a thread could not be started: {e}")))?;
        self.worst.clear();
        for (index, method) in plan.methods.iter().enumerate() {
            self.worst.push(store.worst(&name, &method.name, &budget.name()));
            if store.repeatable(&name, &method.name, spp).is_none() {
                let (loaded, description) = self.scene_cache.with_method(scene, index);
                let mut settings = settings(description);
                let render = &mut settings.render;
                (render.seed, render.spp, render.time) = (REPEATED_SEED, spp, None);
                let render =
                    || render::render_until(loaded, &settings, GuideIo::default(), self.stop, &mut |_| true).estimate;
                let equal = same(&render(), &one_thread.install(render));
                if self.stop.is_asked() {
                    return Ok(());
                }
                store.add_repeat(&name, &method.name, spp, equal)?;
            }
        }
        Ok(())
    }

    /// Keeps the picture of a run for a gallery, where none before it was worse.
    pub(super) fn keep_worst(&mut self, slot: &Slot, rendering: &Rendering, badness: f64) -> Result<()> {
        let Some(worst) = self.worst.get_mut(slot.method) else { return Ok(()) };
        if worst.is_some_and(|worst| badness < worst) {
            return Ok(());
        }
        *worst = Some(badness);
        self.write_picture(slot, rendering, &worst_path(self.folder, self.plan, slot.scene, slot.method))
    }
}

/// Whether pictures and their variances are the same, bit for bit.
fn same(a: &Estimate, b: &Estimate) -> bool {
    let bits = |e: &Estimate| -> Vec<u32> {
        e.mean.iter().chain(&e.variance).flat_map(|c| c.to_array()).map(f32::to_bits).collect()
    };
    bits(a) == bits(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format;
    use std::path::Path;

    fn cornell(more: &[&str]) -> (Scene, Settings) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
        let set: Vec<String> = ["film.width=32", "film.height=32"].iter().chain(more).map(|s| s.to_string()).collect();
        let description = format::load(&path, &set).unwrap().0;
        (description.load_scene(1).unwrap().0, settings(&description))
    }

    #[test]
    fn a_cap_holds_whatever_the_budget() {
        let (scene, mut settings) = cornell(&[]);
        let mut limits = Limits::default();
        limits.set((0, 0), &scene, &mut settings, Budget::Seconds(2.0), Some(3));
        assert_eq!((settings.render.spp, settings.render.time), (3, Some(2.0)));
        limits.set((0, 0), &scene, &mut settings, Budget::Samples(2), Some(3));
        assert_eq!((settings.render.spp, settings.render.time), (2, None));
    }

    #[test]
    fn blocks_get_samples_in_the_place_of_time_and_more_for_more() {
        let (scene, mut settings) = cornell(&["render.order=blocks", "guiding.method=none"]);
        let mut limits = Limits::default();
        let mut samples = |seconds| {
            limits.set((0, 0), &scene, &mut settings, Budget::Seconds(seconds), None);
            assert_eq!(settings.render.time, None);
            f64::from(settings.render.spp)
        };
        let few = samples(10.0);
        assert!((samples(40.0) / few - 4.0).abs() < 0.1, "the pace is found once");
    }

    #[test]
    fn equal_means_every_bit_of_picture_and_variance() {
        let (scene, mut settings) = cornell(&[]);
        settings.render.spp = 2;
        let estimate = render::render(&scene, &settings, &mut |_| true).estimate;
        assert!(same(&estimate, &estimate.clone()));
        let mut other = estimate.clone();
        other.variance[5].y = f32::from_bits(other.variance[5].y.to_bits() ^ 1);
        assert!(!same(&estimate, &other));
    }
}
