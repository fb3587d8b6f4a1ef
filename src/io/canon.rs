//! Hashes of content: over canonical bytes, not over a program's text or types, so that they are the same on every machine
//! and in every release. All numbers are little-endian, floats by their bits, and lists come after their lengths.
//!
//! The hash is XXH3 with 64 bits (<https://github.com/Cyan4973/xxHash>, a frozen format). It keeps nothing secret: who
//! wants two contents with one hash can make them.

use bytemuck::{NoUninit, cast_slice};
use glam::{Affine3A, Vec3};
use rayon::prelude::*;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

/// Bytes of an array that are hashed together; blocks are hashed by all threads. The hash depends on it.
const BLOCK: usize = 1 << 20;

// Arrays are hashed as they lie in memory.
const _: () = assert!(cfg!(target_endian = "little"));

/// Takes canonical bytes.
pub(crate) struct Canon(Xxh3);

impl Canon {
    pub(crate) fn new(domain: &[u8]) -> Canon {
        let mut hasher = Xxh3::new();
        hasher.update(domain);
        Canon(hasher)
    }

    pub(crate) fn u32(&mut self, x: u32) {
        self.0.update(&x.to_le_bytes());
    }

    pub(crate) fn u64(&mut self, x: u64) {
        self.0.update(&x.to_le_bytes());
    }

    pub(crate) fn flag(&mut self, x: bool) {
        self.u32(u32::from(x));
    }

    pub(crate) fn floats<const N: usize>(&mut self, values: [f32; N]) {
        values.iter().for_each(|x| self.u32(x.to_bits()));
    }

    pub(crate) fn vector(&mut self, v: Vec3) {
        self.floats(v.to_array());
    }

    pub(crate) fn transform(&mut self, t: Affine3A) {
        self.floats(t.to_cols_array());
    }

    /// A long list of numbers: its length in bytes, then the hashes of its blocks.
    pub(crate) fn array<T: NoUninit>(&mut self, values: &[T]) {
        let bytes: &[u8] = cast_slice(values);
        self.u64(bytes.len() as u64);
        let blocks: Vec<u64> = bytes.par_chunks(BLOCK).map(xxh3_64).collect();
        blocks.into_iter().for_each(|block| self.u64(block));
    }

    pub(crate) fn finish(self) -> u64 {
        self.0.digest()
    }
}

/// Of a picture of `[width, height]` texels, `write` adding how they are stored and what they are.
pub(crate) fn texels([width, height]: [usize; 2], write: impl FnOnce(&mut Canon)) -> u64 {
    let mut canon = Canon::new(b"phototaxis texels 1\0");
    canon.u64(width as u64);
    canon.u64(height as u64);
    write(&mut canon);
    canon.finish()
}
