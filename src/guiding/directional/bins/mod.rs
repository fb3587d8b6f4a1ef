//! Bins of equal solid angle: the actions of the paper's tables.

pub mod rows;
pub mod strata;
