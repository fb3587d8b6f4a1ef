//! Bytes that accessors and pictures are made of.

use crate::io::{memory, paths};
use crate::{Error, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::buffer::Source;
use gltf::{Accessor, Document, buffer};
use std::path::{Path, PathBuf};

/// All buffers of a file.
pub(super) struct Buffers<'a> {
    pub(crate) path: &'a Path,
    data: Vec<Vec<u8>>,
}

/// What a URI means.
pub(super) enum Uri {
    Data(Vec<u8>),
    File(PathBuf),
}

impl<'a> Buffers<'a> {
    /// # Errors
    /// Files that are missing or too short, and URIs that are none of a file or of data.
    pub(crate) fn read(document: &Document, blob: Option<Vec<u8>>, path: &'a Path) -> Result<Buffers<'a>> {
        let mut blob = blob;
        let mut data = Vec::new();
        for buffer in document.buffers() {
            let bytes = match buffer.source() {
                Source::Bin => blob.take().ok_or_else(|| Error::file(path, "its binary chunk is missing"))?,
                Source::Uri(uri) => match parsed(uri, path)? {
                    Uri::Data(bytes) => bytes,
                    Uri::File(file) => memory::read_file(&file, u64::MAX)?,
                },
            };
            if bytes.len() < buffer.length() {
                let message =
                    format!("buffer {} has {} bytes, and says {}", buffer.index(), bytes.len(), buffer.length());
                return Err(Error::file(path, message));
            }
            data.push(bytes);
        }
        Ok(Buffers { path, data })
    }

    pub(crate) fn of(&self, buffer: buffer::Buffer) -> Option<&[u8]> {
        self.data.get(buffer.index()).map(Vec::as_slice)
    }

    /// The bytes of a view.
    pub(crate) fn view(&self, view: &buffer::View) -> Result<&[u8]> {
        let bytes = self.of(view.buffer()).unwrap_or_default();
        let end = view.offset().checked_add(view.length());
        let found = end.and_then(|end| bytes.get(view.offset()..end));
        found.ok_or_else(|| Error::file(self.path, format!("buffer view {} reaches beyond its buffer", view.index())))
    }

    /// That all that an accessor means is there, before it is read.
    pub(crate) fn check(&self, accessor: &Accessor) -> Result<()> {
        let size = accessor.size();
        let fault = |message: &str| Error::file(self.path, format!("accessor {} {message}", accessor.index()));
        memory::check((accessor.count() as u64).saturating_mul(size as u64))
            .map_err(|shortage| fault(&format!("would {shortage}")))?;
        if let Some(view) = accessor.view() {
            let bytes = self.view(&view)?;
            let stride = view.stride().unwrap_or(size);
            let last = accessor.count().checked_sub(1).and_then(|k| k.checked_mul(stride));
            let end = last.and_then(|last| last.checked_add(size)?.checked_add(accessor.offset()));
            if accessor.count() > 0 && end.is_none_or(|end| end > bytes.len()) || stride < size {
                return Err(fault("reaches beyond its buffer view"));
            }
        }
        if let Some(sparse) = accessor.sparse() {
            let width = match sparse.indices().index_type() {
                gltf::accessor::sparse::IndexType::U8 => 1,
                gltf::accessor::sparse::IndexType::U16 => 2,
                gltf::accessor::sparse::IndexType::U32 => 4,
            };
            let parts = [
                (self.view(&sparse.indices().view())?.len(), sparse.indices().offset(), width),
                (self.view(&sparse.values().view())?.len(), sparse.values().offset(), size),
            ];
            for (there, offset, width) in parts {
                let end = sparse.count().checked_mul(width).and_then(|length| length.checked_add(offset));
                if end.is_none_or(|end| end > there) {
                    return Err(fault("has sparse values beyond their buffer view"));
                }
            }
        }
        Ok(())
    }
}

/// Data of `data:`, or a file beside `path`.
pub(super) fn parsed(uri: &str, path: &Path) -> Result<Uri> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let bytes = encoded.and_then(|encoded| STANDARD.decode(encoded).ok());
        let damaged = || Error::file(path, "a `data:` URI is not base64");
        return bytes.map(Uri::Data).ok_or_else(damaged);
    }
    if uri.contains("://") {
        return Err(Error::file(path, format!("`{uri}` is not beside the file, and nothing is fetched")));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(Uri::File(paths::resolve(folder, &percent_decoded(uri))))
}

/// `%20` is a blank.
fn percent_decoded(uri: &str) -> Vec<u8> {
    let bytes = uri.as_bytes();
    let (mut decoded, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.filter(|_| bytes[at] == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                at += 3;
            }
            None => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    decoded
}
