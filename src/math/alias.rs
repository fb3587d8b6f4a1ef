//! Discrete distributions.

use crate::simd::{LANES, pick};

/// Draws index `i` with probability `w[i]/Σw` in O(1) (Walker's alias method, Vose's construction 1991).
#[derive(Clone, Debug)]
pub struct AliasTable {
    bins: Vec<Bin>,
    pmf: Vec<f32>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Share of this bin that keeps its own index.
    keep: f32,
    alias: u32,
}

impl AliasTable {
    pub(crate) const BYTES_PER_BIN: u64 = (size_of::<Bin>() + size_of::<f32>()) as u64;

    /// `None` where no weight is positive. Weights must be finite and not negative.
    pub fn new(weights: &[f64]) -> Option<AliasTable> {
        debug_assert!(weights.iter().all(|w| w.is_finite() && *w >= 0.0));
        let sum: f64 = weights.iter().sum();
        if weights.is_empty() || sum <= 0.0 || !sum.is_finite() {
            return None;
        }
        let n = weights.len();
        let pmf: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        let mut scaled: Vec<f64> = pmf.iter().map(|p| p * n as f64).collect();
        let mut bins = vec![Bin { keep: 1.0, alias: 0 }; n];
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| scaled[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            bins[s] = Bin { keep: scaled[s] as f32, alias: l as u32 };
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        for i in small.into_iter().chain(large) {
            // Rounding leaves a few bins over; a bin without weight must still never be drawn.
            bins[i] = if pmf[i] > 0.0 { Bin { keep: 1.0, alias: i as u32 } } else { Bin { keep: 0.0, alias: 0 } };
            if pmf[i] == 0.0 {
                bins[i].alias = pmf.iter().position(|&p| p > 0.0).expect("the sum is positive") as u32;
            }
        }
        Some(AliasTable { bins, pmf: pmf.into_iter().map(|p| p as f32).collect() })
    }

    /// An index and what is left of `u` as a fresh uniform number in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let scaled = u * self.bins.len() as f32;
        let i = (scaled as usize).min(self.bins.len() - 1);
        let rest = (scaled - i as f32).clamp(0.0, super::ONE_MINUS_EPSILON);
        let bin = self.bins[i];
        if rest < bin.keep {
            (i, (rest / bin.keep).min(super::ONE_MINUS_EPSILON))
        } else {
            (bin.alias as usize, ((rest - bin.keep) / (1.0 - bin.keep)).min(super::ONE_MINUS_EPSILON))
        }
    }

    /// [`Self::sample`] with a number of more bits: 24 of them give an index rarer than 2⁻²⁴ a wrong share or none,
    /// and leave a coarse rest in a long table. The rest may choose from a further table.
    #[inline]
    pub(crate) fn sample_wide(&self, u: f64) -> (usize, f64) {
        let scaled = u * self.bins.len() as f64;
        let i = (scaled as usize).min(self.bins.len() - 1);
        let rest = (scaled - i as f64).clamp(0.0, super::ONE_MINUS_EPSILON_F64);
        let (keep, alias) = (self.bins[i].keep as f64, self.bins[i].alias);
        let (index, rest) = if rest < keep { (i, rest / keep) } else { (alias as usize, (rest - keep) / (1.0 - keep)) };
        (index, rest.min(super::ONE_MINUS_EPSILON_F64))
    }

    /// [`Self::sample_wide`] for a packet; without jumps, each of which would be a guess.
    #[inline(always)]
    pub(crate) fn sample_lanes(&self, u: &[f64; LANES]) -> ([u32; LANES], [f64; LANES]) {
        AliasTable::sample_each(&[self; LANES], u)
    }

