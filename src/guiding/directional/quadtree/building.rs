//! The quadtree that is being learnt: energy by direction, and how its cells follow it.

use super::frozen::{Branch, MAX_LEVELS, MAX_NODES, QuadNode, are_in_order};
use crate::math::is_amount;
use serde::{Deserialize, Serialize};

/// Side of the square in the units of filter boxes: half steps of an encoded direction, so that all areas are exact.
const SQUARE: u32 = 1 << (MAX_LEVELS + 1);

/// Energy (radiance over density, summed over samples) in the quadrants of a quadtree. Parents come before their
/// children.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyTree {
    branches: Vec<Branch>,
    energy: Vec<[f64; 4]>,
}

/// How fine quadtrees are.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// A cell is divided where it holds more than this share of all energy.
    pub rho: f64,
    /// Levels at most.
    pub levels: u32,
}

impl Fineness {
    pub fn new(rho: f32, levels: u32) -> Fineness {
        // a share below 10⁻⁶ would only fill the quadtree up with what it has room for
        Fineness { rho: rho.max(1e-6) as f64, levels: levels.clamp(1, MAX_LEVELS) }
    }

    /// The same for a share that is `factor` times as large.
    pub fn coarser(self, factor: f32) -> Fineness {
        Fineness { rho: self.rho * factor as f64, ..self }
    }

    /// Whether no cell can hold more energy than it takes to be divided.
    pub fn is_coarsest(self) -> bool {
        // beyond 1, ρ divides nothing
        self.rho >= 1.0
    }
}

/// Part of the square, [low, high) on each axis.
struct Area {
    low: [u32; 2],
    high: [u32; 2],
}

impl EnergyTree {
    /// Bytes of a node.
    pub const BYTES: usize = size_of::<Branch>() + size_of::<[f64; 4]>();

    /// An empty quadtree of the given form.
    fn of(mut branches: Vec<Branch>) -> EnergyTree {
        branches.shrink_to_fit();
        let energy = vec![[0.0; 4]; branches.len()];
        EnergyTree { branches, energy }
    }

    /// Leaves all energy only a share of itself.
    pub fn decay(&mut self, share: f32) {
        self.energy.iter_mut().flatten().for_each(|energy| *energy *= share as f64);
    }

    /// All energy; after [`EnergyTree::sum_up`].
    pub fn whole(&self) -> f64 {
        self.energy[0].iter().sum()
    }

    /// The solid angle's share and the energy of each leaf, and its middle in the unit square.
    pub fn visit_leaves(&self, visit: &mut impl FnMut([f32; 2], f64)) {
        self.visit_below(0, [0.0; 2], 0.5, visit);
    }

    fn visit_below(&self, node: usize, corner: [f32; 2], half: f32, visit: &mut impl FnMut([f32; 2], f64)) {
        for q in 0..4u32 {
            let corner = [corner[0] + (q & 1) as f32 * half, corner[1] + (q >> 1) as f32 * half];
            match self.branches[node].child(q) {
                Some(child) => self.visit_below(child, corner, 0.5 * half, visit),
                None => visit([corner[0] + 0.5 * half, corner[1] + 0.5 * half], self.energy[node][q as usize]),
            }
        }
    }

    pub fn nodes(&self) -> usize {
        self.branches.len()
    }

    /// Whether this is a quadtree with energies that can have been learnt.
    pub fn is_sound(&self) -> bool {
        let known = self.energy.len() == self.branches.len() && self.energy.iter().flatten().all(|&e| is_amount(e));
        known && are_in_order(self.branches.iter().copied())
    }

    /// Adds energy at an encoded direction, to its leaf or, with `filter`, spread evenly over a box of the leaf's
    /// size about the direction (Müller 2019).
    pub fn splat(&mut self, at: [u16; 2], energy: f64, filter: bool) {
        if energy == 0.0 {
            return;
        }
        let (node, quadrant, level) = self.leaf(at);
        if !filter {
            self.energy[node][quadrant] += energy;
            return;
        }
        let side = SQUARE >> level;
        // each coordinate in the middle of its step; the azimuth goes round, at the poles the box stays inside
        let low = at.map(|v| (2 * v as u32 + 1).wrapping_sub(side / 2));
        let x = (low[0] as i32).clamp(0, (SQUARE - side) as i32) as u32;
        let y = low[1] % SQUARE;
        let density = energy / (side as f64 * side as f64);
        let mut spread = |from: u32, to: u32| {
            let area = Area { low: [x, from], high: [x + side, to] };
            self.spread(0, [0, 0], SQUARE / 2, &area, density);
        };
        spread(y, (y + side).min(SQUARE));
        if y + side > SQUARE {
            spread(0, y + side - SQUARE);
        }
    }

