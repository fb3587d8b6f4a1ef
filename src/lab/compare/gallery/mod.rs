//! The stability matrix: what each method does on each scene of a gallery, judged by stated bounds.
//!
//! [`checks`] judge the runs of a cell, [`matrix`] puts them together, [`output`] and [`pictures`] write them. Nothing is red
//! but by its figures; why a cell is red is told by sentences in the comparison's file, and where there is none, that too.

pub(crate) mod checks;
pub(crate) mod matrix;
pub(crate) mod output;
pub(crate) mod pictures;
pub(super) mod reading;

#[cfg(test)]
mod tests;

use serde::Serialize;

/// What the comparison's file says of its matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Gallery {
    pub(crate) bounds: Bounds,
    pub(crate) whys: Vec<Why>,
}

/// Where verdicts change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Bounds {
    /// Probability that any of all tests of bias is wrong, were all cells honest.
    pub(crate) alarm: f64,
    /// How many times as inefficient as the baseline a method may be.
    pub(crate) slower: f64,
    /// Share of the error in the worst 0.1 % of the pixels.
    pub(crate) fireflies: f64,
    /// The worst run's error over the median run's.
    pub(crate) explosion: f64,
    /// Samples per pixel of the pictures that must be equal.
    pub(crate) repeat: u32,
}

impl Default for Bounds {
    fn default() -> Bounds {
        Bounds { alarm: 0.01, slower: 2.0, fireflies: 0.5, explosion: 10.0, repeat: 8 }
    }
}

/// A sentence on why some cells fail.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Why {
    /// Empty: any.
    pub(crate) scenes: Vec<String>,
    pub(crate) methods: Vec<String>,
    pub(crate) fails: Vec<Check>,
    pub(crate) says: String,
}

/// What is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Check {
    Unbiased,
    Finite,
    Efficiency,
    Fireflies,
    Explosion,
    Memory,
    Repeatable,
}

impl Check {
    pub(crate) const NAMES: [(&'static str, Check); 7] = [
        ("unbiased", Check::Unbiased),
        ("finite", Check::Finite),
        ("efficiency", Check::Efficiency),
        ("fireflies", Check::Fireflies),
        ("explosion", Check::Explosion),
        ("memory", Check::Memory),
        ("repeatable", Check::Repeatable),
    ];

    pub(crate) fn name(self) -> &'static str {
        Check::NAMES[self as usize].0
    }
}

/// A verdict, the worst last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Colour {
    Green,
    /// Not known, or within the bounds but worse than the baseline.
    Amber,
    Red,
}

impl Gallery {
    /// The first sentence for this failure.
    pub(crate) fn why(&self, scene: &str, method: &str, check: Check) -> Option<&str> {
        let has = |names: &[String], name: &str| names.is_empty() || names.iter().any(|n| n == name);
        let fits = |why: &&Why| {
            let check = why.fails.is_empty() || why.fails.contains(&check);
            check && has(&why.scenes, scene) && has(&why.methods, method)
        };
        self.whys.iter().find(fits).map(|why| why.says.as_str())
    }
}
