//! Boxes near the surface that know their few sites.
//!
//! The space about the sites is cut into coarse *regions*, each of which tells how the sites there are spaced. Look-ups
//! from a region use cubic *cells* of about that size. A cell, together with a bin of query normals, lists every site
//! that is the answer for some point and normal of it: a superset, so the nearest of the list is the nearest of all.
//! Lists are found with the tree: the nearest site t that agrees with all normals of the bin bounds how far an answer
//! can be, and a site that is farther than t from all corners of the box is farther from all points of it, as the
//! difference of squared distances is linear.

use super::agreement::{Bin, Bins, agree, bin};
use super::site_tree::SiteTree;
use crate::math::Frame;
use crate::math::rng::mix;
use crate::simd::{LANES, Vec3Lanes, pick};
use glam::{UVec3, Vec3};
use rayon::prelude::*;

mod prepare;

/// Sites must leave room for the bits of a key.
pub const MAX_SITES: usize = 1 << 28;

/// Side of a cell in units of the sites' spacing.
const CELL: f32 = 0.6;

/// CandidateCells that are prepared per site at most: those that samples and the surroundings of sites meet most.
const CELLS_PER_SITE: usize = 8;

/// Slots per two cells: room for short probes, yet little memory, as waiting for it is what a look-up does most.
const SLOTS_PER_PAIR: usize = 3;

/// Bytes that a site adds at most, long lists and regions included.
pub const BYTES_PER_SITE: usize =
    CELLS_PER_SITE * SLOTS_PER_PAIR * size_of::<CellSlot>() / 2 + 4 * LONG_PER_SITE + 4 * size_of::<Region>();

/// Numbers in long lists per site at most.
const LONG_PER_SITE: usize = 8;

/// Candidates that a slot holds itself.
const SHORT: usize = 6;

#[derive(Clone, Debug)]
pub struct CandidateCells {
    origin: Vec3,
    regions_per_unit: f32,
    dims: UVec3,
    regions: Vec<Region>,
    /// Open addressing with linear probing; `EMPTY` ends a probe.
    slots: Vec<CellSlot>,
    /// The candidates of cells that have more than `SHORT`.
    long: Vec<u32>,
}

/// How the sites of a region are spaced.
#[derive(Clone, Copy, Debug)]
struct Region {
    spacing: f32,
    /// CandidateCells per unit of length, one of few numbers: regions that are alike share cells.
    scale: f32,
}

/// Half a cache line. `head` is a cell's key; below it the number of candidates, and a flag.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct CellSlot {
    head: u64,
    candidates: [u32; SHORT],
}

/// Low bits of a head: how many candidates there are.
const COUNT: u64 = 7;
/// In place of the count: the candidates lie in `long`, `candidates` says where and how many.
const LONG: u64 = 7;
/// The list may hold sites whose normals do not agree.
const MIXED: u64 = 8;
const FLAGS: u32 = 4;
/// Stands for the key of no cell.
const NOWHERE: u64 = u64::MAX;
const EMPTY: CellSlot = CellSlot { head: u64::MAX, candidates: [0; SHORT] };

const BIN_BITS: u32 = 6;
/// Bits of a cell's coordinate.
const CELL_BITS: u32 = 14;
/// Low bits of a scale that are zero: its exponent and one bit more are left.
const SCALE_BITS: u32 = 22;

