//! A light hierarchy (Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"): a light
//! is chosen by what it may send to a point.
//!
//! A node has up to sixteen children. Their importances are computed side by side, and one child is drawn in proportion to
//! them. Lights at infinity take part beside the children of the root.

mod bounds;
mod build;
mod draw;
mod far;
mod node;
mod patch;

pub(super) use bounds::LightBounds;
pub(super) use draw::{Choice, ChoiceLanes};
pub(super) use far::FarLight;
pub(super) use patch::Patch;

use super::LightSampleContext;
use crate::simd::{LANES, Lanes};
use draw::{Draw, Sums, draw};
use far::Far;
use glam::Vec3;
use node::{Child, Link, Node};
use patch::part;

/// Chooses a light by what it may send to a point.
#[derive(Clone, Debug)]
pub(super) struct LightTree {
    /// The root first. Where all lights are at infinity it has no children.
    nodes: Vec<Node>,
    /// How many children the root has.
    children: usize,
    /// What holds all lights of the tree, where none is at infinity: many points are lit by nothing at all.
    whole: Option<Child>,
    /// Lights at infinity, which stand beside the root's children, and their indices.
    far: Vec<(Far, u32)>,
    /// The light or the patch, if there is but one: it is chosen without a look.
    only: Option<u32>,
    /// By light, the share that it has of its patch; empty where all are 1.
    shares: Vec<f32>,
    /// Where each node and each light is.
    node_places: Vec<Place>,
    light_places: Vec<Place>,
    /// By which coordinates are multiplied: a power of two, so that no digit is lost.
    scale: f32,
}

/// Where a node or a light is: a node times [`LANES`] and a place in it, or one of these.
type Place = u32;
/// Plus a place among the lights at infinity.
const FAR: Place = 1 << 31;
/// At the root, or no light that shines.
const NOWHERE: Place = u32::MAX;

impl LightTree {
    /// What a light takes at most, with what is needed only to build the tree: its bounds, and half a node, twice where nodes
    /// are moved.
    pub const BYTES_PER_LIGHT: u64 = (2 * size_of::<LightBounds>() + size_of::<Node>() + 16) as u64;

    /// Lights that shine, by their indices below `count`.
    pub fn new(near: &[Patch], far: &[(u32, FarLight)], count: usize) -> LightTree {
        let scale = unit_scale(near.iter().map(|patch| patch.bounds.largest_coordinate()).fold(0.0, f32::max));
        let bounds: Vec<LightBounds> = near.iter().map(|patch| patch.bounds.scaled(scale)).collect();
        let brightest = far.iter().map(|(_, light)| light.irradiance).fold(0.0, f64::max);
        let (mut nodes, unit) = build::nodes(&bounds, &mut Vec::from_iter(0..bounds.len() as u32), brightest);
        nodes.iter_mut().for_each(|node| node.rename(|k| near[k as usize].light));
        let mut tree = LightTree {
            children: nodes[0].count(),
            whole: build::whole(&bounds).filter(|_| far.is_empty()).map(|cluster| Child::whole(&cluster)),
            far: far.iter().map(|(index, light)| (Far::new(light, unit), *index)).collect(),
            only: (near.len() + far.len() == 1).then(|| near.first().map_or_else(|| far[0].0, |patch| patch.light)),
            shares: shares(near, count),
            node_places: vec![NOWHERE; nodes.len()],
            light_places: vec![NOWHERE; count],
            nodes,
            scale,
        };
        tree.find_places();
        for patch in near.iter().filter(|patch| patch.is_pair()) {
            tree.light_places[patch.light as usize + 1] = tree.light_places[patch.light as usize];
        }
        tree
    }

