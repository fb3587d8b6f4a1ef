//! What the camera sees first, averaged over the first samples of each pixel.

use super::ids::{IdCounts, Ids, KINDS};
use super::surplus::Surplus;
use super::tile::{Aovs, Tile, TileSamples};
use rayon::prelude::*;

/// Sums over samples, pixel by pixel.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct FeatureSums {
    width: u32,
    sums: Vec<Aovs>,
    /// Empty until some samples say what they met.
    ids: Vec<[IdCounts; KINDS]>,
    /// Per pixel, those that all have, and what some have beyond.
    samples: u32,
    surplus: Surplus,
}

/// By pixel, how many samples met which object and which material, and of how many; empty where not asked for.
#[derive(Clone, Debug, Default)]
pub struct PictureIds {
    pub(crate) counts: Vec<[IdCounts; KINDS]>,
    pub(crate) samples: Vec<u32>,
}

impl FeatureSums {
    pub(super) fn new(width: u32, pixels: usize) -> FeatureSums {
        let sums = vec![Aovs::default(); pixels];
        FeatureSums { width, sums, ids: Vec::new(), samples: 0, surplus: Surplus::default() }
    }

    /// Adds what was sampled in a tile; to be counted by one of the next two.
    pub(super) fn add(&mut self, tile: &Tile, samples: &TileSamples) {
        for (k, &features) in (0..).zip(&samples.features) {
            let pixel = self.pixel(tile, k);
            self.sums[pixel] += features;
        }
        if !samples.ids.is_empty() {
            self.add_ids(tile, &samples.ids);
        }
    }

    fn add_ids(&mut self, tile: &Tile, ids: &[Ids]) {
        self.ids.resize(self.sums.len(), [IdCounts::NONE; KINDS]);
        let pixels = tile.pixels() as u32;
        for (k, met) in (0..).zip(ids) {
            let pixel = self.pixel(tile, k % pixels);
            self.ids[pixel].iter_mut().zip(met).for_each(|(counts, id)| counts.add(*id));
        }
    }

    /// Place of pixel `k` of a tile in the picture.
    fn pixel(&self, tile: &Tile, k: u32) -> usize {
        ((tile.y + k / tile.width) * self.width + tile.x + k % tile.width) as usize
    }

    /// Says that every pixel has received `samples` more.
    pub(super) fn add_samples(&mut self, samples: u32) {
        self.samples += samples;
    }

    /// Says the same of the pixels of a tile alone.
    pub(super) fn add_samples_in(&mut self, tile: &Tile, samples: u32) {
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            self.surplus.add(first..first + tile.width as usize, samples, self.sums.len());
        }
    }

    /// Takes back what the newest call of that said.
    pub(super) fn take_back_samples_in(&mut self, tile: &Tile, samples: u32) {
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            self.surplus.take_back(first..first + tile.width as usize, samples);
        }
    }

    /// Whether there are so many pixels.
    pub(super) fn fits(&self, width: u32, pixels: usize) -> bool {
        let ids = self.ids.is_empty() || self.ids.len() == pixels;
        self.width == width && self.sums.len() == pixels && self.surplus.fits(pixels) && ids
    }

    /// Adds what another film of this size has.
    pub(super) fn join(&mut self, other: FeatureSums) {
        self.sums.par_iter_mut().zip(other.sums).for_each(|(sum, more)| *sum += more);
        if self.ids.is_empty() {
            self.ids = other.ids;
        } else {
            let both = self.ids.iter_mut().zip(&other.ids);
            both.for_each(|(kinds, more)| kinds.iter_mut().zip(more).for_each(|(counts, more)| counts.join(more)));
        }
        self.samples += other.samples;
        self.surplus.add_all(&other.surplus);
    }

    /// Counts for all what all have.
    pub(super) fn level(&mut self) {
        self.samples += self.surplus.level();
    }

    /// Share of the rays that met something, pixel by pixel.
    pub(super) fn coverage(&self) -> Vec<f32> {
        (0..self.sums.len()).map(|i| self.sums[i].met / self.count(i) as f32).collect()
    }

    /// Samples of a pixel; 1 of one that has none.
    fn count(&self, i: usize) -> u32 {
        (self.samples + self.surplus.of(i)).max(1)
    }

    /// The means.
    pub(super) fn finish(self) -> (Vec<Aovs>, PictureIds) {
        let FeatureSums { mut sums, ids, samples, surplus, .. } = self;
        let count = |i: usize| (samples + surplus.of(i)).max(1);
        sums.par_iter_mut().enumerate().for_each(|(i, sum)| *sum = *sum * (1.0 / count(i) as f32));
        let samples = (0..ids.len()).map(count).collect();
        (sums, PictureIds { counts: ids, samples })
    }
}
