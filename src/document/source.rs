//! The text that a document is read from, and where faults in it are.

use super::{At, Fault};
use crate::error::{Place, SourceLocation};
use crate::io::memory;
use crate::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// A file's text, without the mark that some editors put before UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    let bytes = memory::read_file(path, memory::LONGEST_TEXT)?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let (line, column) = line_and_column(e.as_bytes(), e.utf8_error().valid_up_to());
        Error::parse(path, line, column, "this byte is not UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// What faults' places refer to.
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
    pub(crate) overrides: &'a [String],
}

impl Source<'_> {
    /// What paths in the file are relative to.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// The place in the file; `None` for what `--set` says.
    pub(crate) fn location(&self, at: At) -> Option<SourceLocation> {
        let At::Text(offset) = at else { return None };
        let (line, column) = line_and_column(self.text.as_bytes(), offset);
        Some(SourceLocation { path: self.path.to_path_buf(), line, column })
    }

    /// The place in the file, or on the command line.
    pub(crate) fn place(&self, at: At) -> Place {
        match (self.location(at), at) {
            (Some(location), _) => Place::File(location),
            (None, At::Text(index) | At::Set(index)) => {
                Place::Override { index, text: self.overrides.get(index).cloned().unwrap_or_default() }
            }
        }
    }

    pub(crate) fn error(&self, fault: Fault) -> Error {
        self.place(fault.at).error(fault.message)
    }

    /// A copy for what is read later.
    pub(crate) fn to_owned(&self) -> OwnedSource {
        let (path, text, overrides) = (self.path.into(), self.text.into(), self.overrides.into());
        OwnedSource { path, text, overrides }
    }
}

/// A [`Source`] of its own.
#[derive(Clone, Debug)]
pub(crate) struct OwnedSource {
    path: Arc<Path>,
    text: Arc<str>,
    overrides: Arc<[String]>,
}

impl OwnedSource {
    pub(crate) fn borrow(&self) -> Source<'_> {
        Source { path: &self.path, text: &self.text, overrides: &self.overrides }
    }
}

/// Both from 1; columns count characters.
pub(crate) fn line_and_column(text: &[u8], offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let line = before.iter().filter(|b| **b == b'\n').count() + 1;
    // Bytes that continue a UTF-8 character are no columns of their own.
    let column = before[line_start..].iter().filter(|b| **b & 0xC0 != 0x80).count() + 1;
    (line, column)
}
