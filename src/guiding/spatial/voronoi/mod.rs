//! Surface Voronoi states (Dahm & Keller 2017, §2): sites on the surfaces, and every point belongs to one of them.
//!
//! The state of a point p with facing normal n is the nearest site among those whose normal agrees (n·n' > 0.5, less
//! than 60° apart); where no site of the scene agrees, it is the nearest of all. Equally near sites go by the lower
//! index. So the two sides of a thin sheet never share a state as long as each has a site, wherever that lies.
//!
//! [`SiteTree`] finds that site in any case, in O(log n). [`candidate_cells`] remembers, for boxes near the surface, the few sites
//! that can be the answer anywhere within: most look-ups are one probe of a hash and a handful of distances, and
//! agree with the tree's to the bit.

mod agreement;
mod candidate_cells;
mod partition;
mod placement;
mod site_tree;
mod sites;
#[cfg(test)]
mod tests;

pub(crate) use partition::SurfaceVoronoi;
pub(crate) use placement::Gathered;
pub use sites::{Facet, sites_by_area, sites_from_visits};

use crate::math::Frame;
use crate::simd::{LANES, Mask, Vec3Lanes, each};
use candidate_cells::CandidateCells;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use site_tree::SiteTree;

/// Where a state sits: `p` in world space, `n` the unit normal of the side that it is for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Site {
    pub p: Vec3,
    pub n: Vec3,
}

/// The sites, and what finds the one of a point.
#[derive(Clone, Debug)]
pub struct Voronoi {
    tree: SiteTree,
    cells: CandidateCells,
    frames: Vec<Frame>,
}

/// Bytes of a frame, a site in the tree and its share of the nodes.
const TREE_BYTES: usize = size_of::<Frame>() + site_tree::BYTES_PER_SITE;

impl Voronoi {
    /// States of `sites`; those that are not finite, or have no normal, are left out. `None` without any site.
    ///
    /// States are numbered anew, so that neighbours lie together in memory: see [`Self::sites`]. `samples` are points
    /// with unit normals where look-ups are to be expected (path vertices, or points spread over the surfaces): they
    /// make look-ups near them fast and change no answer.
    pub fn new(sites: Vec<Site>, samples: &[(Vec3, Vec3)]) -> Option<Voronoi> {
        let sites: Vec<Site> = sites.into_iter().filter_map(valid).collect();
        if sites.is_empty() || sites.len() > candidate_cells::MAX_SITES {
            return None;
        }
        let tree = SiteTree::new(sites);
        let cells = CandidateCells::new(&tree, samples);
        let frames = tree.normals().iter().map(|n| Frame::from_normal(*n)).collect();
        Some(Voronoi { tree, cells, frames })
    }

    /// The state of point `p` with unit normal `n` on the side of the path, below [`Self::len`]. `jitter`, in [0, 1)²,
    /// moves the point in the plane about `n` by up to half the spacing of the sites around it (infinity norm): over
    /// many look-ups neighbouring states blend. [0.5, 0.5] leaves the point where it is. What is not a number has
    /// some state.
    // as a call, points would go through memory
    #[inline(always)]
    pub fn state(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> u32 {
        let (p, scale) = self.cells.moved(p, n, jitter);
        self.cells.find(&self.tree, (p, scale), n).unwrap_or_else(|| self.tree.nearest(p, n))
    }

    /// [`Self::state`] for the points of a packet that are asked for; any for the others.
    #[inline(never)]
    pub(crate) fn states(&self, asked: Mask, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 2]) -> [u32; LANES] {
        let (mut states, mut moved) = ([0; LANES], Vec3Lanes::ZERO);
        let keys = self.cells.keys(p, n, jitter, &mut moved);
        let slots = self.cells.first_slots(&keys);
        for k in each(asked) {
            let (p, n) = (moved.get(k), n.get(k));
            let found = self.cells.find_from(&self.tree, (keys[k], slots[k]), p, n);
            states[k] = found.unwrap_or_else(|| self.tree.nearest(p, n));
        }
        states
    }

    /// [`Self::state`] by the tree alone: slower, the same answer.
    #[cfg(test)]
    fn state_by_tree(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> u32 {
        self.tree.nearest(self.cells.moved(p, n, jitter).0, n)
    }

    /// The frame in which the state's table is held, about the normal of its site.
    #[inline]
    pub fn frame(&self, state: u32) -> &Frame {
        &self.frames[state as usize]
    }

    /// The site of a state.
    pub fn site(&self, state: u32) -> Site {
        Site { p: self.tree.point(state), n: self.frame(state).n }
    }

    /// The sites, by state.
    pub fn sites(&self) -> impl ExactSizeIterator<Item = Site> + '_ {
        (0..self.len() as u32).map(|state| self.site(state))
    }

    /// Number of states.
    #[allow(clippy::len_without_is_empty, reason = "there is always a site")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Share of `queries` (points with unit normals) that the prepared cells answer without the tree.
    #[cfg(test)]
    fn prepared(&self, queries: &[(Vec3, Vec3)]) -> f64 {
        let find = |p, n| self.cells.find(&self.tree, self.cells.moved(p, n, [0.5; 2]), n);
        let found = queries.iter().filter(|(p, n)| find(*p, *n).is_some()).count();
        found as f64 / queries.len() as f64
    }

    /// Bytes that are held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.frames[..]) + self.tree.bytes() + self.cells.bytes()
    }

    /// What a site adds to [`Self::bytes`] at most, a few pages of fixed cost aside.
    pub const fn bytes_per_site() -> usize {
        TREE_BYTES + candidate_cells::BYTES_PER_SITE
    }
}

/// The site with a unit normal, where that can be said. One that has such a normal stays as it is, to the bit: sites that
/// come back from a file are those that went there.
fn valid(site: Site) -> Option<Site> {
    let n = if site.n.is_normalized() { site.n } else { site.n.try_normalize()? };
    (site.p.is_finite() && n.is_finite()).then_some(Site { p: site.p, n })
}
