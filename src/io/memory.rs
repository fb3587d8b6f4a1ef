//! What memory there is. Sizes that files and settings claim are held against it before it is asked for: Rust's
//! allocator ends the process where there is none, and Linux ends it where memory was promised that is not there.

use crate::{Error, Result};
use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Text that people write, scenes and plans and materials, is no longer than this.
pub(crate) const LONGEST_TEXT: u64 = 256 << 20;

/// Requests up to this are not worth asking the system about.
const SMALL: u64 = 16 << 20;

/// More memory than there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shortage {
    pub(crate) needed: u64,
    /// `None` where the system does not say, but refuses.
    pub(crate) free: Option<u64>,
}

impl fmt::Display for Shortage {
    /// The end of a sentence of which the subject is what takes the memory.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "take {}, ", text(self.needed))?;
        match self.free {
            Some(free) => write!(f, "{} are free", text(free)),
            None => write!(f, "more than the system gives"),
        }
    }
}

/// Whether `bytes` more can be had now.
///
/// # Errors
/// Where that is more than [`free`], or than the allocator gives in one piece.
pub(crate) fn check(bytes: u64) -> Result<(), Shortage> {
    if bytes <= SMALL {
        return Ok(());
    }
    let free = free();
    if free.is_some_and(|free| bytes > free) {
        return Err(Shortage { needed: bytes, free });
    }
    // Address space costs nothing until it is written to.
    let given = usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if given { Ok(()) } else { Err(Shortage { needed: bytes, free: None }) }
}

/// All bytes of a file that has `most` at most.
///
/// # Errors
/// Those of reading; a longer file, and one that does not fit into memory, before it is read.
pub(crate) fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(Error::io(path))?;
    let length = file.metadata().map_err(Error::io(path))?.len();
    let too_long = || Error::file(path, format!("the file is longer than {}", text(most)));
    if length > most {
        return Err(too_long());
    }
    check(length).map_err(|shortage| Error::file(path, format!("its bytes {shortage}")))?;
    let mut bytes = Vec::new();
    // Pipes and devices do not say how long they are.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Error::io(path))?;
    if bytes.len() as u64 > most { Err(too_long()) } else { Ok(bytes) }
}

/// Bytes that this process can still take without swapping: the least of what the machine has left (`MemAvailable`), what
/// the control groups of the process leave (versions 1 and 2), and its own limit of address space. `None` on systems
/// other than Linux.
pub(crate) fn free() -> Option<u64> {
    let machine = read("/proc/meminfo").and_then(|text| kibibytes(&text, "MemAvailable:"));
    [machine, groups(), address_space()].into_iter().flatten().min()
}

/// What is left of `ulimit -v`.
fn address_space() -> Option<u64> {
    let limits = read("/proc/self/limits")?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kibibytes(&read("/proc/self/status")?, "VmSize:")?))
}

/// What is left in the tightest control group.
fn groups() -> Option<u64> {
    read("/proc/self/cgroup")?.lines().filter_map(group).min()
}

/// Of a line `number:controllers:path`; the groups around that group limit it too.
fn group(line: &str) -> Option<u64> {
    let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
    let (root, names) = match controllers {
        "" => ("/sys/fs/cgroup", ["memory.max", "memory.current", ""]),
        c if c.split(',').any(|c| c == "memory") => {
            ("/sys/fs/cgroup/memory", ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_"])
        }
        _ => return None,
    };
    let own = Path::new(path.trim_start_matches('/'));
    // A container's own root is mounted where the machine's is, and its path may be one outside of it.
    own.ancestors().filter_map(|folder| left(&Path::new(root).join(folder), names)).min()
}

/// Files in the cache of a group are let go when memory is asked for.
fn left(folder: &Path, [limit, usage, prefix]: [&str; 3]) -> Option<u64> {
    let number = |name: &str| read(folder.join(name))?.trim().parse::<u64>().ok();
    let (limit, usage) = (number(limit)?, number(usage)?);
    let stat = read(folder.join("memory.stat")).unwrap_or_default();
    let cached = |name: &str| {
        let name = format!("{prefix}{name} ");
        stat.lines().find_map(|line| line.strip_prefix(&name)?.trim().parse::<u64>().ok()).unwrap_or(0)
    };
    let held = usage.saturating_sub(cached("inactive_file") + cached("active_file"));
    Some(limit.saturating_sub(held))
}

/// A line like `MemAvailable:   1234 kB`, in bytes.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}

fn read(path: impl AsRef<Path>) -> Option<String> {
    fs::read_to_string(path).ok()
}

/// For people: three digits and a unit.
pub(crate) fn text(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let step = (bytes.max(1).ilog2() / 10) as usize;
    let value = bytes as f64 / 1024f64.powi(step as i32);
    let digits = if step == 0 || value >= 100.0 { 0 } else { 1 + usize::from(value < 10.0) };
    format!("{value:.digits$} {}", units[step])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_free_is_known_and_bounds_what_is_given() {
        let Some(free) = free() else {
            eprintln!("SKIPPED: this system does not say what memory is free");
            return;
        };
        assert_eq!(check(SMALL), Ok(()));
        assert_eq!(check(free / 4), Ok(()));
        let shortage = check(u64::MAX).unwrap_err();
        assert!(shortage.to_string().starts_with("take 16.0 EiB, "), "{shortage}");
        assert!(shortage.free.is_some());
    }

    #[test]
    fn limits_of_groups_are_read_without_their_cached_files() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        let version_2 = ["memory.max", "memory.current", ""];
        assert_eq!(left(folder.path(), version_2), None);
        write("memory.max", "max\n");
        write("memory.current", "700\n");
        assert_eq!(left(folder.path(), version_2), None);
        write("memory.max", "1000\n");
        assert_eq!(left(folder.path(), version_2), Some(300));
        write("memory.stat", "anon 5\nfile 9\ninactive_file 200\nactive_file 50\n");
        assert_eq!(left(folder.path(), version_2), Some(550));
        assert_eq!(left(folder.path(), ["memory.max", "memory.current", "total_"]), Some(300));
        write("memory.current", "5000\n");
        assert_eq!(left(folder.path(), version_2), Some(0));
    }

    #[test]
    fn files_are_read_up_to_a_length() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_file(&path, 5).unwrap(), b"12345");
        assert!(read_file(&path, 4).unwrap_err().to_string().ends_with("a: the file is longer than 4 B"));
        assert!(matches!(read_file(&folder.path().join("b"), 4), Err(Error::Io { .. })));
        let endless = Path::new("/dev/zero");
        if endless.exists() {
            assert!(read_file(endless, 100).unwrap_err().to_string().contains("longer"));
        }
    }

    #[test]
    fn sizes_are_written_as_people_read_them() {
        let cases = [(0, "0 B"), (1023, "1023 B"), (1536, "1.50 KiB"), (23 << 30, "23.0 GiB"), (412 << 30, "412 GiB")];
        cases.iter().for_each(|(bytes, wanted)| assert_eq!(text(*bytes), *wanted));
        assert_eq!(kibibytes("VmPeak:  9 kB\nVmSize:\t 12 kB\n", "VmSize:"), Some(12 << 10));
    }
}
