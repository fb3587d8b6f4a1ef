//! The frozen directional distribution: a quadtree over the sphere, eight bytes a node.
//!
//! The sphere is cut open by the cylindrical equal-area map: x = (1 + z)/2 and y = φ/2π span the unit square, world
//! z being the axis, and equal areas are equal solid angles.

use crate::guiding::directional::Directions;
use crate::math::warp::atan_unit;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Levels that the 16 bits of a coordinate suffice for.
pub const MAX_LEVELS: u32 = 16;
/// Nodes that a quadtree may have: an index has 15 bits.
pub const MAX_NODES: usize = (1 << 15) - 1;
/// Probabilities are kept in steps of 2⁻¹⁴: the very same numbers are drawn from and evaluated.
const ONE: u32 = 1 << 14;
const SHARE_BITS: u32 = 15;
const SHARE_MASK: u64 = (1 << SHARE_BITS) - 1;

/// The point of the square where the unit vector `w` (world space) lies, in steps of 2⁻¹⁶.
#[inline]
pub fn encode(w: Vec3) -> [u16; 2] {
    // casts saturate: the border belongs to the last step, and NaN to the first
    let step = |v: f32| ((v * 65_536.0) as u32).min(65_535) as u16;
    [step(0.5 * w.z + 0.5), step(azimuth(w.x, w.y))]
}

/// φ/2π in [0, 1] of the vector (x, y); 0 of none.
#[inline]
fn azimuth(x: f32, y: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (less, more) = (ax.min(ay), ax.max(ay));
    // from the nearer axis, then from the x axis, then all the way round
    let eighth = atan_unit(less / more.max(f32::MIN_POSITIVE)) * (1.0 / TAU);
    let quarter = if ay > ax { 0.25 - eighth } else { eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    if y < 0.0 { 1.0 - half } else { half }
}

/// The unit vector at a point of the square, given in steps of 2⁻²⁴: as fine as floats are.
#[inline]
fn decode([x, y]: [u32; 2]) -> Vec3 {
    let z = x as f32 * (1.0 / 8_388_608.0) - 1.0;
    let (sin, cos) = (y as f32 * (TAU / 16_777_216.0)).sin_cos();
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// Which quadrants of a node are divided further; their nodes follow one another from `base` on. Quadrant q is the
/// half q & 1 of x, and the half q >> 1 of y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Branch(u32);

impl Branch {
    /// `base` is at most [`MAX_NODES`], bit q of `mask` says that quadrant q is divided.
    pub fn new(base: usize, mask: u32) -> Branch {
        Branch((base as u32) << 4 | mask)
    }

    /// The node of quadrant `q`; `None` where it is a leaf.
    #[inline]
    pub fn child(self, q: u32) -> Option<usize> {
        if self.0 >> q & 1 == 0 {
            return None;
        }
        // how many of the quadrants before q have nodes: the bits set in a number below eight, two bits a piece
        let before = self.0 & ((1 << q) - 1);
        let rank = 0b11_10_10_01_10_01_01_00u32 >> (2 * before) & 3;
        Some(((self.0 >> 4) + rank) as usize)
    }
}

/// Whether nodes with these branches, the root first, are a quadtree, breadth first, of no more levels than there can be.
pub fn are_in_order(branches: impl ExactSizeIterator<Item = Branch>) -> bool {
    let count = branches.len();
    // how many nodes are known of, and the node at which each level ends
    let (mut known, mut level, mut end) = (1, 1, 1);
    for (at, branch) in branches.enumerate() {
        if at == end {
            (level, end) = (level + 1, known);
        }
        let (base, mask) = ((branch.0 >> 4) as usize, branch.0 & 15);
        if base != known || (mask != 0 && level == MAX_LEVELS) {
            return false;
        }
        known += mask.count_ones() as usize;
    }
    known == count
}

/// A node in one word: the probability of the lower half of x, that of the lower half of y in either half of x, and
/// the [`Branch`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct QuadNode(u64);

impl QuadNode {
    /// `energy` of the four quadrants is finite and not negative.
    pub fn new(branch: Branch, energy: [f64; 4]) -> QuadNode {
        let [a, b, c, d] = energy;
        let shares = [share(a + c, b + d), share(a, c), share(b, d)];
        let packed = shares.iter().rev().fold(branch.0 as u64, |word, &s| word << SHARE_BITS | s as u64);
        QuadNode(packed)
    }

    /// Whether these are the nodes of a quadtree, and their shares ones that can be drawn by.
    pub fn are_sound(nodes: &[QuadNode]) -> bool {
        let shares = |node: &QuadNode| [node.lower_x(), node.lower_y(0), node.lower_y(1)];
        nodes.iter().all(|node| shares(node).iter().all(|&share| share <= ONE))
            && are_in_order(nodes.iter().map(|node| node.branch()))
    }

    #[inline]
    pub fn branch(self) -> Branch {
        Branch((self.0 >> (3 * SHARE_BITS)) as u32)
    }

    /// Probability, of [`ONE`], of the lower half of x.
    #[inline]
    fn lower_x(self) -> u32 {
        (self.0 & SHARE_MASK) as u32
    }

    /// Probability, of [`ONE`], of the lower half of y in the half `x` of x.
    #[inline]
    fn lower_y(self, x: u32) -> u32 {
        (self.0 >> (SHARE_BITS * (1 + x)) & SHARE_MASK) as u32
    }

    /// Density of quadrant (x, y) relative to that of the node.
    #[inline]
    pub fn density(self, x: u32, y: u32) -> f32 {
        let of = |lower: u32, half: u32| if half == 0 { lower } else { ONE - lower };
        (of(self.lower_x(), x) * of(self.lower_y(x), y)) as f32 * (4.0 / (ONE * ONE) as f32)
    }
}

/// Share of `a` in a + b, of [`ONE`]. What is positive keeps a share; nothing at all is shared evenly.
fn share(a: f64, b: f64) -> u32 {
    if a == 0.0 || b == 0.0 {
        return if a == b { ONE / 2 } else { ONE * (b == 0.0) as u32 };
    }
    ((a / (a + b) * ONE as f64).round() as u32).clamp(1, ONE - 1)
}

/// A distribution of directions over the whole sphere, in world space.
#[derive(Clone, Copy, Debug)]
pub struct Quadtree<'a> {
    nodes: &'a [QuadNode],
}

impl Directions for Quadtree<'_> {
    /// `inside` is for both.
    #[inline(never)]
    fn sample(&self, _u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let w = self.draw(inside);
        (w, self.density(w))
    }

    #[inline(never)]
    fn pdf(&self, w: Vec3) -> f32 {
        self.density(w)
    }

    /// Its cells reach beyond any lobe's width, and it is the published method, which knows no product.
    fn times(&self, _value: impl Fn(Vec3) -> f32) -> Self {
        *self
    }
}

