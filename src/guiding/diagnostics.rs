//! What a guide looks like: how large it is, how well known, and what it knows of one region.

use super::directional::{DirectionalModel, Evaluator};
use super::guide::Guide;
use super::memory::region_bytes;
use super::region::Region;
use super::spatial::{RegionId, SpatialPartition};
use glam::Vec3;
use serde::Serialize;

/// Figures over all regions of a guide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuideStats {
    pub states: usize,
    /// Of a region, its part of the snapshot included.
    pub mean_bytes: f64,
    pub min_bytes: usize,
    pub max_bytes: usize,
    /// Bytes of the whole guide.
    pub bytes: usize,
    /// Nodes of all trees of directions; 0 where there are none.
    pub tree_nodes: usize,
    /// Share of the regions without a visit in the last iteration that learnt, those included that its end divided from
    /// larger ones.
    pub not_met_share: f64,
    /// Share of the regions of which too little is known to draw from.
    pub unusable_share: f64,
    /// Regions by the weight of their visits.
    pub visits: Vec<HistogramBin>,
}

/// Regions with at least `from` visits and fewer than `to`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistogramBin {
    pub from: f64,
    pub to: f64,
    pub states: usize,
}

/// What a guide knows of one region.
pub struct StateView<'g> {
    visits: f32,
    normal: Option<Vec3>,
    q: Evaluator<'g>,
}

impl<S: SpatialPartition, D: DirectionalModel> Guide<S, D> {
    pub fn stats(&self) -> GuideStats {
        let regions = || self.store.regions();
        let count = |holds: &dyn Fn(&Region<D::Learnt>) -> bool| regions().filter(|region| holds(region)).count();
        let share = |n: usize| if self.states() == 0 { 0.0 } else { n as f64 / self.states() as f64 };
        let sizes = || regions().map(|region| region_bytes(&self.store.model, region));
        GuideStats {
            states: self.states(),
            mean_bytes: share(sizes().sum()),
            min_bytes: sizes().min().unwrap_or(0),
            max_bytes: sizes().max().unwrap_or(0),
            bytes: self.bytes(),
            tree_nodes: regions().map(|region| self.store.model.nodes(&region.directions)).sum(),
            not_met_share: share(count(&|region| region.fresh == 0.0)),
            unusable_share: share(count(&|region| self.snapshot.summary(region.key).is_none())),
            visits: decades(regions().map(|region| region.visits)),
        }
    }

    /// Weight of a region's visits, if it was ever met.
    pub fn visits(&self, key: RegionId) -> Option<f32> {
        self.store.get(key).map(|region| region.visits)
    }

    /// What was learnt of a region, if it was ever met.
    pub fn view(&self, key: RegionId) -> Option<StateView<'_>> {
        let region = self.store.get(key)?;
        let normal = self.partition.is_oriented().then_some(region.normal);
        let q = self.store.model.evaluator(&region.directions, self.snapshot.smoothing());
        Some(StateView { visits: region.visits, normal, q })
    }
}

impl StateView<'_> {
    /// Weight of the visits.
    pub fn visits(&self) -> f32 {
        self.visits
    }

    /// The normal about which hemispheres are held, where it is the same for all points of the region.
    pub fn normal(&self) -> Option<Vec3> {
        self.normal
    }

    /// Q, the radiance (luminance) that arrives from the unit direction `w` (world space, away from the surface), at a
    /// point with the normal `n`; `None` where nothing is said of it.
    pub fn q(&self, n: Vec3, w: Vec3) -> Option<f32> {
        (self.q)(self.normal.unwrap_or(n), w)
    }
}

/// From 0 to 1, to 10, to 100 … as far as there are any.
fn decades(visits: impl Iterator<Item = f32>) -> Vec<HistogramBin> {
    let mut counts: Vec<usize> = Vec::new();
    for visits in visits {
        let decade = if visits < 1.0 { 0 } else { visits.log10().floor() as usize + 1 };
        counts.resize(counts.len().max(decade + 1), 0);
        counts[decade] += 1;
    }
    let bound = |k: i32| if k < 0 { 0.0 } else { 10f64.powi(k) };
    let decade =
        |(k, &states): (usize, &usize)| HistogramBin { from: bound(k as i32 - 1), to: bound(k as i32), states };
    counts.iter().enumerate().map(decade).collect()
}
