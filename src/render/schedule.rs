//! How a render is cut up: iterations of doubling length, passes over the image, or one block of it after the other;
//! and these in turn into rounds of tasks.

use crate::film::tile::Tile;
use crate::integrator::Task;

/// Paths in a round. Between rounds the guide learns and the wall clock is read; fixed, so that no result depends
/// on the number of threads.
const ROUND_PATHS: usize = 1 << 18;

/// The same where the guide is used as soon as it has learnt: eight batches.
const ONLINE_ROUND_PATHS: usize = 1 << 15;

/// From this many pixels on, a batch takes one sample of a larger tile, so that passes stay short.
const LARGE_IMAGE: usize = 1 << 19;

/// Samples per pixel that an iteration plans at most.
pub const LONGEST_ITERATION: u32 = 1 << 30;

/// Samples per pixel of the iteration after one of `planned`.
pub fn doubled(planned: u32) -> u32 {
    (2 * planned).min(LONGEST_ITERATION)
}

/// The tiles of an image and the samples that a batch takes of each pixel: 4096 paths. Fewer are no faster.
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

    /// The same with batches that take one sample of each pixel, whatever the size of the image: then a batch depends on nothing
    /// but its tile and the number of its sample.
    pub fn of_single_samples(width: u32, height: u32) -> Tiling {
        Tiling { width, height, side: 64, samples: 1 }
    }

    /// Pixels along a tile.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Pixels of the image.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The place of a tile among all, row by row.
    pub fn number(&self, tile: &Tile) -> usize {
        (tile.y / self.side * self.size_in_tiles().0 + tile.x / self.side) as usize
    }

    /// All tiles, row by row.
    pub fn tiles(&self) -> Vec<Tile> {
        let (columns, rows) = self.size_in_tiles();
        (0..rows).flat_map(|row| (0..columns).map(move |column| self.tile(column, row))).collect()
    }

    /// All tasks of a pass, in an order of which every stretch covers the picture evenly: a guide that has learnt enough
    /// before a pass ends has then learnt from all of the picture. Each pass begins elsewhere in that order, so that such
    /// a guide does not learn from the same tiles again and again.
    pub fn pass(&self, first_sample: u32, samples: u32) -> Vec<Task> {
        let (columns, rows) = self.size_in_tiles();
        let mut tiles: Vec<(u32, u32)> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).collect();
        tiles.sort_unstable_by_key(|&(column, row)| dither(column, row));
        let first = start(first_sample, tiles.len());
        tiles.rotate_left(first);
        tiles.into_iter().map(|(x, y)| Task { tile: self.tile(x, y), first_sample, samples }).collect()
    }

    /// All tasks of a render block by block, from the middle outwards; a block takes all of its `spp` samples before
    /// the next begins. They come in stretches of whole blocks, each at least a round of `round_paths` long but the
    /// last.
    pub fn blocks(&self, spp: u32, round_paths: usize) -> Vec<Vec<Task>> {
        let (columns, rows) = self.size_in_tiles();
        let blocks = spiral(columns, rows).into_iter().map(|(x, y)| {
            let tile = self.tile(x, y);
            let task = |first: u32| Task { tile, first_sample: first, samples: self.samples.min(spp - first) };
            (0..spp).step_by(self.samples as usize).map(task).collect::<Vec<_>>()
        });
        gather(blocks, round_paths)
    }

    fn size_in_tiles(&self) -> (u32, u32) {
        (self.width.div_ceil(self.side), self.height.div_ceil(self.side))
    }

    fn tile(&self, column: u32, row: u32) -> Tile {
        let (x, y) = (column * self.side, row * self.side);
        Tile { x, y, width: self.side.min(self.width - x), height: self.side.min(self.height - y) }
    }
}

/// How many paths a round has at least.
pub fn round_paths(online: bool) -> usize {
    if online { ONLINE_ROUND_PATHS } else { ROUND_PATHS }
}

/// Cuts tasks into rounds that have no fewer than `paths` paths, the last excepted.
pub fn rounds(tasks: &[Task], paths: usize) -> Vec<Vec<Task>> {
    gather(tasks.iter().map(|&task| vec![task]), paths)
}

