//! Processor time of other programs and memory of this one, as Linux tells them.

use crate::io::clock::CpuTime;
use crate::{Error, Result};
use std::path::Path;

/// `/proc` counts in hundredths of a second, whatever the kernel's own clock (USER_HZ, proc(5)).
const TICKS: f64 = 100.0;

/// Processor time, user and system, of the programs that this one has started and waited for.
///
/// # Errors
/// Where the system has no `/proc`.
pub(crate) fn of_children() -> Result<CpuTime> {
    let path = Path::new("/proc/self/stat");
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    parse(&text).ok_or_else(|| Error::file(path, "no processor times in it"))
}

fn parse(stat: &str) -> Option<CpuTime> {
    // the second field is a name in brackets that may itself hold blanks and brackets; cutime is the 16th
    let (_, rest) = stat.rsplit_once(')')?;
    let ticks: Vec<u32> = rest.split_whitespace().skip(13).take(2).map_while(|field| field.parse().ok()).collect();
    let [user, system] = ticks[..] else { return None };
    Some(CpuTime::from_seconds((f64::from(user) + f64::from(system)) / TICKS))
}

/// The most memory that the process has had at once, in bytes; `None` where the system does not tell.
pub(crate) fn peak_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| 1024 * kib)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_behind_a_name_with_brackets() {
        let time = parse("1 (a) b) S 2 3 4 5 6 7 8 9 10 11 250 50 30 20 99").unwrap();
        assert!((time.seconds() - 0.5).abs() < 1e-9, "{time:?}");
        assert!(parse("1 (a) S 2").is_none() && parse("").is_none());
    }
}
