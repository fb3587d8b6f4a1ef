//! The frozen guide: what sampling and pdf read during an iteration, and nothing changes.

use super::directional::hemitree::Node;
use super::directional::{DirectionalModel, GlossyLobe, InFrame, Model, Normals, SamplingOptions};
use super::hue::Hue;
use super::region::{Region, ReturnMoments};
use super::region_index::RegionIndex;
use super::settings::GuideSampling;
use super::spatial::{Partition, RegionId, RegionLookup, SpatialPartition};
use super::store::RegionStore;
use crate::math::luminance;
use crate::simd::{LANES, Mask, Vec3Lanes};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::TAU;
use std::ops::Range;

/// What is known of a region besides its directions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct RegionInfo {
    pub(super) key: RegionId,
    /// Of the region's frame; zero where the frame is that of each query.
    normal: Vec3,
    /// Where its directions lie in the pool.
    first: u32,
    end: u32,
    /// ∫ Q cosθ dω: the region's irradiance (luminance) from what is known of its directions.
    pub irradiance: f32,
    /// 2π max Q cosθ: what Q-learning takes for the irradiance.
    pub peak: f32,
    /// Weight of the visits behind it.
    pub visits: f32,
    /// Share of directions left to the BSDF.
    pub bsdf_fraction: f32,
    /// Second moment and variance of the one-sample estimate of irradiance/π, each over the rays that it takes.
    pub square: f32,
    pub variance: f32,
    /// What is expected of that estimate: its mean, the nearer to 0 the less is known of it. Luminance and colour.
    pub expected: f32,
    pub hue: Hue,
    /// Share of shadow rays that are open, between 0 and 1.
    pub open: f32,
}

impl RegionInfo {
    #[inline(always)]
    fn range(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }

    /// The normal about which hemispheres are, at a point with the normal `n`.
    #[inline(always)]
    fn about(&self, n: Vec3) -> Vec3 {
        if self.normal == Vec3::ZERO { n } else { self.normal }
    }
}

/// A snapshot of all regions, ready to be drawn from.
#[derive(Clone, Debug)]
pub struct Snapshot<S = Partition, D: DirectionalModel = Model> {
    partition: S,
    model: D,
    options: SamplingOptions,
    /// Regions with a smaller weight of visits know too little to guide.
    min_visits: f32,
    index: RegionIndex,
    rows: Vec<RegionInfo>,
    pool: D::Pool,
}

impl<S: SpatialPartition, D: DirectionalModel> Snapshot<S, D> {
    /// One that knows nothing yet.
    pub(super) fn empty(partition: S, model: D, options: SamplingOptions, min_visits: f32) -> Snapshot<S, D> {
        let index = RegionIndex::new(std::iter::empty(), None);
        Snapshot { partition, model, options, min_visits, index, rows: Vec::new(), pool: D::Pool::default() }
    }

    /// Freezes what is known now.
    pub(super) fn freeze(&mut self, partition: &S, store: &RegionStore<D>) {
        let informed = |region: &&Region<D::Learnt>| {
            region.visits >= self.min_visits && self.model.is_informed(&region.directions)
        };
        let usable: Vec<&Region<D::Learnt>> = store.regions().filter(informed).collect();
        let oriented = partition.is_oriented();
        let frozen: Vec<_> = usable.into_par_iter().map(|region| self.freeze_region(region, oriented)).collect();
        (self.partition, self.pool) = (partition.frozen(), D::Pool::default());
        let append = |(row, directions)| {
            let Range { start: first, end } = self.model.append(directions, &mut self.pool);
            RegionInfo { first, end, ..row }
        };
        self.rows = frozen.into_iter().map(append).collect();
        self.index = RegionIndex::new(self.rows.iter().map(|row| row.key), self.partition.dense());
    }

    fn freeze_region(&self, region: &Region<D::Learnt>, oriented: bool) -> (RegionInfo, D::Frozen) {
        let options = &self.options;
        let fraction = if options.learnt_fraction { region.fraction.value() } else { options.bsdf_fraction };
        let (directions, totals) = self.model.freeze(&region.directions, options, fraction);
        let ReturnMoments { square, mean, rays, .. } = region.returns;
        let (expected, rays) = (region.returns.expected(), rays.max(1.0));
        let row = RegionInfo {
            key: region.key,
            normal: if oriented { region.normal } else { Vec3::ZERO },
            first: 0,
            end: 0,
            irradiance: totals.irradiance,
            peak: TAU * totals.peak,
            visits: region.visits,
            bsdf_fraction: fraction,
            square: square / rays,
            variance: (square - mean * mean) / rays,
            expected: luminance(expected),
            hue: Hue::of(expected),
            open: region.visibility.share(),
        };
        (row, directions)
    }

    /// The regions of the point `p` with unit normal `n` on the side of the path: [`SpatialPartition::locate`]. While
    /// there are none, points are to be recorded by [`super::Recorder::push_point`].
    #[inline(always)]
    pub fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
        self.partition.locate(p, n, jitter)
    }

    /// [`Self::locate`] for all points of a packet, where that is done side by side; `None` where points are to be asked
    /// for one by one.
    #[inline(always)]
    pub fn locate_lanes(
        &self,
        asked: Mask,
        p: &Vec3Lanes,
        n: &Vec3Lanes,
        jitter: [f32; 3],
    ) -> Option<[RegionId; LANES]> {
        self.partition.locate_lanes(asked, p, n, jitter)
    }

    /// What is known of a region, where that is enough.
    #[inline(always)]
    pub fn summary(&self, key: RegionId) -> Option<&RegionInfo> {
        self.index.find(&self.rows, key)
    }

    /// Where to go on at a point with the normal `n`, on the side of the path, of a region of which `info` is known.
    #[inline(always)]
    pub fn distribution(&self, info: &RegionInfo, n: Vec3) -> InFrame<D::Directions<'_>> {
        self.model.directions(&self.pool, info.range(), Normals { about: info.about(n), here: n }, &self.options)
    }

    /// The same where it is a tree over a hemisphere: the hemisphere's normal, and the nodes.
    #[inline(always)]
    pub fn tree(&self, info: &RegionInfo, n: Vec3) -> Option<(Vec3, &[Node])> {
        Some((info.about(n), self.model.tree(&self.pool, info.range())?))
    }

    /// Where to go on at a point with the normal `n` of a surface that is glossy: the product of both. `None` where the model knows no
    /// such product, or is not asked for it.
    #[inline]
    pub fn product(&self, info: &RegionInfo, n: Vec3, lobe: &GlossyLobe) -> Option<InFrame<D::Directions<'_>>> {
        if self.options.sampling != GuideSampling::GlossyProduct {
            return None;
        }
        self.model.product(&self.pool, info.range(), info.about(n), lobe)
    }

    pub(super) fn smoothing(&self) -> f32 {
        self.options.smoothing
    }

    /// Regions that can be drawn from.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Bytes of the snapshot.
    pub fn bytes(&self) -> usize {
        let rows = size_of_val(&self.rows[..]) + self.index.bytes();
        self.model.pool_bytes(&self.pool) + rows + self.partition.bytes()
    }
}