/// Joins neighbouring groups until each has at least `paths` paths, the last excepted.
fn gather(groups: impl Iterator<Item = Vec<Task>>, paths: usize) -> Vec<Vec<Task>> {
    let mut joined: Vec<Vec<Task>> = Vec::new();
    let mut room = 0;
    for group in groups {
        let size: usize = group.iter().map(Task::paths).sum();
        match joined.last_mut() {
            Some(last) if room > 0 => last.extend(group),
            _ => {
                joined.push(group);
                room = paths;
            }
        }
        room = room.saturating_sub(size);
    }
    joined
}

/// The threshold of a cell in an ordered dither of unlimited size (Bayer 1973): the bits of its place, interleaved, the
/// lowest first. Cells in the order of their thresholds fill the plane evenly, at any time and at every scale.
fn dither(column: u32, row: u32) -> u64 {
    let bits = |k: u32| u64::from((column ^ row) >> k & 1) << 1 | u64::from(row >> k & 1);
    (0..u32::BITS).fold(0, |key, k| key << 2 | bits(k))
}

/// Where the pass that begins with this sample starts in an order of `tiles` tiles. Multiples of the golden ratio, modulo
/// 1, keep apart from each other however many they are.
fn start(first_sample: u32, tiles: usize) -> usize {
    const GOLDEN: u32 = 0x9e37_79b9;
    ((u64::from(first_sample.wrapping_mul(GOLDEN)) * tiles as u64) >> 32) as usize
}

/// The cells of a grid from its middle outwards, turn by turn.
fn spiral(columns: u32, rows: u32) -> Vec<(u32, u32)> {
    let cells = columns as usize * rows as usize;
    let (mut x, mut y) = ((columns / 2) as i64, (rows / 2) as i64);
    let (mut dx, mut dy) = (1, 0);
    let mut found = Vec::with_capacity(cells);
    for leg in 2.. {
        // legs are 1, 1, 2, 2, 3, 3 … steps long; those beyond the grid's edges find nothing
        for _ in 0..leg / 2 {
            if (0..columns as i64).contains(&x) && (0..rows as i64).contains(&y) {
                found.push((x as u32, y as u32));
            }
            (x, y) = (x + dx, y + dy);
        }
        if found.len() == cells {
            break;
        }
        (dx, dy) = (-dy, dx);
    }
    found
}

/// Samples per pixel of an iteration that would take `planned`, when `left` remain of the budget. The last iteration
/// takes all of the rest, so that it has about half of the budget or more (Müller et al. 2017, §4.3).
pub fn iteration_samples(planned: u32, left: u32) -> u32 {
    if is_last_iteration(planned.into(), left.into()) { left } else { planned }
}

/// Whether an iteration that would take `planned` samples per pixel takes all of the `left` ones.
pub fn is_last_iteration(planned: f64, left: f64) -> bool {
    left < 3.0 * planned
}

