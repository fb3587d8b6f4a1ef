//! The binary tree over space: a cube, halved along x, y, z in turn (Müller et al. 2017).
//!
//! A region is a leaf, alone or together with a quantised facing normal.

use super::normal_bins::{NORMALS, normal_bin};
use super::{RegionId, RegionLookup, SpatialPartition};
use crate::math::ONE_MINUS_EPSILON;
use glam::Vec3;
use std::ops::Range;

/// Bits of each coordinate of a position in the cube.
const BITS: u32 = 21;
/// Halvings that the bits suffice for.
const MAX_DEPTH: u8 = 3 * BITS as u8;
/// Place of a normal's bin in a key.
const BIN_SHIFT: u32 = 32;

/// A flat tree. Every point of space has one leaf: outside of the cube, that of the nearest point in it. Cells and leaves
/// are known by the number of their node.
#[derive(Clone, Debug)]
pub struct KdTree {
    low: Vec3,
    per_unit: f32,
    /// The first of a node's two children; 0 for a leaf.
    children: Vec<u32>,
    depths: Vec<u8>,
    filter: bool,
    normals: bool,
}

/// The box of a leaf in world space, half open.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::guiding) struct LeafBox {
    pub leaf: u32,
    pub low: Vec3,
    pub high: Vec3,
}

impl KdTree {
    /// One leaf, number 0, about the box `(low, high)`. With `filter` records blur over neighbouring leaves; with
    /// `normals` the two sides of a sheet, and walls that meet in a corner, are regions of their own.
    pub fn new(low: Vec3, high: Vec3, filter: bool, normals: bool) -> KdTree {
        let extent = (high - low).max_element();
        // A single point has no extent; any cube does.
        let extent = if extent > 0.0 { extent } else { 1.0 };
        // Walls love round coordinates, and the box's own: an odd margin keeps them off the halving planes, where
        // rounding would deal one wall to two leaves.
        let low = low - extent * Vec3::new(0.0137, 0.0141, 0.0133);
        let side = 1.0291 * extent;
        KdTree { low, per_unit: 1.0 / side, children: vec![0], depths: vec![0], filter, normals }
    }

    /// The leaf of `p`.
    #[inline]
    pub(in crate::guiding) fn leaf(&self, p: Vec3) -> u32 {
        self.descend(bits_of(self.unit(p)))
    }

    /// The leaf of `p` moved by up to half of its own leaf's extent along each axis; `jitter` is in [0, 1)³. Over
    /// many records this is the box filter of Müller (2019), for one look-up more.
    #[inline]
    pub(in crate::guiding) fn leaf_jittered(&self, p: Vec3, jitter: [f32; 3]) -> u32 {
        let unit = self.unit(p);
        let leaf = self.descend(bits_of(unit));
        let moved = unit + (Vec3::from_array(jitter) - 0.5) * extent(self.depths[leaf as usize]);
        self.descend(bits_of(moved))
    }

    /// Position in the cube, as a share of its side.
    #[inline]
    fn unit(&self, p: Vec3) -> Vec3 {
        (p - self.low) * self.per_unit
    }

    #[inline]
    fn descend(&self, mut bits: u64) -> u32 {
        let mut node = 0;
        while self.children[node as usize] != 0 {
            node = self.children[node as usize] + (bits >> 63) as u32;
            bits <<= 1;
        }
        node
    }

    /// All leaves, in the order of space.
    #[cfg(test)]
    pub(in crate::guiding) fn leaves(&self) -> impl Iterator<Item = LeafBox> {
        let (side, mut open) = (1.0 / self.per_unit, vec![(0, Vec3::ZERO)]);
        std::iter::from_fn(move || {
            loop {
                let (node, corner) = open.pop()?;
                let (first, depth) = (self.children[node as usize], self.depths[node as usize]);
                if first == 0 {
                    let low = self.low + side * corner;
                    let high = self.low + side * (corner + extent(depth));
                    return Some(LeafBox { leaf: node, low, high });
                }
                let upper = corner + extent(depth + 1) * Vec3::AXES[depth as usize % 3];
                open.extend([(first + 1, upper), (first, corner)]);
            }
        })
    }

