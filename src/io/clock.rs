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

/// Date and time of day in UTC, as ISO 8601 has them: 2026-11-30T16:05:09Z.
pub(crate) fn utc_now() -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    utc(since.map_or(0, |since| since.as_secs()))
}

/// The same of seconds since 1970. Days are counted in eras of 400 years that begin on a 1 March, so that leap days come last (Hinnant,
/// "chrono-Compatible Low-Level Date Algorithms").
fn utc(seconds: u64) -> String {
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = year + 400 * era + u64::from(month <= 2);
    let [hour, minute, second] = [seconds / 3600 % 24, seconds / 60 % 60, seconds % 60];
    format!("{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

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
    fn dates_are_those_of_the_calendar() {
        // by `date -u -d @…`
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_796_054_709, "2026-11-30T16:05:09Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc(seconds), date);
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