/// Seconds that an iteration may take when so many are left, if it is not the last: the share of the rest that
/// [`iteration_samples`] means it to have. Where paths begin to be split, samples may cost several times what they did.
pub fn iteration_seconds(left: f64) -> f64 {
    left / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_task_of_a_pass() {
        for (width, height) in [(1, 1), (33, 31), (320, 180), (1000, 700)] {
            let tiling = Tiling::new(width, height);
            let mut seen = vec![0; (width * height) as usize];
            for tile in rounds(&tiling.pass(0, tiling.samples), ROUND_PATHS).iter().flatten().map(|task| task.tile) {
                for y in tile.y..tile.y + tile.height {
                    (tile.x..tile.x + tile.width).for_each(|x| seen[(y * width + x) as usize] += 1);
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}×{height}");
        }
    }

    /// Largest difference, in tiles, between how many of a stretch of a pass lie in a part of the picture and how many
    /// would if they were spread evenly. The parts are thirds and halves of the picture, across and down.
    fn unevenness(tiling: &Tiling, order: &[Task]) -> f64 {
        let (columns, rows) = tiling.size_in_tiles();
        let mut worst = 0.0f64;
        for (parts, part) in [2, 3].into_iter().flat_map(|parts| (0..parts).map(move |part| (parts, part))) {
            let within = |at: u32, side: u32| at * parts / side == part;
            let across = |t: &Task| within(t.tile.x / tiling.side, columns);
            let down = |t: &Task| within(t.tile.y / tiling.side, rows);
            for is_in in [&across as &dyn Fn(&Task) -> bool, &down] {
                let share = order.iter().filter(|task| is_in(task)).count() as f64 / order.len() as f64;
                let mut count = 0;
                for (length, task) in (1..).zip(order) {
                    count += u32::from(is_in(task));
                    worst = worst.max((f64::from(count) - share * f64::from(length)).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn every_stretch_of_a_pass_covers_the_picture_evenly() {
        for (width, height) in [(320, 180), (720, 1280), (1280, 720), (1920, 1080), (3840, 2160)] {
            let tiling = Tiling::new(width, height);
            for first_sample in [0, 1, 3, 4, 7, 1000] {
                let pass = tiling.pass(first_sample, 1);
                // a lattice is off by no more than lies along an edge of the part, where rows are off by a share of all
                let bound = (pass.len() as f64).sqrt();
                let (found, mut by_rows) = (unevenness(&tiling, &pass), pass.clone());
                assert!(found <= bound, "{width}×{height} from {first_sample}: {found:.1} tiles, {bound:.1} allowed");
                by_rows.sort_by_key(|task| (task.tile.y, task.tile.x));
                assert!(unevenness(&tiling, &by_rows) > 1.5 * bound, "row by row, and unseen");
            }
        }
    }

    #[test]
    fn passes_begin_in_different_places() {
        let tiling = Tiling::new(1280, 720);
        let firsts: std::collections::BTreeSet<_> =
            (0..64).map(|sample| tiling.pass(sample, 1)[0].tile).map(|tile| (tile.x, tile.y)).collect();
        assert_eq!(firsts.len(), 64);
    }

    #[test]
    fn blocks_give_every_pixel_each_of_its_samples_once_and_end_before_the_next_begins() {
        for (width, height, spp) in [(1, 1, 1), (33, 31, 5), (320, 90, 32), (90, 320, 7), (1000, 700, 3)] {
            let tiling = Tiling::new(width, height);
            let mut seen = vec![Vec::new(); (width * height) as usize];
            let mut order: Vec<Tile> = Vec::new();
            for task in tiling.blocks(spp, ONLINE_ROUND_PATHS).iter().flatten() {
                let Tile { x, y, width: w, height: h } = task.tile;
                for i in (y..y + h).flat_map(|y| (x..x + w).map(move |x| y * width + x)) {
                    seen[i as usize].extend(task.first_sample..task.first_sample + task.samples);
                }
                if order.last() != Some(&task.tile) {
                    order.push(task.tile);
                }
            }
            let all: Vec<u32> = (0..spp).collect();
            assert!(seen.iter().all(|samples| *samples == all), "{width}×{height}, {spp} spp");
            assert_eq!(order.len(), tiling.pass(0, 1).len(), "no block is taken up again");
        }
    }

    #[test]
    fn blocks_go_from_the_middle_outwards() {
        let tiling = Tiling::new(320, 320);
        let distance = |t: &Task| (t.tile.x as i32 - 160).abs().max((t.tile.y as i32 - 160).abs());
        let distances: Vec<i32> = tiling.blocks(1, 1).iter().flatten().map(distance).collect();
        assert!(distances.is_sorted(), "{distances:?}");
    }

    #[test]
    fn rounds_are_as_long_as_asked_and_stretches_hold_whole_blocks() {
        let tiling = Tiling::new(320, 180);
        for spp in [1, 16, 32, 256] {
            let stretches = tiling.blocks(spp, ONLINE_ROUND_PATHS);
            let paths = |tasks: &Vec<Task>| tasks.iter().map(Task::paths).sum::<usize>();
            let (last, others) = stretches.split_last().unwrap();
            assert!(others.iter().all(|s| paths(s) >= ONLINE_ROUND_PATHS), "{spp} spp");
            assert!(last.iter().all(|task| others.iter().flatten().all(|other| other.tile != task.tile)));
            for stretch in &stretches {
                let cut = rounds(stretch, ONLINE_ROUND_PATHS);
                assert_eq!(cut.concat(), *stretch);
                assert!(
                    cut.iter()
                        .rev()
                        .skip(1)
                        .all(|r| paths(r) >= ONLINE_ROUND_PATHS && paths(r) < 2 * ONLINE_ROUND_PATHS)
                );
            }
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

    #[test]
    fn no_iteration_but_the_last_is_cut_short_where_samples_cost_what_they_did() {
        for left in 1..500 {
            for planned in 1..=left {
                let cut = planned as f64 > iteration_seconds(left as f64);
                assert!(!cut || iteration_samples(planned, left) == left, "{planned} of {left}");
            }
        }
    }
}
