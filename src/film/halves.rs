//! The samples of a pixel in two parts, those that came first and the others.
//!
//! Samples that are spread evenly are not independent: their mean varies less than they do by themselves, and no one of them
//! tells by how much. The two halves of an even sequence are even sequences too, and each is an unbiased estimate; how far they
//! are apart tells it. Where an even sequence of twice the length has a mean whose variance is 2ʳ times as small, the square of
//! half their difference is 2ʳ − 1 times that variance on average: exactly right for independent samples (r = 1), and too much,
//! never too little, for samples that are spread better than that.

use super::blur::blur;
use crate::film::tile::Tile;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// What a pixel had at some time.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Earlier {
    /// Σ of the luminance of its samples.
    light: f32,
    samples: u32,
}

/// What pixels had when about half of their samples were there, newest first: that one may be nearly all there is, and then the
/// one before is nearer to a half. Empty where nobody asks.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Halves(Vec<[Earlier; 2]>);

impl Halves {
    /// Of so many pixels.
    pub(crate) fn new(pixels: usize) -> Halves {
        Halves(vec![[Earlier::default(); 2]; pixels])
    }

    /// Whether it can be of so many pixels.
    pub(super) fn fits(&self, pixels: usize) -> bool {
        self.0.is_empty() || self.0.len() == pixels
    }

    pub(crate) fn are_asked_for(&self) -> bool {
        !self.0.is_empty()
    }

    /// Keeps what the pixels of a tile have, before they are given further samples: `numbers`, counted from the beginning of
    /// the sequence, `before` being those before it; `sum` is that of a pixel. It is kept where their number comes to a power of two.
    pub(crate) fn keep(
        &mut self,
        (tile, width): (&Tile, u32),
        sum: impl Fn(usize) -> DVec3,
        numbers: Range<u32>,
        before: u32,
    ) {
        let power = numbers.end.saturating_sub(1).checked_ilog2().map_or(0, |m| 1 << m);
        if !self.are_asked_for() || numbers.start == 0 || numbers.start > power {
            return;
        }
        for y in tile.y..tile.y + tile.height {
            let first = (y * width + tile.x) as usize;
            for i in first..first + tile.width as usize {
                let now = Earlier { light: wide_luminance(sum(i)) as f32, samples: before + numbers.start };
                self.0[i] = [now, self.0[i][0]];
            }
        }
    }

    /// The same of what came after `samples` samples, whose sums were `sums`.
    pub(crate) fn since(&self, sums: &[DVec3], samples: u32) -> Halves {
        let later = |earlier: Earlier, sum: DVec3| {
            let later = earlier.samples.checked_sub(samples).filter(|&later| later > 0);
            let light = earlier.light - wide_luminance(sum) as f32;
            later.map_or(Earlier::default(), |samples| Earlier { light, samples })
        };
        Halves(self.0.iter().zip(sums).map(|(both, sum)| both.map(|earlier| later(earlier, *sum))).collect())
    }

    /// What pixel `i`, which has now `samples` samples, had when the fewer of both parts were the most: a third of them and
    /// more, unless it has had fewer than three.
    fn nearest_to_half(&self, i: usize, samples: u32) -> Earlier {
        let fewer = |earlier: &Earlier| earlier.samples.min(samples.saturating_sub(earlier.samples));
        let [newer, older] = self.0[i];
        if fewer(&newer) >= fewer(&older) { newer } else { older }
    }

    /// Half of the difference squared, for parts of different length in proportion: pixel `i` has now `samples` samples with the
    /// sum `sum`. `None` where one part is empty, or light is beyond an `f32`.
    fn difference(&self, i: usize, sum: DVec3, samples: u32) -> Option<f64> {
        let Earlier { light, samples: first } = self.nearest_to_half(i, samples);
        let second = samples.checked_sub(first).filter(|&second| second > 0 && first > 0)?;
        let [light, first, second] = [f64::from(light), first.into(), second.into()];
        let difference = light / first - (wide_luminance(sum) - light) / second;
        let square = difference * difference * first * second / f64::from(samples).powi(2);
        square.is_finite().then_some(square)
    }

    /// Variances of means, pixel by pixel, where `spread` are those that the means of independent samples would have: these
    /// times the mean ratio of squared differences to them, about each pixel among those that count. One difference by itself
    /// says little; and of ratios all pixels have a say, where of sums the brightest would have it alone.
    pub(crate) fn variances(
        &self,
        spread: Vec<f64>,
        moments: impl Fn(usize) -> (DVec3, u32) + Sync,
        counts: impl Fn(usize) -> bool + Sync,
        width: usize,
    ) -> Vec<f64> {
        if !self.are_asked_for() {
            return spread;
        }
        let ratio = |i: usize| {
            let (sum, samples) = moments(i);
            self.difference(i, sum, samples).map_or(1.0, |difference| difference / spread[i])
        };
        let varies = |i: usize| counts(i) && spread[i] > 0.0;
        let ratios = (0..spread.len()).into_par_iter().map(|i| if varies(i) { ratio(i) } else { 0.0 });
        let ratios = blur(&ratios.collect::<Vec<f64>>(), varies, width);
        spread.iter().zip(ratios).map(|(spread, ratio)| spread * ratio).collect()
    }
}

/// [`luminance`] of a colour whose luminance may be beyond an `f32`.
pub(super) fn wide_luminance(c: DVec3) -> f64 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}

#[cfg(test)]
#[path = "halves_tests.rs"]
mod tests;
