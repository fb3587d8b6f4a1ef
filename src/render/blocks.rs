//! One block of the picture after the other, each with all of its samples: the order of a renderer that knows nothing of
//! learning. With on-line updates the guide of the last block knows all, that of the first nothing.

use super::driver::Driver;
use super::schedule::{round_paths, rounds};
use super::{IterationReport, Observer};
use crate::film::accumulate::FEATURE_SAMPLES;
use crate::integrator::Task;
use crate::integrator::probe::Watch;
use std::time::Instant;

impl<W: Watch> Driver<'_, W> {
    /// A single iteration over all blocks. The observer is asked between stretches of whole blocks; those that it does
    /// not want stay blank. A stop may also cut a stretch.
    pub(super) fn run_blocks(&mut self, observer: Observer) {
        let start = Instant::now();
        let (spp, length) = (self.settings.render.spp, round_paths(self.online()));
        let mut report = self.begin_iteration();
        for stretch in self.tiling.blocks(spp, length) {
            self.stretch(&stretch, length, &mut report);
            if !observer(&self.progress()) || self.end.stop.is_asked() {
                break;
            }
        }
        self.take_in(&mut report);
        self.film.end_iteration();
        if self.online() {
            self.learnt_paths = self.learnt_paths.max(report.counters.paths);
        }
        report.seconds = start.elapsed().as_secs_f64();
        self.iterations.push(report);
    }

    fn stretch(&mut self, stretch: &[Task], length: usize, report: &mut IterationReport) {
        for round in rounds(stretch, length) {
            if self.end.is_due() {
                break;
            }
            // Frozen until an end that has no next iteration, a guide would learn for nobody.
            for task in self.round(&round, self.online(), report) {
                self.film.add_samples_in(&task.tile, task.samples, task.first_sample < FEATURE_SAMPLES);
            }
        }
        self.count_samples(report);
    }
}
