//! What guided roulette weighs paths against, found by the parts of an iteration together: how bright the picture is, and how noisy
//! one sample of it, block by block, as sums that do not depend on their order. It is of one camera's view of a scene.

use super::noise::{FLOOR, OUTLIERS};
use super::roulette;
use crate::film::blur::mean_without_largest;
use crate::film::tile::{Tile, TileSamples};
use crate::integrator::{Counters, RouletteNormalisation};
use crate::math::fixed::{fixed, value};
use crate::math::luminance;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Pixels along the side of a block. Tiles begin where blocks do.
const BLOCK: u32 = 8;

/// Sums over the samples of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct BlockSums {
    /// Of the luminance.
    light: i128,
    /// Of half the squares of the differences between pixels side by side: of the variance of one sample, where the picture is even.
    noise: i128,
}

/// Sums over the samples of a picture, by tile and block.
#[derive(Serialize, Deserialize)]
pub(super) struct ViewSums {
    tiles: Vec<Mutex<Vec<BlockSums>>>,
}

/// Where the blocks of a tile are, row by row, within it.
fn blocks(tile: &Tile) -> impl Iterator<Item = Tile> {
    let Tile { width, height, .. } = *tile;
    let corners =
        (0..height).step_by(BLOCK as usize).flat_map(move |y| (0..width).step_by(BLOCK as usize).map(move |x| (x, y)));
    corners.map(move |(x, y)| Tile { x, y, width: BLOCK.min(width - x), height: BLOCK.min(height - y) })
}

/// Pairs of pixels side by side.
fn pairs(block: &Tile) -> u32 {
    block.width / 2 * block.height
}

impl ViewSums {
    pub fn new(tiles: &[Tile]) -> ViewSums {
        let sums = |tile| Mutex::new(vec![BlockSums::default(); blocks(tile).count()]);
        ViewSums { tiles: tiles.iter().map(sums).collect() }
    }

    /// Adds one sample of each pixel of tile `number`.
    pub fn add(&self, number: usize, tile: &Tile, samples: &TileSamples) {
        let light = |x: u32, y: u32| luminance(samples.sum[(y * tile.width + x) as usize]);
        let mut sums = self.tiles[number].lock().unwrap_or_else(PoisonError::into_inner);
        for (sums, block) in sums.iter_mut().zip(blocks(tile)) {
            for y in block.y..block.y + block.height {
                for x in block.x..block.x + block.width {
                    sums.light = sums.light.saturating_add(fixed(light(x, y)));
                }
                for x in (block.x..block.x + block.width - 1).step_by(2) {
                    let difference = light(x, y) - light(x + 1, y);
                    sums.noise = sums.noise.saturating_add(fixed(0.5 * difference * difference));
                }
            }
        }
    }

    /// Adds the sums of another part; `false` where they are of another picture.
    pub fn add_sums(&mut self, other: ViewSums) -> bool {
        let fits = self.tiles.len() == other.tiles.len();
        fits && self.tiles.iter_mut().zip(other.tiles).all(|(own, more)| {
            let own = own.get_mut().unwrap_or_else(PoisonError::into_inner);
            let more = more.into_inner().unwrap_or_else(PoisonError::into_inner);
            own.iter_mut().zip(&more).for_each(|(own, more)| {
                own.light = own.light.saturating_add(more.light);
                own.noise = own.noise.saturating_add(more.noise);
            });
            own.len() == more.len()
        })
    }

    /// What these `samples` of each pixel say, that took as many rays as `counters` tell, where the guide has learnt from `learnt`
    /// samples per pixel.
    pub fn finish(
        self,
        tiles: &[Tile],
        samples: u32,
        learnt: u32,
        counters: &Counters,
    ) -> Option<RouletteNormalisation> {
        let sums = self.tiles.into_iter().map(|tile| tile.into_inner().unwrap_or_else(PoisonError::into_inner));
        let sums: Vec<BlockSums> = sums.flatten().collect();
        let all: Vec<Tile> = tiles.iter().flat_map(blocks).collect();
        let n = f64::from(samples.max(1));
        let light: Vec<f64> =
            sums.iter().zip(&all).map(|(sum, b)| value(sum.light) / (n * b.pixels() as f64)).collect();
        let pixels: f64 = all.iter().map(|block| block.pixels() as f64).sum();
        let mean = sums.iter().map(|sum| value(sum.light)).sum::<f64>() / (n * pixels);
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let squares: Vec<f64> = light.iter().map(|l| l * l + (FLOOR * mean).powi(2)).collect();
        let of_block = |((sum, block), square): ((&BlockSums, &Tile), &f64)| {
            (pairs(block) > 0).then(|| value(sum.noise) / (n * f64::from(pairs(block)) * square))
        };
        let relative: Vec<f64> = sums.iter().zip(&all).zip(&squares).filter_map(of_block).collect();
        let variance = mean_without_largest(relative, OUTLIERS);
        (variance > 0.0).then(|| roulette::of(&squares, || variance, learnt, counters))?
    }
}

/// What roulette goes by, of one view of a scene. Blocks are in the order of the tiles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct View {
    /// Hash of the scene, camera and film included.
    scene: String,
    roulette: RouletteNormalisation,
}

impl View {
    pub(super) fn new(scene: String, roulette: RouletteNormalisation) -> View {
        View { scene, roulette }
    }

    /// The same pixel by pixel; `None` where it is of another view than that of `scene`, or of none.
    pub(super) fn of(&self, scene: &str, tiles: &[Tile], width: u32) -> Option<RouletteNormalisation> {
        let RouletteNormalisation { inverse_luminance: by_block, scale } = &self.roulette;
        let blocks: Vec<(Tile, Tile)> =
            tiles.iter().flat_map(|tile| blocks(tile).map(move |block| (*tile, block))).collect();
        let sound = by_block.iter().chain([scale]).all(|v| *v > 0.0 && v.is_finite());
        if self.scene != scene || blocks.len() != by_block.len() || !sound {
            return None;
        }
        let pixels = tiles.iter().map(Tile::pixels).sum();
        let mut inverse_luminance = vec![0.0; pixels];
        for ((tile, block), inverse) in blocks.into_iter().zip(by_block) {
            for y in tile.y + block.y..tile.y + block.y + block.height {
                let first = (y * width + tile.x + block.x) as usize;
                inverse_luminance[first..first + block.width as usize].fill(*inverse);
            }
        }
        Some(RouletteNormalisation { inverse_luminance, scale: *scale })
    }
}
