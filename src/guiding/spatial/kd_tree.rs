//! The spatial tree: a cube, halved along x, y, z in turn.

use crate::math::ONE_MINUS_EPSILON;
use glam::Vec3;

/// Bits of each coordinate of a position in the cube.
const BITS: u32 = 21;
/// Halvings that the bits suffice for.
pub const MAX_DEPTH: u32 = 3 * BITS;
/// Marks a node as a leaf: the other bits are its number. Else they are the index of the first of two children.
const LEAF: u32 = 1 << 31;

/// A flat binary tree of four bytes a node. Every point of space has one leaf: outside of the cube, that of the
/// nearest point in it.
#[derive(Clone, Debug)]
pub struct SpatialTree {
    low: Vec3,
    side: f32,
    per_unit: f32,
    nodes: Vec<u32>,
}

/// The box of a leaf in world space, half open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub leaf: u32,
    pub low: Vec3,
    pub high: Vec3,
}

impl SpatialTree {
    /// One leaf, number 0, about the box `(low, high)`.
    pub fn new(low: Vec3, high: Vec3) -> SpatialTree {
        let extent = (high - low).max_element();
        // A single point has no extent; any cube does.
        let extent = if extent > 0.0 { extent } else { 1.0 };
        // Walls love round coordinates, and the box's own: an odd margin keeps them off the halving planes, where
        // rounding would deal one wall to two leaves.
        let low = low - extent * Vec3::new(0.0137, 0.0141, 0.0133);
        let side = 1.0291 * extent;
        SpatialTree { low, side, per_unit: 1.0 / side, nodes: vec![LEAF] }
    }

    /// The leaf of `p`, and its depth.
    #[inline]
    pub fn find(&self, p: Vec3) -> (u32, u32) {
        self.descend(key(self.unit(p)))
    }

    /// The leaf of `p` moved by up to half of its own leaf's extent along each axis; `jitter` is in [0, 1)³. Over
    /// many records this is the box filter of Müller (2019), for one look-up more.
    #[inline]
    pub fn find_jittered(&self, p: Vec3, jitter: [f32; 3]) -> u32 {
        let unit = self.unit(p);
        let (_, depth) = self.descend(key(unit));
        let moved = unit + (Vec3::from_array(jitter) - 0.5) * extent(depth);
        self.descend(key(moved)).0
    }

    /// Position in the cube, as a share of its side.
    #[inline]
    fn unit(&self, p: Vec3) -> Vec3 {
        (p - self.low) * self.per_unit
    }

    #[inline]
    fn descend(&self, mut key: u64) -> (u32, u32) {
        let (mut node, mut depth) = (self.nodes[0], 0);
        while node & LEAF == 0 {
            node = self.nodes[node as usize + (key >> 63) as usize];
            key <<= 1;
            depth += 1;
        }
        (node & !LEAF, depth)
    }

    /// Halves the leaf at `node`: the lower half keeps its number, the upper one gets `number`. Returns the nodes
    /// of both.
    pub fn split(&mut self, node: u32, number: u32) -> [u32; 2] {
        let first = self.nodes.len() as u32;
        self.nodes.extend([self.nodes[node as usize], LEAF | number]);
        self.nodes[node as usize] = first;
        [first, first + 1]
    }

    /// All leaves, in the order of space.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        let mut open = vec![(0, Vec3::ZERO, 0)];
        std::iter::from_fn(move || {
            loop {
                let (at, corner, depth) = open.pop()?;
                let node = self.nodes[at as usize];
                if node & LEAF != 0 {
                    let low = self.low + self.side * corner;
                    let high = self.low + self.side * (corner + extent(depth));
                    return Some(Cell { leaf: node & !LEAF, low, high });
                }
                let upper = corner + extent(depth + 1) * axis(depth);
                open.extend([(node + 1, upper, depth + 1), (node, corner, depth + 1)]);
            }
        })
    }

    /// The nodes, the root first.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Takes the nodes of another tree in the same cube. Returns the node of each leaf, and its depth; `None`, and stays as
    /// it is, where these are not a tree with the leaves 0 to `leaves`.
    pub fn replaced(&mut self, nodes: Vec<u32>, leaves: usize) -> Option<Vec<(u32, u32)>> {
        if leaves == 0 || nodes.len() + 1 != 2 * leaves {
            return None;
        }
        let mut found = vec![None; leaves];
        let mut open = vec![(0, 0)];
        while let Some((at, depth)) = open.pop() {
            let node = nodes[at as usize];
            if node & LEAF != 0 {
                let leaf = found.get_mut((node & !LEAF) as usize)?;
                if leaf.replace((at, depth)).is_some() {
                    return None;
                }
            } else if node > at && (node as usize) < nodes.len() - 1 && depth < MAX_DEPTH {
                open.extend([(node, depth + 1), (node + 1, depth + 1)]);
            } else {
                return None;
            }
        }
        let found = found.into_iter().collect::<Option<Vec<_>>>()?;
        self.nodes = nodes;
        Some(found)
    }

    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<u32>()
    }

    /// Bytes that one split adds.
    pub const BYTES_PER_SPLIT: usize = 2 * size_of::<u32>();

    pub fn shrink(&mut self) {
        self.nodes.shrink_to_fit();
    }
}

/// The axis along which a node of this depth is halved.
fn axis(depth: u32) -> Vec3 {
    Vec3::AXES[depth as usize % 3]
}

/// Extent of a leaf of this depth, as a share of the cube's side.
#[inline]
fn extent(depth: u32) -> Vec3 {
    // 2⁻ⁿ by its exponent bits; n ≤ 21
    let halved = |times: u32| f32::from_bits((127 - times) << 23);
    Vec3::new(halved(depth.div_ceil(3)), halved((depth + 1) / 3), halved(depth / 3))
}

/// Bits of the three coordinates in turn, x first, from the highest bit down: one bit per level of the tree.
#[inline]
fn key(unit: Vec3) -> u64 {
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
