//! MTL material libraries.
//!
//! Keywords are taken in any case. Of a material defined twice the first definition counts, as of libraries the first
//! named. What has no meaning here is reported once per keyword and file, but for `sharpness`.

mod material;
mod record;
mod texture;

#[cfg(test)]
mod tests;

use super::Warning;
use super::lines::{self, Lines};
use super::report::Reporter;
use super::source::Fault;
use crate::error::{Error, Result};
use crate::io::memory;
use crate::io::paths;
use crate::scene::description::MaterialDescription;
use record::Record;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The most words tried as one library's name.
const WORDS_IN_NAME: usize = 16;

type Materials = BTreeMap<String, MaterialDescription>;

/// Reads what `mtllib` statements (offset, argument) name. Missing files become warnings of the OBJ file; the
/// warnings returned are the libraries' own.
pub(super) fn load_libraries(
    reporter: &mut Reporter,
    statements: &[(u64, Vec<u8>)],
) -> Result<(Materials, Vec<Warning>)> {
    let folder = reporter.path().parent().unwrap_or(Path::new(""));
    let mut done = BTreeSet::new();
    let (mut materials, mut warnings) = (Materials::new(), Vec::new());
    for (at, argument) in statements {
        for (name, path) in library_paths(folder, argument) {
            if !done.insert(path.clone()) {
                continue;
            }
            match memory::read_file(&path, memory::LONGEST_TEXT) {
                Ok(text) => load_library(&path, text, &mut materials, &mut warnings)?,
                Err(Error::Io { error, .. }) => reporter.warn(*at, format!("material library `{name}`: {error}")),
                Err(other) => return Err(other),
            }
        }
    }
    Ok((materials, warnings))
}

/// File names may hold blanks, bare, after a backslash or in double quotes, and there may be several: the most words that together
/// name an existing file are one name; a word with which none does is a name too.
fn library_paths(folder: &Path, argument: &[u8]) -> Vec<(String, PathBuf)> {
    let kept = with_blanks_kept(argument);
    let words: Vec<&[u8]> = kept.split(|&b| lines::is_blank(b)).filter(|word| !word.is_empty()).collect();
    let mut paths = Vec::new();
    let mut rest = &words[..];
    while !rest.is_empty() {
        let joined = |count: usize| -> Vec<u8> {
            let bytes = rest[..count].join(&b' ').into_iter();
            bytes.map(|b| if b == KEPT { b' ' } else { b }).collect()
        };
        let longest = (1..=rest.len().min(WORDS_IN_NAME)).rev();
        let found = longest
            .map(|n| (n, joined(n)))
            .find_map(|(n, name)| paths::find(folder, &name).map(|path| (n, name, path)));
        let (count, name, path) = found.unwrap_or_else(|| (1, joined(1), paths::resolve(folder, &joined(1))));
        paths.push((lines::text(&name), path));
        rest = &rest[count..];
    }
    paths
}

/// Stands for a blank that is part of a name: NUL cannot be in a file's name.
const KEPT: u8 = 0;

/// The argument with [`KEPT`] for blanks after a backslash and within a pair of double quotes, which are dropped.
fn with_blanks_kept(argument: &[u8]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(argument.len());
    let mut rest = argument;
    while let [first, tail @ ..] = rest {
        let quoted = (*first == b'"').then(|| memchr::memchr(b'"', tail)).flatten();
        rest = match (first, quoted) {
            (_, Some(end)) => {
                kept.extend(tail[..end].iter().map(|&b| if lines::is_blank(b) { KEPT } else { b }));
                &tail[end + 1..]
            }
            (b'\\', None) if tail.first() == Some(&b' ') => {
                kept.push(KEPT);
                &tail[1..]
            }
            _ => {
                kept.push(*first);
                tail
            }
        };
    }
    kept
}

/// Adds a library's materials to those of earlier ones.
fn load_library(path: &Path, text: Vec<u8>, materials: &mut Materials, warnings: &mut Vec<Warning>) -> Result<()> {
    let mut text = in_utf_8(text);
    lines::convert_cr(&mut text);
    let line = |at: usize| 1 + memchr::memchr_iter(b'\n', &text[..at.min(text.len())]).count();
    let mut joined = text.clone();
    lines::join_continuations(&mut joined);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut notes = Notes::default();
    let mut records: Vec<(String, Record)> = Vec::new();
    for (at, statement) in Lines::new(&joined) {
        notes.at = at;
        read_statement(statement, folder, &mut records, &mut notes).map_err(|fault| {
            let start = memchr::memrchr(b'\n', &text[..at]).map_or(0, |i| i + 1);
            Error::parse(path, line(at), at - start + fault.at as usize + 1, fault.message)
        })?;
    }
    for (name, record) in records {
        notes.unseen(&name, &record);
        materials.entry(name).or_insert_with(|| record.describe());
    }
    let warning = |(at, message)| Warning { path: path.to_path_buf(), line: line(at), message };
    warnings.extend(notes.messages.into_iter().map(warning));
    Ok(())
}

/// Text in UTF-16 that says so by its byte-order mark, in UTF-8; any other as it is.
fn in_utf_8(text: Vec<u8>) -> Vec<u8> {
    let unit: fn([u8; 2]) -> u16 = match &text[..] {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return text,
    };
    let units: Vec<u16> = text[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    String::from_utf16_lossy(&units).into_bytes()
}

fn read_statement(
    line: &[u8],
    folder: &Path,
    records: &mut Vec<(String, Record)>,
    notes: &mut Notes,
) -> Result<(), Fault> {
    let (keyword, rest) = lines::keyword(line);
    if keyword.eq_ignore_ascii_case(b"newmtl") {
        let name = lines::text(paths::unquoted(lines::name(rest)));
        if records.iter().any(|(known, _)| *known == name) {
            notes.once(format!("material `{name}` is defined again; the first definition counts"));
        }
        records.push((name, Record { at: notes.at, ..Record::default() }));
        return Ok(());
    }
    match records.last_mut() {
        Some((_, record)) => record.set(keyword, line, folder, notes),
        None => {
            notes.once("statements before the first `newmtl` are ignored");
            Ok(())
        }
    }
}

/// What there is to say about a library.
#[derive(Default)]
struct Notes {
    /// Offset of the statement being read.
    at: usize,
    messages: Vec<(usize, String)>,
    said: BTreeSet<String>,
}

impl Notes {
    /// Says where a material is one that nobody would see, and which of its pictures nobody would.
    fn unseen(&mut self, name: &str, record: &Record) {
        for unused in record.unused_maps() {
            self.messages.push((record.at, format!("material `{name}`: {unused}")));
        }
        let message = if record.is_inverted() {
            "`Tr 1`, with nothing else by which light passes, is taken for opaque, as programs write it that mean `d`"
        } else if record.is_invisible() {
            "light passes it as if it were not there (`d` or `Tr`), so that it cannot be seen"
        } else {
            return;
        };
        self.messages.push((record.at, format!("material `{name}`: {message}")));
    }

    /// Says it at the current statement unless it has been said.
    fn once(&mut self, message: impl Into<String>) {
        let message = message.into();
        if self.said.insert(message.clone()) {
            self.messages.push((self.at, message));
        }
    }
}
