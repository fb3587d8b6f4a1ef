//! Adaptive sampling: tiles get different numbers of samples, by what is known of their noise.
//!
//! First a render is as any other, until it has [`PILOT`] samples per pixel. These decide, and are not weighed. From then on each
//! iteration begins with a plan: how many samples each tile gets in it, and how much they will count. All iterations before have a
//! say in it, and what it brings has none, so that the picture stays unbiased (see [`crate::film::TileShare`]).
//!
//! With a budget of samples or time, a tile gets them in proportion to the standard deviation of a sample relative to the picture:
//! of all ways to deal out so many samples, that leaves the least mean squared relative error (J. Neyman 1934). With a noise to be
//! reached, it gets as many as it needs for that, and then no more.

use super::schedule::Tiling;
use super::state::IterationOrder;
use crate::film::TileShare;
use crate::film::accumulate::{FEATURE_SAMPLES, Film};
use crate::film::tile::Tile;
use crate::integrator::Task;
use serde::{Deserialize, Serialize};

/// Samples per pixel that decide first: iterations of 1, 2, 4 and 8.
const PILOT: u32 = 15;

/// As many times more there have to be after them: where the pilot were more than a fifth of all, nothing could be gained.
const WORTH: u32 = 4;

/// Share of the mean number of samples that each tile gets. However wrong the estimate of its noise, its variance is no more than
/// four times what it would be with as many samples as all others.
const LEAST: f64 = 0.25;

/// Samples that a tile gets at least where it gets any, so that they tell their noise.
const FEWEST: u32 = 4;

/// Share of the squared error that a tile may have which is left to the samples to come, at least. If its noise has shown late, those
/// before may have too large a share already, and the tile ends with a larger error than was asked for.
const LATE: f64 = 0.25;

/// Share that all samples so far keep where a finished render is to become better than before, at most.
const KEPT: f64 = 0.5;

/// What is known of a tile.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct TileState {
    /// Variance of one sample relative to the picture, by the newest iteration that tells it.
    noise: f64,
    /// Squared relative error of the iterations that keep their shares, by themselves; and of the picture as it is.
    kept: f64,
    error: f64,
    /// Samples per pixel of the sequence under way.
    taken: u32,
}

/// What plans the samples of tiles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Adaptive {
    tiles: Vec<TileState>,
    /// Number of the first sample of the sequence under way.
    sequence: u32,
    /// Samples per pixel, on average, that the picture holds.
    weighed: f64,
    /// What the iteration under way gives each tile. Empty while all get as many.
    samples: Vec<u32>,
    /// Passes in which it does.
    passes: u32,
    /// The most samples per pixel that a tile can have had.
    most: u32,
    /// The iteration under way is the last; nothing more is to be rendered.
    last: bool,
    complete: bool,
    /// Its samples are drawn as those before.
    same_sequence: bool,
    /// The budget is another since the newest plan.
    new_budget: bool,
}

/// What is left of the budget.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    /// Samples per pixel.
    pub samples: u32,
    /// Relative error that each tile is to have.
    pub noise: Option<f64>,
}

impl Adaptive {
    pub fn new(tiling: &Tiling) -> Adaptive {
        Adaptive {
            tiles: vec![TileState::default(); tiling.tiles().len()],
            sequence: 0,
            weighed: 0.0,
            samples: Vec::new(),
            passes: 0,
            most: 0,
            last: false,
            complete: false,
            same_sequence: false,
            new_budget: false,
        }
    }

    /// Whether it can be of so many tiles.
    pub fn fits(&self, tiles: usize) -> bool {
        self.tiles.len() == tiles && (self.samples.is_empty() || self.samples.len() == tiles)
    }

    /// Whether all that was to be rendered is.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Says that the budget is another from the next iteration on.
    pub fn change_budget(&mut self) {
        (self.last, self.complete, self.new_budget) = (false, false, self.is_under_way());
    }

