//! Numbers of samples where pixels differ in them.

use rayon::prelude::*;
use std::ops::Range;

/// How many samples pixels have beyond those that all have. It takes memory only where pixels differ, as after a pass that
/// was cut.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Surplus(Vec<u32>);

impl Surplus {
    /// Of one pixel.
    #[inline]
    pub(crate) fn of(&self, pixel: usize) -> u32 {
        self.0.get(pixel).copied().unwrap_or(0)
    }

    /// Of pixels that have so many.
    pub(crate) fn of_counts(counts: Vec<u32>) -> Surplus {
        Surplus(counts)
    }

    /// Whether no pixel has any.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds `samples` to some of `pixels` pixels.
    pub(crate) fn add(&mut self, some: Range<usize>, samples: u32, pixels: usize) {
        self.0.resize(pixels, 0);
        self.0[some].iter_mut().for_each(|n| *n += samples);
    }

    /// Takes back what was added to some pixels.
    pub(crate) fn take_back(&mut self, some: Range<usize>, samples: u32) {
        self.0.get_mut(some).into_iter().flatten().for_each(|n| *n = n.saturating_sub(samples));
    }

    /// Adds what pixels have there.
    pub(crate) fn add_all(&mut self, other: &Surplus) {
        self.0.resize(self.0.len().max(other.0.len()), 0);
        self.0.iter_mut().zip(&other.0).for_each(|(n, more)| *n += more);
    }

    /// Takes out what all pixels have, and returns that.
    pub(crate) fn level(&mut self) -> u32 {
        let least = self.0.iter().copied().min().unwrap_or(0);
        self.0.iter_mut().for_each(|n| *n -= least);
        if self.0.iter().all(|&n| n == 0) {
            self.0 = Vec::new();
        }
        least
    }

    /// Whether it can be of so many pixels.
    pub(super) fn fits(&self, pixels: usize) -> bool {
        self.0.is_empty() || self.0.len() == pixels
    }

    /// On average over the pixels.
    pub(crate) fn mean(&self) -> f64 {
        self.0.par_iter().map(|&n| u64::from(n)).sum::<u64>() as f64 / self.0.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_all_pixels_have_is_no_surplus() {
        let mut surplus = Surplus::default();
        assert_eq!((surplus.of(3), surplus.level(), surplus.mean()), (0, 0, 0.0));
        surplus.add(0..2, 4, 4);
        surplus.add(2..4, 1, 4);
        assert_eq!((surplus.of(0), surplus.of(3), surplus.mean()), (4, 1, 2.5));
        assert_eq!((surplus.level(), surplus.of(0), surplus.of(3)), (1, 3, 0));
        surplus.add(2..4, 3, 4);
        assert_eq!((surplus.level(), surplus), (3, Surplus::default()));
    }

    #[test]
    fn surpluses_add_up() {
        let (mut one, mut other) = (Surplus::default(), Surplus::default());
        one.add_all(&other);
        assert!(one.is_empty());
        other.add(1..2, 5, 3);
        one.add_all(&other);
        other.add_all(&one);
        assert_eq!([0, 1, 2].map(|i| (one.of(i), other.of(i))), [(0, 0), (5, 10), (0, 0)]);
    }
}