    /// The node and quadrant of an encoded direction, and the level of that quadrant, from 1 on.
    fn leaf(&self, [x, y]: [u16; 2]) -> (usize, usize, u32) {
        let (mut node, mut level) = (0, 1);
        loop {
            let shift = MAX_LEVELS - level;
            let quadrant = (x as u32 >> shift & 1) | (y as u32 >> shift & 1) << 1;
            match self.branches[node].child(quadrant) {
                None => return (node, quadrant as usize, level),
                Some(child) => (node, level) = (child, level + 1),
            }
        }
    }

    /// Adds `density` times the area that leaves under `node` share with `area`; `half` is the side of the node's
    /// quadrants.
    fn spread(&mut self, node: usize, corner: [u32; 2], half: u32, area: &Area, density: f64) {
        for q in 0..4 {
            let corner = [corner[0] + (q & 1) * half, corner[1] + (q >> 1) * half];
            let shared = |a: usize| area.high[a].min(corner[a] + half).saturating_sub(area.low[a].max(corner[a]));
            let (width, height) = (shared(0), shared(1));
            if width == 0 || height == 0 {
                continue;
            }
            match self.branches[node].child(q) {
                Some(child) => self.spread(child, corner, half / 2, area, density),
                None => self.energy[node][q as usize] += density * (width as f64 * height as f64),
            }
        }
    }

    /// Sums up the energy of what is divided; returns the whole.
    pub fn sum_up(&mut self) -> f64 {
        for node in (0..self.nodes()).rev() {
            for q in 0..4 {
                if let Some(child) = self.branches[node].child(q) {
                    self.energy[node][q as usize] = self.energy[child].iter().sum();
                }
            }
        }
        self.energy[0].iter().sum()
    }

    /// The distribution of the energy; after [`EnergyTree::sum_up`].
    pub fn write(&self, out: &mut [QuadNode]) {
        for (out, (branch, energy)) in out.iter_mut().zip(self.branches.iter().zip(&self.energy)) {
            *out = QuadNode::new(*branch, *energy);
        }
    }

    /// The form that follows the energy; after [`EnergyTree::sum_up`]. A leaf that is to be divided deals its energy
    /// evenly. Without energy the form stays.
    pub fn refined(&self, fineness: Fineness) -> EnergyTree {
        let whole = self.whole();
        if whole == 0.0 {
            return self.clone();
        }
        let least = fineness.rho * whole;
        let mut branches = Vec::new();
        // breadth first: if there is no room for more nodes, it is the finest that are missing
        let mut open = vec![(Some(0), self.energy[0], 1)];
        while let Some(&(old, energy, level)) = open.get(branches.len()) {
            let (base, mut mask) = (open.len(), 0);
            for q in 0..4 {
                let whole = energy[q as usize];
                if whole > least && level < fineness.levels && open.len() < MAX_NODES {
                    mask |= 1 << q;
                    let child = old.and_then(|node: usize| self.branches[node].child(q));
                    open.push((child, child.map_or([whole / 4.0; 4], |c| self.energy[c]), level + 1));
                }
            }
            branches.push(Branch::new(base, mask));
        }
        branches.shrink_to_fit();
        EnergyTree { branches, energy: open.into_iter().map(|(_, energy, _)| energy).collect() }
    }

    /// The form that evenly spread energy asks for.
    pub fn uniform(fineness: Fineness) -> EnergyTree {
        let whole = EnergyTree { branches: vec![Branch::new(1, 0)], energy: vec![[0.25; 4]] };
        EnergyTree::of(whole.refined(fineness).branches)
    }
}
