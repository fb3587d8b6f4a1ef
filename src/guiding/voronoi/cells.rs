//! Boxes near the surface that know their few sites.
//!
//! The space about the sites is cut into *regions*, each into cubic *cells* of about the spacing of the sites there. A
//! cell, together with a bin of query normals, lists every site that is the answer for some point and normal of it: a
//! superset, so the nearest of the list is the nearest of all. Lists are found with the tree: the nearest site t that
//! agrees with all normals of the bin bounds how far an answer can be, and a site that is farther than t from all
//! corners of the box is farther from all points of it, as the difference of squared distances is linear.

use super::agreement::{Bin, Bins, agree, bin};
use super::kdtree::Tree;
use crate::math::rng::mix;
use glam::{UVec3, Vec3};
use rayon::prelude::*;

mod prepare;

/// Sites must leave room for the bits of a key.
pub const MAX_SITES: usize = 1 << 28;

/// Side of a cell in units of the sites' spacing.
const CELL: f32 = 0.6;

/// Cells that are prepared per site at most: those that samples and the surroundings of sites meet most.
const CELLS_PER_SITE: usize = 10;

/// Slots per cell: probes stay short.
const SLOTS_PER_CELL: f64 = 1.6;

/// Bytes that a site adds at most, long lists and regions included.
pub const BYTES_PER_SITE: usize =
    CELLS_PER_SITE * size_of::<Slot>() * 16 / 10 + 4 * LONG_PER_SITE + 4 * size_of::<Region>();

/// Numbers in long lists per site at most.
const LONG_PER_SITE: usize = 16;

/// Candidates that a slot holds itself.
const SHORT: usize = 6;

#[derive(Clone, Debug)]
pub struct Cells {
    origin: Vec3,
    regions_per_unit: f32,
    dims: UVec3,
    regions: Vec<Region>,
    /// Open addressing with linear probing; `EMPTY` ends a probe.
    slots: Vec<Slot>,
    /// The candidates of cells that have more than `SHORT`.
    long: Vec<u32>,
}

/// Spacing of the sites in a region.
#[derive(Clone, Copy, Debug)]
struct Region {
    spacing: f32,
    /// Cells along its side.
    cells: f32,
}

/// Half a cache line. `head` is the cell's key; in the low bits the number of candidates, and two flags.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Slot {
    head: u64,
    candidates: [u32; SHORT],
}

/// Low bits of a head.
const COUNT: u64 = 7;
/// The list may hold sites whose normals do not agree.
const MIXED: u64 = 8;
/// In place of the count: the candidates lie in `long`, `candidates` says where and how many.
const LONG: u64 = 7;
const LOW_BITS: u32 = 4;
const EMPTY: Slot = Slot { head: u64::MAX, candidates: [0; SHORT] };

const BIN_BITS: u32 = 6;
/// Bits of a cell's coordinate within its region.
const CELL_BITS: u32 = 10;

impl Cells {
    /// The site of `p` and `n`, where the cell is prepared.
    #[inline]
    pub fn find(&self, tree: &Tree, p: Vec3, n: Vec3) -> Option<u32> {
        let key = self.key(p, bin(n))?;
        let mut at = self.home(key);
        loop {
            let slot = &self.slots[at];
            if slot.head >> LOW_BITS == key {
                return Some(self.nearest(tree, slot, p, n));
            }
            if slot.head == EMPTY.head {
                return None;
            }
            at = if at + 1 == self.slots.len() { 0 } else { at + 1 };
        }
    }

    /// Spacing of the sites around `p`.
    #[inline]
    pub fn spacing(&self, p: Vec3) -> f32 {
        let c = ((p - self.origin) * self.regions_per_unit).max(Vec3::ZERO).as_uvec3().min(self.dims - 1);
        self.regions[self.region(c)].spacing
    }

    #[inline]
    fn nearest(&self, tree: &Tree, slot: &Slot, p: Vec3, n: Vec3) -> u32 {
        let candidates = match slot.head & COUNT {
            LONG => &self.long[slot.candidates[0] as usize..][..slot.candidates[1] as usize],
            count => &slot.candidates[..count as usize],
        };
        let mixed = slot.head & MIXED != 0;
        // candidates ascend: the first of equally near ones stays
        let mut best = (candidates[0], f32::INFINITY);
        for &site in candidates {
            let d2 = tree.distance2(site, p);
            if d2 < best.1 && (!mixed || agree(n, tree.normals()[site as usize])) {
                best = (site, d2);
            }
        }
        best.0
    }

    /// The cell of a point and a bin; `None` outside of the regions and for what is not a number.
    #[inline]
    fn key(&self, p: Vec3, bin: usize) -> Option<u64> {
        let at = (p - self.origin) * self.regions_per_unit;
        let c = at.as_uvec3();
        if !(at.min_element() >= 0.0 && c.cmplt(self.dims).all()) {
            return None;
        }
        let region = self.region(c);
        let cells = self.regions[region].cells;
        // the product may round up to the number of cells: `cell_box` reckons with that much error
        let k = ((at - c.as_vec3()) * cells).min(Vec3::splat(cells - 1.0)).as_uvec3();
        let cell = (k.x | k.y << CELL_BITS | k.z << (2 * CELL_BITS)) as u64;
        Some((region as u64) << (3 * CELL_BITS + BIN_BITS) | cell << BIN_BITS | bin as u64)
    }

    #[inline]
    fn region(&self, c: UVec3) -> usize {
        ((c.z * self.dims.y + c.y) * self.dims.x + c.x) as usize
    }

    /// Where a key's probe begins.
    #[inline]
    fn home(&self, key: u64) -> usize {
        ((mix(key) as u128 * self.slots.len() as u128) >> 64) as usize
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.regions[..]) + size_of_val(&self.slots[..]) + size_of_val(&self.long[..])
    }
}
