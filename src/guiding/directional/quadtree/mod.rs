//! A quadtree over the sphere (Müller et al. 2017).

pub mod building;
pub mod frozen;