    /// Of memory.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.nodes.len() * (size_of::<Node>() + size_of::<Place>()) + self.light_places.len() * size_of::<Place>()
    }

    /// Whether there is but one light, or patch.
    pub fn is_single(&self) -> bool {
        self.only.is_some()
    }

    fn find_places(&mut self) {
        for (parent, node) in self.nodes.iter().enumerate() {
            for k in 0..node.count() {
                let place = (parent * LANES + k) as Place;
                match node.link(k) {
                    Link::Node(below) => self.node_places[below as usize] = place,
                    Link::Light(light) => self.light_places[light as usize] = place,
                }
            }
        }
        for (k, (_, light)) in self.far.iter().enumerate() {
            self.light_places[*light as usize] = FAR + k as Place;
        }
    }

    /// Draws a light for a point; `None` where that can be lit by none of those among which the draws have led it.
    pub fn choose(&self, ctx: &LightSampleContext, u: f64) -> Option<Choice> {
        let patch = self.choose_patch(ctx, u)?;
        if self.shares.is_empty() {
            return Some(patch);
        }
        let (next, pmf, rest) = part(self.shares[patch.light as usize], patch.rest);
        Some(Choice { light: patch.light + next, pmf: patch.pmf * pmf, rest })
    }

    fn choose_patch(&self, ctx: &LightSampleContext, u: f64) -> Option<Choice> {
        if let Some(light) = self.only {
            return Some(Choice { light, pmf: 1.0, rest: u });
        }
        let (p, n) = (ctx.p * self.scale, ctx.n);
        if !self.may_reach(p, n, n != Vec3::ZERO) {
            return None;
        }
        let Draw { index, mut pmf, rest: mut u } = self.draw_at_root(p, n, u)?;
        if index >= LANES {
            return Some(Choice { light: self.far[index - LANES].1, pmf: pmf as f32, rest: u });
        }
        let mut link = self.nodes[0].link(index);
        loop {
            match link {
                Link::Light(light) => return Some(Choice { light, pmf: pmf as f32, rest: u }),
                Link::Node(node) => {
                    let node = &self.nodes[node as usize];
                    let next = draw(&node.importances(p, n), u)?;
                    (link, pmf, u) = (node.link(next.index), pmf * next.pmf, next.rest);
                }
            }
        }
    }

    /// Whether light may reach the side of `n` at `p`, in the tree's unit of length; or `p` at all, unless `oriented`.
    #[inline(always)]
    fn may_reach(&self, p: Vec3, n: Vec3, oriented: bool) -> bool {
        self.whole.as_ref().is_none_or(|whole| whole.importance(p, n, oriented) > 0.0)
    }

    /// What the root says of a point, for questions about the probabilities of lights.
    pub fn root(&self, ctx: &LightSampleContext) -> RootView<'_> {
        let (p, n) = (ctx.p * self.scale, ctx.n);
        let looks = self.only.is_none() && self.may_reach(p, n, n != Vec3::ZERO);
        let importances = if looks { self.nodes[0].importances(p, n) } else { [0.0; LANES] };
        let far = self.far.iter().map(|(far, _)| far.importance(n));
        let total = importances.iter().copied().chain(far).fold(0.0, |total, one| total + f64::from(one));
        RootView { tree: self, p, n, importances, total }
    }
}

/// The importances at the root as a point sees them.
pub(super) struct RootView<'a> {
    tree: &'a LightTree,
    p: Vec3,
    n: Vec3,
    importances: Lanes,
    total: f64,
}

impl RootView<'_> {
    /// Probability that [`LightTree::choose`] draws this light.
    pub fn pmf(&self, light: u32) -> f32 {
        self.pmf_of_patch(light) * self.tree.shares.get(light as usize).unwrap_or(&1.0)
    }

    fn pmf_of_patch(&self, light: u32) -> f32 {
        let tree = self.tree;
        let mut place = tree.light_places[light as usize];
        if tree.is_single() {
            return f32::from(place != NOWHERE);
        }
        if place == NOWHERE || !is_amount(self.total) {
            return 0.0;
        }
        if place >= FAR {
            return (f64::from(tree.far[(place - FAR) as usize].0.importance(self.n)) / self.total) as f32;
        }
        let mut pmf = 1.0;
        while place as usize >= LANES {
            let (node, k) = (place as usize / LANES, place as usize % LANES);
            let importances = tree.nodes[node].importances(self.p, self.n);
            let total = Sums::new(&importances).total;
            if !is_amount(total) {
                return 0.0;
            }
            pmf *= f64::from(importances[k]) / total;
            place = tree.node_places[node];
        }
        (pmf * f64::from(self.importances[place as usize]) / self.total) as f32
    }
}

/// As of [`LightTree::shares`].
fn shares(near: &[Patch], count: usize) -> Vec<f32> {
    if !near.iter().any(Patch::is_pair) {
        return Vec::new();
    }
    let mut shares = vec![1.0; count];
    for patch in near.iter().filter(|patch| patch.is_pair()) {
        let first = patch.light as usize;
        (shares[first], shares[first + 1]) = (patch.share, 1.0 - patch.share);
    }
    shares
}

/// Whether anything can be drawn where importances have this sum.
#[inline(always)]
fn is_amount(total: f64) -> bool {
    total > 0.0 && total.is_finite()
}

/// A power of two that brings lengths to between 1 and 2 or so, where the largest is `largest`.
fn unit_scale(largest: f32) -> f32 {
    let exponent = (largest.to_bits() >> 23).clamp(1, 253);
    if largest > 0.0 { f32::from_bits((254 - exponent) << 23) } else { 1.0 }
}