    /// [`Self::sample_wide`] from a table for each lane. No lane waits for another: where tables are in no cache, all of them are
    /// on their way at once.
    #[inline(always)]
    pub(crate) fn sample_each(tables: &[&AliasTable; LANES], u: &[f64; LANES]) -> ([u32; LANES], [f64; LANES]) {
        let (mut bin, mut rest) = ([0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let (bins, last) = (tables[k].bins.len() as f64, (tables[k].bins.len() - 1) as u32);
            let scaled = u[k] * bins;
            bin[k] = (scaled as u32).min(last);
            rest[k] = (scaled - bin[k] as f64).clamp(0.0, super::ONE_MINUS_EPSILON_F64);
        }
        let (mut keep, mut alias) = ([0.0; LANES], [0; LANES]);
        for k in 0..LANES {
            let Bin { keep: share, alias: other } = tables[k].bins[bin[k] as usize];
            (keep[k], alias[k]) = (share, other);
        }
        for k in 0..LANES {
            let keep = keep[k] as f64;
            let kept = rest[k] < keep;
            bin[k] = pick(kept, bin[k], alias[k]);
            let left = pick(kept, rest[k] / keep, (rest[k] - keep) / (1.0 - keep));
            rest[k] = pick(left < super::ONE_MINUS_EPSILON_F64, left, super::ONE_MINUS_EPSILON_F64);
        }
        (bin, rest)
    }

    /// Probability of index `i`.
    #[inline]
    pub(crate) fn pmf(&self, i: usize) -> f32 {
        self.pmf[i]
    }

    /// Number of indices.
    #[allow(clippy::len_without_is_empty, reason = "a table is never empty")]
    pub(crate) fn len(&self) -> usize {
        self.bins.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    #[test]
    fn wide_numbers_draw_rare_indices_at_their_rate() {
        let table = AliasTable::new(&[1e-9, 1.0 - 1e-9]).unwrap();
        let shares = [0.0, 0.4e-9, 0.99e-9].map(|u| table.sample_wide(u));
        assert!(shares.iter().all(|s| s.0 == 0));
        assert!((shares[1].1 - 0.4).abs() < 1e-3, "the rest is {}", shares[1].1);
        assert_eq!(table.sample_wide(1.01e-9).0, 1);
        // a number of 24 bits draws it sixty times too often
        assert_eq!(table.sample(0.0).0, 0);
        assert_eq!(table.sample(2f32.powi(-24)).0, 1);
    }

    #[test]
    fn wide_numbers_draw_by_weight_and_leave_a_uniform_rest() {
        let weights = [3.0, 0.0, 1.0, 5.0, 0.5];
        let table = AliasTable::new(&weights).unwrap();
        let n = 1_000_000;
        let (mut counts, mut rests) = ([0.0; 5], [0.0; 5]);
        for k in 0..n {
            let (i, rest) = table.sample_wide((k as f64 + 0.5) / n as f64);
            assert!((0.0..1.0).contains(&rest));
            counts[i] += 1.0;
            rests[i] += rest;
        }
        for (i, weight) in weights.iter().enumerate() {
            assert!((counts[i] / n as f64 - weight / 9.5).abs() < 1e-5);
            assert!(counts[i] == 0.0 || (rests[i] / counts[i] - 0.5).abs() < 1e-4);
        }
        assert!(weights[table.sample_wide(crate::math::ONE_MINUS_EPSILON_F64).0] > 0.0);
    }

    #[test]
    fn a_packet_draws_like_single_numbers() {
        let mut rng = Rng::new(8);
        for n in [1, 2, 7, 1000] {
            let weights: Vec<f64> = (0..n).map(|i| if i % 3 == 1 { 0.0 } else { rng.f64() }).collect();
            let table = AliasTable::new(&weights).unwrap();
            for round in 0..50 {
                let mut u = [0.0; LANES].map(|_: f64| rng.f64());
                (u[0], u[1]) = (0.0, if round == 0 { crate::math::ONE_MINUS_EPSILON_F64 } else { u[1] });
                let (index, rest) = table.sample_lanes(&u);
                for k in 0..LANES {
                    assert_eq!((index[k] as usize, rest[k]), table.sample_wide(u[k]), "{n} weights, {}", u[k]);
                }
            }
        }
    }
}
