//! How a render is cut up: iterations of doubling length, passes over the image, rounds of tasks.

use crate::film::tile::Tile;
use crate::integrator::Task;

/// Paths in a round. Between rounds the guide learns and the clock is looked at; fixed, so that no result depends
/// on the number of threads.
const ROUND_PATHS: usize = 1 << 18;

/// From this many pixels on, a batch takes one sample of a larger tile, so that passes stay short.
const LARGE_IMAGE: usize = 1 << 19;

/// The tiles of an image and the samples that a batch takes of each pixel: 4096 paths, which a level-2 cache holds.
#[derive(Clone, Copy, Debug)]
pub struct Tiling {
    width: u32,
    height: u32,
    side: u32,
    /// Samples per pixel that one pass adds at most.
    pub samples: u32,
}

impl Tiling {
    pub fn new(width: u32, height: u32) -> Tiling {
        let large = width as usize * height as usize >= LARGE_IMAGE;
        let (side, samples) = if large { (64, 1) } else { (32, 4) };
        Tiling { width, height, side, samples }
    }

    /// All tasks of a pass, in rounds.
    pub fn rounds(&self, first_sample: u32, samples: u32) -> Vec<Vec<Task>> {
        let mut rounds = vec![Vec::new()];
        let mut paths = 0;
        for y in (0..self.height).step_by(self.side as usize) {
            for x in (0..self.width).step_by(self.side as usize) {
                let (width, height) = (self.side.min(self.width - x), self.side.min(self.height - y));
                let task = Task { tile: Tile { x, y, width, height }, first_sample, samples };
                if paths >= ROUND_PATHS {
                    rounds.push(Vec::new());
                    paths = 0;
                }
                paths += task.paths();
                rounds.last_mut().expect("there is always one").push(task);
            }
        }
        rounds
    }
}

/// Samples per pixel of an iteration that would take `planned`, when `left` remain of the budget. The last iteration
/// takes all of the rest, so that it has about half of the budget or more (Müller et al. 2017, §4.3).
pub fn iteration_samples(planned: u32, left: u32) -> u32 {
    if left.saturating_sub(planned) < 2 * planned { left } else { planned }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_task_of_a_pass() {
        for (width, height) in [(1, 1), (33, 31), (320, 180), (1000, 700)] {
            let tiling = Tiling::new(width, height);
            let mut seen = vec![0; (width * height) as usize];
            for tile in tiling.rounds(0, tiling.samples).iter().flatten().map(|task| task.tile) {
                for y in tile.y..tile.y + tile.height {
                    (tile.x..tile.x + tile.width).for_each(|x| seen[(y * width + x) as usize] += 1);
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}×{height}");
        }
    }

    #[test]
    fn iterations_double_and_the_last_has_the_larger_half() {
        for spp in 1..500 {
            let (mut left, mut planned, mut sizes) = (spp, 1, Vec::new());
            while left > 0 {
                let n = iteration_samples(planned, left);
                sizes.push(n);
                left -= n;
                planned *= 2;
            }
            assert_eq!(sizes.iter().sum::<u32>(), spp);
            assert!(2 * sizes[sizes.len() - 1] >= spp, "{sizes:?}");
        }
    }
}
