//! Strata of the hemisphere about the region's normal.

use super::rows::{estimates, strata_row};
use super::{BYTES_PER_STRATUM, BinDirections, Domain, Strata};
use crate::guiding::directional::{
    DirectionalModel, Entry, Evaluator, InFrame, Normals, PROFILE, SamplingOptions, Totals,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::Rate;
use crate::math::Frame;
use crate::simd::{LANES, Vec3Lanes};
use std::ops::Range;

#[derive(Clone, Debug)]
pub struct HemisphereBins {
    strata: Strata,
}

impl HemisphereBins {
    /// `side`² strata.
    pub fn new(side: u32) -> HemisphereBins {
        HemisphereBins { strata: Strata::new(Domain::Hemisphere, side) }
    }
}

#[cfg(test)]
impl HemisphereBins {
    pub(in crate::guiding) fn strata(&self) -> &Strata {
        &self.strata
    }
}

impl DirectionalModel for HemisphereBins {
    type Learnt = Vec<Entry>;
    type Located = [Option<usize>; LANES];
    /// A row: where each stratum begins in the unit interval, in units of 1/2¹⁶; before these, the same for the lines of
    /// strata, so that a draw reads two short runs of a row. Small numbers keep a row in few cache lines, where the time
    /// of a guided bounce goes; the rounding is exact for all that reads it, as draws and densities go by the rounded
    /// numbers.
    type Frozen = Vec<u16>;
    type Pool = Vec<u16>;
    type Directions<'f> = BinDirections<'f>;

    fn untrained(&self) -> Vec<Entry> {
        vec![Entry::default(); self.strata.count()]
    }

    fn locate(&self, about: &Vec3Lanes, wi: &Vec3Lanes) -> [Option<usize>; LANES] {
        std::array::from_fn(|k| self.strata.index(Frame::from_normal(about.get(k)).to_local(wi.get(k))))
    }

    #[inline(always)]
    fn record(&self, learnt: &mut Vec<Entry>, at: &Self::Located, k: usize, transition: &Transition, rate: Rate) {
        super::record(learnt, at[k], transition.target, rate);
    }

    fn entries_mut<'l>(&self, learnt: &'l mut Vec<Entry>) -> &'l mut [Entry] {
        learnt
    }

    fn entry_index(&self, _learnt: &Vec<Entry>, at: &Self::Located, k: usize) -> Option<usize> {
        at[k]
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

    fn freeze(&self, learnt: &Vec<Entry>, options: &SamplingOptions, fraction: f32) -> (Vec<u16>, Totals) {
        let strata = &self.strata;
        let q = estimates(learnt, strata, options.smoothing);
        let lit = || q.iter().zip(strata.cosines());
        let irradiance = lit().map(|(q, cos)| q * cos).sum::<f32>() * strata.solid_angle();
        let peak = lit().map(|(q, cos)| q * cos).fold(0.0, f32::max);
        let weight = options.weight(irradiance, fraction);
        let row = strata_row(strata, &lit().map(|(q, cos)| weight(*q, *cos) as f64).collect::<Vec<_>>());
        (row, Totals { irradiance, peak })
    }

    fn append(&self, frozen: Vec<u16>, pool: &mut Vec<u16>) -> Range<u32> {
        super::append(frozen, pool)
    }

    #[inline(always)]
    fn directions<'f>(
        &'f self,
        pool: &'f Vec<u16>,
        range: Range<usize>,
        normals: Normals,
        _options: &SamplingOptions,
    ) -> InFrame<BinDirections<'f>> {
        let directions = BinDirections::Row { strata: &self.strata, row: &pool[range] };
        InFrame { frame: Frame::from_normal(normals.about), directions }
    }

    fn evaluator<'l>(&'l self, learnt: &'l Vec<Entry>, smoothing: f32) -> Evaluator<'l> {
        let q = estimates(learnt, &self.strata, smoothing);
        Box::new(move |about, w| self.strata.index(Frame::from_normal(about).to_local(w)).map(|k| q[k]))
    }

    fn bytes(&self, learnt: &Vec<Entry>) -> usize {
        learnt.len() * BYTES_PER_STRATUM
    }

    fn usual_bytes(&self) -> usize {
        self.strata.count() * BYTES_PER_STRATUM
    }

    fn pool_bytes(&self, pool: &Vec<u16>) -> usize {
        size_of_val(&pool[..])
    }

    fn is_sound(&self, learnt: &Vec<Entry>) -> bool {
        super::is_sound(learnt, &self.strata)
    }
}
