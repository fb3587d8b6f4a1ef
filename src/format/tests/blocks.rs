//! Whether pictures of one scene are the same but for noise: by the means of blocks of pixels in independent runs.

use crate::film::tile::Tile;
use crate::format::SceneFile;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::math::luminance;
use crate::stats::Summary;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Independent runs, and samples per pixel of each.
pub(crate) const RUNS: usize = 16;
pub(crate) const SPP: u32 = 100;

/// Blocks of a picture: four columns and three rows.
pub(crate) const BLOCKS: usize = 12;

/// All tests of one kind together raise a false alarm with this probability, were they independent.
const FALSE_ALARM: f64 = 1e-3;

/// By run, the mean luminance of each block.
pub(crate) fn runs(file: &SceneFile, first_seed: u64) -> Vec<Vec<f64>> {
    runs_of(file, first_seed, SPP)
}

/// The same with so many samples per pixel in each run.
pub(crate) fn runs_of(file: &SceneFile, first_seed: u64, spp: u32) -> Vec<Vec<f64>> {
    let scene = file.load_scene(1).unwrap().0;
    let (width, height) = (scene.camera.width, scene.camera.height);
    let task = Task { tile: Tile { x: 0, y: 0, width, height }, first_sample: 0, samples: spp };
    let run = |run: usize| {
        let integrator = PathIntegrator::plain(&scene, &file.integrator, first_seed + run as u64);
        let sums = integrator.render(&task, &mut Batch::new()).samples.sum;
        let (width, height) = (width as usize, height as usize);
        let unit = scene.light_unit().value() / f64::from(spp);
        let pixel = |x: usize, y: usize| f64::from(luminance(sums[y * width + x])) * unit;
        let block = |k: usize| {
            let columns = k % 4 * width / 4..(k % 4 + 1) * width / 4;
            let rows = k / 4 * height / 3..(k / 4 + 1) * height / 3;
            let count = columns.len() * rows.len();
            let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
            pixels.map(|(x, y)| pixel(x, y)).sum::<f64>() / count as f64
        };
        (0..BLOCKS).map(block).collect()
    };
    (0..RUNS).map(run).collect()
}

/// The largest t of a block, and by how much the means over all differ, in shares of the second.
pub(crate) fn compare(first: &[Vec<f64>], second: &[Vec<f64>]) -> (f64, f64) {
    let block = |runs: &[Vec<f64>], k: usize| Summary::of(&runs.iter().map(|run| run[k]).collect::<Vec<_>>()).unwrap();
    let t = |k: usize| {
        let (a, b) = (block(first, k), block(second, k));
        let error = a.std_error().hypot(b.std_error());
        let off = (a.mean - b.mean).abs();
        if off <= 1e-6 * b.mean.abs() { 0.0 } else { off / error }
    };
    let mean = |runs: &[Vec<f64>]| runs.iter().flatten().sum::<f64>();
    ((0..BLOCKS).map(t).fold(0.0, f64::max), mean(first) / mean(second) - 1.0)
}

/// The standard error of the mean over all, in shares of it.
pub(crate) fn error_of_mean(runs: &[Vec<f64>]) -> f64 {
    let means: Vec<f64> = runs.iter().map(|run| run.iter().sum()).collect();
    let summary = Summary::of(&means).unwrap();
    summary.std_error() / summary.mean
}

/// What t may be where so many blocks are compared: 15 degrees of freedom, the fewest that Welch's test may have of 16 runs.
pub(crate) fn bound(blocks: usize) -> f64 {
    let student = StudentsT::new(0.0, 1.0, RUNS as f64 - 1.0).unwrap();
    student.inverse_cdf(1.0 - 0.5 * FALSE_ALARM / blocks as f64)
}
