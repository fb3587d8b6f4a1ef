//! The frozen tables: what sampling and pdf read during an iteration, and nothing changes.

use super::learner::{Learner, Table};
use super::region_index::RegionIndex;
use super::sdtree::LeafInfo;
use crate::guiding::directional::bins::rows::{estimates, strata_row};
use crate::guiding::directional::bins::strata::{Domain, Strata};
use crate::guiding::directional::distribution::{Directions, GuidingDistribution};
use crate::guiding::directional::hemitree::{Node, Totals};
use crate::guiding::settings::GuideSampling;
use crate::guiding::spatial::{StateKey, States};
use crate::guiding::store::{Actions, Entry, ReturnMoments, State};
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// A state with fewer visits knows too little to guide.
const MIN_VISITS: f32 = 16.0;

/// Parts into which a row divides the unit interval.
pub(super) const WHOLE: u32 = 1 << 16;

/// How what is learnt is used.
#[derive(Clone, Copy, Debug)]
pub struct SamplingOptions {
    pub sampling: GuideSampling,
    /// Share of directions left to the BSDF, where it is not learnt.
    pub bsdf_fraction: f32,
    pub learnt_fraction: bool,
    /// The guide leaves out what the BSDF's share already covers (Karlík et al. 2019, "MIS Compensation").
    pub compensation: bool,
    /// Share of its neighbours in a stratum's estimate.
    pub smoothing: f32,
}

/// What is known of a state besides its directions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct RegionInfo {
    pub(super) key: StateKey,
    /// Of the state's frame; zero where the frame is that of each query.
    normal: Vec3,
    /// First row or node; of an SD-tree, the leaf.
    first: u32,
    rows: u32,
    /// ∫ Q cosθ dω: the state's irradiance (luminance) from what the table holds.
    pub irradiance: f32,
    /// 2π max Q cosθ: what Q-learning takes for the irradiance.
    pub peak: f32,
    /// Weight of the visits behind it.
    pub visits: f32,
    /// Share of directions left to the BSDF.
    pub bsdf_fraction: f32,
    /// Moments of the one-sample estimate of irradiance/π, and the rays it takes.
    pub square: f32,
    pub mean: f32,
    pub rays: f32,
}

/// A snapshot of the table, ready to be drawn from.
#[derive(Clone, Debug)]
pub struct Snapshot {
    states: States,
    table: Table,
    usage: SamplingOptions,
    slots: RegionIndex,
    summaries: Vec<RegionInfo>,
    /// Of a hemisphere's strata, row by row: where each begins in the unit interval, in units of 1/`WHOLE`; before
    /// these, the same for the lines of strata, so that a draw reads two short runs of a row. Small numbers keep a row
    /// in few cache lines, where the time of a guided bounce goes; the rounding is exact for all that reads it, as
    /// draws and densities go by the rounded numbers.
    rows: Vec<u16>,
    /// Of a sphere's strata: Q.
    spheres: Vec<f32>,
    /// Of trees.
    nodes: Vec<Node>,
}

/// Bytes that a snapshot holds for a state besides its row, its places in the hash included.
pub(super) fn bytes_besides_rows() -> usize {
    size_of::<RegionInfo>() + RegionIndex::BYTES_PER_STATE
}

/// Bytes that a snapshot holds for a stratum, at most.
pub(super) fn bytes_per_stratum() -> usize {
    size_of::<f32>()
}

/// One state's part of a snapshot.
struct Frozen {
    summary: RegionInfo,
    row: Row,
}

enum Row {
    Strata(Vec<u16>),
    Sphere(Vec<f32>),
    Tree(Vec<Node>),
}

impl Snapshot {
    /// A field that knows nothing yet.
    pub fn empty(states: States, table: Table, usage: SamplingOptions) -> Snapshot {
        Snapshot {
            states,
            table,
            usage,
            slots: RegionIndex::new(std::iter::empty()),
            summaries: Vec::new(),
            rows: Vec::new(),
            spheres: Vec::new(),
            nodes: Vec::new(),
        }
    }

