//! Files that are either complete or not there.

use super::temporary;
use crate::{Error, Result};
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Replaces the file at `path` by what `write` writes, or leaves it as it was.
///
/// The bytes go to a temporary file in the same folder, reach the disk, and are renamed. On any error the temporary
/// file is removed; one that a killed program left is removed by the next that writes into the folder. A symbolic link
/// stays and the file it names is replaced; a replaced file keeps its permissions. A device or a pipe is written directly,
/// for it cannot be replaced.
///
/// # Errors
/// [`Error::Io`] about `path`: no such folder, no permission, full disk, or what `write` returned.
pub(crate) fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    write_or_undo(path, write).map_err(Error::io(path))
}

/// Makes and removes an empty file in a folder, so as to know whether it takes files.
///
/// # Errors
/// What keeps a file from being made.
pub(crate) fn try_folder(folder: &Path) -> io::Result<()> {
    temporary::create(folder).map(drop)
}

fn write_or_undo(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let target = follow_link(path)?;
    let existing = match std::fs::metadata(&target) {
        Ok(existing) => Some(existing),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    match &existing {
        Some(existing) if existing.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Some(existing) if !existing.is_file() => fill(&OpenOptions::new().write(true).open(&target)?, write),
        _ => {
            let file = temporary_beside(&target, existing.as_ref())?;
            fill(file.as_file(), write)?;
            file.as_file().sync_all()?;
            file.persist(&target)?;
            Ok(())
        }
    }
}

/// The file that a symbolic link names, where that exists.
fn follow_link(path: &Path) -> io::Result<PathBuf> {
    if path.is_symlink() && path.exists() { path.canonicalize() } else { Ok(path.to_path_buf()) }
}

fn fill(file: &File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush()
}

fn temporary_beside(target: &Path, existing: Option<&Metadata>) -> io::Result<NamedTempFile> {
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(io::Error::new(io::ErrorKind::NotFound, "its folder does not exist"));
    }
    let file = temporary::create(folder)?;
    if let Some(existing) = existing {
        file.as_file().set_permissions(existing.permissions())?;
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_written_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["first, the longer one", "second"] {
            write_atomically(&path, |file| file.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names_in(folder.path()), ["a.txt"]);
    }

    #[test]
    fn after_an_error_the_old_file_stands_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(error.unwrap_err().to_string().starts_with(&path.display().to_string()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names_in(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_target_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/a.txt");
        let error = write_atomically(&missing, |_| Ok(())).unwrap_err().to_string();
        assert_eq!(error, format!("{}: its folder does not exist", missing.display()));
        let error = write_atomically(folder.path(), |_| Ok(())).unwrap_err().to_string();
        assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_full_disk_is_an_error_and_devices_survive() {
        use std::os::unix::fs::FileTypeExt;
        let full = Path::new("/dev/full");
        if !full.exists() {
            eprintln!("SKIPPED: this system has no /dev/full");
            return;
        }
        // A little stays in the buffer until the end, a lot does not: both must be noticed.
        for length in [10, 1_000_000] {
            let error = write_atomically(full, |file| file.write_all(&vec![1; length]));
            let message = error.unwrap_err().to_string();
            assert!(message.starts_with("/dev/full: No space left"), "{message}");
        }
        assert!(fs::metadata(full).unwrap().file_type().is_char_device());
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_without_permission_is_an_error() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        if File::create(folder.path().join("probe")).is_ok() {
            eprintln!("SKIPPED: permissions do not bind this user");
            return;
        }
        let path = folder.path().join("a.txt");
        let error = write_atomically(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("link"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("a.txt", &link).unwrap();
        write_atomically(&link, |file| file.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_usual_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, usual) = (folder.path().join("ours"), folder.path().join("usual"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        fs::write(&usual, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&ours), mode(&usual));
    }
}
