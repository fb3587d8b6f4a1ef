//! Directions: what arrives at a region, told apart by where it comes from.
//!
//! A [`DirectionalModel`] says how that is learnt, frozen, drawn from and evaluated. Where in space it is learnt is no
//! business of it.

pub mod bins;
mod distribution;
mod glossy;
mod guide_lanes;
pub mod hemitree;
mod model;
pub mod quadtree;
mod weights;

pub(crate) use distribution::{GuidingDistribution, InFrame};
pub(crate) use glossy::GlossyLobe;
pub(crate) use guide_lanes::GuideLanes;
#[cfg(test)]
pub(crate) use model::Learnt;
pub use model::{AnyDirections, Model};

use super::recorder::Transition;
use super::settings::{GuideSampling, Rate};
use crate::math::Frame;
use crate::simd::Vec3Lanes;
use glam::Vec3;
use hemitree::Node;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;
use std::fmt::Debug;
use std::ops::Range;

/// Parts of the directions by which regions are compared.
pub const PROFILE: usize = 16;

/// The frame of directions in world space.
pub(super) const WORLD: Frame = Frame { s: Vec3::X, t: Vec3::Y, n: Vec3::Z };

/// What is the same for all regions: how directions are told apart, and how fine.
pub trait DirectionalModel: Clone + Send + Sync {
    /// What the learner keeps of a region.
    type Learnt: Clone + Debug + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static;
    /// Where the directions of a packet of transitions lie.
    type Located;
    /// What sampling reads of a region.
    type Frozen: Send;
    /// The same of all regions, one after the other.
    type Pool: Clone + Debug + Default + Send + Sync;
    /// A region's directions, to be drawn from.
    type Directions<'f>: Directions
    where
        Self: 'f;

    /// Of a region that was never met.
    fn untrained(&self) -> Self::Learnt;

    /// Where the unit directions `wi` lie, in world space; of hemispheres, in those about the unit normals `about`.
    fn locate(&self, about: &Vec3Lanes, wi: &Vec3Lanes) -> Self::Located;

    /// Learns from a transition, the `k`-th of those that were located.
    fn record(&self, learnt: &mut Self::Learnt, at: &Self::Located, k: usize, transition: &Transition, rate: Rate);

    /// The estimates, one for each cell of directions, where they are all that is learnt and are about the region's normal. Else
    /// none, and sums of other renders cannot be taken in.
    fn entries_mut<'l>(&self, _learnt: &'l mut Self::Learnt) -> &'l mut [Entry] {
        &mut []
    }

    /// Which of them a transition teaches, the `k`-th of those that were located; `None` below the horizon.
    fn entry_index(&self, _learnt: &Self::Learnt, _at: &Self::Located, _k: usize) -> Option<usize> {
        None
    }

    /// Leaves earlier visits only a share of their weight.
    fn decay(&self, learnt: &mut Self::Learnt, share: f32);

    /// Whether there is any light to draw by.
    fn is_informed(&self, learnt: &Self::Learnt) -> bool;

    /// Takes notice that an iteration ended: for models of which only whole iterations are frozen.
    fn end_iteration(&self, _learnt: &mut Self::Learnt) {}

    /// The same knowledge in the form that suits it, cells being cut where they hold `coarseness` times as much as the
    /// settings ask for; `None` for models of one form.
    fn refined(&self, _learnt: &Self::Learnt, _coarseness: f32) -> Option<Self::Learnt> {
        None
    }

    /// Whether nothing is coarser than what [`Self::refined`] makes of such a coarseness.
    fn is_coarsest(&self, _coarseness: f32) -> bool {
        true
    }

    /// Irradiance (luminance) from each part of the directions, for telling regions apart.
    fn profile(&self, learnt: &Self::Learnt) -> [f32; PROFILE];

    /// What sampling needs, where the BSDF keeps the share `fraction` of the directions.
    fn freeze(&self, learnt: &Self::Learnt, options: &SamplingOptions, fraction: f32) -> (Self::Frozen, Totals);

    /// Puts a region's part to those of the others; returns where it lies.
    fn append(&self, frozen: Self::Frozen, pool: &mut Self::Pool) -> Range<u32>;

    /// The directions of the region that lies at `range` of the pool, and the frame that they are in, at a point with
    /// these normals.
    fn directions<'f>(
        &'f self,
        pool: &'f Self::Pool,
        range: Range<usize>,
        normals: Normals,
        options: &SamplingOptions,
    ) -> InFrame<Self::Directions<'f>>;

    /// Its nodes, where these are a hemisphere's tree: packets draw from such side by side.
    #[inline(always)]
    fn tree<'f>(&self, _pool: &'f Self::Pool, _range: Range<usize>) -> Option<&'f [Node]> {
        None
    }

    /// The same directions, in the frame about `about`, times what a glossy surface reflects of them; `None` for models that know
    /// no such product.
    #[inline]
    fn product<'f>(
        &'f self,
        _pool: &'f Self::Pool,
        _range: Range<usize>,
        _about: Vec3,
        _lobe: &GlossyLobe,
    ) -> Option<InFrame<Self::Directions<'f>>> {
        None
    }

    /// Q, the radiance (luminance) that arrives from a unit direction (second argument), at a point where hemispheres are
    /// those about a unit normal (first); `None` where nothing is said of it.
    fn evaluator<'l>(&'l self, learnt: &'l Self::Learnt, smoothing: f32) -> Evaluator<'l>;

    /// Nodes of a region's tree; 0 where there is none.
    fn nodes(&self, _learnt: &Self::Learnt) -> usize {
        0
    }

    /// Bytes of a region's directions, learnt and frozen.
    fn bytes(&self, learnt: &Self::Learnt) -> usize;

    /// The same of most regions.
    fn usual_bytes(&self) -> usize;

    /// Bytes of a pool.
    fn pool_bytes(&self, pool: &Self::Pool) -> usize;

    /// Whether what a file holds can have been learnt by this model.
    fn is_sound(&self, learnt: &Self::Learnt) -> bool;
}

