//! The nearest site, exactly: a balanced k-d tree without pointers (Bentley 1975).

use super::Site;
use super::agreement::{Bin, Bins, agree, bin};
use glam::Vec3;
use std::cmp::Ordering;

/// Sites of a leaf at most.
const LEAF: usize = 8;

/// Bytes of a site and, at worst, its share of the nodes: leaves are more than half full, nodes twice as many.
pub const BYTES_PER_SITE: usize = 2 * size_of::<Vec3>() + 4 * size_of::<SiteNode>() / LEAF;

/// A tree over sites, which it keeps in the order of its leaves. SiteNode i has the children 2i and 2i + 1; each has half of
/// the sites, so that their ranges need not be stored.
#[derive(Clone, Debug)]
pub struct SiteTree {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    nodes: Vec<SiteNode>,
}

#[derive(Clone, Copy, Debug, Default)]
struct SiteNode {
    /// The bins of the normals below.
    bins: Bins,
    split: f32,
    axis: u32,
}

/// A subtree: its node and its sites.
#[derive(Clone, Copy, Default)]
struct Part {
    node: u32,
    begin: u32,
    end: u32,
}

impl Part {
    #[inline]
    fn halves(self) -> (Part, Part) {
        let middle = self.begin + (self.end - self.begin) / 2;
        let node = 2 * self.node;
        (Part { node, end: middle, ..self }, Part { node: node + 1, begin: middle, ..self })
    }
}

impl SiteTree {
    /// A tree of one site or more, all finite with unit normals. The same sites make the same tree, in whatever order they
    /// come.
    pub fn new(mut sites: Vec<Site>) -> SiteTree {
        let leaves = sites.len().div_ceil(LEAF).next_power_of_two();
        let mut nodes = vec![SiteNode::default(); 2 * leaves];
        build(&mut sites, &mut nodes, 1);
        let (points, normals) = sites.iter().map(|site| (site.p, site.n)).unzip();
        SiteTree { points, normals, nodes }
    }

    /// The nearest site whose normal agrees with `n`, or the nearest of all where none does; of equally near ones the
    /// first.
    #[cold]
    #[inline(never)]
    pub fn nearest(&self, p: Vec3, n: Vec3) -> u32 {
        let partners = Bin::all()[bin(n)].partners;
        self.nearest_where(p, partners, |site| agree(n, self.normals[site as usize]))
            .or_else(|| self.nearest_where(p, Bins::MAX, |_| true))
            .map_or(0, |(site, _)| site)
    }

    /// The nearest site with a normal in `bins` that `accept` takes, and its squared distance.
    pub fn nearest_where(&self, p: Vec3, bins: Bins, accept: impl Fn(u32) -> bool) -> Option<(u32, f32)> {
        let mut best = (u32::MAX, f32::INFINITY);
        self.visit(p, bins, f32::INFINITY, |site, d2| {
            if (d2 < best.1 || (d2 == best.1 && site < best.0)) && accept(site) {
                best = (site, d2);
            }
            best.1
        });
        (best.0 != u32::MAX).then_some(best)
    }

    /// Shows `meet` sites near `p`, with their squared distances: all those with normals in `bins` and a squared
    /// distance up to `bound`, and some others. What `meet` returns is the bound from there on.
    #[inline]
    pub fn visit(&self, p: Vec3, bins: Bins, mut bound: f32, mut meet: impl FnMut(u32, f32) -> f32) {
        let mut stack = [(Part::default(), 0.0); u32::BITS as usize];
        stack[0] = (Part { node: 1, begin: 0, end: self.points.len() as u32 }, 0.0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (mut part, least) = stack[height];
            // not-a-number passes: it meets everything, and wins nowhere
            if least > bound {
                continue;
            }
            loop {
                let node = &self.nodes[part.node as usize];
                if node.bins & bins == 0 {
                    break;
                }
                if part.node as usize >= self.nodes.len() / 2 {
                    (part.begin..part.end).for_each(|site| bound = meet(site, self.distance2(site, p)));
                    break;
                }
                let offset = p[node.axis as usize] - node.split;
                let (below, above) = part.halves();
                let (near, far) = if offset < 0.0 { (below, above) } else { (above, below) };
                stack[height] = (far, least.max(offset * offset));
                height += 1;
                part = near;
            }
        }
    }

    /// Squared distance of a site from `p`.
    #[inline]
    pub fn distance2(&self, site: u32, p: Vec3) -> f32 {
        (p - self.points[site as usize]).length_squared()
    }

    #[inline]
    pub fn point(&self, site: u32) -> Vec3 {
        self.points[site as usize]
    }

    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.points[..]) + size_of_val(&self.normals[..]) + size_of_val(&self.nodes[..])
    }
}

/// Sorts `sites` into the halves of the subtree at `node`, along the longest side of their box, and returns the bins of
/// their normals.
fn build(sites: &mut [Site], nodes: &mut [SiteNode], node: usize) -> Bins {
    if node >= nodes.len() / 2 {
        sites.sort_unstable_by(|a, b| before(a, b, 0));
        nodes[node].bins = sites.iter().fold(0, |bins, site| bins | 1 << bin(site.n));
        return nodes[node].bins;
    }
    let low = sites.iter().fold(Vec3::INFINITY, |low, site| low.min(site.p));
    let high = sites.iter().fold(Vec3::NEG_INFINITY, |high, site| high.max(site.p));
    let axis = (high - low).max_position();
    let middle = sites.len() / 2;
    sites.select_nth_unstable_by(middle, |a, b| before(a, b, axis));
    let split = sites[middle].p[axis];
    let (below, above) = sites.split_at_mut(middle);
    let bins = build(below, nodes, 2 * node) | build(above, nodes, 2 * node + 1);
    nodes[node] = SiteNode { bins, split, axis: axis as u32 };
    bins
}

/// The order along an axis; sites that are level there go by their other coordinates, and then by their normals.
fn before(a: &Site, b: &Site, axis: usize) -> Ordering {
    let numbers = |site: &Site| site.p.to_array().into_iter().chain(site.n.to_array());
    let others = || numbers(a).zip(numbers(b)).map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne());
    a.p[axis].total_cmp(&b.p[axis]).then_with(|| others().unwrap_or(Ordering::Equal))
}