impl<'a> Quadtree<'a> {
    /// The root comes first; there is one.
    #[inline]
    pub fn new(nodes: &'a [QuadNode]) -> Quadtree<'a> {
        Quadtree { nodes }
    }

    /// A unit direction; `u` is in [0, 1)². Its density is [`Self::density`] of it, and positive.
    #[inline]
    pub fn draw(&self, u: [f32; 2]) -> Vec3 {
        let ([mut u, mut v], mut cell, mut level) = (u, [0u32; 2], 0);
        let mut node = self.nodes[0];
        loop {
            let (x, y);
            (x, u) = choose(u, node.lower_x());
            (y, v) = choose(v, node.lower_y(x));
            cell = [cell[0] << 1 | x, cell[1] << 1 | y];
            level += 1;
            let Some(child) = node.branch().child(x | y << 1) else { break };
            node = self.nodes[child];
        }
        // In fixed point, rounding never leaves the cell. The way to world space and back keeps z to the bit, but
        // moves the azimuth by up to two steps: so much it keeps off the cell's borders.
        let rest = 24 - level;
        let within = |cell: u32, u: f32, margin: u32| {
            let steps = 1u32 << rest;
            (cell << rest) + ((u * steps as f32) as u32).clamp(margin, steps - 1 - margin)
        };
        decode([within(cell[0], u, 0), within(cell[1], v, 2)])
    }

    /// Density per steradian of [`Self::draw`] at the unit direction `w` of world space.
    #[inline]
    pub fn density(&self, w: Vec3) -> f32 {
        self.density_encoded(encode(w))
    }

    /// The same of an [`encode`]d direction.
    #[inline]
    pub fn density_encoded(&self, [x, y]: [u16; 2]) -> f32 {
        let (mut x, mut y) = ((x as u32) << 16, (y as u32) << 16);
        let (mut node, mut pdf) = (self.nodes[0], 0.25 * FRAC_1_PI);
        loop {
            pdf *= node.density(x >> 31, y >> 31);
            let Some(child) = node.branch().child(x >> 31 | y >> 31 << 1) else { return pdf };
            node = self.nodes[child];
            (x, y) = (x << 1, y << 1);
        }
    }

    #[cfg(test)]
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    #[cfg(test)]
    pub fn words(&self) -> &'a [QuadNode] {
        self.nodes
    }
}

/// The half that `u` falls into, the lower one having `lower` of [`ONE`], and `u` rescaled to it.
#[inline]
fn choose(u: f32, lower: u32) -> (u32, f32) {
    // arithmetic instead of a branch that is guessed wrong half of the time; all but the quotient is exact
    let p = lower as f32 * (1.0 / ONE as f32);
    let half = (u >= p) as u32;
    let upper = half as f32;
    (half, (u - upper * p) / (p + upper * (1.0 - 2.0 * p)))
}
