//! Renders of one scene with other seeds, joined.

use super::onlooker::in_watts;
use super::schedule::Tiling;
use super::{Checkpoint, IterationReport, Rendering};
use crate::film::JointFilm;
use crate::io::clock::CpuTime;
use crate::scene::Scene;

/// Several renders as one.
pub(crate) struct Merged {
    film: JointFilm,
    seeds: Vec<u64>,
    iterations: Vec<IterationReport>,
    training: Vec<IterationReport>,
    samples: u32,
    wall_seconds: f64,
    cpu: CpuTime,
    /// Pixels along the tiles that have different numbers of samples in one of them.
    adaptive_tiles: Option<u32>,
}

impl Merged {
    /// Begins with one.
    pub(crate) fn new(first: Checkpoint) -> Merged {
        let Checkpoint { state, record, spent, .. } = first;
        let (samples, height) = (state.samples(), (state.pixels / u64::from(state.width)) as u32);
        let adaptive_tiles = state.is_allotted().then(|| Tiling::new(state.width, height).side());
        let mut iterations = state.iterations;
        iterations.push(record.report);
        let training = state.training;
        let (wall_seconds, cpu) = (spent.wall.elapsed().as_secs_f64(), spent.cpu);
        Merged {
            film: state.film.into_joint(),
            seeds: vec![state.seed],
            iterations,
            training,
            samples,
            wall_seconds,
            cpu,
            adaptive_tiles,
        }
    }

    /// Adds another.
    ///
    /// # Errors
    /// Where it drew the same random numbers as one of those before.
    pub(crate) fn add(&mut self, other: Checkpoint) -> Result<(), String> {
        if self.seeds.contains(&other.state.seed) {
            return Err("its render has the same seed as another: its samples would be the same again".into());
        }
        let other = Merged::new(other);
        self.film.join(other.film);
        self.seeds.extend(other.seeds);
        self.iterations.extend(other.iterations);
        self.training.extend(other.training);
        self.samples = self.samples.saturating_add(other.samples);
        self.wall_seconds += other.wall_seconds;
        self.cpu += other.cpu;
        self.adaptive_tiles = self.adaptive_tiles.or(other.adaptive_tiles);
        Ok(())
    }

    /// The picture, and what is to be said of all renders together.
    pub(crate) fn finish(self, scene: &Scene) -> Rendering {
        Rendering {
            estimate: in_watts(self.film.finish(), scene.light_unit()),
            iterations: self.iterations,
            training: self.training,
            samples: self.samples,
            wall_seconds: self.wall_seconds,
            cpu: self.cpu,
            film_wall_seconds: 0.0,
            guide: None,
            verdict: None,
            learnt_paths: 0,
            relative_error: None,
            adaptive_tiles: self.adaptive_tiles,
        }
    }
}

#[cfg(test)]
#[path = "merge_tests.rs"]
mod tests;
