//! File names as people write them: with backslashes, in the wrong case, from another machine.

use std::path::{Component, Path, PathBuf};

/// The file that `name`, written in a file in `folder`, means; where there is none, the path where it would be.
pub(super) fn resolve(folder: &Path, name: &str) -> PathBuf {
    find(folder, name).unwrap_or_else(|| folder.join(name.replace('\\', "/")))
}

/// The existing file that `name`, written in a file in `folder`, means: tried as written, with `\` for `/`, without
/// regard to case, and, if it is an absolute path, as a file of that name in `folder`.
pub(super) fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let slashed = name.replace('\\', "/");
    let path = folder.join(&slashed);
    if path.is_file() {
        return Some(path);
    }
    ignoring_case(folder, Path::new(&slashed)).or_else(|| {
        let last = slashed.rsplit('/').next().filter(|_| is_absolute(&slashed))?;
        ignoring_case(folder, Path::new(last))
    })
}

/// On this system or on Windows.
fn is_absolute(path: &str) -> bool {
    let bytes = path.as_bytes();
    bytes.first() == Some(&b'/') || bytes.len() > 2 && bytes[0].is_ascii_alphabetic() && bytes[1..3] == *b":/"
}

fn ignoring_case(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut found = folder.to_path_buf();
    for component in path.components() {
        let next = found.join(component);
        found = match component {
            Component::Normal(name) if !next.exists() => entry_ignoring_case(&found, name.to_str()?)?,
            _ => next,
        };
    }
    found.is_file().then_some(found)
}

/// The entry of `folder` with this name but for case; of several the first in the alphabet.
fn entry_ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let wanted = name.to_lowercase();
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    entries
        .filter(|entry| entry.file_name().to_str().is_some_and(|n| n.to_lowercase() == wanted))
        .map(|entry| entry.path())
        .min()
}
