//! A tree of directions: the hemisphere's square cut into 4×4 cells, and a cell that holds much of the light cut again.
//!
//! It is the quadtree of Müller et al. (2017) two levels at a time: a node of 16 cells is drawn from with one vector
//! comparison, and what sampling reads of it is one cache line.

use super::qtable::Entry;
use super::strata::mean_cosine;
use crate::math::warp;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;

/// Cells along the side of a node.
const SIDE: u32 = 4;
/// Cells of a node.
pub const FAN: usize = (SIDE * SIDE) as usize;
/// Nodes on the way to the smallest cells: 64×64 over the hemisphere.
const DEPTH: usize = 3;
/// Nodes of a state at most, so that their numbers fit.
const MAX_NODES: usize = 1 << 12;
/// Parts into which a node divides the unit interval.
const WHOLE: u32 = 1 << 16;

/// What sampling reads of a node: where each cell begins in the unit interval, in units of 1/`WHOLE`, and the node that
/// cuts it, counted from the state's first; 0 for none. Draws and densities both go by the rounded numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Node {
    starts: [u16; FAN],
    children: [u16; FAN],
}

/// What the learner keeps of a state's directions: the cells of all nodes, and which node cuts each (0 for none).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cells {
    pub entries: Vec<Entry>,
    children: Vec<u16>,
}

/// What is the same for all trees.
#[derive(Clone, Debug)]
pub struct TreeShape {
    /// Mean cosines of the cells of each size, over the whole square.
    cosines: [Vec<f32>; DEPTH],
    /// A cell with more than this share of a state's irradiance is cut.
    share: f32,
    /// And with at least this many visits.
    visits: f32,
}

/// Where a cell is: the size, by how many nodes lead to it, and its place among those of its size.
#[derive(Clone, Copy, Debug)]
struct Place {
    depth: usize,
    x: u32,
    y: u32,
}

impl Place {
    const ROOT: Place = Place { depth: 0, x: 0, y: 0 };

    #[inline]
    fn cell(self, k: usize) -> Place {
        Place { depth: self.depth + 1, x: self.x * SIDE + k as u32 % SIDE, y: self.y * SIDE + k as u32 / SIDE }
    }

    /// Cells of its size along the square's side.
    #[inline]
    fn side(self) -> u32 {
        SIDE.pow(self.depth as u32)
    }

    /// Uniform direction in the cell, in the state's frame.
    #[inline]
    fn direction(self, inside: [f32; 2]) -> Vec3 {
        let scale = 1.0 / self.side() as f32;
        let square = [(self.x as f32 + inside[0]) * scale, (self.y as f32 + inside[1]) * scale];
        warp::square_to_uniform_hemisphere(square)
    }

    #[inline]
    fn solid_angle(self) -> f32 {
        TAU / (self.side() * self.side()) as f32
    }
}

/// What the estimates of a node's cells amount to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Totals {
    /// ∫ Q cosθ dω.
    pub irradiance: f32,
    /// max Q cosθ.
    pub peak: f32,
}

impl TreeShape {
    pub fn new(share: f32, visits: f32) -> TreeShape {
        let cosines = [1, 2, 3].map(|depth| {
            let side = SIDE.pow(depth);
            (0..side * side).map(|k| mean_cosine(side, k)).collect()
        });
        TreeShape { cosines, share, visits }
    }

    fn cosine(&self, place: Place) -> f32 {
        self.cosines[place.depth - 1][(place.y * place.side() + place.x) as usize]
    }

    /// Cuts cells that hold more than their share of the light and are visited enough, joins those that do not, and
    /// hands what they know to the new ones.
    pub fn refine(&self, cells: &Cells) -> Cells {
        let irradiance = self.irradiance(cells, 0, Place::ROOT, 0.0);
        let mut refined = Cells { entries: Vec::new(), children: Vec::new() };
        let root: [Entry; FAN] = std::array::from_fn(|k| cells.entries[k]);
        self.rebuild(cells, Some(0), &root, Place::ROOT, self.share * irradiance, &mut refined);
        refined
    }

