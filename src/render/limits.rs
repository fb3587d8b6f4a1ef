//! When a render ends, and when a pass is cut: by the budget of wall time, or by a wish to stop.

use super::schedule::iteration_seconds;
use crate::integrator::Stop;
use crate::io::clock::{CpuClock, CpuTime, WallClock};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Share of a time limit by which a pass may go beyond it. A pass that is longer is cut at the limit itself.
const LEEWAY: f64 = 0.01;

/// Tells threads to begin no further task.
#[derive(Clone, Copy)]
pub(super) struct PassEnd<'a> {
    pub stop: &'a Stop,
    /// When the pass under way is cut, if ever.
    pub deadline: Option<Instant>,
    /// Whether what was traced is to be learnt in any case, since the render is to go on later.
    pub learns_all: bool,
    /// Whether it comes between two rounds, unless it is urgent: a guide that learns from round to round can go on later
    /// only from there.
    pub between_rounds: bool,
}

impl PassEnd<'_> {
    /// Whether no further task is to begin. Threads ask between tasks, which take milliseconds.
    pub fn is_due(&self) -> bool {
        self.stop.is_due() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// The same in the middle of a round.
    pub fn cuts_round(&self) -> bool {
        if self.between_rounds { self.stop.is_urgent() } else { self.is_due() }
    }

    /// Whether nothing more is to be learnt.
    pub fn ends_learning(&self) -> bool {
        self.stop.is_urgent() && !self.learns_all
    }
}

/// Time that a render has taken, which goes on from there.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Spent {
    pub wall: WallClock,
    pub cpu: CpuTime,
}

/// What ends a render.
pub(super) struct Limits<'a> {
    /// Started with the render, both.
    pub clock: WallClock,
    cpu: CpuClock,
    /// Processor time before that, of a render that goes on.
    cpu_before: CpuTime,
    /// As in [`PassEnd`].
    pub learns_all: bool,
    /// Seconds of wall time that the render may take.
    pub seconds: Option<f64>,
    pub stop: &'a Stop,
    /// What the newest pass took; nothing before the first.
    pub newest_pass: Duration,
}

impl<'a> Limits<'a> {
    /// Of a render that begins now, and may take so many `seconds` of wall time.
    pub fn from_now(seconds: Option<f64>, stop: &'a Stop) -> Limits<'a> {
        Limits {
            clock: WallClock::start(),
            cpu: CpuClock::process(),
            cpu_before: CpuTime::default(),
            learns_all: false,
            seconds,
            stop,
            newest_pass: Duration::ZERO,
        }
    }

    /// The same of a render that goes on and has taken `spent` already.
    pub fn after(self, spent: Spent) -> Limits<'a> {
        Limits { clock: spent.wall, cpu_before: spent.cpu, ..self }
    }

    /// What the render has taken.
    pub fn spent(&self) -> Spent {
        Spent { wall: self.clock, cpu: self.cpu_before + self.cpu.elapsed() }
    }

    /// Seconds of wall time since the render began.
    pub fn elapsed(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    /// Share of the time that is used; 0 without a limit.
    pub fn share(&self) -> f64 {
        self.seconds.map_or(0.0, |limit| self.elapsed() / limit)
    }

    /// Seconds that are left of a limit.
    pub fn left(&self) -> Option<f64> {
        self.seconds.map(|limit| limit - self.elapsed())
    }

    /// Whether there is no time for another pass that takes as long as the last: where it can end near enough to the limit, if
    /// it would go beyond that by more than half of itself; where it will be cut, if nothing is left.
    pub fn time_is_up(&self) -> bool {
        let half = 0.5 * self.newest_pass.as_secs_f64();
        self.seconds
            .zip(self.left())
            .is_some_and(|(limit, left)| left <= if half <= LEEWAY * limit { half } else { 0.0 })
    }

    /// The end of a pass that may be cut by a wish to stop alone.
    pub fn uncut(&self) -> PassEnd<'a> {
        PassEnd { stop: self.stop, deadline: None, learns_all: self.learns_all, between_rounds: false }
    }

    /// The end of a pass that takes as long as the last.
    pub fn next_pass(&self) -> PassEnd<'a> {
        let deadline = self.seconds.and_then(|limit| {
            let short = 0.5 * self.newest_pass.as_secs_f64() <= LEEWAY * limit;
            self.clock.moment(limit + if short { LEEWAY * limit } else { 0.0 })
        });
        PassEnd { deadline, ..self.uncut() }
    }

    /// Whether an iteration that has taken `taken` so far has used all the time that it may, which only the last may go beyond.
    pub fn is_too_long(&self, taken: Duration) -> bool {
        let taken = taken.as_secs_f64();
        self.left().is_some_and(|left| iteration_seconds(left + taken) < taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit of 100 seconds, of which so many are gone, after a pass of `pass` seconds.
    fn limits(stop: &Stop, gone: f64, pass: f64) -> Limits<'_> {
        let clock = WallClock::started(Duration::from_secs_f64(gone));
        Limits { clock, newest_pass: Duration::from_secs_f64(pass), ..Limits::from_now(Some(100.0), stop) }
    }

    /// Seconds after which a pass that takes `pass` seconds is cut.
    fn cut(pass: f64) -> f64 {
        let (stop, now) = (Stop::new(), Instant::now());
        let deadline = limits(&stop, 0.0, pass).next_pass().deadline.unwrap();
        (deadline - now).as_secs_f64()
    }

    #[test]
    fn short_passes_end_nearest_to_the_limit() {
        let stop = Stop::new();
        assert!(!limits(&stop, 99.4, 1.0).time_is_up() && limits(&stop, 99.6, 1.0).time_is_up());
        assert!((cut(1.0) - 101.0).abs() < 0.1, "one that takes longer than expected is cut all the same");
    }

    #[test]
    fn long_passes_are_cut_at_the_limit() {
        let stop = Stop::new();
        assert!(!limits(&stop, 99.0, 30.0).time_is_up() && limits(&stop, 100.1, 30.0).time_is_up());
        assert!((cut(30.0) - 100.0).abs() < 0.1);
    }

    #[test]
    fn an_iteration_has_a_third_of_the_time_that_was_left_when_it_began() {
        let stop = Stop::new();
        let too_long = |taken| limits(&stop, 40.0 + taken, 1.0).is_too_long(Duration::from_secs_f64(taken));
        assert!(!too_long(19.9) && too_long(20.1));
    }

    #[test]
    fn a_limit_beyond_all_clocks_never_comes() {
        let stop = Stop::new();
        let limits = Limits::from_now(Some(1e300), &stop);
        assert_eq!(limits.next_pass().deadline, None);
        assert!(!limits.time_is_up() && !Limits { seconds: None, ..limits }.time_is_up());
    }
}
