//! What the time of batches goes into.
//!
//! Every batch is stamped where it goes from stage to stage, a few times in a wave. That cannot tell apart what is done
//! vertex by vertex, and a stamp there takes about as long as the work. So about half of the batches, by a hash of their
//! place, get stamps at every vertex too. From these only the *proportions* within the shading pass are taken, after
//! the cost of a stamp is taken off each; all times are those of the other batches. What a stamp costs, in place, is
//! the time by which shading is slower where there are stamps, over the number of stamps. It differs a little from place
//! to place: a stage within shading is known to a few nanoseconds a vertex.

use crate::embree::{Coherence, HitBatch, Scene};
use crate::integrator::Task;
use crate::integrator::probe::{Cast, Probe, Stage, Watch};
use crate::math::rng::mix;
use crate::{Error, Result};
use std::sync::Mutex;
use std::time::Instant;

const STAGES: usize = Stage::ALL.len();

/// Seconds in each stage and the stamps that ended them, in the order of [`Stage::ALL`].
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    seconds: [f64; STAGES],
    stamps: [u64; STAGES],
}

impl Times {
    fn add(&mut self, other: &Times) {
        for k in 0..STAGES {
            self.seconds[k] += other.seconds[k];
            self.stamps[k] += other.stamps[k];
        }
    }
}

/// Times of some batches.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    /// Rays that were shaded.
    rays: u64,
    /// Outside of the shading pass.
    outside: Times,
    /// Within it; all is [`Stage::Shade`] where vertices are not stamped.
    shading: Times,
}

impl Totals {
    fn add(&mut self, other: &Totals) {
        self.rays += other.rays;
        self.outside.add(&other.outside);
        self.shading.add(&other.shading);
    }
}

/// Watches a render's time.
#[derive(Default)]
pub struct Clock {
    /// Of batches without and with stamps at vertices.
    totals: Mutex<[Totals; 2]>,
}

/// How the time of batches is divided.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// In the order of [`Stage::ALL`]; they sum to 1.
    pub shares: [f64; STAGES],
    /// What a stamp at a vertex cost, in nanoseconds; it is in none of the shares.
    pub stamp_nanoseconds: f64,
}

impl Clock {
    /// # Errors
    /// Where the render had too few batches for both kinds of stamps.
    pub fn split(self) -> Result<Split> {
        let [coarse, fine] = self.totals.into_inner().expect("no thread fails while it holds the lock");
        if coarse.rays == 0 || fine.rays == 0 {
            return Err(Error::Scene("too few samples to tell stages apart: more pixels, or more of each".into()));
        }
        Ok(split(&coarse, &fine))
    }
}

fn split(coarse: &Totals, fine: &Totals) -> Split {
    let shading: f64 = coarse.shading.seconds.iter().sum();
    let stamped: f64 = fine.shading.seconds.iter().sum();
    let stamps: u64 = fine.shading.stamps.iter().sum();
    let unstamped = shading * fine.rays as f64 / coarse.rays as f64;
    let stamp = ((stamped - unstamped) / stamps.max(1) as f64).max(0.0);
    let own: [f64; STAGES] =
        std::array::from_fn(|k| (fine.shading.seconds[k] - stamp * fine.shading.stamps[k] as f64).max(0.0));
    let sum: f64 = own.iter().sum();
    let seconds: [f64; STAGES] = std::array::from_fn(|k| coarse.outside.seconds[k] + shading * own[k] / sum);
    let all: f64 = seconds.iter().sum();
    Split { shares: seconds.map(|s| s / all), stamp_nanoseconds: stamp * 1e9 }
}

impl Watch for Clock {
    type Probe = BatchClock;

    fn begin(&self, task: &Task) -> BatchClock {
        let place = (task.tile.x as u64) << 40 ^ (task.tile.y as u64) << 20 ^ task.first_sample as u64;
        let (fine, stage) = (mix(place) & 1 == 1, Stage::Generate);
        BatchClock { fine, shading: false, stage, since: Instant::now(), totals: Totals::default() }
    }

    fn end(&self, _task: &Task, mut probe: BatchClock) {
        probe.stamp();
        let mut totals = self.totals.lock().expect("no thread fails while it holds the lock");
        totals[probe.fine as usize].add(&probe.totals);
    }
}

/// The clock of one batch.
pub struct BatchClock {
    fine: bool,
    shading: bool,
    stage: Stage,
    since: Instant,
    totals: Totals,
}

impl BatchClock {
    /// Ends the stage under way.
    #[inline]
    fn stamp(&mut self) {
        let now = Instant::now();
        let times = if self.shading { &mut self.totals.shading } else { &mut self.totals.outside };
        times.seconds[self.stage as usize] += (now - self.since).as_secs_f64();
        times.stamps[self.stage as usize] += 1;
        self.since = now;
    }
}

impl Probe for BatchClock {
    fn trace(&mut self, cast: Cast<HitBatch>, scene: &Scene, coherence: Coherence) {
        self.totals.rays += cast.rays.len() as u64;
        cast.rays.trace(scene, coherence);
    }

    #[inline]
    fn stage(&mut self, stage: Stage) {
        self.stamp();
        (self.stage, self.shading) = (stage, stage == Stage::Shade);
    }

    #[inline]
    fn step(&mut self, stage: Stage) {
        if self.fine {
            self.stamp();
            self.stage = stage;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(stage: Stage, seconds: f64, stamps: u64) -> Times {
        let mut times = Times::default();
        times.seconds[stage as usize] = seconds;
        times.stamps[stage as usize] = stamps;
        times
    }

    #[test]
    fn stages_stand_in_their_order() {
        Stage::ALL.iter().enumerate().for_each(|(k, stage)| assert_eq!(*stage as usize, k));
    }

    #[test]
    fn a_planted_cost_of_stamps_is_found_and_taken_off() {
        // Without stamps shading takes 3 s for 100 rays; with them 200 rays take 6 s and 300 stamps of 10 ms more.
        // Of the 6 s, 4 are shading, 2 the guide; intersecting takes as long as shading.
        let coarse = Totals { rays: 100, outside: at(Stage::Intersect, 3.0, 9), shading: at(Stage::Shade, 3.0, 1) };
        let mut shading = at(Stage::Shade, 4.0 + 2.0, 200);
        shading.add(&at(Stage::Guide, 2.0 + 1.0, 100));
        let fine = Totals { rays: 200, outside: Times::default(), shading };
        let split = split(&coarse, &fine);
        assert!((split.stamp_nanoseconds - 1e7).abs() < 1.0, "{split:?}");
        let share = |stage: Stage| split.shares[stage as usize];
        assert!((share(Stage::Intersect) - 0.5).abs() < 1e-12);
        assert!((share(Stage::Guide) - 1.0 / 6.0).abs() < 1e-12 && (share(Stage::Shade) - 1.0 / 3.0).abs() < 1e-12);
        assert!((split.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_kind_of_batches_is_too_few() {
        assert!(Clock::default().split().is_err());
    }
}
