//! Wall time and processor time. Each has its own type, so that the compiler keeps them apart: wall time is a
//! [`Duration`], processor time a [`CpuTime`].
//!
//! Reading a processor clock is a system call, some ten times as dear as reading the wall clock: it is for pieces of work
//! of a millisecond or more.

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::iter::Sum;
use std::marker::PhantomData;
use std::ops::{Add, AddAssign};
use std::time::{Duration, Instant};

/// Measures wall time: it goes on while threads sleep, wait, or have lost the processor to other programs. In a file it is the
/// time that has passed, and goes on from there when it is read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallClock {
    start: Instant,
    /// What had passed at the start.
    before: Duration,
}

impl WallClock {
    pub(crate) fn start() -> WallClock {
        WallClock::started(Duration::ZERO)
    }

    pub(crate) fn elapsed(self) -> Duration {
        self.start.elapsed().saturating_add(self.before)
    }

    /// The moment that is `seconds` after the start, or now if that is past; `None` where no clock reaches it.
    pub(crate) fn moment(self, seconds: f64) -> Option<Instant> {
        let duration = Duration::try_from_secs_f64(seconds).ok()?;
        self.start.checked_add(duration.saturating_sub(self.before))
    }

    /// A clock that has run for so long already.
    pub(crate) fn started(ago: Duration) -> WallClock {
        WallClock { start: Instant::now(), before: ago }
    }
}

impl Serialize for WallClock {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.elapsed().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for WallClock {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<WallClock, D::Error> {
        Duration::deserialize(deserializer).map(WallClock::started)
    }
}

/// Processor time, user and system: the sum over the threads that it was measured for.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct CpuTime(Duration);

impl CpuTime {
    pub(crate) fn seconds(self) -> f64 {
        self.0.as_secs_f64()
    }

    pub(crate) fn from_seconds(seconds: f64) -> CpuTime {
        CpuTime(Duration::from_secs_f64(seconds))
    }

    /// The difference, or zero where `part` is more than all.
    pub(crate) fn without(self, part: CpuTime) -> CpuTime {
        CpuTime(self.0.saturating_sub(part.0))
    }
}

impl Add for CpuTime {
    type Output = CpuTime;

    fn add(self, other: CpuTime) -> CpuTime {
        CpuTime(self.0 + other.0)
    }
}

impl AddAssign for CpuTime {
    fn add_assign(&mut self, other: CpuTime) {
        self.0 += other.0;
    }
}

impl Sum for CpuTime {
    fn sum<I: Iterator<Item = CpuTime>>(times: I) -> CpuTime {
        times.fold(CpuTime::default(), Add::add)
    }
}

/// Measures processor time. It is read by the thread that started it, and cannot be sent to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CpuClock {
    id: ClockId,
    start: Duration,
    stays_here: PhantomData<*const ()>,
}

impl CpuClock {
    /// Of the calling thread alone (`CLOCK_THREAD_CPUTIME_ID`).
    pub(crate) fn thread() -> CpuClock {
        CpuClock::of(ClockId::ThreadCPUTime)
    }

    /// Of all threads of the process (`CLOCK_PROCESS_CPUTIME_ID`).
    pub(crate) fn process() -> CpuClock {
        CpuClock::of(ClockId::ProcessCPUTime)
    }

    fn of(id: ClockId) -> CpuClock {
        CpuClock { id, start: now(id), stays_here: PhantomData }
    }

    pub(crate) fn elapsed(self) -> CpuTime {
        CpuTime(now(self.id).saturating_sub(self.start))
    }
}

fn now(id: ClockId) -> Duration {
    let time = clock_gettime(id);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps the calling thread busy until it has used so much processor time.
    fn work(seconds: f64) {
        let clock = CpuClock::thread();
        while clock.elapsed().seconds() < seconds {
            std::hint::spin_loop();
        }
    }

    #[test]
    fn a_sleeping_thread_costs_wall_time_and_no_processor_time() {
        let (wall, cpu) = (WallClock::start(), CpuClock::thread());
        std::thread::sleep(Duration::from_millis(200));
        let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu.elapsed().seconds());
        assert!(wall >= 0.2 && cpu < 0.1, "{wall} s of wall time, {cpu} s of processor time");
    }

    #[test]
    fn a_thread_counts_its_own_work_and_the_process_that_of_all() {
        let (thread, process) = (CpuClock::thread(), CpuClock::process());
        std::thread::scope(|scope| (0..2).for_each(|_| drop(scope.spawn(|| work(0.1)))));
        let (thread, process) = (thread.elapsed().seconds(), process.elapsed().seconds());
        assert!(process >= 0.2 && thread < 0.1, "{process} s of the process, {thread} s of the waiting thread");
    }

    #[test]
    fn times_add_up_and_never_become_negative() {
        let [one, two] = [1.0, 2.0].map(CpuTime::from_seconds);
        assert_eq!([one, two].into_iter().sum::<CpuTime>().seconds(), 3.0);
        assert_eq!((two.without(one).seconds(), one.without(two).seconds()), (1.0, 0.0));
        assert!(WallClock::start().moment(1e300).is_none() && WallClock::start().moment(1.0).is_some());
    }
}
