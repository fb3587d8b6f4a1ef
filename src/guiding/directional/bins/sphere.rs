//! Strata of the sphere in world space, the hemisphere being taken out at each query.

use super::rows::estimates;
use super::{BYTES_PER_STRATUM, BinDirections, Domain, Strata};
use crate::guiding::directional::{
    DirectionalModel, Entry, Evaluator, InFrame, Normals, PROFILE, SamplingOptions, Totals, WORLD,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::{GuideSampling, Rate};
use crate::simd::{LANES, Vec3Lanes};
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

#[derive(Clone, Debug)]
pub struct SphereBins {
    strata: Strata,
}

impl SphereBins {
    /// 2·`side`² strata.
    pub fn new(side: u32) -> SphereBins {
        SphereBins { strata: Strata::new(Domain::Sphere, side) }
    }
}

#[cfg(test)]
impl SphereBins {
    pub(in crate::guiding) fn strata(&self) -> &Strata {
        &self.strata
    }
}

impl DirectionalModel for SphereBins {
    type Learnt = Vec<Entry>;
    type Located = [Option<usize>; LANES];
    /// Q by stratum.
    type Frozen = Vec<f32>;
    type Pool = Vec<f32>;
    type Directions<'f> = BinDirections<'f>;

    fn untrained(&self) -> Vec<Entry> {
        vec![Entry::default(); self.strata.count()]
    }

    fn locate(&self, _about: &Vec3Lanes, wi: &Vec3Lanes) -> [Option<usize>; LANES] {
        std::array::from_fn(|k| self.strata.index(wi.get(k)))
    }

    #[inline(always)]
    fn record(&self, learnt: &mut Vec<Entry>, at: &Self::Located, k: usize, transition: &Transition, rate: Rate) {
        super::record(learnt, at[k], transition.target, rate);
    }

    fn decay(&self, learnt: &mut Vec<Entry>, share: f32) {
        super::decay(learnt, share);
    }

    fn is_informed(&self, learnt: &Vec<Entry>) -> bool {
        super::is_informed(learnt)
    }

    fn profile(&self, learnt: &Vec<Entry>) -> [f32; PROFILE] {
        super::profile(learnt, &self.strata)
    }

    fn freeze(&self, learnt: &Vec<Entry>, options: &SamplingOptions, _fraction: f32) -> (Vec<f32>, Totals) {
        let q = estimates(learnt, &self.strata, options.smoothing);
        // which half of it counts depends on the query's normal: an isotropic part of the irradiance is kept
        let mean = q.iter().sum::<f32>() / q.len() as f32;
        let totals = Totals { irradiance: mean / FRAC_1_PI, peak: q.iter().copied().fold(0.0, f32::max) };
        (q, totals)
    }

    fn append(&self, frozen: Vec<f32>, pool: &mut Vec<f32>) -> Range<u32> {
        super::append(frozen, pool)
    }

    /// The hemisphere about the point's own normal is taken out stratum by stratum: what the paper blames for the sphere's cost.
    fn directions<'f>(
        &'f self,
        pool: &'f Vec<f32>,
        range: Range<usize>,
        normals: Normals,
        options: &SamplingOptions,
    ) -> InFrame<BinDirections<'f>> {
        let (strata, q, mut sum) = (&self.strata, &pool[range], 0.0);
        let ends = (0..q.len()).map(|k| {
            let cos = strata.direction(k, [0.5; 2]).dot(normals.here).max(0.0);
            sum += q[k] * if options.sampling == GuideSampling::Q { (cos > 0.0) as u32 as f32 } else { cos };
            sum
        });
        InFrame { frame: WORLD, directions: BinDirections::Weighed { strata, ends: ends.collect() } }
    }

    fn evaluator<'l>(&'l self, learnt: &'l Vec<Entry>, smoothing: f32) -> Evaluator<'l> {
        let q = estimates(learnt, &self.strata, smoothing);
        Box::new(move |_, w| self.strata.index(w).map(|k| q[k]))
    }

    fn bytes(&self, learnt: &Vec<Entry>) -> usize {
        learnt.len() * BYTES_PER_STRATUM
    }

    fn usual_bytes(&self) -> usize {
        self.strata.count() * BYTES_PER_STRATUM
    }

    fn pool_bytes(&self, pool: &Vec<f32>) -> usize {
        size_of_val(&pool[..])
    }

    fn is_sound(&self, learnt: &Vec<Entry>) -> bool {
        super::is_sound(learnt, &self.strata)
    }
}
