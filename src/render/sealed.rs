//! Files with a checksum: each is one kind of thing, in one version.
//!
//! All numbers are little-endian: 8 bytes that name the kind, the format's version (`u32`), values in the wire format of the crate
//! `postcard`, and the CRC-32 (IEEE 802.3) of all before it. Values are written and read one after the other, so that neither
//! takes memory for the whole file.

use crate::io::atomic::write_atomically;
use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes before the values, and after them.
const HEAD: u64 = 12;
const TAIL: u64 = 4;

/// Bytes that all texts of a value take together at most.
const TEXTS: usize = 1 << 20;

const BUFFER: usize = 1 << 18;

/// What a file is.
pub(super) struct Kind {
    pub magic: [u8; 8],
    /// Changes whenever older files would be read wrongly.
    pub version: u32,
    /// What messages call it.
    pub name: &'static str,
}

impl Kind {
    /// Whether a file begins as one of this kind does.
    pub fn is_of(&self, path: &Path) -> bool {
        let mut start = [0; 8];
        File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok() && start == self.magic
    }

    /// Writes a file, as a whole or not at all.
    ///
    /// # Errors
    /// All failures to write.
    pub fn write(&self, path: &Path, value: &impl Serialize) -> Result<()> {
        self.write_unless(path, value, &|| false)
    }

    /// The same, or not at all once it is `given_up`.
    ///
    /// # Errors
    /// All failures to write, and that it was given up.
    pub fn write_unless(&self, path: &Path, value: &impl Serialize, given_up: &dyn Fn() -> bool) -> Result<()> {
        write_atomically(path, |file| {
            let mut out = BufWriter::with_capacity(BUFFER, Summed::new(file, given_up));
            out.write_all(&self.magic)?;
            out.write_all(&self.version.to_le_bytes())?;
            let written = postcard::to_io(value, &mut out).map(drop);
            out.get_mut().error.take().map_or(Ok(()), Err)?;
            written.map_err(io::Error::other)?;
            let Summed { to, sum, .. } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            to.write_all(&sum.finalize().to_le_bytes())
        })
    }

    /// Opens a file of this kind.
    ///
    /// # Errors
    /// [`Error::Io`] where there is none; [`Error::File`] for one that is of another kind or version, truncated or damaged.
    pub fn open(&'static self, path: &Path) -> Result<SealedFile> {
        let mut file = File::open(path).map_err(Error::io(path))?;
        let length = self.check(path, &mut file)?;
        file.seek(SeekFrom::Start(HEAD)).map_err(Error::io(path))?;
        let rest = BufReader::with_capacity(BUFFER, file).take(length - HEAD - TAIL);
        Ok(SealedFile { kind: self, path: path.to_path_buf(), rest })
    }

    /// That the file is of this kind, of this version, and whole; returns its length.
    fn check(&self, path: &Path, file: &mut File) -> Result<u64> {
        let Kind { magic, version: own, name } = self;
        let bad = |message: String| Error::file(path, message);
        let length = file.metadata().map_err(Error::io(path))?.len();
        let mut head = Vec::new();
        file.take(HEAD).read_to_end(&mut head).map_err(Error::io(path))?;
        if head.is_empty() || !head.iter().zip(magic).all(|(a, b)| a == b) {
            return Err(bad(format!("this is no {name}")));
        }
        let truncated = || bad(format!("the {name} is truncated"));
        let version = head.get(8..12).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
        let version = version.ok_or_else(truncated)?;
        if version != *own {
            let message = format!("the {name} is of version {version} of the format; this program reads version {own}");
            return Err(bad(message));
        }
        let body = length.checked_sub(HEAD + TAIL).ok_or_else(truncated)?;
        let sum = checksum(&head, file, body).map_err(Error::io(path))?;
        let mut tail = [0; TAIL as usize];
        file.read_exact(&mut tail).map_err(Error::io(path))?;
        if sum.to_le_bytes() != tail {
            return Err(bad(format!("the {name} is truncated or damaged: its checksum does not match")));
        }
        Ok(length)
    }
}

fn checksum(head: &[u8], file: &mut File, mut left: u64) -> io::Result<u32> {
    let mut sum = crc32fast::Hasher::new();
    sum.update(head);
    let mut buffer = vec![0; BUFFER];
    while left > 0 {
        let some = &mut buffer[..left.min(BUFFER as u64) as usize];
        file.read_exact(some)?;
        sum.update(some);
        left -= some.len() as u64;
    }
    Ok(sum.finalize())
}

/// An open file that is whole, at one of its values.
pub(super) struct SealedFile {
    kind: &'static Kind,
    path: PathBuf,
    rest: io::Take<BufReader<File>>,
}

impl SealedFile {
    /// The next value.
    ///
    /// # Errors
    /// Where there is another one.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T> {
        let read = postcard::from_io((&mut self.rest, &mut vec![0; TEXTS][..])).map(|(value, _)| value);
        read.map_err(|_| self.error("it is malformed"))
    }

    /// Whether no value is left.
    pub fn is_at_end(&self) -> bool {
        self.rest.limit() == 0
    }

    /// What is wrong with it.
    pub fn error(&self, what: &str) -> Error {
        Error::file(&self.path, format!("the {}: {what}", self.kind.name))
    }
}

/// Counts the checksum of what is written. Postcard forgets why it could not write, so it is kept.
struct Summed<'a, T> {
    to: T,
    given_up: &'a dyn Fn() -> bool,
    sum: crc32fast::Hasher,
    error: Option<io::Error>,
}

impl<T> Summed<'_, T> {
    fn new(to: T, given_up: &dyn Fn() -> bool) -> Summed<'_, T> {
        Summed { to, given_up, sum: crc32fast::Hasher::new(), error: None }
    }
}

impl<T: Write> Write for Summed<'_, T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = if (self.given_up)() { Err(io::ErrorKind::TimedOut.into()) } else { self.to.write(bytes) };
        let written = written.inspect_err(|error| {
            self.error = Some(error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error));
        })?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    static KIND: Kind = Kind { magic: *b"PTXTEST!", version: 1, name: "test" };

    #[test]
    fn what_is_given_up_half_written_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        KIND.write(&path, &vec![1u8; 10]).unwrap();
        let large = vec![2u8; 10 * BUFFER];
        let give_up_after = |pieces: u32| {
            let written = Cell::new(0);
            KIND.write_unless(&path, &large, &|| written.replace(written.get() + 1) >= pieces)
        };
        for pieces in [0, 1, 3] {
            let error = give_up_after(pieces).unwrap_err();
            assert!(error.to_string().contains("timed out"), "{error}");
            let old: Vec<u8> = KIND.open(&path).unwrap().take().unwrap();
            assert_eq!(old, [1; 10]);
            assert_eq!(folder.path().read_dir().unwrap().count(), 1);
        }
        give_up_after(1000).unwrap();
        assert!(KIND.open(&path).unwrap().take::<Vec<u8>>().unwrap() == large);
    }
}
