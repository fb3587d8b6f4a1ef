//! What a batch brings back: its pixels, and what is to be learnt from it.

use super::{Probe, Stage, Wavefront};
use crate::film::tile::{Aovs, TileSamples};
use crate::guiding::Recorder;
use crate::integrator::backward_pass::{self, WaveRecord};
use crate::integrator::batch::BatchResult;
use crate::io::clock::CpuClock;
use crate::math::{Rgb, luminance};

impl<P: Probe> Wavefront<'_, '_, P> {
    /// Keeps for learning what the vertex of ray `i` sends along it by itself.
    #[inline]
    pub(super) fn keep_local(&mut self, i: usize, depth: u32, local: Rgb) {
        if self.learn {
            self.batch.vertices[depth as usize - 1].local[i] = local;
        }
    }

    pub(super) fn record(&mut self) -> Option<Recorder> {
        if !self.learn {
            return None;
        }
        self.probe.stage(Stage::Record);
        let clock = CpuClock::thread();
        let mut recorder = std::mem::take(&mut self.batch.recorder);
        let b = &mut *self.batch;
        backward_pass::record(&mut b.vertices, &mut b.followed, &mut recorder);
        b.points.drain(..).for_each(|(p, n)| recorder.push_point(p, n));
        b.vertices.iter_mut().for_each(WaveRecord::clear);
        self.counters.recording_cpu = clock.elapsed();
        Some(recorder)
    }

    /// Sums over the samples of each pixel. A sample that is not finite is counted and left out as black.
    pub(super) fn gather(mut self) -> BatchResult {
        self.probe.stage(Stage::Film);
        let (tile, pixels) = (self.task.tile, self.task.tile.pixels());
        let first = self.task.first_sample;
        let mut samples = TileSamples {
            numbers: first..first + self.task.samples,
            ids: std::mem::take(&mut self.batch.ids),
            sum: vec![Rgb::ZERO; pixels],
            sum_squares: vec![Rgb::ZERO; pixels],
            layers: Vec::new(),
            features: vec![Aovs::default(); if self.integrator.features { pixels } else { 0 }],
        };
        for (slot, radiance) in self.batch.radiance.all().enumerate() {
            let pixel = slot % pixels;
            if !radiance.is_finite() {
                self.counters.non_finite += 1;
                let (x, y) = (tile.x + pixel as u32 % tile.width, tile.y + pixel as u32 / tile.width);
                let sample = self.task.first_sample + (slot / pixels) as u32;
                self.counters.first_non_finite.get_or_insert((x, y, sample));
                continue;
            }
            self.counters.zero_contribution += !self.batch.radiance.is_lit(slot) as u64;
            samples.sum[pixel] += radiance;
            samples.sum_squares[pixel] += radiance * radiance;
        }
        for (slot, &features) in self.batch.features.iter().enumerate() {
            samples.features[slot % pixels] += features;
        }
        self.batch.radiance.gather_layers(self.integrator.layers.len(), &mut samples);
        let bounced = self.gather_bounced(pixels);
        BatchResult { samples, bounced, recorder: None, counters: self.counters }
    }

    /// Sums of the light that bounced, and of its squares, pixel by pixel. What is not finite is black here too.
    fn gather_bounced(&self, pixels: usize) -> Vec<[f32; 2]> {
        let radiance = &self.batch.radiance;
        let Some(direct) = self.integrator.unbounced().and_then(|layer| radiance.layer(layer)) else {
            return Vec::new();
        };
        let mut sums = vec![[0.0; 2]; pixels];
        for (slot, (all, direct)) in radiance.all().zip(direct).enumerate().filter(|(_, (all, _))| all.is_finite()) {
            let bounced = luminance(all - *direct);
            sums[slot % pixels][0] += bounced;
            sums[slot % pixels][1] += bounced * bounced;
        }
        sums
    }
}
