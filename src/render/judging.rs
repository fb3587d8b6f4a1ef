//! What iterations say of the guide, and what the driver makes of it.

use super::IterationReport;
use super::cost::Rendered;
use super::driver::{Driver, LONGEST};
use super::efficiency;
use super::noise::Noise;
use super::worth::Worth;
use crate::film::tile::Tile;
use crate::integrator::Roulette;
use crate::integrator::probe::Watch;

/// Samples per pixel from which the guide of `auto` learns first: as few as any other guide's.
const LESSON: u32 = 1;

impl<W: Watch> Driver<'_, W> {
    /// Samples per pixel of the iteration after one that planned so many. Once there is no guide, all of the rest is one.
    pub(super) fn next_length(&self, planned: u32) -> u32 {
        match &self.worth {
            Some(worth) if worth.measures() => worth.more_samples(self.samples).unwrap_or((2 * planned).min(LONGEST)),
            Some(worth) if !worth.pays() => LONGEST,
            Some(worth) if worth.unguided() => LESSON,
            _ => (2 * planned).min(LONGEST),
        }
    }

    /// Whether a guide is there, and in use.
    pub(super) fn guided(&self) -> bool {
        self.guide.is_some() && self.worth.as_ref().is_none_or(Worth::pays)
    }

    /// Whether it is being measured how samples vary without a guide.
    pub(super) fn measures(&self) -> bool {
        self.worth.as_ref().is_some_and(Worth::measures)
    }

    /// What the noise of an iteration says of roulette, and of the guide.
    pub(super) fn weigh(&mut self, report: &IterationReport) {
        let Some(noise) = Noise::of(&self.film) else { return };
        if self.settings.integrator.roulette == Roulette::Guided {
            // of samples that the guide did not learn from it knows nothing
            let learnt = self.samples.saturating_sub(self.worth.as_ref().map_or(0, Worth::unlearnt));
            self.efficiency = efficiency::efficiency(&noise, learnt, &report.counters).or(self.efficiency.take());
        }
        let pixels = self.pixels() as f64;
        let budget = self.worth.as_ref().map(|worth| self.budget(worth.cost() * pixels));
        let Some((worth, budget)) = self.worth.as_mut().zip(budget) else { return };
        let learning = report.learn_seconds * rayon::current_num_threads() as f64;
        let rendered = Rendered { samples: report.samples, counters: &report.counters, learning };
        if worth.measures() {
            worth.begin(&noise, budget);
            return;
        }
        // not of earlier iterations, with which the film may weigh a short one
        let Some(variances) = self.film.newest_variances() else { return };
        if worth.unguided() {
            worth.learnt(variances, self.samples, &rendered);
        } else {
            worth.judge(&noise, &variances, &rendered);
        }
    }

    /// Samples per pixel that the whole render holds, where one costs so much processor time. Not by the time that has
    /// passed: caches were cold.
    fn budget(&self, cost: f64) -> f64 {
        let spp = self.settings.render.spp as f64;
        let by_time = |limit: f64| limit * rayon::current_num_threads() as f64 / cost;
        self.settings.render.time.map_or(spp, |limit| by_time(limit).min(spp))
    }

    /// Adds what bounced light brought to a tile.
    pub(super) fn add_bounced(&mut self, tile: &Tile, sums: &[[f32; 2]]) {
        let Some(worth) = &mut self.worth else { return };
        for (k, &sum) in sums.iter().enumerate() {
            let (x, y) = (tile.x as usize + k % tile.width as usize, tile.y as usize + k / tile.width as usize);
            worth.add_bounced(y * self.scene.camera.width as usize + x, sum);
        }
    }
}

#[cfg(test)]
#[path = "judging_tests.rs"]
mod tests;
