//! The film: sums of samples, iteration by iteration, and how iterations become one picture.

use super::allotted::Allotted;
use super::features::FeatureSums;
pub use super::features::PictureIds;
use super::group::IterationGroup;
use super::halves::Halves;
use super::picture::Picture;
use super::tile::{Aovs, Tile, TileSamples};
use crate::film::{Combine, RadianceLayer};
use crate::math::Rgb;

/// Samples for which albedo, normal and depth are averaged; they have little noise.
pub(crate) const FEATURE_SAMPLES: u32 = 32;

/// Iterations are weighed in groups of at least this many samples per pixel: the variance of fewer says little.
pub(super) const MIN_GROUP: u32 = 4;

/// Bytes that a render holds for each pixel, and that writing its pictures takes: the test
/// `a_render_takes_the_memory_that_is_said` measures them again.
pub const BYTES_PER_PIXEL: u64 = 336;

/// As many more for each radiance layer: sums in double precision thrice (of the group, and before it), and the mean twice.
pub(crate) const BYTES_PER_LAYER: u64 = 96;

/// Accumulates what tiles bring back. Memory is constant in the number of samples.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Film {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) combine: Combine,
    /// Whether samples are spread evenly, so that halves of them tell how their means vary.
    halved: bool,
    /// Whether it is to tell the error of its picture. Where all samples count alike that takes the halves of all.
    pub(super) tells_error: bool,
    pub(super) halves: Halves,
    /// Those of the groups and of the picture.
    pub(super) layers: Vec<RadianceLayer>,
    pub(super) group: IterationGroup,
    /// State of the group at the start of the current iteration, if the group spans several iterations.
    pub(super) before: Option<IterationGroup>,
    /// The previous group. Its weight is computed once the next group exists, against whose picture its noise is measured.
    pub(super) pending: Option<IterationGroup>,
    /// Of the groups before these.
    pub(super) picture: Picture,
    /// What tiles get, where they get different numbers of samples; then the picture is of what is kept of the groups before.
    pub(super) allotted: Option<Allotted>,
    pub(super) features: FeatureSums,
}

/// A picture with what is known of its noise.
#[derive(Clone, Debug)]
pub struct Estimate {
    pub width: u32,
    pub height: u32,
    pub mean: Vec<Rgb>,
    /// Variance of `mean`, estimated from the samples; zero where there were fewer than two.
    pub variance: Vec<Rgb>,
    /// Samples per pixel that the picture holds; where pixels differ, on average, rounded down.
    pub samples: u32,
    /// The same pixel by pixel, where they differ because rendering ended in the middle of a pass; else empty. A pixel
    /// without any is black.
    pub counts: Vec<u32>,
    /// Means of the light in each radiance layer, in the order in which they were asked for.
    pub layers: Vec<(RadianceLayer, Vec<Rgb>)>,
    /// Means of what the camera sees first.
    pub features: Vec<Aovs>,
    /// Which objects and materials the same samples met.
    pub ids: PictureIds,
}

impl Estimate {
    /// Samples of a pixel.
    pub fn count(&self, pixel: usize) -> u32 {
        self.counts.get(pixel).copied().unwrap_or(self.samples)
    }

    /// The fewest samples of a pixel, the most, and how many pixels have none.
    pub fn spread(&self) -> (u32, u32, usize) {
        let all = || (0..self.mean.len()).map(|i| self.count(i));
        (all().min().unwrap_or(0), all().max().unwrap_or(0), all().filter(|&n| n == 0).count())
    }
}

impl Film {
    /// A film with these radiance layers, which `TileSamples` bring in the same order.
    pub(crate) fn new(width: u32, height: u32, combine: Combine, layers: &[RadianceLayer]) -> Film {
        let pixels = width as usize * height as usize;
        Film {
            width,
            height,
            combine,
            halved: false,
            tells_error: false,
            halves: Halves::default(),
            layers: layers.to_vec(),
            group: IterationGroup::new(pixels, layers.len()),
            before: None,
            pending: None,
            picture: Picture::new(pixels, layers.len()),
            allotted: None,
            features: FeatureSums::new(width, pixels),
        }
    }

    /// The same film, for samples that are spread evenly if `even`.
    pub(crate) fn of_even_samples(mut self, even: bool) -> Film {
        self.halved = even;
        self.group = self.empty_group();
        self
    }

    /// The same film, which [tells](Self::relative_error) the error of its picture if `tells`.
    pub(crate) fn that_tells_its_error(mut self, tells: bool) -> Film {
        let alike = self.combine == Combine::All;
        self.tells_error = tells;
        self.halves = if tells && alike && self.halved { Halves::new(self.pixels()) } else { Halves::default() };
        self.picture = self.picture.that_tells_its_error(tells && !alike);
        self
    }

