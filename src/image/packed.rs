//! The bytes of a picture's file, before they are written.

use crate::io::atomic::write_atomically;
use crate::{Error, Result};
use std::path::Path;

/// How small they are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    /// Takes most of the time that writing a picture takes.
    Tight,
    /// For those who have no time: several times as large.
    Loose,
}

/// The bytes, or what cannot be stored.
pub(crate) struct Packed(pub(super) std::result::Result<Vec<u8>, String>);

impl Packed {
    /// Writes them, as a whole or not at all.
    ///
    /// # Errors
    /// What cannot be stored, and all failures to write.
    pub(crate) fn write(self, path: &Path) -> Result<()> {
        let bytes = self.0.map_err(|message| Error::file(path, message))?;
        write_atomically(path, |file| file.write_all(&bytes))
    }
}
