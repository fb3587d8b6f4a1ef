//! Processor time and memory of the process, as Linux tells them.

use crate::{Error, Result};
use std::path::Path;

/// Seconds of processor time, user and system.
#[derive(Clone, Copy, Debug)]
pub struct CpuTimes {
    /// Of this process, all threads.
    pub own: f64,
    /// Of the programs that it has started and waited for.
    pub children: f64,
}

/// `/proc` counts in hundredths of a second, whatever the kernel's own clock (USER_HZ, proc(5)).
const TICKS: f64 = 100.0;

/// # Errors
/// Where the system has no `/proc`.
pub fn times() -> Result<CpuTimes> {
    let path = Path::new("/proc/self/stat");
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    parse(&text).ok_or_else(|| Error::file(path, "no processor times in it"))
}

fn parse(stat: &str) -> Option<CpuTimes> {
    // the second field is a name in brackets that may itself hold blanks and brackets; utime is the 14th
    let (_, rest) = stat.rsplit_once(')')?;
    let ticks: Vec<f64> = rest.split_whitespace().skip(11).take(4).map_while(|field| field.parse().ok()).collect();
    let [user, system, children_user, children_system] = ticks[..] else { return None };
    Some(CpuTimes { own: (user + system) / TICKS, children: (children_user + children_system) / TICKS })
}

/// The most memory that the process has had at once, in bytes; `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_behind_a_name_with_brackets() {
        let times = parse("1 (a) b) S 2 3 4 5 6 7 8 9 10 11 250 50 30 20 99").unwrap();
        assert!((times.own - 3.0).abs() < 1e-12 && (times.children - 0.5).abs() < 1e-12, "{times:?}");
        assert!(parse("1 (a) S 2").is_none() && parse("").is_none());
    }
}
