//! How much memory the process holds, as Linux tells it.

use std::fs;

/// Begins to look for the most memory held; returns whether the system can tell.
pub(crate) fn reset_peak() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// Bytes of main memory that the process held at most since [`reset_peak`]; `None` on systems that do not say.
pub(crate) fn peak() -> Option<u64> {
    field(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// A line like `VmHWM:     1234 kB`, in bytes.
fn field(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_in_bytes() {
        let status = "VmPeak:\t  9 kB\nVmHWM:\t  1234 kB\nThreads:\t2\n";
        assert_eq!(field(status, "VmHWM:"), Some(1234 << 10));
        assert_eq!((field(status, "VmRSS:"), field(status, "Threads:")), (None, None));
    }

    #[test]
    fn what_is_held_shows_in_the_peak() {
        if !reset_peak() {
            eprintln!("SKIPPED: this system does not let a program begin its peak of memory anew");
            return;
        }
        let held = vec![1u8; 64 << 20];
        assert!(held.iter().all(|b| *b == 1));
        assert!(peak().is_some_and(|bytes| bytes >= 64 << 20), "{:?}", peak());
    }
}
