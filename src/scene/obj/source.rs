//! The bytes of a text file in blocks of whole lines, so that all cores read it and it is never in memory as a whole.

use super::lines;
use crate::error::{Error, Result};
use crate::io::memory;
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Bytes read at a time in search of the end of a line.
const PROBE: u64 = 4096;

/// A place in a text, as a byte offset, and what is wrong there.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    pub(crate) at: u64,
    pub(crate) message: String,
}

impl Fault {
    pub(crate) fn new(at: usize, message: impl Into<String>) -> Fault {
        Fault { at: at as u64, message: message.into() }
    }

    /// The same fault where the text is itself at `offset` of a longer one.
    pub(crate) fn shifted(mut self, offset: u64) -> Fault {
        self.at += offset;
        self
    }
}

/// Why a pass over the file ended early.
#[derive(Debug)]
pub(super) enum Failure {
    Io(io::Error),
    Fault(Fault),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Failure {
        Failure::Io(error)
    }
}

/// A text file that is read more than once.
pub(super) struct Source {
    path: PathBuf,
    store: Store,
    len: u64,
}

enum Store {
    /// Opened anew for each block, so that threads do not share a position.
    File,
    /// What cannot be read twice (a pipe), or needed its line ends converted.
    Memory(Vec<u8>),
}

impl Source {
    pub(crate) fn open(path: &Path) -> Result<Source> {
        let file = std::fs::metadata(path).map_err(Error::io(path))?;
        let source = Source { path: path.to_path_buf(), store: Store::File, len: file.len() };
        if !file.is_file() {
            return Ok(Source::memory(path, memory::read_file(path, u64::MAX)?));
        }
        let mut head = Vec::new();
        source.read(0..source.len.min(16 * PROBE), &mut head).map_err(Error::io(path))?;
        if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
            return Err(Error::file(path, "the text is UTF-16; it has to be ASCII or UTF-8"));
        }
        if lines::ends_in_cr(&head) {
            return Ok(Source::memory(path, memory::read_file(path, u64::MAX)?));
        }
        Ok(source)
    }

    pub(crate) fn memory(path: &Path, mut bytes: Vec<u8>) -> Source {
        lines::convert_cr(&mut bytes);
        let len = bytes.len() as u64;
        Source { path: path.to_path_buf(), store: Store::Memory(bytes), len }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces what `buffer` holds by the bytes of `range`.
    fn read(&self, range: Range<u64>, buffer: &mut Vec<u8>) -> io::Result<()> {
        buffer.clear();
        match &self.store {
            Store::Memory(bytes) => {
                buffer.extend_from_slice(&bytes[range.start as usize..range.end as usize]);
            }
            Store::File => {
                let mut file = File::open(&self.path)?;
                file.seek(SeekFrom::Start(range.start))?;
                let wanted = range.end - range.start;
                buffer.reserve_exact(wanted as usize);
                file.take(wanted).read_to_end(buffer)?;
                if (buffer.len() as u64) < wanted {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
            }
        }
        Ok(())
    }

    /// Cuts the file into blocks of at least `size` bytes (but for the last) that end where a logical line ends.
    pub(crate) fn blocks(&self, size: u64) -> io::Result<Vec<Range<u64>>> {
        let mut blocks = Vec::new();
        let mut start = 0;
        while start < self.len {
            let end = self.line_start(start.saturating_add(size))?;
            blocks.push(start..end);
            start = end;
        }
        Ok(blocks)
    }

    /// The first start of a logical line at or after `target` (≥ 1), or the file's end.
    fn line_start(&self, target: u64) -> io::Result<u64> {
        let mut buffer = Vec::new();
        let mut from = target - 1;
        while from < self.len {
            // What precedes a line end decides whether it ends the line: at most `\` and CR.
            let start = from.saturating_sub(2);
            let end = (from + PROBE).min(self.len);
            self.read(start..end, &mut buffer)?;
            let searched = (from - start) as usize;
            let found = memchr::memchr_iter(b'\n', &buffer[searched..])
                .map(|i| searched + i)
                .find(|&i| !lines::continues(&buffer[..i]));
            if let Some(i) = found {
                return Ok(start + i as u64 + 1);
            }
            from = end;
        }
        Ok(self.len)
    }

    /// Runs `work` on every task's block with continuation lines joined, on all threads. The results are in the order
    /// of the blocks; of several failures the first in the file is returned, whatever the threads did.
    pub(crate) fn each_block<S: Send, T: Send>(
        &self,
        tasks: Vec<(Range<u64>, S)>,
        work: impl Fn(S, &[u8]) -> Result<T, Fault> + Sync,
    ) -> Result<Vec<T>, Failure> {
        let results: Vec<Result<T, Failure>> = tasks
            .into_par_iter()
            .map_init(Vec::new, |buffer, (range, task)| {
                self.read(range.clone(), buffer)?;
                lines::join_continuations(buffer);
                work(task, buffer).map_err(|fault| Failure::Fault(fault.shifted(range.start)))
            })
            .collect();
        results.into_iter().collect()
    }

    /// Physical line ends in each block.
    pub(crate) fn count_lines(&self, blocks: &[Range<u64>]) -> io::Result<Vec<usize>> {
        blocks
            .par_iter()
            .map_init(Vec::new, |buffer, range| {
                self.read(range.clone(), buffer)?;
                Ok(memchr::memchr_iter(b'\n', buffer).count())
            })
            .collect()
    }

    /// Line and column (bytes), both from 1, of a byte in `block`, whose first line is number `first`.
    pub(crate) fn position(&self, at: u64, block: Range<u64>, first: usize) -> io::Result<(usize, usize)> {
        let mut buffer = Vec::new();
        self.read(block.start..at.min(block.end), &mut buffer)?;
        let line = first + memchr::memchr_iter(b'\n', &buffer).count();
        let line_start = memchr::memrchr(b'\n', &buffer).map_or(0, |i| i + 1);
        Ok((line, buffer.len() - line_start + 1))
    }
}
