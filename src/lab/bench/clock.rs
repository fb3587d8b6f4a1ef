//! What the time of batches goes into.
//!
//! Every batch is stamped where it goes from stage to stage, a few times in a wave. That cannot tell apart what is done
//! vertex by vertex, and a stamp there takes about as long as the work. So about half of the batches, by a hash of their
//! place, get stamps at every vertex too. From these only the *proportions* within the shading pass are taken, after
//! the cost of a stamp is taken off each; all times are those of the other batches.
//!
//! What a stamp costs, in place, is the time by which a ray's shading is slower where there are stamps, over the number
//! of stamps: of medians over batches, as some are interrupted by the system. It is no less than what stamps cost
//! without any work between them, and no more than the mean interval that the shortest stage ends with one. It differs
//! a little from place to place: a stage within shading is known to some nanoseconds a vertex.

use crate::embree::{Coherence, HitBatch, Scene};
use crate::integrator::Task;
use crate::integrator::probe::{Cast, Probe, Stage, Watch};
use crate::math::rng::mix;
use crate::stats::Median;
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
pub(crate) struct Clock {
    /// Batches without and with stamps at vertices.
    batches: Mutex<[Vec<Totals>; 2]>,
}

/// How the time of batches is divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Split {
    /// In the order of [`Stage::ALL`]; they sum to 1.
    pub(crate) shares: [f64; STAGES],
    /// What a stamp at a vertex cost, in nanoseconds; it is in none of the shares.
    pub(crate) stamp_nanoseconds: f64,
}

impl Clock {
    /// # Errors
    /// Where the render had too few batches for both kinds of stamps.
    pub(crate) fn split(self) -> Result<Split> {
        let [coarse, fine] = self.batches.into_inner().expect("no thread fails while it holds the lock");
        let stamp = Median::of(&per_ray(&coarse)).zip(Median::of(&per_ray(&fine)));
        let Some((plain, stamped)) = stamp.map(|(plain, stamped)| (plain.median, stamped.median)) else {
            return Err(Error::Scene("too few samples to tell stages apart: more pixels, or more of each".into()));
        };
        let (coarse, fine) = (sum(&coarse), sum(&fine));
        let per_ray = fine.shading.stamps.iter().sum::<u64>() as f64 / fine.rays as f64;
        let stamp = ((stamped - plain) / per_ray).max(bare_stamp()).min(shortest(&fine.shading));
        Ok(split(&coarse, &fine, stamp))
    }
}

fn sum(batches: &[Totals]) -> Totals {
    let mut sum = Totals::default();
    batches.iter().for_each(|batch| sum.add(batch));
    sum
}

/// Seconds of shading for each ray of each batch.
fn per_ray(batches: &[Totals]) -> Vec<f64> {
    let shaded = batches.iter().filter(|batch| batch.rays > 0);
    shaded.map(|batch| batch.shading.seconds.iter().sum::<f64>() / batch.rays as f64).collect()
}

/// Seconds of a stamp with nothing between it and the next: the least of some tries.
fn bare_stamp() -> f64 {
    const STAMPS: u32 = 1000;
    let try_once = |_| {
        let mut clock = BatchClock::new(true);
        let start = Instant::now();
        (0..STAMPS).for_each(|_| clock.step(Stage::Shade));
        start.elapsed().as_secs_f64() / STAMPS as f64
    };
    (0..20).map(try_once).fold(f64::INFINITY, f64::min)
}

/// Of the stages that occur, the least mean time from stamp to stamp.
fn shortest(times: &Times) -> f64 {
    let intervals = times.seconds.iter().zip(times.stamps).filter(|(_, n)| *n > 0).map(|(s, n)| s / n as f64);
    intervals.fold(f64::INFINITY, f64::min)
}

/// `stamp`: seconds of a stamp at a vertex.
fn split(coarse: &Totals, fine: &Totals, stamp: f64) -> Split {
    let shading: f64 = coarse.shading.seconds.iter().sum();
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
        BatchClock::new(mix(place) & 1 == 1)
    }

    fn end(&self, _task: &Task, mut probe: BatchClock) {
        probe.stamp();
        let mut batches = self.batches.lock().expect("no thread fails while it holds the lock");
        batches[probe.fine as usize].push(probe.totals);
    }
}

/// The clock of one batch.
pub(crate) struct BatchClock {
    fine: bool,
    shading: bool,
    stage: Stage,
    since: Instant,
    totals: Totals,
}

impl BatchClock {
    fn new(fine: bool) -> BatchClock {
        let (since, totals) = (Instant::now(), Totals::default());
        BatchClock { fine, shading: false, stage: Stage::Generate, since, totals }
    }

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

    /// Batches of 100 rays: without stamps shading takes 3 s; with them 1 s more for 200 stamps, of which 100 end 2 s
    /// of shading and 100 the guide's 1 s. Intersecting takes as long as shading.
    fn planted(with_guide: bool) -> Clock {
        let coarse = Totals { rays: 100, outside: at(Stage::Intersect, 3.0, 9), shading: at(Stage::Shade, 3.0, 1) };
        let mut shading = at(Stage::Shade, 2.0 + 0.5, 100);
        shading.add(&at(if with_guide { Stage::Guide } else { Stage::Shade }, 1.0 + 0.5, 100));
        let fine = Totals { rays: 100, outside: Times::default(), shading };
        let clock = Clock::default();
        *clock.batches.lock().unwrap() = [vec![coarse; 5], vec![fine; 5]];
        clock
    }

    #[test]
    fn a_planted_cost_of_stamps_is_found_and_taken_off() {
        let split = planted(true).split().unwrap();
        assert!((split.stamp_nanoseconds - 5e6).abs() < 1.0, "{split:?}");
        let share = |stage: Stage| split.shares[stage as usize];
        assert!((share(Stage::Intersect) - 0.5).abs() < 1e-9);
        assert!((share(Stage::Guide) - 1.0 / 6.0).abs() < 1e-9 && (share(Stage::Shade) - 1.0 / 3.0).abs() < 1e-9);
        assert!((split.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(planted(false).split().unwrap().shares[Stage::Guide as usize], 0.0);
    }

    #[test]
    fn a_batch_that_was_interrupted_does_not_change_what_a_stamp_costs() {
        let clock = planted(true);
        clock.batches.lock().unwrap()[1][2].shading.seconds[Stage::Shade as usize] += 40.0;
        assert!((clock.split().unwrap().stamp_nanoseconds - 5e6).abs() < 1.0);
    }

    #[test]
    fn a_stamp_costs_no_more_than_the_shortest_stage() {
        let clock = planted(true);
        // the machine was slow for all batches with stamps, but for the guide
        for batch in &mut clock.batches.lock().unwrap()[1] {
            batch.shading.seconds[Stage::Shade as usize] += 40.0;
        }
        let split = clock.split().unwrap();
        assert!((split.stamp_nanoseconds - 1.5e7).abs() < 1.0, "{split:?}");
    }

    #[test]
    fn one_kind_of_batches_is_too_few() {
        assert!(Clock::default().split().is_err());
    }
}