    /// Appends the node at `place`, whose cells are those of node `old`, or new ones that know what `inherited` says.
    fn rebuild(
        &self,
        cells: &Cells,
        old: Option<usize>,
        inherited: &[Entry; FAN],
        place: Place,
        limit: f32,
        out: &mut Cells,
    ) -> usize {
        let node = out.children.len() / FAN;
        out.entries.extend(inherited);
        out.children.extend([0; FAN]);
        for (k, own) in inherited.iter().enumerate() {
            let at = place.cell(k);
            let child = old.and_then(|old| cells.child(old, k));
            let entry = child.map_or(*own, |child| cells.summary(child));
            out.entries[node * FAN + k] = entry;
            let light = match child {
                Some(child) => self.irradiance(cells, child, at, entry.q),
                None => entry.q * self.cosine(at) * at.solid_angle(),
            };
            let enough = light > limit && entry.visits >= self.visits;
            if at.depth == DEPTH || !enough || out.children.len() / FAN >= MAX_NODES {
                continue;
            }
            let part = Entry { q: entry.q, visits: entry.visits / FAN as f32 };
            let next = child.map_or([part; FAN], |child| std::array::from_fn(|i| cells.entries[child * FAN + i]));
            let child = self.rebuild(cells, child, &next, at, limit, out);
            out.children[node * FAN + k] = child as u16;
        }
        node
    }

    /// ∫ Q cosθ dω over each cell of the root.
    pub fn profile(&self, cells: &Cells) -> [f32; FAN] {
        let prior = cells.mean(0).unwrap_or(0.0);
        std::array::from_fn(|k| match (cells.child(0, k), Place::ROOT.cell(k)) {
            (Some(child), at) => self.irradiance(cells, child, at, prior),
            (None, at) => cells.entries[k].shrunk(prior) * self.cosine(at) * at.solid_angle(),
        })
    }

    /// ∫ Q cosθ dω over a node; `prior` is what its parent would expect.
    fn irradiance(&self, cells: &Cells, node: usize, place: Place, prior: f32) -> f32 {
        let prior = cells.mean(node).unwrap_or(prior);
        (0..FAN)
            .map(|k| match (cells.child(node, k), place.cell(k)) {
                (Some(child), at) => self.irradiance(cells, child, at, prior),
                (None, at) => cells.entries[node * FAN + k].shrunk(prior) * self.cosine(at) * at.solid_angle(),
            })
            .sum()
    }

    /// ∫ Q cosθ dω and max Q cosθ.
    pub fn totals(&self, cells: &Cells) -> Totals {
        self.freeze(cells, &|_, _| 0.0, &mut Vec::new())
    }

    /// Appends what sampling needs: cells are drawn in proportion to `weight(Q, cosθ)` times their solid angle.
    pub fn freeze(&self, cells: &Cells, weight: &impl Fn(f32, f32) -> f32, out: &mut Vec<Node>) -> Totals {
        let base = out.len();
        out.resize(base + cells.nodes(), Node { starts: [0; FAN], children: [0; FAN] });
        let mut totals = Totals::default();
        self.freeze_node(cells, 0, Place::ROOT, 0.0, weight, &mut out[base..], &mut totals);
        totals
    }

    /// Returns the node's weight.
    #[allow(clippy::too_many_arguments, reason = "one step of a recursion")]
    fn freeze_node(
        &self,
        cells: &Cells,
        node: usize,
        place: Place,
        prior: f32,
        weight: &impl Fn(f32, f32) -> f32,
        out: &mut [Node],
        totals: &mut Totals,
    ) -> f64 {
        let prior = cells.mean(node).unwrap_or(prior);
        let mut begun = [0.0f64; FAN + 1];
        for k in 0..FAN {
            let at = place.cell(k);
            let mass = match cells.child(node, k) {
                Some(child) => {
                    out[node].children[k] = child as u16;
                    self.freeze_node(cells, child, at, prior, weight, out, totals)
                }
                None => {
                    let (q, cos) = (cells.entries[node * FAN + k].shrunk(prior), self.cosine(at));
                    totals.irradiance += q * cos * at.solid_angle();
                    totals.peak = totals.peak.max(q * cos);
                    (weight(q, cos) * at.solid_angle()) as f64
                }
            };
            begun[k + 1] = begun[k] + mass;
        }
        out[node].starts = starts(&begun);
        begun[FAN]
    }
}

/// Rounded shares of the unit interval; a node without weight is drawn from evenly.
fn starts(begun: &[f64; FAN + 1]) -> [u16; FAN] {
    let whole = begun[FAN];
    std::array::from_fn(|k| {
        let share = if whole > 0.0 { begun[k] / whole } else { k as f64 / FAN as f64 };
        (share * WHOLE as f64).round().min((WHOLE - 1) as f64) as u16
    })
}

