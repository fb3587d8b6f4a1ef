//! The one error type of the library: what went wrong, and where.

use std::path::{Path, PathBuf};

/// What the library reports. Messages are complete sentences without a full stop; the command line adds context.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    Io { path: PathBuf, error: std::io::Error },
    /// A text file is malformed. `line` and `column` count from 1; column 0: the whole line.
    #[error("{}:{line}{}: {message}", path.display(), column_suffix(*column))]
    Parse { path: PathBuf, line: usize, column: usize, message: String },
    /// A file is readable but what it holds cannot be used (an image, a binary format).
    #[error("{}: {message}", path.display())]
    File { path: PathBuf, message: String },
    /// One of the `key=value` that change a scene is wrong; `index` counts them from 0.
    #[error("--set '{text}': {message}")]
    Override { index: usize, text: String, message: String },
    /// A scene or a setting contradicts itself.
    #[error("{0}")]
    Scene(String),
    /// There is no denoiser, or it refused.
    #[error("denoising: {0}")]
    Denoise(String),
    /// Embree refused a call.
    #[error("Embree: {0}")]
    Embree(String),
}

/// Result with the library's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// For `map_err` on file operations.
    pub(crate) fn io(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.as_ref().to_path_buf();
        move |error| Error::Io { path, error }
    }

    /// A fault in what a file holds, without a line.
    pub(crate) fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Error {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into() }
    }

    /// A fault in a text file; `line` and `column` count from 1, column 0 means the whole line.
    pub(crate) fn parse(path: impl AsRef<Path>, line: usize, column: usize, message: impl Into<String>) -> Error {
        Error::Parse { path: path.as_ref().to_path_buf(), line, column, message: message.into() }
    }
}

/// Where a scene file says something. Line and column count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceLocation {
    pub(crate) path: PathBuf,
    pub line: usize,
    pub column: usize,
}

impl SourceLocation {
    /// That what is said there cannot be used.
    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        Error::parse(&self.path, self.line, self.column, message)
    }
}

/// Where something is said in a file or on the command line, for what is found wrong with it only later.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Place {
    File(SourceLocation),
    /// One of the `key=value` that change a scene, as of [`Error::Override`].
    Override {
        index: usize,
        text: String,
    },
}

impl Place {
    /// That what is said there cannot be used.
    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        match self {
            Place::File(location) => location.error(message),
            Place::Override { index, text } => {
                Error::Override { index: *index, text: text.clone(), message: message.into() }
            }
        }
    }
}

fn column_suffix(column: usize) -> String {
    if column == 0 { String::new() } else { format!(":{column}") }
}
