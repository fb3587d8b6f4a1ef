//! How much the samples of a tile count, where tiles get different numbers of them by what is known of their noise.
//!
//! The mean of as many samples as these samples themselves have asked for is biased (D. Kirk, J. Arvo, "Unbiased sampling
//! techniques for image synthesis", SIGGRAPH 1991). So what a tile gets in an iteration, and how much that will count, is settled
//! before the iteration begins. Let cⱼ be the share that iteration j has in a pixel, and Xⱼ the mean of its samples there. As cⱼ
//! and the number of samples are known before the first of them is drawn, Xⱼ − µ is zero on average whatever they are; and as
//! all shares add up to one, so is Σ cⱼ Xⱼ − µ. The newest iteration always has the share that is left.

use super::accumulate::Film;
use super::blur::{blur, mean_without_largest};
use super::group::{FLOOR, IterationGroup};
use super::picture::Picture;
use super::tile::Tile;
use crate::math::{Rgb, luminance};
use rayon::prelude::*;

/// What was settled of a tile.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct TileShare {
    /// Sum of the shares of the iterations before, in [0, 1].
    pub(crate) before: f64,
    /// Share of the iteration under way; what is left of one goes to iterations after it.
    pub(crate) share: f64,
    /// Samples per pixel that it is to have.
    pub(crate) samples: u32,
    /// Number of the first of them.
    pub(crate) first: u32,
}

/// What was settled of all tiles, row by row.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Allotted {
    /// Columns of pixels of the picture, pixels along a tile, columns of tiles.
    width: u32,
    side: u32,
    columns: u32,
    tiles: Vec<TileShare>,
    /// Share of the iteration under way that is done in all tiles, in [0, 1]. It does not depend on what samples have found.
    done: f64,
    /// The picture before the iteration under way: that of all iterations before, of which the newest has the share that was left.
    shown: Picture,
}

impl Allotted {
    fn new(width: u32, side: u32, tiles: Vec<TileShare>, shown: Picture) -> Allotted {
        Allotted { width, side, columns: width.div_ceil(side), tiles, done: 0.0, shown }
    }

    /// Whether it is of a picture of this size, with so many layers.
    pub(super) fn fits(&self, [width, height]: [u32; 2], layers: usize) -> bool {
        let tiles = self.columns as usize * height.div_ceil(self.side.max(1)) as usize;
        let sizes = self.width == width && self.side > 0 && self.columns == width.div_ceil(self.side);
        sizes && self.tiles.len() == tiles && self.shown.fits(width as usize * height as usize, layers)
    }

    fn tile_of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
        (y / self.side * self.columns + x / self.side) as usize
    }

    fn share(&self, pixel: usize) -> &TileShare {
        &self.tiles[self.tile_of(pixel)]
    }

    /// Number of the first sample of the iteration under way in a tile.
    pub(super) fn first(&self, tile: &Tile) -> u32 {
        self.share((tile.y * self.width + tile.x) as usize).first
    }
}

impl TileShare {
    /// Share of the iteration in all that is kept for those after it, where so much of it is done.
    fn kept(&self, done: f64) -> f64 {
        let new = self.share * done;
        if new > 0.0 { new / (self.before + new) } else { 0.0 }
    }
}

impl Film {
    /// Settles, before an iteration begins, what tiles of `side` × `side` pixels get in it, row by row. What was sampled before
    /// the first call has no share in the finished picture: it has decided.
    pub(crate) fn allot(&mut self, side: u32, tiles: Vec<TileShare>) {
        let shown = match self.allotted.take() {
            Some(allotted) => allotted.shown,
            None => {
                let shown = self.picture_so_far();
                self.picture = Picture::new(self.group.sum.len(), self.layers.len());
                (self.pending, self.before) = (None, None);
                self.group = self.empty_group();
                shown
            }
        };
        self.allotted = Some(Allotted::new(self.width, side, tiles, shown));
    }

    /// Whether tiles get different numbers of samples.
    pub(crate) fn is_allotted(&self) -> bool {
        self.allotted.is_some()
    }

    /// Makes one iteration of all so far, with a share that nothing decides of what samples have said.
    pub(crate) fn settle(&mut self, share: f64) {
        if let Some(allotted) = &mut self.allotted {
            self.picture = allotted.shown.clone();
            allotted.tiles.iter_mut().for_each(|tile| tile.before = share);
        }
    }

    /// Says how much of the iteration under way is done: the same in all tiles, each of which then has samples of it if it is to have
    /// any.
    pub(crate) fn say_done(&mut self, share: f64) {
        self.allotted.iter_mut().for_each(|allotted| allotted.done = share.min(1.0));
    }

    /// What was said last.
    pub(crate) fn share_done(&self) -> f64 {
        self.allotted.as_ref().map_or(0.0, |allotted| allotted.done)
    }

    /// Sums of shares of all iterations so far, and samples per pixel of the one under way, tile by tile.
    pub(crate) fn shares(&self) -> Vec<(TileShare, u32)> {
        let Some(allotted) = &self.allotted else { return Vec::new() };
        let corner = |k: usize| {
            let (x, y) = (k as u32 % allotted.columns * allotted.side, k as u32 / allotted.columns * allotted.side);
            (y * allotted.width + x) as usize
        };
        allotted.tiles.iter().enumerate().map(|(k, share)| (*share, self.group.count(corner(k)))).collect()
    }