    /// Adds what was sampled in a tile. Call `add_samples` once all pixels have theirs, or `add_samples_in` for the tile.
    pub(crate) fn add(&mut self, tile: &Tile, samples: &TileSamples) {
        self.features.add(tile, samples);
        let (sum, before) = (&self.group.sum, &self.picture);
        let all = |i: usize| before.mean[i].as_dvec3() * f64::from(before.count(i)) + sum[i];
        self.halves.keep((tile, self.width), all, samples.numbers.clone(), 0);
        let (group, before) = (&mut self.group, self.before.as_ref().map_or(0, |before| before.samples));
        let begin = self.allotted.as_ref().map_or(group.first + before, |allotted| allotted.first(tile));
        let numbers = samples.numbers.start.saturating_sub(begin)..samples.numbers.end.saturating_sub(begin);
        let sum = &group.sum;
        group.halves.keep((tile, self.width), |i| sum[i], numbers, before);
        for y in 0..tile.height {
            let from = (y * tile.width) as usize..((y + 1) * tile.width) as usize;
            let to = ((tile.y + y) * self.width + tile.x) as usize;
            for (k, i) in from.enumerate() {
                self.group.sum[to + k] += samples.sum[i].as_dvec3();
                self.group.sum_squares[to + k] += samples.sum_squares[i];
                for (layer, sums) in self.group.layers.iter_mut().zip(&samples.layers) {
                    layer[to + k] += sums[i].as_dvec3();
                }
            }
        }
    }

    /// Says that every pixel has received `samples` more, with their features or without.
    pub(crate) fn add_samples(&mut self, samples: u32, features: bool) {
        self.group.samples += samples;
        if features {
            self.features.add_samples(samples);
        }
    }