impl Cells {
    /// Nothing known, nothing cut.
    pub fn new() -> Cells {
        Cells { entries: vec![Entry::default(); FAN], children: vec![0; FAN] }
    }

    pub fn nodes(&self) -> usize {
        self.children.len() / FAN
    }

    #[inline]
    fn child(&self, node: usize, k: usize) -> Option<usize> {
        Some(self.children[node * FAN + k] as usize).filter(|&child| child != 0)
    }

    /// The entry for a direction in the state's frame; `None` below its horizon.
    #[inline]
    pub fn entry_mut(&mut self, local: Vec3) -> Option<&mut Entry> {
        let [x, y] = coordinates(local)?;
        let mut node = 0;
        for depth in 1..=DEPTH {
            let k = cell_at(x, y, depth);
            match self.child(node, k) {
                Some(child) => node = child,
                None => return Some(&mut self.entries[node * FAN + k]),
            }
        }
        None
    }

    /// The estimate for a direction in the state's frame, as sampling sees it; `None` below the horizon.
    pub fn estimate(&self, local: Vec3) -> Option<f32> {
        let [x, y] = coordinates(local)?;
        let (mut node, mut prior) = (0, 0.0);
        for depth in 1..=DEPTH {
            prior = self.mean(node).unwrap_or(prior);
            let k = cell_at(x, y, depth);
            match self.child(node, k) {
                Some(child) => node = child,
                None => return Some(self.entries[node * FAN + k].shrunk(prior)),
            }
        }
        None
    }

    /// Whether the nodes form one tree, in the order in which [`TreeShape::refine`] makes them, and no deeper than there
    /// are cells: what all else relies on, and a file need not hold.
    pub fn is_sound(&self) -> bool {
        let nodes = self.nodes();
        let shaped = nodes >= 1 && self.children.len() == nodes * FAN && self.entries.len() == nodes * FAN;
        let mut next = 1;
        shaped && self.is_sound_below(0, 1, &mut next) && next == nodes
    }

    /// `next` is the node that comes next in the tree's order.
    fn is_sound_below(&self, node: usize, depth: usize, next: &mut usize) -> bool {
        (0..FAN).filter_map(|k| self.child(node, k)).all(|child| {
            let sound = child == *next && child < self.nodes() && depth < DEPTH;
            *next += 1;
            sound && self.is_sound_below(child, depth + 1, next)
        })
    }

    /// Mean over the cells of a node that were visited, cut ones by theirs.
    fn mean(&self, node: usize) -> Option<f32> {
        let known = (0..FAN).filter_map(|k| match self.child(node, k) {
            Some(child) => self.mean(child),
            None => Some(self.entries[node * FAN + k]).filter(|e| e.visits > 0.0).map(|e| e.q),
        });
        let (sum, n) = known.fold((0.0, 0), |(sum, n), q| (sum + q, n + 1));
        (n > 0).then(|| sum / n as f32)
    }

    /// A node as one cell would know it.
    fn summary(&self, node: usize) -> Entry {
        let visits = (0..FAN).map(|k| match self.child(node, k) {
            Some(child) => self.summary(child).visits,
            None => self.entries[node * FAN + k].visits,
        });
        Entry { q: self.mean(node).unwrap_or(0.0), visits: visits.sum() }
    }

    /// Bytes of what is kept of one state's directions.
    pub fn bytes(&self) -> usize {
        self.nodes() * bytes_per_node()
    }
}

impl Default for Cells {
    fn default() -> Cells {
        Cells::new()
    }
}

/// Bytes that a node takes, learnt and frozen.
pub fn bytes_per_node() -> usize {
    FAN * (size_of::<Entry>() + size_of::<u16>()) + size_of::<Node>()
}

/// A direction in the state's frame, in units of the smallest cells.
#[inline]
fn coordinates(local: Vec3) -> Option<[u32; 2]> {
    const SMALLEST: f32 = (SIDE * SIDE * SIDE) as f32;
    (local.z >= 0.0).then(|| warp::uniform_hemisphere_to_square(local).map(|v| (v * SMALLEST) as u32))
}

/// The cell at `depth` that holds the coordinates.
#[inline]
fn cell_at(x: u32, y: u32, depth: usize) -> usize {
    let shift = 2 * (DEPTH - depth);
    (((y >> shift) % SIDE) * SIDE + (x >> shift) % SIDE) as usize
}