    /// Freezes what the learner knows now.
    pub fn freeze(&mut self, states: &States, learner: &Learner) {
        let usable: Vec<&State> = learner
            .states()
            .filter(|state| state.visits >= MIN_VISITS && state.entries().iter().any(|e| e.q > 0.0))
            .collect();
        let frozen: Vec<Frozen> = usable.into_par_iter().map(|state| self.freeze_state(state, states)).collect();
        self.states = states.clone();
        (self.rows, self.spheres, self.nodes) = (Vec::new(), Vec::new(), Vec::new());
        self.summaries = frozen.into_iter().map(|state| self.append(state)).collect();
        self.slots = RegionIndex::new(self.summaries.iter().map(|summary| summary.key));
    }

    fn append(&mut self, state: Frozen) -> RegionInfo {
        let first = match state.row {
            Row::Strata(row) => append(&mut self.rows, row),
            Row::Sphere(row) => append(&mut self.spheres, row),
            Row::Tree(nodes) => append(&mut self.nodes, nodes),
        };
        RegionInfo { first, ..state.summary }
    }

    fn freeze_state(&self, state: &State, states: &States) -> Frozen {
        let fraction = if self.usage.learnt_fraction { state.fraction.share() } else { self.usage.bsdf_fraction };
        let (row, rows, totals) = self.freeze_actions(&state.actions, fraction);
        let summary = RegionInfo {
            key: state.key,
            normal: if states.oriented() { state.normal } else { Vec3::ZERO },
            first: 0,
            rows,
            irradiance: totals.irradiance,
            peak: TAU * totals.peak,
            visits: state.visits,
            bsdf_fraction: fraction,
            square: state.returns.square,
            mean: state.returns.mean,
            rays: state.returns.rays,
        };
        Frozen { summary, row }
    }

    fn freeze_actions(&self, actions: &Actions, fraction: f32) -> (Row, u32, Totals) {
        match (actions, &self.table) {
            (Actions::Tree(cells), Table::Tree(shape)) => {
                // it takes as long as freezing does
                let irradiance = if self.usage.compensation { shape.totals(cells).irradiance } else { 0.0 };
                let mut nodes = Vec::with_capacity(cells.nodes());
                let totals = shape.freeze(cells, &self.usage.weight(irradiance, fraction), &mut nodes);
                let rows = nodes.len() as u32;
                (Row::Tree(nodes), rows, totals)
            }
            (Actions::Strata(entries), Table::Strata(strata)) => self.freeze_strata(entries, strata, fraction),
            _ => unreachable!("a state's actions are those of its table"),
        }
    }

    fn freeze_strata(&self, entries: &[Entry], strata: &Strata, fraction: f32) -> (Row, u32, Totals) {
        let q = estimates(entries, strata, self.usage.smoothing);
        if strata.domain() == Domain::Sphere {
            // which half of it counts depends on the query's normal: an isotropic part of the irradiance is kept
            let mean = q.iter().sum::<f32>() / q.len() as f32;
            let totals = Totals { irradiance: mean / FRAC_1_PI, peak: q.iter().copied().fold(0.0, f32::max) };
            let rows = q.len() as u32;
            return (Row::Sphere(q), rows, totals);
        }
        let lit = || q.iter().zip(strata.cosines());
        let irradiance = lit().map(|(q, cos)| q * cos).sum::<f32>() * strata.solid_angle();
        let peak = lit().map(|(q, cos)| q * cos).fold(0.0, f32::max);
        let weight = self.usage.weight(irradiance, fraction);
        let row = strata_row(strata, &lit().map(|(q, cos)| weight(*q, *cos) as f64).collect::<Vec<_>>());
        let rows = row.len() as u32;
        (Row::Strata(row), rows, Totals { irradiance, peak })
    }

    /// The state of a point, as [`States::key`].
    #[inline(always)]
    pub fn state(&self, p: Vec3, n: Vec3, jitter: [f32; 2]) -> Option<StateKey> {
        self.states.key(p, n, jitter)
    }

    /// What is known of a state, where that is enough.
    #[inline(always)]
    pub fn summary(&self, key: StateKey) -> Option<&RegionInfo> {
        self.slots.find(&self.summaries, key)
    }

