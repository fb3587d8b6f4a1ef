//! Elements in blocks that can be read side by side.

use super::header::{Element, Encoding};
use super::values::{Binary, Fault, Text, Values, with_values, within};
use crate::io::memory;
use crate::{Error, Result};
use flate2::bufread::MultiGzDecoder;
use rayon::prelude::*;
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Things that a thread reads at a time.
const BLOCK: usize = 1 << 14;

/// Bytes that a thread reads at a time where a file is taken into memory.
const PIECE: usize = 1 << 22;

/// The bytes of a file.
pub(super) enum Source<'a> {
    /// Read block by block, so that they are never in memory as a whole.
    File(File, usize),
    Memory(Cow<'a, [u8]>),
}

impl Source<'_> {
    /// A file, or the bytes of what cannot be read from any place (a pipe) or is compressed.
    pub(crate) fn open(path: &Path) -> Result<Source<'static>> {
        if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gz")) {
            return unpacked(path).map(|bytes| Source::Memory(bytes.into()));
        }
        let file = File::open(path).map_err(Error::io(path))?;
        let metadata = file.metadata().map_err(Error::io(path))?;
        if metadata.is_file() {
            return Ok(Source::File(file, metadata.len() as usize));
        }
        memory::read_file(path, u64::MAX).map(|bytes| Source::Memory(bytes.into()))
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Source::File(_, length) => *length,
            Source::Memory(bytes) => bytes.len(),
        }
    }

    /// Bytes of a range that is within the file; `buffer` may come to hold them.
    pub(crate) fn bytes<'b>(&'b self, range: Range<usize>, buffer: &'b mut Vec<u8>) -> io::Result<&'b [u8]> {
        match self {
            Source::Memory(bytes) => Ok(&bytes[range]),
            Source::File(file, _) => {
                // what is there is overwritten, and is not to be cleared first
                buffer.resize(buffer.len().max(range.len()), 0);
                file.read_exact_at(&mut buffer[..range.len()], range.start as u64)?;
                Ok(&buffer[..range.len()])
            }
        }
    }

    /// Takes the file into memory.
    ///
    /// # Errors
    /// Those of reading; where there is not the memory.
    pub(crate) fn keep(&mut self, path: &Path) -> Result<()> {
        let Source::File(file, length) = self else { return Ok(()) };
        memory::check(*length as u64).map_err(|shortage| Error::file(path, format!("its bytes {shortage}")))?;
        let mut bytes = vec![0; *length];
        let pieces = bytes.par_chunks_mut(PIECE).enumerate();
        pieces.try_for_each(|(k, piece)| file.read_exact_at(piece, (k * PIECE) as u64)).map_err(Error::io(path))?;
        *self = Source::Memory(bytes.into());
        Ok(())
    }
}

/// What is in a file that gzip has compressed, piece by piece, so that no more is taken than there is memory.
fn unpacked(path: &Path) -> Result<Vec<u8>> {
    let mut packed = MultiGzDecoder::new(BufReader::new(File::open(path).map_err(Error::io(path))?));
    let mut bytes = Vec::new();
    loop {
        memory::check(PIECE as u64 + bytes.len() as u64)
            .map_err(|shortage| Error::file(path, format!("its bytes, unpacked, {shortage}")))?;
        let read = packed.by_ref().take(PIECE.max(bytes.len()) as u64).read_to_end(&mut bytes);
        if read.map_err(|error| Error::file(path, format!("not compressed by gzip, or damaged: {error}")))? == 0 {
            return Ok(bytes);
        }
    }
}

/// Where a block of things is, and which of them it has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    /// In bytes of the file.
    pub(crate) range: Range<usize>,
    pub(crate) first: usize,
    pub(crate) count: usize,
}

/// How the things of an element are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    /// Lists are taken to be as long as those of the first thing. Who reads them has to look.
    Even,
    /// One by one, in a file that is in memory.
    Scan,
}

/// Bytes that a thing is taken to have at most where lists are taken to be even.
const LARGEST_EVEN: usize = 1 << 16;

/// Cuts an element's things, which begin at `at`, into blocks. Returns also where they end.
pub(super) fn blocks(
    element: &Element,
    encoding: Encoding,
    source: &Source,
    at: usize,
    search: Search,
) -> Result<(Vec<Block>, usize), Fault> {
    if element.properties.is_empty() || element.count == 0 {
        return Ok((Vec::new(), at));
    }
    let mut buffer = Vec::new();
    if encoding != Encoding::Ascii && element.properties.iter().all(|property| property.length.is_none()) {
        let size = element.properties.iter().map(|property| property.kind.bytes()).sum();
        return even(element, source, at, size);
    }
    match search {
        Search::Even => {
            let head = at..source.len().min(at + LARGEST_EVEN);
            let bytes = source.bytes(head, &mut buffer).map_err(|error| unread(at, &error))?;
            let size = with_values!(encoding, bytes, values => values.pass(element).map(|()| values.at()))?;
            even(element, source, at, size)
        }
        Search::Scan => {
            let bytes = source.bytes(at..source.len(), &mut buffer).map_err(|error| unread(at, &error))?;
            with_values!(encoding, bytes, values => scanned(element, &mut values, at)).map_err(|fault| fault.after(at))
        }
    }
}

/// That bytes of a file could not be read.
#[cold]
pub(super) fn unread(at: usize, error: &io::Error) -> Fault {
    Fault::new(at, error.to_string())
}

/// Things of `size` bytes each.
fn even(element: &Element, source: &Source, at: usize, size: usize) -> Result<(Vec<Block>, usize), Fault> {
    let there = (source.len() - at) / size;
    if there < element.count {
        let message = format!("the file ends in `{}` {there} of {}", element.name, element.count);
        return Err(Fault::new(at + there * size, message));
    }
    let block = |first| {
        let count = BLOCK.min(element.count - first);
        Block { range: at + first * size..at + (first + count) * size, first, count }
    };
    Ok(((0..element.count).step_by(BLOCK).map(block).collect(), at + element.count * size))
}

/// The values are those from `start` on.
fn scanned<V: Values>(element: &Element, values: &mut V, start: usize) -> Result<(Vec<Block>, usize), Fault> {
    let mut found = Vec::new();
    for first in (0..element.count).step_by(BLOCK) {
        let (count, at) = (BLOCK.min(element.count - first), values.at());
        for k in first..first + count {
            values.pass(element).map_err(|fault| within(fault, element, k))?;
        }
        found.push(Block { range: start + at..start + values.at(), first, count });
    }
    Ok((found, start + values.at()))
}
