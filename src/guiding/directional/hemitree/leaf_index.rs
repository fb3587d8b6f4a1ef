//! The cells of a snapshot's tree that are not cut, one after the other.

use super::square::{SquareCell, cell_at, coordinates};
use super::{DEPTH, FAN, Node, WHOLE};
use glam::Vec3;

/// The cells of a state that are not cut, each with the probability of being drawn and the direction of its centre, in
/// the order in which a [`LeafIndex`] numbers them.
pub fn leaves(nodes: &[Node], visit: &mut impl FnMut(f32, Vec3)) {
    visit_leaves(nodes, 0, SquareCell::ROOT, 1.0, visit);
}

fn visit_leaves(nodes: &[Node], node: usize, place: SquareCell, share: f32, visit: &mut impl FnMut(f32, Vec3)) {
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
    places: Vec<SquareCell>,
}

impl LeafIndex {
    pub fn new(nodes: &[Node]) -> LeafIndex {
        let mut index = LeafIndex { first: vec![[0; FAN]; nodes.len()], places: Vec::new() };
        index.number(nodes, 0, SquareCell::ROOT);
        index
    }

    fn number(&mut self, nodes: &[Node], node: usize, place: SquareCell) {
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

    /// The leaf that holds a direction in the region's frame; `None` below its horizon.
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