    /// Where to go on at a point with the normal `n`, on the side of the path, of a state of which `summary` is known.
    #[inline(always)]
    pub fn distribution(&self, summary: &RegionInfo, n: Vec3) -> GuidingDistribution<'_> {
        let range = summary.first as usize..(summary.first + summary.rows) as usize;
        let normal = if summary.normal == Vec3::ZERO { n } else { summary.normal };
        match &self.table {
            Table::Tree(_) => GuidingDistribution::new(normal, Directions::Tree(&self.nodes[range])),
            Table::Strata(strata) if strata.domain() == Domain::Hemisphere => {
                GuidingDistribution::new(normal, Directions::Strata { strata, row: &self.rows[range] })
            }
            Table::Strata(strata) => {
                GuidingDistribution::on_sphere(n, strata, &self.spheres[range], self.usage.sampling)
            }
        }
    }

    /// The same where it is a tree: the normal of its hemisphere, and its nodes.
    #[inline(always)]
    pub fn tree(&self, summary: &RegionInfo, n: Vec3) -> Option<(Vec3, &[Node])> {
        let range = summary.first as usize..(summary.first + summary.rows) as usize;
        let normal = if summary.normal == Vec3::ZERO { n } else { summary.normal };
        matches!(self.table, Table::Tree(_)).then(|| (normal, &self.nodes[range]))
    }

    /// The state of each point of a packet, where that is known side by side.
    #[inline(always)]
    pub fn keys(&self, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 2]) -> Option<[StateKey; LANES]> {
        match &self.states {
            States::Adaptive(adaptive) => Some(adaptive.keys(p, n, jitter)),
            States::Grid(grid) => Some(grid.keys(p, n, jitter)),
            States::Voronoi(_) => None,
        }
    }

    /// Share of its neighbours in a stratum's estimate.
    pub(super) fn smoothing(&self) -> f32 {
        self.usage.smoothing
    }

    /// States that can be drawn from.
    pub fn len(&self) -> usize {
        self.summaries.len()
    }

    pub fn is_empty(&self) -> bool {
        self.summaries.is_empty()
    }

    /// Bytes of the snapshot.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.rows[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.summaries[..])
            + self.slots.bytes()
            + self.states.bytes()
    }
}

impl RegionInfo {
    /// What is known of a leaf of an SD-tree in which the given radiance arrives on average over the sphere: its
    /// irradiance is that of light from everywhere alike.
    pub(super) fn of_leaf(leaf: &LeafInfo, radiance: f32, bsdf_fraction: f32, returns: &ReturnMoments) -> RegionInfo {
        RegionInfo {
            key: StateKey(leaf.leaf as u64),
            normal: Vec3::ZERO,
            first: leaf.leaf,
            rows: leaf.nodes as u32,
            irradiance: PI * radiance,
            peak: TAU * radiance,
            visits: leaf.visits as f32,
            bsdf_fraction,
            square: returns.square,
            mean: returns.mean,
            rays: returns.rays,
        }
    }

    /// The leaf of [`RegionInfo::of_leaf`].
    #[inline]
    pub(super) fn leaf(&self) -> u32 {
        self.first
    }

    /// Whether that leaf has a quadtree.
    #[inline]
    pub(super) fn is_known(&self) -> bool {
        self.rows > 0
    }
}

impl SamplingOptions {
    /// What a direction with the estimate `q` and the cosine `cos` is drawn in proportion to, in a state with the given
    /// irradiance, which compensation goes by.
    fn weight(&self, irradiance: f32, fraction: f32) -> impl Fn(f32, f32) -> f32 {
        let covered = if self.compensation { fraction * irradiance * FRAC_1_PI } else { 0.0 };
        let cosine = self.sampling != GuideSampling::Q;
        move |q, cos| (q - covered).max(0.0) * if cosine { cos } else { 1.0 }
    }
}

fn append<T>(all: &mut Vec<T>, row: Vec<T>) -> u32 {
    let first = all.len() as u32;
    all.extend(row);
    first
}