/// The unit normals by which a point's directions are told.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    /// That of the region's hemisphere: its own, or where points of a region face many ways, that of the point.
    pub about: Vec3,
    /// That of the point, on the side of the path.
    pub here: Vec3,
}

/// What [`DirectionalModel::evaluator`] gives.
pub type Evaluator<'l> = Box<dyn Fn(Vec3, Vec3) -> Option<f32> + Sync + 'l>;

/// Frozen directions. They are in a frame of their own, unit, away from the surface; densities are per steradian.
pub trait Directions: Sized {
    /// A direction and its density, that of `pdf` but where rounding takes it over the border of a cell. `u` chooses where
    /// to look, `inside` where within; a model may use `inside` for both.
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32);

    /// Density of `sample` at a unit direction.
    fn pdf(&self, local: Vec3) -> f32;

    /// The product with `value`, of which the centre of each cell is taken. Models that know no product stay as they are.
    fn times(&self, value: impl Fn(Vec3) -> f32) -> Self;
}

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

impl SamplingOptions {
    /// What a direction with the estimate `q` and the cosine `cos` is drawn in proportion to, in a region with the given
    /// irradiance, which compensation goes by.
    pub(super) fn weight(&self, irradiance: f32, fraction: f32) -> impl Fn(f32, f32) -> f32 + use<> {
        let covered = if self.compensation { fraction * irradiance * FRAC_1_PI } else { 0.0 };
        let cosine = self.sampling != GuideSampling::Q;
        move |q, cos| (q - covered).max(0.0) * if cosine { cos } else { 1.0 }
    }
}

/// What the estimates of a region amount to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Totals {
    /// ∫ Q cosθ dω.
    pub irradiance: f32,
    /// max Q cosθ.
    pub peak: f32,
}

/// A region and a cell of its directions: the estimate of incident radiance (luminance), and the weight of the visits
/// behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    pub q: f32,
    pub visits: f32,
}

/// Pseudo-count of the prior: below so many visits an entry leans towards what its surroundings say, so that what was
/// never tried stays possible, in units that no exposure changes.
const PRIOR_VISITS: f32 = 1.0;

impl Entry {
    /// The estimate, leaning towards `prior` where visits are few.
    #[inline]
    pub fn shrunk(self, prior: f32) -> f32 {
        (self.q * self.visits + prior * PRIOR_VISITS) / (self.visits + PRIOR_VISITS)
    }

    /// Targets come from the frozen table, so one visit after the other, Q ← Q + (target − Q)/n, gives just what one batch
    /// update with the vanishing rate w = b/(n + b) would.
    #[inline(always)]
    pub(super) fn learn(&mut self, target: f32, rate: Rate) {
        self.visits += 1.0;
        // the first visit has nothing to keep
        let step = match rate {
            Rate::Constant(alpha) if self.visits > 1.0 => alpha,
            _ => 1.0 / self.visits,
        };
        self.q += (target - self.q) * step;
    }

    /// Learns from so many visits at once, whose targets have this sum: what one after the other would teach, but for rounding and,
    /// at a constant rate, for their order.
    pub(super) fn learn_all(&mut self, visits: u64, sum: f64, rate: Rate) {
        let (count, before) = (visits as f64, f64::from(self.visits));
        let kept = match rate {
            _ if count == 0.0 => return,
            Rate::Constant(alpha) if before > 0.0 => (1.0 - f64::from(alpha)).powf(count),
            Rate::Constant(_) => 0.0,
            Rate::Vanishing | Rate::Forgetting(_) => before / (before + count),
        };
        let q = f64::from(self.q) * kept + sum / count * (1.0 - kept);
        *self = Entry { q: q.min(f64::from(f32::MAX)) as f32, visits: (before + count) as f32 };
    }

    /// Whether the numbers are of the range that learning keeps them in.
    pub(super) fn is_sound(&self) -> bool {
        [self.q, self.visits].iter().all(|v| v.is_finite() && *v >= 0.0)
    }
}