    /// The picture as it is now: as far as the iteration under way is done, it takes the place of the newest before it. Both are
    /// unbiased, and how far it is does not depend on what it has found.
    pub(super) fn allotted_picture(&self, allotted: &Allotted) -> Picture {
        let (kept, shown, group) = (&self.picture, &allotted.shown, &self.group);
        let (mut picture, done) = (shown.clone(), allotted.done);
        let left = |i: usize| 1.0 - allotted.share(i).before;
        picture.mean.par_iter_mut().zip(&mut picture.variance).enumerate().for_each(|(i, (mean, variance))| {
            let (left, (new, new_variance)) = (left(i), group.moments(i));
            let with_new = toward(kept.mean[i], new, left);
            let its_variance = kept.variance[i] * squared(1.0 - left) + new_variance * squared(left);
            *variance = correlated(*variance, its_variance, done);
            *mean = toward(*mean, with_new, done);
        });
        for (layer, means) in picture.layers.iter_mut().enumerate() {
            means.par_iter_mut().enumerate().for_each(|(i, mean)| {
                let with_new = toward(kept.layers[layer][i], group.layer_mean(layer, i), left(i));
                *mean = toward(*mean, with_new, done);
            });
        }
        if done > 0.0 {
            let before = |i: usize| if done < 1.0 { shown.count(i) } else { kept.count(i) };
            picture.set_counts((0..picture.mean.len()).into_par_iter().map(|i| before(i) + group.count(i)).collect());
        }
        picture
    }

    /// Ends the iteration under way.
    pub(super) fn end_allotted(&mut self) {
        let Some(mut allotted) = self.allotted.take() else { return };
        let shown = self.allotted_picture(&allotted);
        let (group, kept) = (&self.group, &mut self.picture);
        let share = |i: usize| allotted.share(i).kept(allotted.done);
        kept.mean.par_iter_mut().zip(&mut kept.variance).enumerate().for_each(|(i, (mean, variance))| {
            let (share, (new, new_variance)) = (share(i), group.moments(i));
            *mean = toward(*mean, new, share);
            *variance = *variance * squared(1.0 - share) + new_variance * squared(share);
        });
        for (layer, means) in kept.layers.iter_mut().enumerate() {
            let new = |i: usize| group.layer_mean(layer, i);
            means.par_iter_mut().enumerate().for_each(|(i, mean)| *mean = toward(*mean, new(i), share(i)));
        }
        let counts = (0..kept.mean.len()).into_par_iter().map(|i| kept.count(i) + group.count(i)).collect();
        kept.set_counts(counts);
        allotted.shown = shown;
        let done = std::mem::take(&mut allotted.done);
        allotted.tiles.iter_mut().for_each(|tile| {
            tile.before += std::mem::take(&mut tile.share) * done;
        });
        self.allotted = Some(allotted);
        self.group = self.empty_group();
    }

    /// Variance of one sample of the newest iterations relative to the picture, tile by tile: the mean over its pixels but for the
    /// noisiest, as iterations are weighed by ([`IterationGroup::weights`]). `None` of a tile with fewer than two samples there,
    /// and of all tiles of a black picture.
    pub(crate) fn tile_noise(&self, tiles: &[Tile]) -> Vec<Option<f64>> {
        let (group, width) = (&self.group, self.width as usize);
        let light: Vec<f64> = self.picture_so_far().mean.par_iter().map(|&c| f64::from(luminance(c))).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return vec![None; tiles.len()];
        }
        let (about, tells) = (blur(&light, |_| true, width), |i: usize| group.count(i) >= 2);
        let variances = group.mean_variances(width, tells);
        let relative =
            |i: usize| variances[i] * f64::from(group.count(i)) / (about[i].powi(2) + (FLOOR * mean).powi(2));
        let of_tile = |tile: &Tile| {
            let rows = tile.y as usize..(tile.y + tile.height) as usize;
            let row = |y: usize| y * width + tile.x as usize..y * width + (tile.x + tile.width) as usize;
            let pixels: Vec<usize> = rows.flat_map(row).collect();
            let known = pixels.iter().all(|&i| tells(i));
            known.then(|| {
                mean_without_largest(pixels.iter().map(|&i| relative(i)).collect(), outliers(group, pixels[0]))
            })
        };
        tiles.par_iter().map(of_tile).collect()
    }
}

/// Share of a tile's pixels that are left out.
fn outliers(group: &IterationGroup, pixel: usize) -> f64 {
    super::group::outliers(group.count(pixel).into())
}

/// The way from one mean to another; exactly there at 1, and exactly where it was for equal ones.
fn toward(from: Rgb, to: Rgb, share: f64) -> Rgb {
    if share >= 1.0 { to } else { from + (to - from) * share as f32 }
}

fn squared(share: f64) -> f32 {
    (share * share) as f32
}

/// The variance of a mean of two that share samples, at most.
fn correlated(from: Rgb, to: Rgb, share: f64) -> Rgb {
    match share {
        share if share >= 1.0 => to,
        share => {
            let deviation = from.map(f32::sqrt) * (1.0 - share as f32) + to.map(f32::sqrt) * share as f32;
            deviation * deviation
        }
    }
}

#[cfg(test)]
#[path = "allotted_tests.rs"]
mod tests;
