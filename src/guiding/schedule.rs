//! When what is divided, and how much of what was learnt outlives an iteration.

use super::directional::DirectionalModel;
use super::settings::Rate;
use super::spatial::SpatialPartition;
use super::store::RegionStore;
use super::{ppg, refinement};

/// Visits of an iteration that doubles the paths, on average over the regions, after which divisible partitions stop to learn
/// until the next one begins; of a shorter one, fewer. With four times fewer, rooms lit through a gap got a tenth noisier; without end, tables grow and gain
/// nothing.
const VISITS_PER_REGION: f64 = 1024.0;

/// A region with fewer visits knows too little to guide.
const MIN_VISITS: f32 = 16.0;

/// How a guide goes from one iteration to the next.
#[derive(Clone, Copy, Debug)]
pub enum Schedule {
    /// What was learnt stays, at the rate's discount; cells are divided where neighbours differ.
    Continuous(refinement::DivisionLimits),
    /// Each iteration is learnt from alone, and twice as long as the one before; cells are divided by samples (Müller
    /// et al. 2017).
    Ppg(ppg::SplitLimits),
}

impl Schedule {
    /// Least weight of the visits of a region that is drawn from.
    pub(super) fn min_visits(self) -> f32 {
        match self {
            Schedule::Continuous(_) => MIN_VISITS,
            Schedule::Ppg(_) => 0.0,
        }
    }

    /// Share of their weight that visits keep when an iteration begins that adds `growth` times the paths so far: the rate's
    /// for each time that these double. Early targets were bootstrapped from a table that knew little; a rate of 1/n
    /// alone forgets their error only as n^−(1−albedo).
    pub(super) fn retain(self, rate: Rate, growth: f64) -> f32 {
        match (self, rate) {
            (Schedule::Ppg(_), _) => 0.0,
            (_, Rate::Forgetting(retain)) => retain.powf(doublings(growth) as f32),
            (_, Rate::Vanishing | Rate::Constant(_)) => 1.0,
        }
    }

    /// Whether regions are made between iterations only, but for the first.
    pub(super) fn divides_only(self) -> bool {
        matches!(self, Schedule::Ppg(_))
    }

    /// Whether `transitions` in one iteration have taught so many regions enough. Partitions that do not divide learn from
    /// all: their memory is laid out beforehand, or what they are compared with does so too.
    pub(super) fn has_enough(
        self,
        partition: &impl SpatialPartition,
        transitions: u64,
        regions: usize,
        growth: f64,
    ) -> bool {
        let stops = matches!(self, Schedule::Continuous(_)) && partition.cells() > 0;
        let visits = VISITS_PER_REGION * doublings(growth);
        stops && transitions as f64 > visits * regions.max(1) as f64
    }

    /// Mid-iteration snapshots are of guides that learn without end.
    pub(super) fn refreshes(self) -> bool {
        matches!(self, Schedule::Continuous(_))
    }

    /// Divides cells after an iteration of `paths` camera paths.
    pub(super) fn divide<D: DirectionalModel>(
        self,
        partition: &mut impl SpatialPartition,
        store: &mut RegionStore<D>,
        paths: u64,
    ) {
        match self {
            Schedule::Continuous(limits) => refinement::refine(partition, store, limits),
            Schedule::Ppg(limits) => ppg::split(partition, store, limits, paths),
        }
    }
}

/// How often an iteration doubles the paths so far that adds `growth` times as many; once at most, however few came before.
fn doublings(growth: f64) -> f64 {
    (1.0 + growth).log2().min(1.0)
}