impl CandidateCells {
    /// Where `jitter` moves `p` along the plane about `n`, and the scale of its cells.
    #[inline(always)]
    pub fn moved(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> (Vec3, f32) {
        let Region { spacing, scale } = self.regions[self.region(p) as usize];
        (jittered(p, n, jitter, spacing), scale)
    }

    /// The same for a packet: moves its points, and gives the keys of their cells.
    #[inline(always)]
    pub fn keys(&self, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 2], moved: &mut Vec3Lanes) -> [u64; LANES] {
        let (mut regions, mut spacing, mut scale) = ([0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            regions[k] = self.region(p.get(k));
        }
        for k in 0..LANES {
            let region = &self.regions[regions[k] as usize];
            (spacing[k], scale[k]) = (region.spacing, region.scale);
        }
        let mut keys = [0; LANES];
        for k in 0..LANES {
            let n = n.get(k);
            moved.set(k, jittered(p.get(k), n, jitter, spacing[k]));
            keys[k] = self.key(moved.get(k), scale[k], bin(n));
        }
        keys
    }

    /// The site of `p` and `n`, where the cell of that scale is prepared.
    #[inline(always)]
    pub fn find(&self, tree: &SiteTree, (p, scale): (Vec3, f32), n: Vec3) -> Option<u32> {
        let key = self.key(p, scale, bin(n));
        let home = self.home(key);
        self.find_from(tree, (key, (home, self.slots[home as usize].head)), p, n)
    }

    /// The same where the key is known, and where its probe begins, with the head of the slot there.
    #[inline(always)]
    pub fn find_from(&self, tree: &SiteTree, (key, first): (u64, (u32, u64)), p: Vec3, n: Vec3) -> Option<u32> {
        let (mut at, mut head) = (first.0 as usize, first.1);
        while head >> FLAGS != key {
            if head == EMPTY.head {
                return None;
            }
            at = if at + 1 == self.slots.len() { 0 } else { at + 1 };
            head = self.slots[at].head;
        }
        Some(self.nearest(tree, &self.slots[at], p, n))
    }

    #[inline(always)]
    fn nearest(&self, tree: &SiteTree, slot: &CellSlot, p: Vec3, n: Vec3) -> u32 {
        if slot.head & (COUNT | MIXED) < LONG {
            return nearest_of(tree, &slot.candidates, p);
        }
        let candidates = match slot.head & COUNT {
            LONG => &self.long[slot.candidates[0] as usize..][..slot.candidates[1] as usize],
            count => &slot.candidates[..count as usize],
        };
        let mixed = slot.head & MIXED != 0;
        // Candidates ascend: the first of equally near ones stays. Without distances that are numbers, or where `n` is
        // no number, it is the first of all.
        let mut best = (candidates[0], f32::INFINITY);
        for &site in candidates {
            let d2 = tree.distance2(site, p);
            if d2 < best.1 && (!mixed || agree(n, tree.normals()[site as usize])) {
                best = (site, d2);
            }
        }
        best.0
    }

    /// The cell of a point and a bin; [`NOWHERE`] far outside.
    #[inline(always)]
    fn key(&self, p: Vec3, scale: f32, bin: usize) -> u64 {
        let at = (p - self.origin) * scale;
        let (x, y, z) = (whole(at.x), whole(at.y), whole(at.z));
        let cell = x as u64 | (y as u64) << CELL_BITS | (z as u64) << (2 * CELL_BITS);
        let scale = (scale.to_bits() >> SCALE_BITS) as u64;
        let key = (scale << (3 * CELL_BITS) | cell) << BIN_BITS | bin as u64;
        pick((x | y | z) >> CELL_BITS == 0, key, NOWHERE)
    }

    /// The region of `p`; outside of all, some region at the border.
    #[inline(always)]
    fn region(&self, p: Vec3) -> u32 {
        let at = (p - self.origin) * self.regions_per_unit;
        let part = |at: f32, dim: u32| (whole(at) as i32).max(0).min(dim as i32 - 1) as u32;
        let (x, y, z) = (part(at.x, self.dims.x), part(at.y, self.dims.y), part(at.z, self.dims.z));
        (z * self.dims.y + y) * self.dims.x + x
    }

    /// Where a key's probe begins.
    #[inline(always)]
    fn home(&self, key: u64) -> u32 {
        (((mix(key) >> 32) * self.slots.len() as u64) >> 32) as u32
    }

    /// The places for a packet, each with the head of the slot there: all are on their way from memory at once.
    #[inline(always)]
    pub fn first_slots(&self, keys: &[u64; LANES]) -> [(u32, u64); LANES] {
        let (mut homes, mut slots) = ([0; LANES], [(0, 0); LANES]);
        for k in 0..LANES {
            homes[k] = self.home(keys[k]);
        }
        for k in 0..LANES {
            slots[k] = (homes[k], self.slots[homes[k] as usize].head);
        }
        slots
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.regions[..]) + size_of_val(&self.slots[..]) + size_of_val(&self.long[..])
    }
}

/// The whole part of `v`, or the number below for a whole `v`; anything from 2²¹ to 2³² − 1 for a negative `v`, for one of
/// 2²¹ or more, and for what is not a number. Adding a number so large that it has no fraction takes one instruction,
/// where a saturating cast takes several. `CandidateCell::half` reckons with faces that belong to either cell.
#[inline]
fn whole(v: f32) -> u32 {
    const NO_FRACTION: f32 = (3 << 22) as f32;
    (v - 0.5 + NO_FRACTION).to_bits().wrapping_sub(NO_FRACTION.to_bits())
}

/// `p`, moved along the plane about `n` by up to half a spacing.
#[inline(always)]
fn jittered(p: Vec3, n: Vec3, jitter: [f32; 2], spacing: f32) -> Vec3 {
    let frame = Frame::from_normal(n);
    p + (frame.s * (jitter[0] - 0.5) + frame.t * (jitter[1] - 0.5)) * spacing
}

/// The nearest of a short list, without jumps: of equally near ones the first, and of those whose distance is no number too.
#[inline(always)]
fn nearest_of(tree: &SiteTree, candidates: &[u32; SHORT], p: Vec3) -> u32 {
    let mut best = (candidates[0], f32::INFINITY);
    for &site in candidates {
        let d2 = tree.distance2(site, p);
        let nearer = d2 < best.1;
        best = (pick(nearer, site, best.0), pick(nearer, d2, best.1));
    }
    best.0
}