    /// Whether tiles get different numbers of samples already.
    pub fn is_under_way(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Whether they do from the next iteration on, after `samples` samples per pixel.
    pub fn begins(&self, samples: u32, left: &Left) -> bool {
        self.is_under_way() || (samples >= PILOT && left.samples / WORTH >= samples)
    }

    /// Number of the first sample of the sequence under way.
    pub fn sequence(&self) -> u32 {
        self.sequence
    }

    /// Says whether the samples that come are drawn as those before.
    pub fn continue_sequence(&mut self, same: bool) {
        self.same_sequence = same;
    }

    /// Passes in which the iteration under way comes.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// The tasks of pass `number` of the iteration under way. So many of its passes give each tile as large a part of its samples, and
    /// already the first gives it some.
    pub fn tasks(&self, tiling: &Tiling, number: u32) -> Vec<Task> {
        let passes = u64::from(self.passes);
        let upto = |k: usize, pass: u32| (u64::from(self.samples[k]) * u64::from(pass)).div_ceil(passes) as u32;
        let of_tile = |place: Task| {
            let k = tiling.number(&place.tile);
            let (from, to) = (upto(k, number), upto(k, number + 1));
            let first = self.sequence + self.tiles[k].taken;
            let steps = (from..to).step_by(tiling.samples as usize);
            steps.map(move |n| Task { tile: place.tile, first_sample: first + n, samples: tiling.samples.min(to - n) })
        };
        tiling.pass(number, 1).into_iter().flat_map(of_tile).collect()
    }

    /// Takes what an iteration has found of the noise of tiles, before the film ends it.
    pub fn survey(&mut self, film: &Film, tiling: &Tiling) {
        let found = film.tile_noise(&tiling.tiles());
        self.tiles.iter_mut().zip(found).for_each(|(tile, noise)| tile.noise = noise.unwrap_or(tile.noise));
    }

    /// Takes the end of an iteration, before the film does.
    pub fn end_iteration(&mut self, film: &Film, tiling: &Tiling) {
        if !self.is_under_way() {
            return;
        }
        let (mut paths, whole) = (0, film.share_done());
        for ((tile, of), (TileShare { before, share, .. }, done)) in
            self.tiles.iter_mut().zip(tiling.tiles()).zip(film.shares())
        {
            if done == 0 || whole * share == 0.0 {
                continue;
            }
            let of_mean = tile.noise / f64::from(done);
            let (kept, new) = (before * before * tile.kept, whole * share);
            // of a part of an iteration the picture takes a part
            let error = kept + (1.0 - before).powi(2) * of_mean;
            tile.error = if whole < 1.0 && tile.error > 0.0 { error.min(tile.error) } else { error };
            tile.kept = (kept + new * new * of_mean) / (before + new).powi(2);
            tile.taken += done;
            paths += u64::from(done) * of.pixels() as u64;
        }
        self.weighed += paths as f64 / tiling.pixels() as f64;
        self.complete = self.last;
    }

    /// The picture's relative error, as of its newest iteration; `None` before the first plan.
    pub fn relative_error(&self, tiling: &Tiling) -> Option<f64> {
        let squares = self.tiles.iter().zip(tiling.tiles()).map(|(tile, of)| tile.error * of.pixels() as f64);
        (self.weighed > 0.0).then(|| (squares.sum::<f64>() / tiling.pixels() as f64).sqrt())
    }

    /// Plans the next iteration, for which `order` gives each tile that goes on as many samples on average; `first` is a number
    /// above those of all samples so far. Returns what comes of the order.
    pub fn plan(
        &mut self,
        film: &mut Film,
        tiling: &Tiling,
        (order, left, first): (IterationOrder, Left, u32),
    ) -> IterationOrder {
        if std::mem::take(&mut self.new_budget) {
            self.settle(film, tiling, left.noise);
        }
        let kept: Vec<f64> = match film.is_allotted() {
            true => film.shares().iter().map(|(share, _)| share.before).collect(),
            false => vec![0.0; self.tiles.len()],
        };
        let planned = left.noise.and_then(|noise| self.by_noise(noise, &kept, tiling, (order, left.samples)));
        let (shares, last) = planned.unwrap_or_else(|| self.by_budget(&kept, tiling, (order, left)));
        self.number(film, first);
        let numbered = shares.iter().zip(&self.tiles);
        let shares: Vec<TileShare> =
            numbered.map(|(share, tile)| TileShare { first: self.sequence + tile.taken, ..*share }).collect();
        self.samples = shares.iter().map(|share| share.samples).collect();
        // as many as were ordered, but for rounding
        let samples = ((paths(&shares, tiling) + tiling.pixels() / 2) / tiling.pixels()).max(1) as u32;
        self.passes = samples.div_ceil(tiling.samples).max(2);
        self.last = last;
        self.most = self.most.saturating_add(self.samples.iter().copied().max().unwrap_or(0));
        film.allot(tiling.side(), shares);
        IterationOrder { samples, last, ..order }
    }

    /// Begins a sequence of samples, unless that before goes on.
    fn number(&mut self, film: &Film, first: u32) {
        if !(self.same_sequence && film.is_allotted()) {
            let most = self.tiles.iter().map(|tile| tile.taken).max().unwrap_or(0);
            // features are means over as many samples of one pixel as of another: over the pilot's
            self.sequence = self.sequence.saturating_add(most).max(first).max(FEATURE_SAMPLES);
            self.tiles.iter_mut().for_each(|tile| tile.taken = 0);
        }
    }

    /// All samples so far become one iteration, of which a share is kept that suits another budget.
    fn settle(&mut self, film: &mut Film, tiling: &Tiling, noise: Option<f64>) {
        let error = self.relative_error(tiling).filter(|error| *error > 0.0);
        let wanted = noise.zip(error).map(|(noise, error)| (noise / error).powi(2));
        let share = wanted.map_or(KEPT, |share| share.min(KEPT));
        self.tiles.iter_mut().for_each(|tile| tile.kept = tile.error);
        film.settle(share);
    }

    /// By the relative error that each tile is to have: those that have it get nothing more, and the others what they need, but in one
    /// iteration no more than in all before, by which that is known. `None` where the budget is not enough for that.
    fn by_noise(
        &self,
        noise: f64,
        kept: &[f64],
        tiling: &Tiling,
        (order, left): (IterationOrder, u32),
    ) -> Option<(Vec<TileShare>, bool)> {
        let ends = order.last && order.samples <= self.doubled();
        let most = f64::from(order.samples.min(self.doubled()));
        let share = |(tile, &before): (&TileState, &f64)| {
            let (rest, goal) = (1.0 - before, noise * noise);
            if rest <= 0.0 {
                return TileShare { before: 1.0, share: 0.0, samples: 0, first: 0 };
            }
            let error = (goal - before * before * tile.kept).max(LATE * goal);
            let needed = (rest * rest * tile.noise / error).max(LEAST * most).ceil();
            let needed = needed.clamp(f64::from(FEWEST), f64::from(u32::MAX >> 2));
            let samples = if ends { needed } else { needed.min(most) };
            let share = if samples < needed { rest * samples / needed } else { rest };
            TileShare { before, share, samples: samples as u32, first: 0 }
        };
        let shares: Vec<TileShare> = self.tiles.iter().zip(kept).map(share).collect();
        let last = shares.iter().all(|tile| tile.before + tile.share >= 1.0);
        let enough = paths(&shares, tiling) <= u64::from(left).saturating_mul(tiling.pixels());
        (enough && (last || !ends)).then_some((shares, last))
    }

    /// As many samples as a tile has had.
    fn doubled(&self) -> u32 {
        self.most.max(PILOT + 1)
    }

    /// By the samples that are left, `order.samples` of which come now.
    fn by_budget(
        &self,
        kept: &[f64],
        tiling: &Tiling,
        (order, left): (IterationOrder, Left),
    ) -> (Vec<TileShare>, bool) {
        let mean = f64::from(order.samples);
        let rest = f64::from(left.samples.max(order.samples));
        // the same for all tiles, and by numbers of samples alone
        let before = self.weighed / (self.weighed + rest);
        let goes_on = |before: f64| left.noise.is_none() || before < 1.0;
        let weight = |(tile, &before): (&TileState, &f64)| goes_on(before).then(|| tile.noise.sqrt());
        let weights: Vec<Option<f64>> = self.tiles.iter().zip(kept).map(weight).collect();
        let samples = deal(&weights, mean, &tiling.tiles());
        let share = |(samples, &kept): (u32, &f64)| {
            let before = if left.noise.is_some() { kept } else { before };
            let share = (1.0 - before) * if order.last { 1.0 } else { mean / rest };
            TileShare { before, share, samples, first: 0 }
        };
        (samples.into_iter().zip(kept).map(share).collect(), order.last)
    }
}

/// Samples of a pixel in each tile, `mean` on average over all pixels and no fewer: in proportion to the weights, but for a least
/// number of each. Those without a weight get none.
fn deal(weights: &[Option<f64>], mean: f64, tiles: &[Tile]) -> Vec<u32> {
    let areas: Vec<f64> = weights.iter().zip(tiles).map(|(w, tile)| w.map_or(0.0, |_| tile.pixels() as f64)).collect();
    let paths = mean * tiles.iter().map(|tile| tile.pixels() as f64).sum::<f64>();
    let even = paths / areas.iter().sum::<f64>();
    let least = (LEAST * even).max(f64::from(FEWEST)).min(even);
    let sum: f64 = weights.iter().zip(&areas).map(|(weight, area)| weight.unwrap_or(0.0) * area).sum();
    let proportional = |k: usize| weights[k].map_or(1.0, |weight| if sum > 0.0 { weight / sum * paths } else { even });
    // what the least takes more than its proportion is taken from the others
    let samples = |scale: f64, k: usize| (scale * proportional(k)).max(least);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        let total: f64 = (0..tiles.len()).map(|k| samples(middle, k) * areas[k]).sum();
        *(if total > paths { &mut high } else { &mut low }) = middle;
    }
    // what rounding has given too much, or not yet, is made up for by the next
    let mut owed = 0.0;
    let rounded = |k: usize| {
        let exact = samples(high, k);
        owed += exact * areas[k];
        let whole = if owed > exact.floor() * areas[k] { exact.ceil() } else { exact.floor() };
        owed -= whole * areas[k];
        if areas[k] > 0.0 { whole as u32 } else { 0 }
    };
    (0..tiles.len()).map(rounded).collect()
}

/// Camera paths of all tiles.
fn paths(shares: &[TileShare], tiling: &Tiling) -> u64 {
    let of = |(share, tile): (&TileShare, Tile)| u64::from(share.samples) * tile.pixels() as u64;
    shares.iter().zip(tiling.tiles()).map(of).sum()
}

#[cfg(test)]
#[path = "adaptive_tests.rs"]
mod tests;
