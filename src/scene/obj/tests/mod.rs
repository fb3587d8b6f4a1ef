mod against_tobj;
mod colors;
mod fixtures;
mod polygons;
mod random;
mod smoothing;
mod statements;

use super::scan::{Census, Counts};
use super::source::{Failure, Source};
use super::{check_memory, load_in_blocks};
use crate::Result;
use crate::geometry::mesh::{Attribute, Indices};
use crate::scene::model::Model;
use std::path::{Path, PathBuf};

/// Loads OBJ text as if from `test.obj`, in blocks of `block` bytes.
fn load_text(text: impl AsRef<[u8]>, block: u64) -> Result<Model> {
    let source = Source::memory(Path::new("test.obj"), text.as_ref().to_vec());
    load_in_blocks(&source, block)
}

#[test]
fn counts_that_do_not_fit_into_memory_are_an_error_by_name() {
    let (counts, triangles) = (Counts { positions: 1 << 50, ..Counts::default() }, 7);
    let Err(Failure::Fault(fault)) = check_memory(&Census { counts, triangles, ..Census::default() }) else {
        panic!("12 PiB are more than there is");
    };
    let message = fault.message;
    assert!(message.starts_with("1125899906842624 vertices and 7 triangles take 12.0 PiB, "), "{message}");
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
