//! Numbers whose sums do not depend on their order: integers, in units of 2⁻⁶⁴.
//!
//! A single-precision number has 24 bits, so that all larger than 2⁻⁴⁰ are converted without rounding, and smaller ones are rounded
//! towards zero, to the same on every machine. Sums reach to 2⁶³.

const UNIT: f64 = (1u128 << 64) as f64;

/// A number as such an integer; 0 for what is not a number.
#[inline]
pub(crate) fn fixed(v: f32) -> i128 {
    (f64::from(v) * UNIT) as i128
}

/// The number that such an integer stands for.
#[inline]
pub(crate) fn value(sum: i128) -> f64 {
    sum as f64 / UNIT
}