/// Draws a direction in the state's frame from the nodes of a state.
#[inline]
pub fn sample(nodes: &[Node], mut u: f64, inside: [f32; 2]) -> Vec3 {
    let (mut node, mut place) = (&nodes[0], Place::ROOT);
    loop {
        let at = (u * WHOLE as f64) as u16;
        // counting instead of searching: no branch to guess wrong, and it runs in vectors
        let k = node.starts[1..].iter().map(|&start| (start <= at) as usize).sum::<usize>();
        place = place.cell(k);
        let child = node.children[k] as usize;
        if child == 0 {
            return place.direction(inside);
        }
        let (from, to) = node.range(k);
        u = ((u * WHOLE as f64 - from as f64) / (to - from) as f64).min(crate::math::ONE_MINUS_EPSILON_F64);
        node = &nodes[child];
    }
}

/// Density per steradian of [`sample`] at a direction in the state's frame; 0 below the horizon.
#[inline]
pub fn pdf(nodes: &[Node], local: Vec3) -> f32 {
    let Some([x, y]) = coordinates(local) else { return 0.0 };
    let mut density = 1.0 / TAU;
    let mut node = &nodes[0];
    for depth in 1..=DEPTH {
        let k = cell_at(x, y, depth);
        let (from, to) = node.range(k);
        density *= (to - from) as f32 * (FAN as f32 / WHOLE as f32);
        match node.children[k] as usize {
            0 => break,
            child => node = &nodes[child],
        }
    }
    density
}

/// The cells of a state that are not cut, each with the probability of being drawn and the direction of its centre, in
/// the order in which a [`LeafIndex`] numbers them.
pub fn leaves(nodes: &[Node], visit: &mut impl FnMut(f32, Vec3)) {
    visit_leaves(nodes, 0, Place::ROOT, 1.0, visit);
}

fn visit_leaves(nodes: &[Node], node: usize, place: Place, share: f32, visit: &mut impl FnMut(f32, Vec3)) {
    for k in 0..FAN {
        let (from, to) = nodes[node].range(k);
        let share = share * (to - from) as f32 / WHOLE as f32;
        match nodes[node].children[k] as usize {
            0 => visit(share, place.cell(k).direction([0.5; 2])),
            child => visit_leaves(nodes, child, place.cell(k), share, visit),
        }
    }
}

/// Where the leaves of each cell of each node begin in the order of [`leaves`], and the cells' places by leaf.
#[derive(Clone, Debug, Default)]
pub struct LeafIndex {
    first: Vec<[u16; FAN]>,
    places: Vec<Place>,
}

impl LeafIndex {
    pub fn new(nodes: &[Node]) -> LeafIndex {
        let mut index = LeafIndex { first: vec![[0; FAN]; nodes.len()], places: Vec::new() };
        index.number(nodes, 0, Place::ROOT);
        index
    }

    fn number(&mut self, nodes: &[Node], node: usize, place: Place) {
        for k in 0..FAN {
            match nodes[node].children[k] as usize {
                0 => {
                    self.first[node][k] = self.places.len() as u16;
                    self.places.push(place.cell(k));
                }
                child => self.number(nodes, child, place.cell(k)),
            }
        }
    }

    /// The leaf that holds a direction in the state's frame; `None` below its horizon.
    #[inline]
    pub fn leaf(&self, nodes: &[Node], local: Vec3) -> Option<usize> {
        let [x, y] = coordinates(local)?;
        let mut node = 0;
        for depth in 1..=DEPTH {
            let k = cell_at(x, y, depth);
            match nodes[node].children[k] as usize {
                0 => return Some(self.first[node][k] as usize),
                child => node = child,
            }
        }
        None
    }

    /// Uniform direction in a leaf, and the leaf's solid angle.
    #[inline]
    pub fn direction(&self, leaf: usize, inside: [f32; 2]) -> Vec3 {
        self.places[leaf].direction(inside)
    }

    #[inline]
    pub fn solid_angle(&self, leaf: usize) -> f32 {
        self.places[leaf].solid_angle()
    }
}

impl Node {
    /// The cell's part of the unit interval.
    #[inline]
    fn range(&self, k: usize) -> (u32, u32) {
        let to = if k + 1 < FAN { self.starts[k + 1] as u32 } else { WHOLE };
        (self.starts[k] as u32, to)
    }
}
