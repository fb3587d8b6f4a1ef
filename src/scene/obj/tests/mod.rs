mod against_tobj;
mod fixtures;
mod polygons;
mod random;
mod statements;

use super::source::Source;
use super::{Obj, load_in_blocks};
use crate::Result;
use crate::geometry::mesh::{Attribute, Indices};
use std::path::{Path, PathBuf};

/// Loads OBJ text as if from `test.obj`, in blocks of `block` bytes.
fn load_text(text: impl AsRef<[u8]>, block: u64) -> Result<Obj> {
    let source = Source::memory(Path::new("test.obj"), text.as_ref().to_vec());
    load_in_blocks(&source, block)
}

/// An attribute's indices, triangle by triangle.
fn triples<T>(attribute: &Attribute<T>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    match &attribute.indices {
        Indices::OfPositions => triangles.to_vec(),
        Indices::Own(indices) => indices.clone(),
    }
}

/// The folder of test scenes; says so loudly where it is missing.
fn scenes(test: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("PHOTOTAXIS_SCENES").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: {test}: no scenes in {} (set PHOTOTAXIS_SCENES)", folder.display());
    None
}
