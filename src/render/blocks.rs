//! One block of the picture after the other, each with all of its samples: the order of a renderer that knows nothing of
//! learning. With on-line updates the guide of the last block knows all, that of the first nothing.

use super::Observer;
use super::driver::Driver;
use super::schedule::{round_paths, rounds};
use crate::film::accumulate::FEATURE_SAMPLES;
use crate::integrator::probe::Watch;
use std::time::Instant;

impl<W: Watch> Driver<'_, W> {
    /// A single iteration over all blocks. The observer is asked between stretches of whole blocks; those that it does
    /// not want stay blank.
    pub(super) fn run_blocks(&mut self, observer: Observer) {
        let start = Instant::now();
        let (spp, length) = (self.settings.render.spp, round_paths(self.online()));
        let mut report = self.begin_iteration();
        let mut go_on = true;
        for stretch in self.tiling.blocks(spp, length) {
            if !go_on {
                stretch.iter().for_each(|task| self.film.leave_blank(&task.tile));
                continue;
            }
            for round in rounds(&stretch, length) {
                // Frozen until an end that has no next iteration, a guide would learn for nobody.
                self.round(&round, self.online(), &mut report);
            }
            self.samples = (self.paths / self.pixels()) as u32;
            go_on = observer(&self.progress());
        }
        self.take_in(&mut report);
        for first in (0..spp).step_by(self.tiling.samples as usize) {
            self.film.add_samples(self.tiling.samples.min(spp - first), first < FEATURE_SAMPLES);
        }
        self.film.end_iteration();
        if self.online() {
            self.learnt_paths = self.learnt_paths.max(report.counters.paths);
        }
        report.samples = spp;
        report.seconds = start.elapsed().as_secs_f64();
        self.iterations.push(report);
    }
}
