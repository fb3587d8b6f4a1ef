//! What transitions taught of one region.

use super::FractionSums;
use crate::guiding::recorder::Transition;
use crate::guiding::region::ReturnMoments;
use crate::math::fixed::fixed;
use serde::{Deserialize, Serialize};

/// Steps of a normal's coordinate: as fine as a packed direction.
const NORMAL_STEPS: f32 = (1 << 20) as f32;

/// Visits that sums hold at most: counts in double precision stay exact.
const MOST_VISITS: u64 = 1 << 53;

/// Sums over the visits of a region.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct RegionSums {
    pub visits: u64,
    /// Of the normals.
    pub normal: [i64; 3],
    /// By cell of directions, in their order: the guide's entries where it knew the region, else world cells
    /// ([`crate::guiding::PackedDirection::cell`]).
    pub cells: Vec<(u32, CellSums)>,
    pub returns: ReturnSums,
    pub fraction: FractionSums,
    pub visibility: VisibilitySums,
}

/// Visits of a cell of directions, and the sum of their targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct CellSums {
    pub visits: u64,
    pub target: i128,
}

/// Sums over the one-sample estimates of which [`ReturnMoments`] keeps the means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ReturnSums {
    pub visits: u64,
    pub estimate: i128,
    pub square: i128,
    pub rays: u64,
    pub red: i128,
    pub blue: i128,
}

/// Shadow rays, and those of them that were open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct VisibilitySums {
    pub rays: i128,
    pub open: i128,
}

impl RegionSums {
    /// Adds a transition whose direction is in a cell, if in any.
    pub fn add(&mut self, transition: &Transition, cell: Option<u32>) {
        self.visits += 1;
        let normal = (transition.normal.unpack() * NORMAL_STEPS).round();
        self.normal.iter_mut().zip(normal.to_array()).for_each(|(sum, v)| *sum += v as i64);
        if let Some(cell) = cell {
            self.cell(cell).add(CellSums { visits: 1, target: fixed(transition.target) });
        }
        if let Some(estimate) = ReturnMoments::estimate(transition) {
            self.returns.add(transition, estimate);
        }
        let [rays, open] = transition.shadow.rays().map(fixed);
        self.visibility.add(VisibilitySums { rays, open });
        let contribution = transition.contribution();
        if transition.scattered != 0.0 && (contribution * contribution).is_finite() {
            self.fraction.add(contribution, transition.bsdf_pdf, transition.guide_pdf);
        }
    }

    pub fn add_sums(&mut self, other: &RegionSums) {
        self.visits = self.visits.saturating_add(other.visits);
        self.normal.iter_mut().zip(other.normal).for_each(|(sum, more)| *sum = sum.saturating_add(more));
        other.cells.iter().for_each(|(cell, more)| self.cell(*cell).add(*more));
        self.returns.add_sums(&other.returns);
        self.fraction.add_sums(&other.fraction);
        self.visibility.add(other.visibility);
    }

    fn cell(&mut self, cell: u32) -> &mut CellSums {
        let at = self.cells.binary_search_by_key(&cell, |(cell, _)| *cell).unwrap_or_else(|at| {
            self.cells.insert(at, (cell, CellSums::default()));
            at
        });
        &mut self.cells[at].1
    }

    /// Whether these can be sums of transitions, in as many cells at most: what a file need not hold.
    pub fn is_sound(&self, cells: usize) -> bool {
        let in_order = self.cells.is_sorted_by(|(a, _), (b, _)| a < b);
        let within = self.cells.iter().all(|(cell, sums)| (*cell as usize) < cells && sums.is_sound(self.visits));
        let ReturnSums { visits, estimate, square, red, blue, .. } = self.returns;
        let amounts = [estimate, square, red, blue].iter().all(|sum| *sum >= 0);
        let counted = (1..=MOST_VISITS).contains(&self.visits) && visits <= self.visits;
        let VisibilitySums { rays, open } = self.visibility;
        let seen = (0..=rays).contains(&open);
        in_order && within && amounts && counted && seen && self.fraction.is_sound(self.visits)
    }
}

impl CellSums {
    pub fn add(&mut self, other: CellSums) {
        self.visits = self.visits.saturating_add(other.visits);
        self.target = self.target.saturating_add(other.target);
    }

    fn is_sound(&self, most: u64) -> bool {
        self.visits <= most && self.target >= 0
    }
}

impl VisibilitySums {
    fn add(&mut self, other: VisibilitySums) {
        self.rays = self.rays.saturating_add(other.rays);
        self.open = self.open.saturating_add(other.open);
    }
}

impl ReturnSums {
    fn add(&mut self, transition: &Transition, estimate: f32) {
        let light = transition.hue.light() * estimate;
        self.add_sums(&ReturnSums {
            visits: 1,
            estimate: fixed(estimate),
            square: fixed(estimate * estimate),
            rays: transition.rays.into(),
            red: fixed(light.x),
            blue: fixed(light.z),
        });
    }

    fn add_sums(&mut self, other: &ReturnSums) {
        self.visits = self.visits.saturating_add(other.visits);
        self.rays = self.rays.saturating_add(other.rays);
        let own = [&mut self.estimate, &mut self.square, &mut self.red, &mut self.blue];
        let more = [other.estimate, other.square, other.red, other.blue];
        own.into_iter().zip(more).for_each(|(sum, more)| *sum = sum.saturating_add(more));
    }
}
