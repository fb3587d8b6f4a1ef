//! Directions: how what arrives at a region is told apart by where it comes from.

pub mod bins;
pub mod distribution;
pub mod guide_lanes;
pub mod hemitree;
pub mod quadtree;