    /// The depths of nodes with these children; `None` where they are no tree.
    fn depths(children: &[u32]) -> Option<Vec<u8>> {
        let mut depths = vec![None; children.len()];
        *depths.first_mut()? = Some(0);
        for (node, &first) in children.iter().enumerate().filter(|(_, first)| **first != 0) {
            // parents come before their children, and so have their depths first
            let depth = depths[node]? + 1;
            let pair = depths.get_mut(first as usize..first as usize + 2)?;
            if first as usize <= node || depth > MAX_DEPTH || pair.iter().any(Option::is_some) {
                return None;
            }
            pair.fill(Some(depth));
        }
        depths.into_iter().collect()
    }

    #[inline]
    fn key(&self, leaf: u32, n: Vec3) -> RegionId {
        let bin = if self.normals { normal_bin(n) } else { 0 };
        RegionId(leaf as u64 | (bin as u64) << BIN_SHIFT)
    }
}

/// The node that a key names.
fn node_of(key: RegionId) -> usize {
    key.0 as u32 as usize
}

impl SpatialPartition for KdTree {
    /// The children of all nodes.
    type Stored = Vec<u32>;

    #[inline(always)]
    fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
        let recorded = if self.filter { self.leaf_jittered(p, jitter) } else { self.leaf(p) };
        Some(RegionLookup { drawn: self.key(self.leaf(p), n), recorded: self.key(recorded, n) })
    }

    fn is_oriented(&self) -> bool {
        self.normals
    }

    fn holds(&self, key: RegionId) -> bool {
        let bins = if self.normals { NORMALS as u64 } else { 1 };
        self.children.get(node_of(key)) == Some(&0) && key.0 >> BIN_SHIFT < bins
    }

    fn dense(&self) -> Option<usize> {
        (!self.normals).then_some(self.children.len())
    }

    fn bytes(&self) -> usize {
        self.children.len() * (size_of::<u32>() + size_of::<u8>())
    }

    fn cells(&self) -> usize {
        self.children.len()
    }

    fn cell_of(&self, key: RegionId) -> usize {
        node_of(key)
    }

    fn parts_per_region(&self) -> usize {
        2
    }

    fn divide(&mut self, leaf: usize) -> Option<Range<usize>> {
        let (first, depth) = (self.children.len(), self.depths[leaf] + 1);
        if depth > MAX_DEPTH || self.children[leaf] != 0 {
            return None;
        }
        self.children[leaf] = first as u32;
        self.children.extend([0; 2]);
        self.depths.extend([depth; 2]);
        Some(first..first + 2)
    }

    fn parts(&self, key: RegionId) -> Vec<(RegionId, f32)> {
        let (mut parts, mut open) = (Vec::new(), vec![(node_of(key), 1.0)]);
        if self.children[node_of(key)] == 0 {
            return parts;
        }
        while let Some((node, share)) = open.pop() {
            match self.children[node] as usize {
                0 => parts.push((RegionId(node as u64 | key.0 >> BIN_SHIFT << BIN_SHIFT), share)),
                first => open.extend([(first + 1, 0.5 * share), (first, 0.5 * share)]),
            }
        }
        parts
    }

    fn stored(&self) -> Vec<u32> {
        self.children.clone()
    }

    fn restore(&mut self, children: Vec<u32>, _memory: usize) -> Result<(), String> {
        let Some(depths) = KdTree::depths(&children) else {
            return Err("its cells are not ones that a tree over space can have".into());
        };
        (self.children, self.depths) = (children, depths);
        Ok(())
    }
}

/// Extent of a leaf of this depth, as a share of the cube's side.
#[inline]
fn extent(depth: u8) -> Vec3 {
    // 2⁻ⁿ by its exponent bits; n ≤ 21
    let (depth, halved) = (depth as u32, |times: u32| f32::from_bits((127 - times) << 23));
    Vec3::new(halved(depth.div_ceil(3)), halved((depth + 1) / 3), halved(depth / 3))
}

/// Bits of the three coordinates in turn, x first, from the highest bit down: one bit per level of the tree.
#[inline]
fn bits_of(unit: Vec3) -> u64 {
    // Casts saturate, and NaN is 0: whatever comes in, some leaf comes out.
    let bits = |v: f32| spread((v.min(ONE_MINUS_EPSILON) * (1 << BITS) as f32) as u32);
    bits(unit.x) << 3 | bits(unit.y) << 2 | bits(unit.z) << 1
}

/// Moves bit i of 21 to bit 3i.
#[inline]
fn spread(v: u32) -> u64 {
    let v = v as u64;
    let v = (v | v << 32) & 0x001f_0000_0000_ffff;
    let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}
