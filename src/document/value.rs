//! Values of documents as numbers, colours, paths, and what they must satisfy.

use super::tree::{Fault, Node, Value};
use crate::math::Rgb;
use std::path::{Path, PathBuf};

/// What a number must satisfy once it is rounded to `f32`; that it is finite is always asked.
#[derive(Clone, Copy)]
pub(crate) struct Bounds {
    holds: fn(f64) -> bool,
    text: &'static str,
}

pub(crate) const FINITE: Bounds = Bounds::new(|_| true, "finite");
pub(crate) const UNIT: Bounds = Bounds::new(|x| (0.0..=1.0).contains(&x), "between 0 and 1");
pub(crate) const POSITIVE: Bounds = Bounds::new(|x| x > 0.0, "greater than 0");
pub(crate) const NOT_NEGATIVE: Bounds = Bounds::new(|x| x >= 0.0, "0 or more");
/// Within what can be traced in single precision ([`crate::embree::LARGEST_COORDINATE`]).
pub(crate) const COORDINATE: Bounds = Bounds::new(|x| x.abs() <= 1e12, "between -1e12 and 1e12");

impl Bounds {
    /// `text` goes on from "must be".
    pub(crate) const fn new(holds: fn(f64) -> bool, text: &'static str) -> Bounds {
        Bounds { holds, text }
    }

    /// For the reference; empty where all finite numbers are within them.
    pub(crate) fn range(self) -> &'static str {
        if self.text == FINITE.text { "" } else { self.text }
    }
}

impl Node {
    /// That the value is not `expected` ("a number").
    pub(crate) fn mismatch(&self, key: &str, expected: &str) -> Fault {
        Fault::new(self.at, format!("`{key}` must be {expected}, found {}", self.value.kind()))
    }

    pub(crate) fn string(&self, key: &str) -> Result<&str, Fault> {
        match &self.value {
            Value::String(s) => Ok(s),
            _ => Err(self.mismatch(key, "a string")),
        }
    }

    /// A file's name, which is relative to the folder `base`.
    pub(crate) fn path(&self, key: &str, base: &Path) -> Result<PathBuf, Fault> {
        match self.string(key)? {
            "" => Err(Fault::new(self.at, format!("`{key}` must not be empty"))),
            name => Ok(base.join(name)),
        }
    }

    pub(crate) fn number(&self, key: &str, bounds: Bounds) -> Result<f32, Fault> {
        self.double(key, bounds).map(|x| x as f32)
    }

    /// A number as it is written, which is within the bounds once it is rounded to `f32`.
    pub(crate) fn double(&self, key: &str, bounds: Bounds) -> Result<f64, Fault> {
        let written = match self.value {
            Value::Integer(i) => i as f64,
            Value::Float(x) => x,
            _ => return Err(self.mismatch(key, "a number")),
        };
        let x = written as f32;
        if x.is_finite() && (bounds.holds)(f64::from(x)) {
            return Ok(written);
        }
        let text = if x.is_finite() { bounds.text } else { FINITE.text };
        let long = written.abs() >= 1e16;
        let found = if long { format!("{written:e}") } else { written.to_string() };
        Err(Fault::new(self.at, format!("`{key}` must be {text}, found {found}")))
    }

    pub(crate) fn numbers<const N: usize>(&self, key: &str, bounds: Bounds) -> Result<[f32; N], Fault> {
        self.doubles(key, bounds).map(|numbers| numbers.map(|x| x as f32))
    }

    pub(crate) fn doubles<const N: usize>(&self, key: &str, bounds: Bounds) -> Result<[f64; N], Fault> {
        let expected = || format!("an array of {N} numbers");
        let Value::Array(items) = &self.value else {
            return Err(self.mismatch(key, &expected()));
        };
        if items.len() != N {
            let message = format!("`{key}` must be {}, found {}", expected(), items.len());
            return Err(Fault::new(self.at, message));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.double(key, bounds)?;
        }
        Ok(numbers)
    }

    /// A grey number or `[r, g, b]`.
    pub(crate) fn color(&self, key: &str, bounds: Bounds) -> Result<Rgb, Fault> {
        match &self.value {
            Value::Integer(_) | Value::Float(_) => self.number(key, bounds).map(Rgb::splat),
            Value::Array(_) => self.numbers::<3>(key, bounds).map(Rgb::from),
            _ => Err(self.mismatch(key, "a number or an array of 3 numbers")),
        }
    }

    /// The tables of an array of tables.
    pub(crate) fn tables(self, key: &str) -> Result<Vec<Node>, Fault> {
        match self.value {
            Value::Array(items) => Ok(items),
            _ => Err(self.mismatch(key, &format!("an array of tables ([[{key}]])"))),
        }
    }
}