    /// Says the same of the pixels of a tile alone.
    pub(crate) fn add_samples_in(&mut self, tile: &Tile, samples: u32, features: bool) {
        let pixels = self.pixels();
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            let row = first..first + tile.width as usize;
            self.group.surplus.add(row, samples, pixels);
        }
        if features {
            self.features.add_samples_in(tile, samples);
        }
    }

    /// Takes back what `add_samples_in` said of a tile, whose samples stay: they are to be counted with those of all others.
    pub(crate) fn take_back_samples_in(&mut self, tile: &Tile, samples: u32, features: bool) {
        for y in tile.y..tile.y + tile.height {
            let first = (y * self.width + tile.x) as usize;
            self.group.surplus.take_back(first..first + tile.width as usize, samples);
        }
        if features {
            self.features.take_back_samples_in(tile, samples);
        }
    }

    /// Counts for all pixels what all have.
    pub(crate) fn level(&mut self) {
        self.group.samples += self.group.surplus.level();
        self.features.level();
    }

    /// Whether it is a film of this size with these layers.
    pub(crate) fn fits(&self, width: u32, height: u32, layers: &[RadianceLayer]) -> bool {
        let pixels = width as usize * height as usize;
        let mut groups = [Some(&self.group), self.before.as_ref(), self.pending.as_ref()].into_iter().flatten();
        (self.width, self.height, &self.layers[..]) == (width, height, layers)
            && groups.all(|group| group.fits(pixels, layers.len()))
            && self.picture.fits(pixels, layers.len())
            && self.halves.fits(pixels)
            && self.allotted.as_ref().is_none_or(|allotted| allotted.fits([width, height], layers.len()))
            && self.features.fits(width, pixels)
    }

    /// Ends an iteration: its samples are weighed into the picture once there are enough of them.
    pub(crate) fn end_iteration(&mut self) {
        self.level();
        if self.allotted.is_some() {
            self.end_allotted();
        } else if self.group.samples >= MIN_GROUP {
            self.close_group();
            self.before = None;
        } else {
            self.before = Some(self.group.clone());
        }
    }

    /// As [`Self::sample_variances`], of the newest iteration alone.
    pub(crate) fn newest_variances(&self) -> Option<Vec<f64>> {
        let Some(before) = &self.before else { return self.sample_variances() };
        self.group.since(before).sample_variances(self.width as usize)
    }

    /// As [`Self::sample_spreads`], of the newest iteration alone.
    pub(crate) fn newest_spreads(&self) -> Option<Vec<f64>> {
        let Some(before) = &self.before else { return self.sample_spreads() };
        self.group.since(before).sample_spreads()
    }

    /// Variance of the luminance of the current group's mean times its samples, pixel by pixel; `None` where there are fewer
    /// than two. Where samples are independent it is the variance of one.
    pub(crate) fn sample_variances(&self) -> Option<Vec<f64>> {
        self.group.sample_variances(self.width as usize)
    }

    /// Variance of the luminance of one sample of the current group, however its samples are spread.
    pub(crate) fn sample_spreads(&self) -> Option<Vec<f64>> {
        self.group.sample_spreads()
    }

    /// Adds to the group before it a rest that is too small to be weighed by its own variance. Such a rest is left where
    /// rendering ends before it was planned to; without this the picture would not hold it.
    pub(crate) fn join_rest(&mut self) {
        if self.group.samples >= MIN_GROUP || self.group.is_empty() || self.allotted.is_some() {
            return;
        }
        if let Some(before) = self.pending.take() {
            let new = self.empty_group();
            let rest = std::mem::replace(&mut self.group, new);
            self.pending = Some(before.joined(&rest));
        }
    }

    /// The picture with all that is known of it.
    pub(crate) fn finish(mut self) -> Estimate {
        let features = std::mem::replace(&mut self.features, FeatureSums::new(self.width, 0));
        let estimate = self.resolve();
        drop(self);
        let (features, ids) = features.finish();
        Estimate { features, ids, ..estimate }
    }

    /// The picture so far, without what the camera sees first.
    pub(crate) fn resolve(&self) -> Estimate {
        self.estimate(self.whole_picture())
    }

    pub(super) fn whole_picture(&self) -> Picture {
        if let Some(allotted) = &self.allotted {
            return self.allotted_picture(allotted);
        }
        // a rest too small to be weighed by its own variance joins only where there is nothing else
        let alone = self.picture.samples == 0 && self.picture.surplus.is_empty() && self.pending.is_none();
        let joins = self.group.samples >= MIN_GROUP || alone || self.combine != Combine::InverseVariance;
        self.picture_of(self.pending.as_ref(), Some(&self.group).filter(|group| joins && !group.is_empty()))
    }

    /// Share of the camera's rays that met something, pixel by pixel.
    pub(crate) fn coverage(&self) -> Vec<f32> {
        self.features.coverage()
    }

    /// The picture of the groups before `pending`, of that and of the newest.
    pub(super) fn picture_of(&self, pending: Option<&IterationGroup>, newest: Option<&IterationGroup>) -> Picture {
        let mut picture = self.picture.clone();
        if let Some(newest) = newest {
            self.weigh_in(&mut picture, pending, newest);
        }
        if let Some(last) = newest.or(pending).filter(|_| self.combine == Combine::InverseVariance) {
            picture.weigh_in(self.width, last, last.weights(self.width as usize, last));
        }
        picture
    }

    pub(super) fn estimate(&self, picture: Picture) -> Estimate {
        picture.estimate([self.width, self.height], &self.layers)
    }

    fn pixels(&self) -> usize {
        self.group.sum.len()
    }

    /// The group after the current one.
    pub(super) fn empty_group(&self) -> IterationGroup {
        let group = IterationGroup::new(self.pixels(), self.layers.len());
        let halves = if self.halved { Halves::new(self.pixels()) } else { Halves::default() };
        IterationGroup { first: self.group.first + self.group.samples, halves, ..group }
    }

    fn close_group(&mut self) {
        let new = self.empty_group();
        let closed = std::mem::replace(&mut self.group, new);
        let (mut picture, pending) = (std::mem::take(&mut self.picture), self.pending.take());
        self.weigh_in(&mut picture, pending.as_ref(), &closed);
        self.picture = picture;
        self.pending = (self.combine == Combine::InverseVariance).then_some(closed);
    }

    /// Weighs the newest group into a picture; by inverse variance the one before it, as that has now a better picture than
    /// its own to be held against.
    fn weigh_in(&self, picture: &mut Picture, pending: Option<&IterationGroup>, newest: &IterationGroup) {
        match self.combine {
            Combine::Last => {
                let tells = picture.tells_error();
                let new = Picture::new(self.pixels(), self.layers.len()).that_tells_its_error(tells);
                let before = std::mem::replace(picture, new);
                picture.weigh_in(self.width, newest, [Some(1.0); 2]);
                picture.fill_in(before, newest);
            }
            Combine::All => picture.weigh_in(self.width, newest, [Some(newest.mean_count()); 2]),
            Combine::InverseVariance => {
                if let Some(before) = pending {
                    picture.weigh_in(self.width, before, before.weights(self.width as usize, newest));
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "accumulate_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "extremes_tests.rs"]
mod extremes;

#[cfg(test)]
#[path = "cut_tests.rs"]
mod cut_tests;
