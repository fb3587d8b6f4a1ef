//! Temporary files in the folder of what they will be.
//!
//! A program that is killed leaves its temporary file behind; the next one that writes into that folder removes it. Whether
//! the writer is gone is told by a lock on the open file (`flock`), which the kernel holds for it and gives back when it ends,
//! however it ends. Unlike the number of a process in the name, that is never mistaken for another process's, and it is right
//! for programs in containers and on other machines that share the folder. Where a file system has no locks, nothing is
//! removed.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use tempfile::NamedTempFile;

/// A name is this, then so many letters and digits, and then [`SUFFIX`]. No file of anyone else's is named so.
const PREFIX: &str = ".phototaxis-";
const RANDOM: usize = 12;
const SUFFIX: &str = ".tmp";

/// Makes a temporary file in a folder, with the permissions of any new file, after removing those that nobody writes any more.
/// It is removed when it is dropped.
pub(super) fn create(folder: &Path) -> io::Result<NamedTempFile> {
    remove_abandoned(folder);
    loop {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).rand_bytes(RANDOM).suffix(SUFFIX);
        // Temporary files are private by default; this one becomes a file like any other, as the umask has it.
        builder.permissions(PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder)?;
        // Without locks nobody removes it either.
        let _ = file.as_file().lock();
        // Before it was locked it may have been taken for an abandoned one, and removed.
        if file.as_file().metadata()?.nlink() > 0 {
            return Ok(file);
        }
    }
}

/// Removes the temporary files whose writers are gone. What cannot be removed stays: it is in nobody's way.
fn remove_abandoned(folder: &Path) {
    for entry in folder.read_dir().into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_temporary) {
            let path = entry.path();
            // The lock is held until the file is removed, so that no writer takes it meanwhile.
            if let Some(_locked) = locked(&path) {
                let _ = std::fs::remove_file(&path);
            }
        }
    }
}

/// The file, unless somebody else has its lock.
fn locked(path: &Path) -> Option<File> {
    // Over a network only files that are open for writing can be locked.
    let file = OpenOptions::new().read(true).write(true).open(path).ok()?;
    file.try_lock().ok().map(|()| file)
}

fn is_temporary(name: &str) -> bool {
    let random = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_suffix(SUFFIX));
    random.is_some_and(|random| random.len() == RANDOM && random.bytes().all(|b| b.is_ascii_alphanumeric()))
}

#[cfg(test)]
mod tests {
    use super::super::atomic::write_atomically;
    use super::*;
    use std::process::{Child, Command};
    use std::time::{Duration, Instant};

    /// Names the file that another process of this test is to write, and never finish.
    const UNFINISHED: &str = "PHOTOTAXIS_TEST_UNFINISHED_FILE";

    #[test]
    fn another_process_writes() {
        let Some(path) = std::env::var_os(UNFINISHED) else { return };
        let _ = write_atomically(Path::new(&path), |file| {
            file.write_all(&[1; 100_000])?;
            std::thread::sleep(Duration::from_secs(300));
            Ok(())
        });
    }

    /// A process in the middle of writing a file. It ends with the test.
    struct Writer(Child);

    impl Writer {
        fn start(path: &Path) -> Writer {
            let name = "io::temporary::tests::another_process_writes";
            let mut command = Command::new(std::env::current_exe().unwrap());
            let writer = Writer(command.args([name, "--exact"]).env(UNFINISHED, path).spawn().unwrap());
            let start = Instant::now();
            while !temporaries(path.parent().unwrap()).iter().any(|(_, length)| *length > 0) {
                assert!(start.elapsed() < Duration::from_secs(60), "the other process writes nothing");
                std::thread::sleep(Duration::from_millis(10));
            }
            writer
        }
    }

    impl Drop for Writer {
        fn drop(&mut self) {
            // SIGKILL: it has no chance to clean up.
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    /// Names and lengths of the temporary files in a folder.
    fn temporaries(folder: &Path) -> Vec<(String, u64)> {
        let entries = folder.read_dir().unwrap().map(Result::unwrap);
        let all = entries.map(|e| (e.file_name().into_string().unwrap(), e.metadata().map_or(0, |m| m.len())));
        all.filter(|(name, _)| is_temporary(name)).collect()
    }

    #[test]
    fn what_a_killed_writer_left_is_removed_and_a_live_one_is_let_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (theirs, ours) = (folder.path().join("theirs.exr"), folder.path().join("ours.exr"));
        let writer = Writer::start(&theirs);
        write_atomically(&ours, |file| file.write_all(b"first")).unwrap();
        assert_eq!(temporaries(folder.path()).len(), 1, "somebody writes it");
        drop(writer);
        assert_eq!(temporaries(folder.path()).len(), 1, "nobody has written here since");
        write_atomically(&ours, |file| file.write_all(b"second")).unwrap();
        assert_eq!(temporaries(folder.path()), []);
        assert!(!theirs.exists() && std::fs::read(&ours).unwrap() == b"second");
    }

    #[test]
    fn no_file_of_anyone_else_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let others = [
            "phototaxis-abcdefghijkl.tmp",
            ".phototaxis-.tmp",
            ".phototaxis-abcdefghijk.tmp",
            ".phototaxis-abcdefghijklm.tmp",
            ".phototaxis-abcdef.hijkl.tmp",
            ".phototaxis-abcdefghijk\u{e9}.tmp",
            ".phototaxis-abcdefghijkl.tmp.exr",
            ".phototaxis-abcdefghijkl",
            "scene.tmp",
        ];
        others.iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
        std::fs::create_dir(folder.path().join(".phototaxis-abcdefghijkl.tmp")).unwrap();
        let elsewhere = tempfile::NamedTempFile::new().unwrap();
        let link = folder.path().join(".phototaxis-mnopqrstuvwx.tmp");
        std::os::unix::fs::symlink(elsewhere.path(), &link).unwrap();
        std::fs::write(folder.path().join(".phototaxis-ABCdef012345.tmp"), "").unwrap();
        create(folder.path()).unwrap();
        let left = folder.path().read_dir().unwrap().count();
        assert_eq!(left, others.len() + 2, "of all these one alone was left by a killed run");
        assert!(!folder.path().join(".phototaxis-ABCdef012345.tmp").exists() && link.is_symlink());
    }

    #[test]
    fn one_that_was_removed_before_it_was_locked_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..8)
                .map(|_| scope.spawn(|| (0..100).all(|_| create(folder.path()).is_ok_and(|file| file.path().exists()))))
                .collect();
            assert!(all.into_iter().all(|thread| thread.join().unwrap()), "a live temporary file was removed");
        });
        assert_eq!(temporaries(folder.path()), []);
    }
}
