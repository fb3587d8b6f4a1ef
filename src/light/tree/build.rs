//! Makes the tree: sets of lights are cut in two until a node is full, and again below each of its children.

use super::bounds::{Cluster, LightBounds, Summary};
use super::node::{Link, Node};
use crate::simd::LANES;
use glam::Vec3;
use rayon::prelude::*;

/// Places where a set may be cut, along each axis, and one more.
const BINS: usize = 16;

/// Sets of more lights are worth a task of their own.
const PARALLEL: usize = 4096;

/// A set on its way to become a child.
struct Part<'a> {
    set: &'a mut [u32],
    sums: Summary,
    cost: f64,
}

/// Nodes over the `set` of lights, the root first. `others`: the brightest of what stands beside the root's children.
pub(super) fn nodes(lights: &[LightBounds], set: &mut [u32], others: f64) -> (Vec<Node>, f64) {
    let parts = parts(lights, set);
    let clusters: Vec<Cluster> = parts.iter().map(|part| cluster(lights, part)).collect();
    let unit = clusters.iter().map(|cluster| cluster.intensity).fold(others, f64::max);
    let below = |part: Part| match part.set {
        [light] => (Link::Light(*light), Vec::new()),
        set => (Link::Node(0), nodes(lights, set, 0.0).0),
    };
    let large = parts.iter().map(|part| part.set.len()).sum::<usize>() > PARALLEL;
    let below: Vec<_> =
        if large { parts.into_par_iter().map(below).collect() } else { parts.into_iter().map(below).collect() };
    let mut all = vec![Node::EMPTY];
    for (k, ((link, nodes), cluster)) in below.into_iter().zip(&clusters).enumerate() {
        let first = all.len() as u32;
        let link = if nodes.is_empty() { link } else { Link::Node(first) };
        all[0].set(k, cluster, link, unit);
        all.extend(nodes.into_iter().map(|node| moved(node, first)));
    }
    (all, unit)
}

/// What holds all lights; `None` where there are none.
pub(super) fn whole(lights: &[LightBounds]) -> Option<Cluster> {
    let set = Vec::from_iter(0..lights.len() as u32);
    let sums = Summary::of(lights.iter(), lights.first()?.axis);
    Some(Cluster::of_set(lights, &set, &sums))
}

/// The node where the first of its tree comes to stand at `first`.
fn moved(mut node: Node, first: u32) -> Node {
    for k in 0..node.count() {
        if let Link::Node(below) = node.link(k) {
            node.set_link(k, Link::Node(below + first));
        }
    }
    node
}

fn cluster(lights: &[LightBounds], part: &Part) -> Cluster {
    match *part.set {
        [light] => Cluster::of_light(&lights[light as usize]),
        _ => Cluster::of_set(lights, part.set, &part.sums),
    }
}

/// The children of a node over a set. Each light of a small set is a child; of a large one the costliest part is cut in two
/// until there are enough, but what is small stays together: it fills a node of its own.
fn parts<'a>(lights: &[LightBounds], set: &'a mut [u32]) -> Vec<Part<'a>> {
    if set.len() <= LANES {
        return set.chunks_mut(1).map(|set| part(lights, set, Vec3::ZERO)).collect();
    }
    let reference = lights[set[0] as usize].axis;
    let mut parts = vec![part(lights, set, reference)];
    while parts.len() < LANES {
        let large = parts.iter().enumerate().filter(|(_, part)| part.set.len() > LANES);
        let Some((k, _)) = large.max_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) else { break };
        let Part { set, sums, .. } = parts.swap_remove(k);
        let reference = sums.axes.try_normalize().unwrap_or_default().as_vec3();
        let middle = cut(lights, set, reference);
        let (a, b) = set.split_at_mut(middle);
        parts.extend([part(lights, a, reference), part(lights, b, reference)]);
    }
    parts
}

fn part<'a>(lights: &[LightBounds], set: &'a mut [u32], reference: Vec3) -> Part<'a> {
    let sums = Summary::of(set.iter().map(|&k| &lights[k as usize]), reference);
    Part { set, sums, cost: sums.cost() }
}

/// Puts the lights of a set in an order, so that those before the place that is returned are one part of it and the others
/// another; neither is empty.
fn cut(lights: &[LightBounds], set: &mut [u32], reference: Vec3) -> usize {
    let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &k in &*set {
        let centre = lights[k as usize].centre;
        (lo, hi) = (lo.min(centre), hi.max(centre));
    }
    let longest = (hi - lo).max_element();
    let cuts = (0..3).filter_map(|axis| {
        let bins = Bins { axis, lo: lo[axis], scale: BINS as f32 / (hi[axis] - lo[axis]) };
        let (at, cost) = bins.best(lights, set, reference)?;
        // thin slices are no good clusters
        Some((bins, at, cost * f64::from(longest / (hi[axis] - lo[axis]))))
    });
    let Some((bins, at, _)) = cuts.min_by(|a, b| a.2.total_cmp(&b.2)) else { return set.len() / 2 };
    let mut middle = 0;
    for k in 0..set.len() {
        if bins.of(&lights[set[k] as usize]) <= at {
            set.swap(middle, k);
            middle += 1;
        }
    }
    middle
}

/// Equal slices of a set across an axis.
struct Bins {
    axis: usize,
    lo: f32,
    scale: f32,
}

impl Bins {
    fn of(&self, light: &LightBounds) -> usize {
        (((light.centre[self.axis] - self.lo) * self.scale) as usize).min(BINS - 1)
    }

    /// After which bin the set is best cut, and what that costs; `None` where it cannot be cut across this axis.
    fn best(&self, lights: &[LightBounds], set: &[u32], reference: Vec3) -> Option<(usize, f64)> {
        if !self.scale.is_finite() {
            return None;
        }
        let mut bins = [Summary::EMPTY; BINS];
        for &k in set {
            let light = &lights[k as usize];
            let bin = self.of(light);
            bins[bin] = bins[bin].with(light, reference);
        }
        let (mut before, mut costs) = (Summary::EMPTY, [f64::INFINITY; BINS]);
        for k in 0..BINS - 1 {
            before = before.join(&bins[k]);
            costs[k] = if before.count > 0 && before.count < set.len() { before.cost() } else { f64::INFINITY };
        }
        let mut after = Summary::EMPTY;
        for k in (0..BINS - 1).rev() {
            after = after.join(&bins[k + 1]);
            costs[k] += after.cost();
        }
        let best = (0..BINS - 1).min_by(|&a, &b| costs[a].total_cmp(&costs[b]))?;
        costs[best].is_finite().then_some((best, costs[best]))
    }
}
