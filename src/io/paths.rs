//! File names as people write them: with backslashes, in the wrong case, from another machine.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Component, Path, PathBuf};

/// The file that `name`, written in a file in `folder`, means; where there is none, the path where it would be. Names are bytes:
/// a file is found by those that it has on disk, whatever encoding they were written in.
pub(crate) fn resolve(folder: &Path, name: &[u8]) -> PathBuf {
    find(folder, name).unwrap_or_else(|| folder.join(os(&slashed(name))))
}

/// The existing file that `name`, written in a file in `folder`, means: tried as written, with `\` for `/`, without
/// regard to case, and, if it is an absolute path, as a file of that name in `folder`.
pub(crate) fn find(folder: &Path, name: &[u8]) -> Option<PathBuf> {
    let exact = folder.join(os(name));
    if exact.is_file() {
        return Some(exact);
    }
    let slashed = slashed(name);
    let path = folder.join(os(&slashed));
    if path.is_file() {
        return Some(path);
    }
    ignoring_case(folder, Path::new(os(&slashed))).or_else(|| {
        let last = slashed.rsplit(|&b| b == b'/').next().filter(|_| is_absolute(&slashed))?;
        ignoring_case(folder, Path::new(os(last)))
    })
}

fn os(name: &[u8]) -> &OsStr {
    OsStr::from_bytes(name)
}

fn slashed(name: &[u8]) -> Vec<u8> {
    name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect()
}

/// A name without the double quotes that some programs put around names with blanks.
pub(crate) fn unquoted(name: &[u8]) -> &[u8] {
    name.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).unwrap_or(name)
}

/// On this system or on Windows.
fn is_absolute(bytes: &[u8]) -> bool {
    bytes.first() == Some(&b'/') || bytes.len() > 2 && bytes[0].is_ascii_alphabetic() && bytes[1..3] == *b":/"
}

fn ignoring_case(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut found = folder.to_path_buf();
    for component in path.components() {
        let next = found.join(component);
        found = match component {
            Component::Normal(name) if !next.exists() => entry_ignoring_case(&found, name)?,
            _ => next,
        };
    }
    found.is_file().then_some(found)
}

/// The entry of `folder` with this name but for case; of several the first in the alphabet.
fn entry_ignoring_case(folder: &Path, name: &OsStr) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let lower = |name: &OsStr| name.to_str().map(str::to_lowercase);
    let wanted = lower(name)?;
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    entries.filter(|entry| lower(&entry.file_name()).as_ref() == Some(&wanted)).map(|entry| entry.path()).min()
}
